"""Kernels that scan-convert a reference's surface: which disparity each desired pixel sees.

Cells of four samples are two small triangles of disparity; cells with an edge through them are
drawn in parts (`_parts`). Colours are looked up later, backwards through the disparity (`_lookup`).

The lowest bit of a disparity says how sure it is: 1 where it was drawn from a part, between two
surfaces, where the true edge may run on either side; 0 inside a surface.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import bits16, bits_of, float_of, load16
from belvedere.warp._edges import INTACT, RIM, list_set
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
NAN = np.float32(np.nan)
SLACK = np.float32(-1e-4)
"""Barycentric slack of the inside test: neighbouring triangles may both paint a shared edge, but
never leave a pixel between them. A hundred float32 roundings."""
REACH = np.float32(1e-3)
"""Pixels by which a cell's bounds are widened, for the same reason."""
LARGEST_CELL = np.float32(64.0)
"""Pixels a single cell may grow to. More is not a reconstruction but a guess from one sample, and
would let a sample near the eye paint the whole view."""
HOLE = np.float32(-1.0)
RUN = TILE
"""Cells of a run, at most."""
SURE, UNSURE = np.uint32(0), np.uint32(1)


@inner
def marked(delta: Real, mark: Real) -> Real:
    """The disparity with its lowest bit set to ``mark``: `SURE` or `UNSURE`."""
    return float_of(np.uint32((bits_of(delta) & ~UNSURE) | mark))


@inner
def is_unsure(delta: Real) -> bool:
    """Whether a disparity was drawn at an edge."""
    return np.uint32(bits_of(delta) & UNSURE) != 0


@inner
def is_cut(edge: Real) -> bool:
    """Whether an edge is known to run through a pixel, from what it holds of `out_edge`."""
    return is_unsure(edge) & (edge >= ZERO)


@inner
def up(x: Real) -> int:
    """The whole number next above, of x >= 0; `np.ceil` of one number is a function call."""
    whole = int(x)
    return whole + 1 if np.float32(whole) < x else whole


@inner
def land_row(
    w: F4, disparity: F4, v: int, u_low: int, count: int, ramp: F4, out_x: F4, out_y: F4, out_z: F4
) -> None:
    """Where ``count`` samples of row v from column u_low on land, and their warped disparities.

    NaN behind the eye. ramp is 0, 1, 2, ...: counting in whole numbers does not vectorise well.
    """
    row = disparity[v, u_low:]
    v4, u4 = np.float32(v), np.float32(u_low)
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for i in range(count):
        u, delta = u4 + ramp[i], row[i]
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t if t > ZERO else NAN
        out_x[i] = (w[0] * u + r0 + w[3] * delta) * scale
        out_y[i] = (w[4] * u + s0 + w[7] * delta) * scale
        out_z[i] = delta * scale


@inner
def misses_rows(ya: F4, yb: F4, count: int, first: int, end: int) -> bool:
    """Whether no cell between two rows of samples, which land at ya and yb, meets the rows.

    In whole numbers, whose least and greatest are found many at once.
    """
    low, high, strange = np.int32(1 << 30), np.int32(-(1 << 30)), np.int32(0)
    for i in range(count):
        a, b = ya[i], yb[i]
        good = abs(a) + abs(b) < np.float32(1e9)  # neither behind the eye nor missing
        upper, lower = np.int32(a if good else ZERO), np.int32(b if good else ZERO)
        low = min(low, upper, lower)
        high = max(high, upper, lower)
        strange |= np.int32(not good)
    return bool(strange == 0) and bool(high + 2 < first or low - 2 > end)


@inner
def test_quads(
    xa: F4, ya: F4, za: F4, xb: F4, yb: F4, zb: F4, xc: F4, yc: F4, zc: F4, xd: F4, yd: F4, zd: F4,
    drawn: U1, mark: Real, width: int, row_low: int, first: int, end: int,
    out_corner: F4, out_z: F4, out_place: I4, out_hits: I4, out_span: I4,
) -> None:  # fmt: skip
    """Which of the first 2 x 2 pixel centres in its bounds each of RUN quads covers.

    A quad mostly holds one centre or none, so many are tested at once. Straight-line arithmetic on
    purpose: it vectorises. The areas that a centre spans with the four edges and the disparity are
    affine: they are computed at the upper left centre and stepped to the other three. A quad is two
    triangles of disparity, folded along the diagonal from b to c.

    Args:
        xa: (RUN,) where the upper left corners land.
        ya: ...
        za: their warped disparities.
        xb: the upper right corners ...
        yb: ...
        zb: ...
        xc: the lower left ...
        yc: ...
        zc: ...
        xd: the lower right ...
        yd: ...
        zd: ...
        drawn: (RUN,) 0 where there is nothing to draw.
        mark: lowest bit of the disparities, `SURE` or `UNSURE`.
        width: of the desired view.
        row_low: first row of the band.
        first: first row to paint.
        end: row after the last.
        out_corner: (2, RUN) column and row of the upper left centre.
        out_z: (5, RUN) disparity at the four centres, -1 where the quad does not cover one or has
            more of them; then that of the first it covers.
        out_place: (2, RUN) flat index in the band of the upper left centre, which may lie outside;
            and of the first that is covered, if any is.
        out_hits: (RUN,) how many are covered.
        out_span: (RUN,) centres across and down, the larger, at least 3 for a quad that is bent; 0
            for none; -1 for a quad that is not drawn, behind the eye, or too large.
    """
    right, top_most = np.float32(width - 1), np.float32(first)
    bottom = np.float32(end - 1)
    columns, rows = np.uint32(width), np.uint32(end - first)
    for i in range(RUN):
        x00, x01, x10, x11 = xa[i], xb[i], xc[i], xd[i]
        y00, y01, y10, y11 = ya[i], yb[i], yc[i], yd[i]
        x_low, x_high = min(x00, x01, x10, x11), max(x00, x01, x10, x11)
        y_low, y_high = min(y00, y01, y10, y11), max(y00, y01, y10, y11)
        left, top = np.ceil(x_low - REACH), np.ceil(y_low - REACH)
        across, down = np.floor(x_high + REACH) - left, np.floor(y_high + REACH) - top
        total = x00 + x01 + x10 + x11
        whole = total - total == ZERO  # no corner is behind the eye
        outside = (left + across < ZERO) | (left > right)
        outside |= (top + down < top_most) | (top > bottom)
        span = max(across, down) + ONE
        small = whole & (span <= LARGEST_CELL) & (drawn[i] != 0)
        fits = small & (across >= ZERO) & (down >= ZERO) & (not outside)
        # edges a to b, a to c, d to b, d to c: two triangles, a b c and d c b
        bx, by, cx, cy = x01 - x00, y01 - y00, x10 - x00, y10 - y00
        ex, ey, fx, fy = x01 - x11, y01 - y11, x10 - x11, y10 - y11
        area, other = bx * cy - cx * by, fx * ey - ex * fy
        convex = (area > ZERO) & (other > ZERO)
        convex &= (by * ex - bx * ey > ZERO) & (cx * fy - cy * fx > ZERO)
        facing = (area > ZERO) | (other > ZERO)
        few = fits & convex & (span <= TWO)
        # one of its triangles turns away, or it has a dent: each triangle by itself
        span = span if convex or not facing else max(span, np.float32(3.0))
        out_span[i] = np.int32(span) if fits else (np.int32(0) if small else np.int32(-1))
        left, top = left if fits else ZERO, top if fits else ZERO
        out_corner[0, i], out_corner[1, i] = left, top
        px, py, qx, qy = left - x00, top - y00, left - x11, top - y11
        # twice the areas that a centre spans with each edge: inside, all are positive
        ab, ac = bx * py - by * px, cy * px - cx * py
        dc, db = fx * qy - fy * qx, ey * qx - ex * qy
        scale = ONE / area
        zb4, zc4 = (zb[i] - za[i]) * scale, (zc[i] - za[i]) * scale
        plane = za[i] + ac * zb4 + ab * zc4
        plane_x, plane_y = cy * zb4 - by * zc4, bx * zc4 - cx * zb4
        # beyond the diagonal the other triangle's plane bends away from it
        beyond, beyond_x, beyond_y = area - ab - ac, by - cy, cx - bx
        bend = (plane_x * (x11 - x00) + plane_y * (y11 - y00) + za[i] - zd[i]) / other
        slack = SLACK * area
        slack2 = SLACK * other
        ab, ac, dc, db = ab - slack, ac - slack, dc - slack2, db - slack2
        column, row = np.int32(left), np.int32(top) - np.int32(first)
        in_left, in_right = np.uint32(column) < columns, np.uint32(column + np.int32(1)) < columns
        in_top, in_bottom = np.uint32(row) < rows, np.uint32(row + np.int32(1)) < rows
        in_top, in_bottom = in_top & few, in_bottom & few
        hit0 = (min(ab, ac, dc, db) >= ZERO) & in_left & in_top
        z0 = max(plane + bend * min(beyond, ZERO), ZERO)
        ab1, ac1, dc1, db1 = ab - by, ac + cy, dc - fy, db + ey
        hit1 = (min(ab1, ac1, dc1, db1) >= ZERO) & in_right & in_top
        z1 = max(plane + plane_x + bend * min(beyond + beyond_x, ZERO), ZERO)
        hit2 = (min(ab + bx, ac - cx, dc + fx, db - ex) >= ZERO) & in_left & in_bottom
        plane, beyond = plane + plane_y, beyond + beyond_y
        z2 = max(plane + bend * min(beyond, ZERO), ZERO)
        hit3 = (min(ab1 + bx, ac1 - cx, dc1 + fx, db1 - ex) >= ZERO) & in_right & in_bottom
        z3 = max(plane + plane_x + bend * min(beyond + beyond_x, ZERO), ZERO)
        z0, z1 = marked(z0, mark) if hit0 else HOLE, marked(z1, mark) if hit1 else HOLE
        z2, z3 = marked(z2, mark) if hit2 else HOLE, marked(z3, mark) if hit3 else HOLE
        out_z[0, i], out_z[1, i], out_z[2, i], out_z[3, i] = z0, z1, z2, z3
        out_z[4, i] = z0 if hit0 else z1 if hit1 else z2 if hit2 else z3
        wide = np.int32(width)
        base = np.int32((np.int32(top) - np.int32(row_low)) * wide + column)
        step = (
            np.int32(0) if hit0 else np.int32(1) if hit1 else wide if hit2 else wide + np.int32(1)
        )
        out_place[0, i] = base
        out_place[1, i] = base + np.int32(step) if hit0 | hit1 | hit2 | hit3 else np.int32(0)
        out_hits[i] = np.int32(hit0) + np.int32(hit1) + np.int32(hit2) + np.int32(hit3)


@inner
def paint_quads(z: F4, place: I4, hits: I4, width: int, more: U1, listed: I4, flat: F4) -> None:
    """The nearer of what is there and what `test_quads` found; -1 changes nothing.

    more and listed are (RUN,) to work in.
    """
    for i in range(RUN):
        more[i] = np.uint8(hits[i] > 1)
    for i in range(RUN):
        at = np.uint32(place[1, i])
        flat[at] = max(flat[at], z[4, i])
    for k in range(list_set(more, listed)):
        i = listed[k]
        for n in range(1, 4):
            if z[n, i] >= ZERO:
                at = np.uint32(place[0, i] + (n & 1) + (n >> 1) * width)
                flat[at] = max(flat[at], z[n, i])


@inner
def draw_triangle(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    left: int, right: int, top: int, bottom: int, row_low: int, mark: Real, out: F4,
) -> None:  # fmt: skip
    """Disparity at the pixel centres of a triangle that turns from a to b to c as the picture does.

    Disparity is affine on the desired view too, so the triangle's plane is kept exactly.
    """
    bx, by, cx, cy = xb - xa, yb - ya, xc - xa, yc - ya
    area = bx * cy - cx * by
    if not area > ZERO:  # seen from behind, or edge on
        return
    scale = ONE / area
    zb, zc = zb - za, zc - za
    for y in range(top, bottom + 1):
        py = np.float32(y) - ya
        for x in range(left, right + 1):
            px = np.float32(x) - xa
            wb, wc = (px * cy - cx * py) * scale, (bx * py - px * by) * scale
            if min(wb, wc, ONE - wb - wc) < SLACK:
                continue
            z = max(za + wb * zb + wc * zc, ZERO)
            if z > out[y - row_low, x]:
                out[y - row_low, x] = marked(z, mark)


@inner
def note_part(
    x: int, row: int, bits: Real, z: Real, z_high: Real, keep: Real, mark: Real, out_edge: F4,
    out_mask: U2,
) -> None:  # fmt: skip
    """Add what a cell covers of one pixel to what is known of its nearest surface there."""
    held = out_edge[row, x]
    if bits == 0:  # too thin for a place, but an edge does run through the pixel
        if mark == UNSURE and z_high >= held * keep:
            if held < ZERO:
                out_mask[row, x] = 0
                held = z
            out_edge[row, x] = marked(held, mark)
    elif z * keep > held:
        out_edge[row, x] = marked(z, mark)
        out_mask[row, x] = bits
    elif z >= held * keep:
        out_edge[row, x] = marked(max(z, held), mark | (bits_of(held) & UNSURE))
        out_mask[row, x] |= bits


@inner
def mask_quad(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    xd: Real, yd: Real, width: int, row_low: int, first: int, end: int, keep: Real, mark: Real,
    steps: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """Which of sixteen places in each pixel a cell covers, of the nearest surface there.

    A surface that is clearly nearer than what the pixel holds starts its mask anew; one clearly
    behind leaves no trace. Corners are a, b above and c, d below; disparity is that of the plane
    through a, b and c, at the pixel's centre or the nearest corner. It is marked `UNSURE` as soon
    as a part of a broken cell is among what the pixel holds: else no edge runs through it, and an
    intact cell leaves it alone. steps is (4, 16) to work in.
    """
    bx, by, cx, cy = xb - xa, yb - ya, xc - xa, yc - ya
    area = bx * cy - cx * by
    if not area > ZERO or not (xd - xc) * (yd - yb) - (xd - xb) * (yd - yc) > ZERO:
        return
    x_high, y_high = max(xa, xb, xc, xd) + HALF, max(ya, yb, yc, yd) + HALF
    if x_high < ZERO or y_high < ZERO:
        return
    left = up(max(min(xa, xb, xc, xd) - HALF, ZERO))
    right = int(min(x_high, np.float32(width - 1)))
    top = up(max(min(ya, yb, yc, yd) - HALF, np.float32(first)))
    bottom = int(min(y_high, np.float32(end - 1)))
    if mark == SURE:
        cut = False
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                cut |= is_cut(out_edge[y - row_low, x])
        if not cut:
            return
    scale = ONE / area
    zb, zc = zb - za, zc - za
    z_low, z_high = min(za, za + zb, za + zc, za + zb + zc), max(za, za + zb, za + zc, za + zb + zc)
    # edges a to b, b to d, d to c, c to a: inside is to the right of each
    dx, dy, ex, ey = xd - xb, yd - yb, xc - xd, yc - yd
    slack = SLACK * area
    for k in range(16):  # from the pixel's centre to its places, along the normals of the edges
        mirrored = (k & 1) * 8 + (k & 2) * 2 + (k & 4) // 2 + (k & 8) // 8
        ox = (np.float32(k) - np.float32(7.5)) * np.float32(0.0625)
        oy = (np.float32(mirrored) - np.float32(7.5)) * np.float32(0.0625)
        steps[0, k], steps[1, k] = bx * oy - by * ox, dx * oy - dy * ox
        steps[2, k], steps[3, k] = ex * oy - ey * ox, cy * ox - cx * oy
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            px, py = np.float32(x) - xa, np.float32(y) - ya
            qx, qy = np.float32(x) - xd, np.float32(y) - yd
            above, beside = bx * py - by * px - slack, dx * qy - dy * qx - slack
            below, before = ex * qy - ey * qx - slack, cy * px - cx * py - slack
            bits = np.uint32(bits16(load16(steps, 0), -above) & bits16(load16(steps, 4), -beside))
            bits = np.uint32(bits & bits16(load16(steps, 8), -below))
            bits = np.uint32(bits & bits16(load16(steps, 12), -before))
            wb, wc = (px * cy - cx * py) * scale, (bx * py - px * by) * scale
            z = max(min(max(za + wb * zb + wc * zc, z_low), z_high), ZERO)
            note_part(x, y - row_low, bits, z, z_high, keep, mark, out_edge, out_mask)


@inner
def draw_large(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    xd: Real, yd: Real, zd: Real, left: Real, top: Real, span: int, width: int, row_low: int,
    first: int, end: int, mark: Real, out: F4,
) -> None:  # fmt: skip
    """A quad that holds more than 2 x 2 pixel centres."""
    right = int(min(left + np.float32(span), np.float32(width))) - 1
    bottom = int(min(top + np.float32(span), np.float32(end))) - 1
    x_low, y_low = int(max(left, ZERO)), int(max(top, np.float32(first)))
    draw_triangle(
        xa, ya, za, xb, yb, zb, xc, yc, zc, x_low, right, y_low, bottom, row_low, mark, out
    )
    draw_triangle(
        xd, yd, zd, xc, yc, zc, xb, yb, zb, x_low, right, y_low, bottom, row_low, mark, out
    )


@inner
def land_parts(w: F4, parts: F4, begin: int, count: int, out_corners: F4) -> None:
    """Where the corners of ``count`` parts land: (12, RUN) x, y, disparity of each, NaN behind.

    In place, in an array of its own: so it vectorises.
    """
    w0, w1, w2, w3, w4, w5 = w[0], w[1], w[2], w[3], w[4], w[5]
    w6, w7, w8, w9, w10, w11 = w[6], w[7], w[8], w[9], w[10], w[11]
    first = np.uint64(begin)  # a signed sum might be an index from the end
    for k in range(12):
        for i in range(count):
            out_corners[k, i] = parts[k, first + np.uint64(i)]
    for c in range(4):
        for i in range(RUN):
            u, v, delta = (
                out_corners[3 * c, i],
                out_corners[3 * c + 1, i],
                out_corners[3 * c + 2, i],
            )
            t = w8 * u + w9 * v + w10 + w11 * delta
            scale = ONE / t if t > ZERO else NAN
            out_corners[3 * c, i] = (w0 * u + w1 * v + w2 + w3 * delta) * scale
            out_corners[3 * c + 1, i] = (w4 * u + w5 * v + w6 + w7 * delta) * scale
            out_corners[3 * c + 2, i] = delta * scale


@kernel
def draw_parts(
    w: F4, parts: F4, near: U1, ends: I4, tiles: I4, row_low: int, row_high: int, tolerance: Real,
    out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """As `draw_surface`, the parts of broken cells.

    parts is (CORNERS, n), near (n,) and ends (tiles down, tiles across), of `_parts`.
    """
    keep = ONE - np.float32(tolerance)
    width = out.shape[1]
    flat, flat_ends = out.reshape(-1), ends.reshape(-1)
    q = np.full((12, RUN), NAN, np.float32)
    corner, zs = np.zeros((2, RUN), np.float32), np.zeros((5, RUN), np.float32)
    places, hits, spans = (
        np.zeros((2, RUN), np.int32), np.zeros(RUN, np.int32), np.zeros(RUN, np.int32)
    )  # fmt: skip
    drawn, more = np.zeros(RUN, np.uint8), np.zeros(RUN, np.uint8)
    listed, steps = np.zeros(RUN, np.int32), np.zeros((4, 16), np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        tile = tiles[n, 3] // TILE * ends.shape[1] + tiles[n, 0] // TILE
        begin, close = int(flat_ends[tile - 1]) if tile > 0 else 0, int(flat_ends[tile])
        while begin < close:
            count = min(RUN, close - begin)
            land_parts(w, parts, begin, count, q)
            for i in range(RUN):
                drawn[i] = i < count
            test_quads(
                q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7], q[8], q[9], q[10], q[11], drawn,
                UNSURE, width, row_low, first, end, corner, zs, places, hits, spans,
            )  # fmt: skip
            paint_quads(zs, places, hits, width, more, listed, flat)
            for i in range(count):
                if spans[i] < 0:
                    continue
                if near[begin + i]:
                    mask_quad(
                        q[0, i], q[1, i], q[2, i], q[3, i], q[4, i], q[5, i], q[6, i], q[7, i],
                        q[8, i], q[9, i], q[10, i], width, row_low, first, end, keep, UNSURE,
                        steps, out_edge, out_mask,
                    )  # fmt: skip
                if spans[i] > 2:
                    draw_large(
                        q[0, i], q[1, i], q[2, i], q[3, i], q[4, i], q[5, i], q[6, i], q[7, i],
                        q[8, i], q[9, i], q[10, i], q[11, i], corner[0, i], corner[1, i], spans[i],
                        width, row_low, first, end, UNSURE, out,
                    )  # fmt: skip
            begin += count


@kernel
def draw_surface(
    w: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int, tolerance: Real,
    out: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """Disparity that each pixel of the band sees of the intact cells of one reference.

    Args:
        w: (12,) warp matrix.
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS), whole ones, in any order.
        row_low: first row of the band.
        row_high: row after its last.
        tolerance: relative difference in disparity up to which two cells are one surface.
        out: (rows, width) preset to -1.
        out_edge: (rows, width) nearest disparity of what was drawn at rims, preset to -1.
        out_mask: (rows, width) which sixteenths of the pixel it covers; read where out_edge >= 0.
    """
    keep = ONE - np.float32(tolerance)
    rows, stride = disparity.shape
    width = out.shape[1]
    flat = out.reshape(-1)
    ends = np.zeros((6, RUN + 1), np.float32)
    xa, ya, za, xb, yb, zb = ends[0], ends[1], ends[2], ends[3], ends[4], ends[5]
    corner, zs = np.zeros((2, RUN), np.float32), np.zeros((5, RUN), np.float32)
    places, hits, spans = (
        np.zeros((2, RUN), np.int32), np.zeros(RUN, np.int32), np.zeros(RUN, np.int32)
    )  # fmt: skip
    drawn, more = np.zeros(RUN, np.uint8), np.zeros(RUN, np.uint8)
    listed, steps = np.zeros(RUN, np.int32), np.zeros((4, 16), np.float32)
    ramp = np.arange(RUN + 1).astype(np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        straddles = tiles[n, 6] < row_low or tiles[n, 7] > row_high
        u_low = tiles[n, 0]
        across = min(tiles[n, 1], stride - 1) - u_low
        land_row(w, disparity, tiles[n, 3], u_low, across + 1, ramp, xb, yb, zb)
        for v in range(tiles[n, 3], min(tiles[n, 4], rows - 1)):
            for i in range(RUN + 1):
                xa[i], ya[i], za[i] = xb[i], yb[i], zb[i]
            land_row(w, disparity, v + 1, u_low, across + 1, ramp, xb, yb, zb)
            if straddles and misses_rows(ya, yb, across + 1, first, end):
                continue
            row = links[v, u_low:]
            for i in range(RUN):
                drawn[i] = row[i] & INTACT if i < across else 0
            test_quads(
                xa, ya, za, xa[1:], ya[1:], za[1:], xb, yb, zb, xb[1:], yb[1:], zb[1:], drawn,
                SURE, width, row_low, first, end, corner, zs, places, hits, spans,
            )  # fmt: skip
            paint_quads(zs, places, hits, width, more, listed, flat)
            for i in range(RUN):
                rim = i < across and row[i] & RIM != 0
                more[i] = np.uint8((rim & (spans[i] >= 0)) | (spans[i] > 2))
            for k in range(list_set(more, listed)):
                i = listed[k]
                if row[i] & RIM:
                    mask_quad(
                        xa[i], ya[i], za[i], xa[i + 1], ya[i + 1], za[i + 1], xb[i], yb[i], zb[i],
                        xb[i + 1], yb[i + 1], width, row_low, first, end, keep, SURE, steps,
                        out_edge, out_mask,
                    )  # fmt: skip
                if spans[i] > 2:
                    draw_large(
                        xa[i], ya[i], za[i], xa[i + 1], ya[i + 1], za[i + 1], xb[i], yb[i], zb[i],
                        xb[i + 1], yb[i + 1], zb[i + 1], corner[0, i], corner[1, i], spans[i],
                        width, row_low, first, end, SURE, out,
                    )  # fmt: skip
