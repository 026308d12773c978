"""Kernels that scan-convert a reference's surface between any two central cameras.

The twin of `_surface` for passages with a panorama at either end. A triangle of three samples,
seen from the desired eye along Ya, Yb and Yc (`_landing.reach`), covers the rays

    D = wa Ya + wb Yb + wc Yc,   wa, wb, wc >= 0          wa = det(D, Yb, Yc) / det(Ya, Yb, Yc) ...

and shows on them the disparity ``wa delta_a + wb delta_b + wc delta_c``: both linear in D, so that
a flat triangle stays flat whatever the manifold of the desired picture.

A picture that goes round may show one column twice, at both its ends.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import INTACT, RIM
from belvedere.warp._landing import TARGET, Geometry, project, reach
from belvedere.warp._masks import note_part
from belvedere.warp._quads import LARGEST_CELL, ONE, SURE, UNSURE, ZERO, marked
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]
SLACK_PX = 2e-3
"""Pixels outside a side that still count as inside. Half cells meet whole ones at points between
samples, which stay a thousandth of a pixel off the straight line on a curved picture."""
REACH_PX = 4e-3
"""Pixels by which a cell's bounds are widened; more than the slack."""
CAP = 2
"""Side of a part that closes the picture over a pole: no edge, but surface."""
CORNER = 6
"""Numbers of a landed corner: Y, where it lands, its disparity there."""
NOWHERE = (1 << 30, -(1 << 30), 1 << 30, -(1 << 30))
"""Bounds of what is not drawn."""


@inner
def land_corner(g: Geometry, u: Real, v: Real, delta: Real, out_corner: F8) -> None:
    """Fill (CORNER,) for one sample; it lands at NaN where it has no image."""
    a, b, c = reach(g, u, v, delta)
    x, y, scale = project(g, TARGET, a, b, c)
    out_corner[0], out_corner[1], out_corner[2] = a, b, c
    out_corner[3], out_corner[4], out_corner[5] = x, y, delta * scale


@inner
def triple(p: F8, q: F8, r: F8) -> Real:
    """Determinant of three rays: twice their triangle's signed area, as the eye sees it."""
    return (
        p[0] * (q[1] * r[2] - q[2] * r[1])
        + p[1] * (q[2] * r[0] - q[0] * r[2])
        + p[2] * (q[0] * r[1] - q[1] * r[0])
    )


@inner
def apart(g: Geometry, p: F8, q: F8) -> Real:
    """Distance of two corners on the unit cylinder or sphere, in pixels at its equator."""
    flat_p, flat_q = p[0] * p[0] + p[1] * p[1], q[0] * q[0] + q[1] * q[1]
    if g[TARGET] == 2.0:
        flat_p, flat_q = flat_p + p[2] * p[2], flat_q + q[2] * q[2]
    long_p, long_q = 1.0 / np.sqrt(flat_p), 1.0 / np.sqrt(flat_q)
    total = 0.0
    for axis in range(3):
        step = p[axis] * long_p - q[axis] * long_q
        total += step * step
    return np.sqrt(total) / min(g[TARGET + 2], g[TARGET + 4])


@inner
def flat_bounds(quad: F8, margin: Real) -> tuple[int, int, int, int]:
    """`bounds` in a planar picture."""
    x_low, x_high, y_low, y_high = quad[0, 3], quad[0, 3], quad[0, 4], quad[0, 4]
    for n in range(1, 4):
        x_low, x_high = min(x_low, quad[n, 3]), max(x_high, quad[n, 3])
        y_low, y_high = min(y_low, quad[n, 4]), max(y_high, quad[n, 4])
    limit = np.float64(LARGEST_CELL)
    if not (x_high - x_low <= limit and y_high - y_low <= limit):
        return NOWHERE
    if not (abs(x_low) < 1e8 and abs(y_low) < 1e8):
        return NOWHERE
    return (
        int(np.ceil(x_low - margin)), int(np.floor(x_high + margin)),
        int(np.ceil(y_low - margin)), int(np.floor(y_high + margin)),
    )  # fmt: skip


@inner
def bulge(g: Geometry, span: Real, low: Real, high: Real) -> Real:
    """Rows that the sides of a cell reach beyond its corners, at most: toward the nearer pole.

    Over an azimuth of a, up to a quarter turn, a great circle rises
    ``atan(tan e / cos(a / 2)) - e`` above two points at elevation e, which is below a^2 / 12; on a
    cylinder ``1 / cos(a / 2) - 1`` times their height, below 0.17 a^2.
    """
    angle = span * g[TARGET + 2]
    if g[TARGET] == 2.0:
        return angle * angle / (12.0 * g[TARGET + 4])
    return 0.17 * angle * angle * max(abs(low - g[TARGET + 3]), abs(high - g[TARGET + 3]))


@inner
def round_bounds(g: Geometry, quad: F8, margin: Real) -> tuple[int, int, int, int]:
    """`bounds` in a panorama."""
    turn, x0 = g[TARGET + 5], quad[0, 3]
    left, right, low, high = 0.0, 0.0, quad[0, 4], quad[0, 4]  # of columns from x0; of rows
    for n in range(1, 4):
        step = quad[n, 3] - x0
        step -= turn * np.rint(step / turn)
        left, right = min(left, step), max(right, step)
        low, high = min(low, quad[n, 4]), max(high, quad[n, 4])
    span, limit, most = right - left, np.float64(LARGEST_CELL), 1e8
    if span + high - low > limit and not (
        apart(g, quad[0], quad[3]) <= limit and apart(g, quad[1], quad[2]) <= limit
    ):
        return NOWHERE
    if span <= 0.25 * turn:  # no axis within
        more = margin + bulge(g, span, low, high)
        low, high = low - more, high + more
    else:  # near an axis, or round it: all columns, and rows as far as that pole
        upper, lower = low + high <= 2.0 * g[TARGET + 3], low + high >= 2.0 * g[TARGET + 3]
        low = -most if upper else low - margin
        high = most if lower else high + margin
        left, right, x0 = 0.0, turn - 1.0, np.ceil(g[TARGET + 6])
    return (
        int(np.ceil(x0 + left - margin)), int(np.floor(x0 + right + margin)),
        int(np.ceil(max(low, -most))), int(np.floor(min(high, most))),
    )  # fmt: skip


@inner
def bounds(g: Geometry, quad: F8, margin: Real) -> tuple[int, int, int, int]:
    """Left, right, top and bottom pixel whose centres a cell may cover; see `NOWHERE`.

    Args:
        g: geometry.
        quad: (4, CORNER) upper left, upper right, lower left, lower right corner.
        margin: pixels to widen them by.

    Columns count on beyond the seam: take them modulo the turn.
    """
    for n in range(4):
        if not abs(quad[n, 3] + quad[n, 4]) < 1e9:
            return NOWHERE  # behind the eye, or missing
    if g[TARGET] == 0.0:
        return flat_bounds(quad, margin)
    return round_bounds(g, quad, margin)


@inner
def side(p: F8, q: F8, out_normal: F8) -> None:
    """Normal of the plane through the eye and two corners. Swapped corners negate every bit."""
    out_normal[0] = p[1] * q[2] - p[2] * q[1]
    out_normal[1] = p[2] * q[0] - p[0] * q[2]
    out_normal[2] = p[0] * q[1] - p[1] * q[0]


@inner
def set_up(g: Geometry, quad: F8, deltas: F8, out_sides: F8, out_planes: F8) -> tuple[bool, bool]:
    """Sides and disparities of a cell's two triangles, and which of them face the eye.

    Args:
        g: geometry.
        quad: (4, CORNER).
        deltas: (4,) disparities in the reference.
        out_sides: (5, 4) inward normals of the sides a-b, b-d, d-c, c-a, the diagonal b-c as the
            upper triangle sees it; and the slack of each.
        out_planes: (2, 3) disparity along D is the product with it: a-b-c, d-c-b.
    """
    a, b, c, d = quad[0], quad[1], quad[2], quad[3]
    side(a, b, out_sides[0])
    side(b, d, out_sides[1])
    side(d, c, out_sides[2])
    side(c, a, out_sides[3])
    side(b, c, out_sides[4])
    pixel = 1.0 if g[TARGET] == 0.0 else g[TARGET + 4]
    for n in range(5):
        long = out_sides[n, 0] * out_sides[n, 0] + out_sides[n, 1] * out_sides[n, 1]
        if g[TARGET] != 0.0:
            long += out_sides[n, 2] * out_sides[n, 2]
        out_sides[n, 3] = -SLACK_PX * pixel * np.sqrt(long)
    upper, lower = triple(a, b, c), triple(d, c, b)
    over = 1.0 / upper if upper > 0.0 else 0.0  # edge on, or a corner of a cap twice
    under = 1.0 / lower if lower > 0.0 else 0.0
    for axis in range(3):
        out_planes[0, axis] = over * (
            deltas[0] * out_sides[4, axis] + deltas[1] * out_sides[3, axis]
            + deltas[2] * out_sides[0, axis]
        )  # fmt: skip
        out_planes[1, axis] = under * (
            deltas[2] * out_sides[1, axis] + deltas[1] * out_sides[2, axis]
            - deltas[3] * out_sides[4, axis]
        )  # fmt: skip
    return upper > 0.0, lower > 0.0


@inner
def along(normal: F8, d0: Real, d1: Real, d2: Real) -> Real:
    """Product of a normal and a ray."""
    return normal[0] * d0 + normal[1] * d1 + normal[2] * d2


@inner
def ray_of(g: Geometry, across: F8, down: F8, x: int, y: int) -> tuple[Real, Real, Real]:
    """Ray of a desired pixel from the tables of `tabulate`; x in one turn."""
    if g[TARGET] == 0.0:
        return np.float64(x), np.float64(y), 1.0
    flat = down[0, y]
    return flat * across[0, x], flat * across[1, x], down[1, y]


@kernel
def tabulate(g: Geometry, width: int, row_low: int, rows: int) -> tuple[F8, F8]:
    """Tables for `ray_of`: cosine and sine of each column's azimuth, of each row's elevation.

    Rows count from row_low; a cylinder's rows have a flat length of 1 and their height.
    """
    across, down = np.empty((2, width)), np.empty((2, rows))
    for x in range(width):
        psi = g[TARGET + 1] - x * g[TARGET + 2]
        across[0, x], across[1, x] = np.cos(psi), np.sin(psi)
    for y in range(rows):
        up = (g[TARGET + 3] - (y + row_low)) * g[TARGET + 4]
        sphere = g[TARGET] == 2.0
        down[0, y], down[1, y] = (np.cos(up), np.sin(up)) if sphere else (1.0, up)
    return across, down


@inner
def column_in_turn(g: Geometry, x: int) -> int:
    """First column of a picture that shows what column x would, were it to go on for ever."""
    if g[TARGET] == 0.0:
        return x
    turn = int(g[TARGET + 5])
    return x - turn * int(np.floor(x / turn))


@inner
def draw_centers(
    g: Geometry, across: F8, down: F8, quad: F8, sides: F8, planes: F8, faces: tuple[bool, bool],
    box: tuple[int, int, int, int], row_low: int, mark: Real, out: F4,
) -> None:  # fmt: skip
    """The disparity of a cell at the pixel centres that it covers, where it is the nearest.

    box is left, right, top, bottom, the rows inside the band.
    """
    width = out.shape[1]
    turn = int(g[TARGET + 5])
    low = min(quad[0, 5], quad[1, 5], quad[2, 5], quad[3, 5])
    high = max(quad[0, 5], quad[1, 5], quad[2, 5], quad[3, 5])
    for y in range(box[2] - row_low, box[3] + 1 - row_low):
        for x_far in range(box[0], box[1] + 1):
            x = column_in_turn(g, x_far)
            if x < 0 or x >= width:
                continue
            d0, d1, d2 = ray_of(g, across, down, x, y if g[TARGET] != 0.0 else y + row_low)
            cut = along(sides[4], d0, d1, d2)
            first, last = along(sides[0], d0, d1, d2), along(sides[3], d0, d1, d2)
            right, under = along(sides[1], d0, d1, d2), along(sides[2], d0, d1, d2)
            over = first >= sides[0, 3] and last >= sides[3, 3] and cut >= sides[4, 3]
            below = right >= sides[1, 3] and under >= sides[2, 3] and -cut >= sides[4, 3]
            if faces[0] and over:
                z, inward = along(planes[0], d0, d1, d2), min(first, last, cut)
            elif faces[1] and below:
                z, inward = along(planes[1], d0, d1, d2), min(right, under, -cut)
            else:
                continue
            if inward < 0.0:  # a sliver's plane is no guide outside it
                z = max(min(z, high), low)
            value = marked(np.float32(max(z, 0.0)), mark)
            out[y, x] = max(out[y, x], value)
            if g[TARGET] != 0.0 and x + turn < width:
                out[y, x + turn] = max(out[y, x + turn], value)


@inner
def steps_in_pixel(
    g: Geometry, sides: F8, d0: Real, d1: Real, d2: Real, flat: Real, out_steps: F8
) -> None:
    """(2, 4) change of each side's product for a pixel to the right, and for one down."""
    x0, x1, x2, y0, y1, y2 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    if g[TARGET] != 0.0:
        step, up = g[TARGET + 2], g[TARGET + 4]
        x0, x1 = step * d1, -step * d0
        y0, y1, y2 = 0.0, 0.0, -up
        if g[TARGET] == 2.0:
            tilt = d2 / flat if flat > 0.0 else 0.0
            y0, y1, y2 = up * tilt * d0, up * tilt * d1, -up * flat
    for n in range(4):
        out_steps[0, n] = along(sides[n], x0, x1, x2)
        out_steps[1, n] = along(sides[n], y0, y1, y2)


@inner
def draw_masks(
    g: Geometry, across: F8, down: F8, quad: F8, sides: F8, planes: F8,
    box: tuple[int, int, int, int], row_low: int, keep: Real, mark: Real, steps: F8,
    out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """Which sixteenths of each pixel a cell covers; as `_masks.mask_quad`."""
    width = out_edge.shape[1]
    turn = int(g[TARGET + 5])
    low = np.float32(min(quad[0, 5], quad[1, 5], quad[2, 5], quad[3, 5]))
    high = np.float32(max(quad[0, 5], quad[1, 5], quad[2, 5], quad[3, 5]))
    for y in range(box[2] - row_low, box[3] + 1 - row_low):
        for x_far in range(box[0], box[1] + 1):
            x = column_in_turn(g, x_far)
            if x < 0 or x >= width:
                continue
            d0, d1, d2 = ray_of(g, across, down, x, y if g[TARGET] != 0.0 else y + row_low)
            flat = down[0, y] if g[TARGET] != 0.0 else 1.0
            steps_in_pixel(g, sides, d0, d1, d2, flat, steps)
            bits = 0
            for k in range(16):
                mirrored = (k & 1) * 8 + (k & 2) * 2 + (k & 4) // 2 + (k & 8) // 8
                ox, oy = (k - 7.5) * 0.0625, (mirrored - 7.5) * 0.0625
                inside = True
                for n in range(4):
                    here = along(sides[n], d0, d1, d2)
                    inside &= here + ox * steps[0, n] + oy * steps[1, n] >= sides[n, 3]
                bits |= int(inside) << k
            z = np.float32(along(planes[0], d0, d1, d2))
            z = max(min(max(z, low), high), ZERO)
            note_part(x, y, bits, z, high, keep, mark, out_edge, out_mask)
            if g[TARGET] != 0.0 and x + turn < width:
                note_part(x + turn, y, bits, z, high, keep, mark, out_edge, out_mask)


@inner
def draw_quad(
    g: Geometry, across: F8, down: F8, quad: F8, deltas: F8, row_low: int, first: int, end: int,
    keep: Real, mark: Real, masked: bool, sides: F8, planes: F8, steps: F8, out: F4, out_edge: F4,
    out_mask: U2,
) -> None:  # fmt: skip
    """One cell, or part of one. sides (5, 4), planes (2, 3), steps (2, 4) are to work in."""
    wide = bounds(g, quad, 0.5 if masked else REACH_PX)
    if wide[3] < first or wide[2] >= end or wide[1] < wide[0]:
        return
    faces = set_up(g, quad, deltas, sides, planes)
    if masked and faces[0] and faces[1]:
        box = wide[0], wide[1], max(wide[2], first), min(wide[3], end - 1)
        draw_masks(
            g, across, down, quad, sides, planes, box, row_low, keep, mark, steps, out_edge,
            out_mask,
        )  # fmt: skip
    if faces[0] or faces[1]:
        tight = bounds(g, quad, REACH_PX) if masked else wide
        box = tight[0], tight[1], max(tight[2], first), min(tight[3], end - 1)
        draw_centers(g, across, down, quad, sides, planes, faces, box, row_low, mark, out)


@inner
def land_cells(g: Geometry, disparity: F4, v: int, u_low: int, count: int, out_corners: F8) -> None:
    """``count`` samples of a row landed to (count, CORNER)."""
    for i in range(count):
        land_corner(
            g, np.float64(u_low + i), np.float64(v), np.float64(disparity[v, u_low + i]),
            out_corners[i],
        )  # fmt: skip


@inner
def take_cell(
    above: F8, below: F8, disparity: F4, v: int, u: int, i: int, out_quad: F8, out_deltas: F8
) -> None:
    """Corners and disparities of the cell at sample (v, u), number i of its row."""
    for k in range(CORNER):
        out_quad[0, k], out_quad[1, k] = above[i, k], above[i + 1, k]
        out_quad[2, k], out_quad[3, k] = below[i, k], below[i + 1, k]
    out_deltas[0], out_deltas[1] = disparity[v, u], disparity[v, u + 1]
    out_deltas[2], out_deltas[3] = disparity[v + 1, u], disparity[v + 1, u + 1]


@inner
def take_part(g: Geometry, parts: F4, n: int, out_quad: F8, out_deltas: F8) -> None:
    """Corners and disparities of part n."""
    for corner in range(4):
        u, v, delta = parts[3 * corner, n], parts[3 * corner + 1, n], parts[3 * corner + 2, n]
        land_corner(g, np.float64(u), np.float64(v), np.float64(delta), out_quad[corner])
        out_deltas[corner] = delta


@kernel
def draw_surface(
    g: Geometry, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int,
    tolerance: Real, out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """As `_surface.draw_surface`, with a geometry instead of a warp matrix."""
    keep = ONE - np.float32(tolerance)
    rows, stride = disparity.shape
    across, down = tabulate(g, out.shape[1], row_low, row_high - row_low)
    above, below = np.empty((TILE + 1, CORNER)), np.empty((TILE + 1, CORNER))
    quad, deltas = np.empty((4, CORNER)), np.empty(4)
    sides, planes, steps = np.empty((5, 4)), np.empty((2, 3)), np.empty((2, 4))
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        u_low = tiles[n, 0]
        count = min(tiles[n, 1], stride - 1) - u_low
        for v in range(tiles[n, 3], min(tiles[n, 4], rows - 1)):
            land_cells(g, disparity, v, u_low, count + 1, above)
            land_cells(g, disparity, v + 1, u_low, count + 1, below)
            for i in range(count):
                bits = links[v, u_low + i]
                if bits & INTACT:
                    take_cell(above, below, disparity, v, u_low + i, i, quad, deltas)
                    draw_quad(
                        g, across, down, quad, deltas, row_low, first, end, keep, SURE,
                        bits & RIM != 0, sides, planes, steps, out, out_edge, out_mask,
                    )  # fmt: skip


@kernel
def draw_parts(
    g: Geometry, parts: F4, near: U1, ends: I4, tiles: I4, row_low: int, row_high: int,
    tolerance: Real, out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """As `_surface.draw_parts`, with a geometry instead of a warp matrix."""
    keep = ONE - np.float32(tolerance)
    flat_ends = ends.reshape(-1)
    across, down = tabulate(g, out.shape[1], row_low, row_high - row_low)
    quad, deltas = np.empty((4, CORNER)), np.empty(4)
    sides, planes, steps = np.empty((5, 4)), np.empty((2, 3)), np.empty((2, 4))
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        tile = tiles[n, 3] // TILE * ends.shape[1] + tiles[n, 0] // TILE
        for k in range(flat_ends[tile - 1] if tile > 0 else 0, flat_ends[tile]):
            take_part(g, parts, k, quad, deltas)
            mark = SURE if near[k] == CAP else UNSURE
            draw_quad(
                g, across, down, quad, deltas, row_low, first, end, keep, mark, near[k] == 1,
                sides, planes, steps, out, out_edge, out_mask,
            )  # fmt: skip


@kernel
def bound_tiles(
    g: Geometry, disparity: F4, links: U1, parts: F4, ends: I4, height: int, low: int, high: int,
    out_tiles: I4,
) -> None:  # fmt: skip
    """Rows of the desired view that tiles [low, high) reach: columns 6 and 7 of their table.

    Args:
        g: geometry.
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        parts: (CORNERS, n) of broken cells.
        ends: (tiles down, tiles across) of parts.
        height: of the desired view.
        low: first tile to do.
        high: tile after the last.
        out_tiles: (n, FIELDS); the first six columns are read.
    """
    rows, stride = disparity.shape
    flat_ends = ends.reshape(-1)
    above, below = np.empty((TILE + 1, CORNER)), np.empty((TILE + 1, CORNER))
    quad, deltas = np.empty((4, CORNER)), np.empty(4)
    for n in range(low, high):
        first, end = height, 0
        u_low = out_tiles[n, 0]
        count = min(out_tiles[n, 1], stride - 1) - u_low
        for v in range(out_tiles[n, 3], min(out_tiles[n, 4], rows - 1)):
            land_cells(g, disparity, v, u_low, count + 1, above)
            land_cells(g, disparity, v + 1, u_low, count + 1, below)
            for i in range(count):
                if links[v, u_low + i] & INTACT:
                    take_cell(above, below, disparity, v, u_low + i, i, quad, deltas)
                    _, _, top, bottom = bounds(g, quad, 0.5)
                    first, end = min(first, top), max(end, bottom + 1)
        tile = out_tiles[n, 3] // TILE * ends.shape[1] + out_tiles[n, 0] // TILE
        for k in range(flat_ends[tile - 1] if tile > 0 else 0, flat_ends[tile]):
            take_part(g, parts, k, quad, deltas)
            _, _, top, bottom = bounds(g, quad, 0.5)
            first, end = min(first, top), max(end, bottom + 1)
        out_tiles[n, 6], out_tiles[n, 7] = max(first, 0), min(end, height)
