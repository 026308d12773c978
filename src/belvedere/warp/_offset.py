"""Kernels of the offset-buffer reconstructor: visibility in a finer grid, then one filter.

Colours are linear and have four channels (RGBA, or RGB and padding), so that one sample is one
vector register.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import intact, joined, slope_toward, usable

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U2 = npt.NDArray[np.uint16]
Four = tuple[Real, Real, Real, Real]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
SPARE = np.float32(1.2)
"""Sub-samples along a cell's side, for each that covering needs: with none to spare, predictions of
photographs lose 0.4 dB; with more, little is gained."""


@inner
def mix(color: F4, v: int, u: int, w00: Real, w01: Real, w10: Real, w11: Real) -> Four:
    """Weighted mean of the four samples of cell (v, u)."""
    return (
        w00 * color[v, u, 0] + w01 * color[v, u + 1, 0]
        + w10 * color[v + 1, u, 0] + w11 * color[v + 1, u + 1, 0],
        w00 * color[v, u, 1] + w01 * color[v, u + 1, 1]
        + w10 * color[v + 1, u, 1] + w11 * color[v + 1, u + 1, 1],
        w00 * color[v, u, 2] + w01 * color[v, u + 1, 2]
        + w10 * color[v + 1, u, 2] + w11 * color[v + 1, u + 1, 2],
        w00 * color[v, u, 3] + w01 * color[v, u + 1, 3]
        + w10 * color[v + 1, u, 3] + w11 * color[v + 1, u + 1, 3],
    )  # fmt: skip


@inner
def lattice_size(need: Real, largest: int) -> int:
    """The whole number of sub-samples for a need of so many, 1 to ``largest``."""
    if not need < np.float32(largest):
        return largest
    return max(int(np.ceil(need)), 1)


@inner
def cell_lattice(
    w: F4, u: Real, v: Real, du: Real, dv: Real, d00: Real, d01: Real, d10: Real,
    d11: Real, scale_b: Real, first: Real, end: Real, columns: int, largest: int,
) -> tuple[int, int]:  # fmt: skip
    """Sub-samples along u and v that leave no cell of the warp buffer empty inside this one.

    Any translate of a lattice's parallelogram holds a point of the lattice, so every cell of the
    buffer holds one if the parallelogram's bounding box is no larger than a cell: along x and along
    y the two spacings add up to at most one. (For a square turned by 45 degrees that is the known
    1/sqrt(2).) A fifth more along each side gives cells a choice, see `claim`.

    Args:
        w: (12,) warp matrix.
        u: column of the corner with disparity d00.
        v: its row.
        du: +1 or -1, toward d01.
        dv: +1 or -1, toward d10.
        d00: disparities of the four corners.
        d01: ...
        d10: ...
        d11: ...
        scale_b: cells per output pixel.
        first: first row of cells that counts, as in `claim`.
        end: row after the last.
        columns: of the buffer.
        largest: upper bound, and the answer for a cell that reaches behind the eye.

    Returns:
        How many along u and along v; 0 where the cell misses those rows, or the buffer, altogether.

    Source: spec offset-buffer-warping 3.3 (the bound for rotated lattices).
    """
    r0 = w[0] * u + w[1] * v + w[2]
    s0 = w[4] * u + w[5] * v + w[6]
    t0 = w[8] * u + w[9] * v + w[10]
    ta, tb = t0 + w[11] * d00, t0 + du * w[8] + w[11] * d01
    tc, td = t0 + dv * w[9] + w[11] * d10, t0 + du * w[8] + dv * w[9] + w[11] * d11
    low = min(ta, tb, tc, td)
    if not low > ZERO:
        most = largest if max(ta, tb, tc, td) > ZERO else 0
        return most, most
    xa, ya = (r0 + w[3] * d00) / ta, (s0 + w[7] * d00) / ta
    xb, yb = (r0 + du * w[0] + w[3] * d01) / tb, (s0 + du * w[4] + w[7] * d01) / tb
    xc, yc = (r0 + dv * w[1] + w[3] * d10) / tc, (s0 + dv * w[5] + w[7] * d10) / tc
    xd = (r0 + du * w[0] + dv * w[1] + w[3] * d11) / td
    yd = (s0 + du * w[4] + dv * w[5] + w[7] * d11) / td
    ab = (xb - xa) * (xb - xa) + (yb - ya) * (yb - ya)
    cd = (xd - xc) * (xd - xc) + (yd - yc) * (yd - yc)
    ac = (xc - xa) * (xc - xa) + (yc - ya) * (yc - ya)
    bd = (xd - xb) * (xd - xb) + (yd - yb) * (yd - yb)
    along_u, along_v = np.sqrt(max(ab, cd)), np.sqrt(max(ac, bd))
    # sub-samples lie between the corners, but for float32: its noise grows with the cell
    slack = ONE + np.float32(0.01) * max(along_u, along_v)
    if (
        (max(xa, xb, xc, xd) + ONE + slack) * scale_b < ZERO
        or (min(xa, xb, xc, xd) + ONE - slack) * scale_b > np.float32(columns)
        or (max(ya, yb, yc, yd) + ONE + slack) * scale_b < first
        or (min(ya, yb, yc, yd) + ONE - slack) * scale_b > end
    ):
        return 0, 0
    # extents of the two sides in cells, the larger of opposite ones
    ux = scale_b * max(abs(xb - xa), abs(xd - xc))
    uy = scale_b * max(abs(yb - ya), abs(yd - yc))
    vx = scale_b * max(abs(xc - xa), abs(xd - xb))
    vy = scale_b * max(abs(yc - ya), abs(yd - yb))
    nu = lattice_size(max(ux + uy, SPARE * scale_b * along_u), largest)
    nv = lattice_size(max(vx + vy, SPARE * scale_b * along_v), largest)
    nu4, nv4 = np.float32(nu), np.float32(nv)
    excess = max(ux / nu4 + vx / nv4, uy / nu4 + vy / nv4)
    if excess > ONE:  # a sheared cell
        nu, nv = lattice_size(nu4 * excess, largest), lattice_size(nv4 * excess, largest)
    return nu, nv


@inner
def lay_lattice(nu: int, nv: int, u_step: int, v_step: int, out_fu: F4, out_fv: F4) -> None:
    """Places of a whole cell's sub-samples, in the order in which they are visited."""
    for j in range(nv):
        fv = (np.float32(j if v_step > 0 else nv - 1 - j) + HALF) / np.float32(nv)
        for i in range(nu):
            fu = (np.float32(i if u_step > 0 else nu - 1 - i) + HALF) / np.float32(nu)
            out_fu[j * nu + i] = fu
            out_fv[j * nu + i] = fv


@inner
def land_lattice(
    w: F4, u4: Real, v4: Real, d00: Real, d01: Real, d10: Real, d11: Real, scale_b: Real,
    bits: int, row_first: int, first: Real, end: Real, columns: int, count: int,
    fus: F4, fvs: F4, out_cell: I4, out_delta: F4, out_place: I4,
) -> None:  # fmt: skip
    """Cell (or -1), warped disparity and place in the cell of every sub-sample of a whole cell.

    Disparity is bilinear. Straight-line arithmetic on purpose: it vectorises.
    """
    places, right = np.float32(1 << bits), np.float32(columns)
    low, wide, shift = np.int32(row_first), np.int32(columns), np.int32(bits)
    for k in range(count):
        fu, fv = fus[k], fvs[k]
        u, v = u4 + fu, v4 + fv
        left = d00 + fv * (d10 - d00)
        delta = left + fu * (d01 + fv * (d11 - d01) - left)
        t = w[8] * u + w[9] * v + w[10] + w[11] * delta
        scale = ONE / t
        x = ((w[0] * u + w[1] * v + w[2] + w[3] * delta) * scale + ONE) * scale_b
        y = ((w[4] * u + w[5] * v + w[6] + w[7] * delta) * scale + ONE) * scale_b
        inside = (t > ZERO) & (x >= ZERO) & (y >= first) & (x < right) & (y < end)
        x = x if inside else ZERO
        y = y if inside else ZERO
        column, row = np.int32(x), np.int32(y)
        qu = np.int32((x - np.float32(column)) * places)
        qv = np.int32((y - np.float32(row)) * places)
        cell = (row - low) * wide + column
        out_cell[k] = cell if inside else np.int32(-1)
        out_delta[k] = delta * scale
        out_place[k] = (qv << shift) | qu


@inner
def claim(
    cell: int, warped: Real, place: int, by_order: bool, keep: Real, eccentricity: I4,
    out_disparity: F4, out_offset: U1,
) -> bool:  # fmt: skip
    """Whether a sub-sample becomes what its cell sees; notes its disparity and place if so.

    Of several on one surface a cell keeps the one nearest its middle: the first or the last would
    lie toward one side of every cell, and the whole picture with them. Selects instead of branches
    on purpose: which of them wins is noise to a branch predictor. An empty cell holds -1.

    Args:
        cell: flat index of the cell.
        warped: the sub-sample's disparity.
        place: its place in the cell.
        by_order: later surfaces win; otherwise the larger disparity.
        keep: ratio of two disparities from which on they are one surface.
        eccentricity: squared distance of each place from the cell's middle.
        out_disparity: (cells,).
        out_offset: (cells,).
    """
    held, old = out_disparity[cell], out_offset[cell]
    nearer = warped > held
    low, high = (held, warped) if nearer else (warped, held)
    same = low >= high * keep
    central = eccentricity[place] < eccentricity[old]
    wins = central if same else (nearer | by_order)
    out_disparity[cell] = warped if wins else held
    out_offset[cell] = place if wins else old
    return wins


@inner
def fill_whole_cell(
    color: F4, v: int, u: int, count: int, by_order: bool, keep: Real, eccentricity: I4,
    fus: F4, fvs: F4, cells: I4, deltas: F4, places: I4, owner: U2,
    out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Let the sub-samples of an intact cell claim theirs, then colour those still standing."""
    for k in range(count):
        cell = cells[k]
        if cell >= 0:
            wins = claim(
                cell, deltas[k], places[k], by_order, keep, eccentricity, out_disparity, out_offset
            )
            owner[cell] = k if wins else owner[cell]
            cells[k] = cell if wins else -1
    for k in range(count):
        cell = cells[k]
        if cell < 0 or owner[cell] != k:  # did not win its cell, or lost it since
            continue
        fu, fv = fus[k], fvs[k]
        c0, c1, c2, c3 = mix(
            color, v, u, (ONE - fu) * (ONE - fv), fu * (ONE - fv), (ONE - fu) * fv, fu * fv
        )
        out_color[cell, 0] = c0
        out_color[cell, 1] = c1
        out_color[cell, 2] = c2
        out_color[cell, 3] = c3


@inner
def fill_quarter_cell(
    w: F4, color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int, density: int,
    largest: int, scale_b: Real, bits: int, row_first: int, first: Real, end: Real, columns: int,
    by_order: bool, keep: Real, eccentricity: I4,
    out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Sub-samples of the quarter that (v, u) owns of a broken cell toward (dv, du), each +-1."""
    across = slope_toward(disparity, links, v, u, 0, du)
    along = slope_toward(disparity, links, v, u, dv, 0)
    tied_u, tied_v = joined(links, v, u, 0, du), joined(links, v, u, dv, 0)
    own = disparity[v, u]
    nu, nv = density, density
    if density == 0:
        nu, nv = cell_lattice(
            w, np.float32(u), np.float32(v), np.float32(du), np.float32(dv),
            own, own + across, own + along, own + across + along, scale_b, first, end, columns,
            largest,
        )  # fmt: skip
    # a quarter holds half the lattice of a cell along each axis
    for j in range((nv + 1) // 2):
        fv = (np.float32(j) + HALF) / np.float32(nv + (nv & 1))
        v4 = np.float32(v) + np.float32(dv) * fv
        for i in range((nu + 1) // 2):
            fu = (np.float32(i) + HALF) / np.float32(nu + (nu & 1))
            u4 = np.float32(u) + np.float32(du) * fu
            delta = max(own + fu * across + fv * along, ZERO)
            t = w[8] * u4 + w[9] * v4 + w[10] + w[11] * delta
            if not t > ZERO:
                continue
            scale = ONE / t
            x = ((w[0] * u4 + w[1] * v4 + w[2] + w[3] * delta) * scale + ONE) * scale_b
            y = ((w[4] * u4 + w[5] * v4 + w[6] + w[7] * delta) * scale + ONE) * scale_b
            if not (x >= ZERO and y >= first and x < np.float32(columns) and y < end):
                continue
            column, row, size = int(x), int(y), np.float32(1 << bits)
            qu = int((x - np.float32(column)) * size)
            qv = int((y - np.float32(row)) * size)
            cell = (row - row_first) * columns + column
            if not claim(
                cell, delta * scale, (qv << bits) | qu, by_order, keep, eccentricity,
                out_disparity, out_offset,
            ):  # fmt: skip
                continue
            for k in range(4):
                value = color[v, u, k]
                if tied_u:
                    value += fu * (color[v, u + du, k] - color[v, u, k])
                if tied_v:
                    value += fv * (color[v + dv, u, k] - color[v, u, k])
                out_color[cell, k] = value


@kernel
def fill_offset_buffer(
    w: F4, color: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int,
    height: int, density: int, largest: int, scale_b: int, bits: int, by_order: bool,
    tolerance: Real, out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Warp every sub-sample that can reach the band into its warp buffer.

    Rows of cells count from one output pixel above the whole desired view, and positions are
    rounded before the band comes in, so that they are the same for every band.

    Args:
        w: (12,) warp matrix.
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS).
        row_low: first row of the band.
        row_high: row after its last.
        height: of the desired view.
        density: sub-samples per pixel and axis (the paper's a), even; 0: what each cell needs.
        largest: upper bound of what a cell may need.
        scale_b: cells per output pixel and axis (b), even.
        bits: of a place within a cell, per axis (o).
        by_order: later surfaces win; otherwise the larger disparity.
        tolerance: relative difference in disparity up to which sub-samples are on one surface.
        out_color: (cells_v * cells_u, 4).
        out_disparity: (cells_v, cells_u), preset to -1.
        out_offset: (cells_v, cells_u) place within the cell, ``qv << bits | qu``.
    """
    b4, row_first = np.float32(scale_b), row_low * scale_b
    keep = np.float32(1.0 - tolerance)
    rows, columns = out_disparity.shape
    row_end = row_first + rows
    flat, flat_offset = out_disparity.reshape(-1), out_offset.reshape(-1)
    eccentricity = np.zeros(256, np.int32)  # for any byte: empty cells hold whatever was there
    mask = (1 << bits) - 1
    for place in range(1 << (2 * bits)):
        off_u, off_v = 2 * (place & mask) - mask, 2 * (place >> bits) - mask
        eccentricity[place] = off_u * off_u + off_v * off_v
    most = max(density, largest)
    fus, fvs = np.empty(most * most, np.float32), np.empty(most * most, np.float32)
    cells, deltas = np.empty(most * most, np.int32), np.empty(most * most, np.float32)
    places = np.empty(most * most, np.int32)
    owner = np.zeros(rows * columns, np.uint16)
    nu, nv, laid_nu, laid_nv, laid_u, laid_v = density, density, 0, 0, 0, 0
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        # what float32 lands outside the tile's float64 bounds is noise: the same for every band
        first = max((tiles[n, 6] + 1) * scale_b, row_first) if tiles[n, 6] > 0 else row_first
        end = min(tiles[n, 7] * scale_b, row_end) if tiles[n, 7] < height else row_end
        first4, end4 = np.float32(first), np.float32(end)
        u_step, v_step = tiles[n, 2], tiles[n, 5]
        u_first = tiles[n, 0] - 1 if tiles[n, 0] == 0 else tiles[n, 0]
        v_first = tiles[n, 3] - 1 if tiles[n, 3] == 0 else tiles[n, 3]
        for j in range(tiles[n, 4] - v_first):
            v = v_first + j if v_step > 0 else tiles[n, 4] - 1 - j
            for i in range(tiles[n, 1] - u_first):
                u = u_first + i if u_step > 0 else tiles[n, 1] - 1 - i
                if intact(disparity, links, v, u):
                    u4, v4 = np.float32(u), np.float32(v)
                    d00, d01 = disparity[v, u], disparity[v, u + 1]
                    d10, d11 = disparity[v + 1, u], disparity[v + 1, u + 1]
                    if density == 0:
                        nu, nv = cell_lattice(
                            w, u4, v4, ONE, ONE, d00, d01, d10, d11, b4, first4, end4, columns,
                            largest,
                        )  # fmt: skip
                    if nu == 0:
                        continue
                    if nu != laid_nu or nv != laid_nv or u_step != laid_u or v_step != laid_v:
                        lay_lattice(nu, nv, u_step, v_step, fus, fvs)
                        laid_nu, laid_nv, laid_u, laid_v = nu, nv, u_step, v_step
                    land_lattice(
                        w, u4, v4, d00, d01, d10, d11, b4, bits, row_first, first4, end4, columns,
                        nu * nv, fus, fvs, cells, deltas, places,
                    )  # fmt: skip
                    fill_whole_cell(
                        color, v, u, nu * nv, by_order, keep, eccentricity, fus, fvs, cells,
                        deltas, places, owner, out_color, flat, flat_offset,
                    )  # fmt: skip
                    continue
                for corner in range(4):
                    dv = corner >> 1 if v_step > 0 else 1 - (corner >> 1)
                    du = corner & 1 if u_step > 0 else 1 - (corner & 1)
                    if usable(disparity, links, v + dv, u + du):
                        fill_quarter_cell(
                            w, color, disparity, links, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du,
                            density, largest, b4, bits, row_first, first4, end4, columns,
                            by_order, keep, eccentricity, out_color, flat, flat_offset,
                        )  # fmt: skip


@kernel
def resolve_offset_buffer(
    cell_color: F4, cell_disparity: F4, cell_offset: U1, weights: F4, scale_b: int, bits: int,
    tolerance: Real, out_color: F4, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Filter the visible sub-samples into output pixels.

    Args:
        cell_color: (rows * b + b, width * b + b, 4), half a pixel of margin on every side.
        cell_disparity: same grid; -1 is an empty cell.
        cell_offset: same grid.
        weights: (2 b 2^bits, 2 b 2^bits) filter at the resolution of the offsets, by v then u.
        scale_b: cells per pixel and axis.
        bits: of a place within a cell, per axis.
        tolerance: relative difference in disparity up to which cells are one surface.
        out_color: (rows, width, 4).
        out_disparity: (rows, width), the surface with more weight; -1 = uncovered.
        out_coverage: (rows, width), share of the pixel's own cells that were hit.
    """
    rows, width = out_disparity.shape
    half, mask = scale_b // 2, (1 << bits) - 1
    share = ONE / np.float32(scale_b * scale_b)
    keep = np.float32(1.0 - tolerance)
    for y in range(rows):
        for x in range(width):
            front, hit = np.float32(-1.0), 0
            for j in range(half, half + scale_b):
                for i in range(half, half + scale_b):
                    delta = cell_disparity[y * scale_b + j, x * scale_b + i]
                    hit += 1 if delta >= ZERO else 0
                    front = max(front, delta)
            out_coverage[y, x] = np.float32(hit) * share
            out_disparity[y, x] = np.float32(-1.0)
            if hit == 0:
                out_color[y, x, :] = ZERO
                continue
            limit = front * keep
            c0, c1, c2, c3 = ZERO, ZERO, ZERO, ZERO
            near, far, near_delta, far_delta = ZERO, ZERO, ZERO, ZERO
            for j in range(2 * scale_b):
                row = y * scale_b + j
                for i in range(2 * scale_b):
                    column = x * scale_b + i
                    delta = cell_disparity[row, column]
                    place = np.int64(cell_offset[row, column])
                    if delta < ZERO:
                        continue
                    weight = weights[(j << bits) + (place >> bits), (i << bits) + (place & mask)]
                    if delta >= limit:
                        near += weight
                        near_delta += weight * delta
                    else:
                        far += weight
                        far_delta += weight * delta
                    c0 += weight * cell_color[row, column, 0]
                    c1 += weight * cell_color[row, column, 1]
                    c2 += weight * cell_color[row, column, 2]
                    c3 += weight * cell_color[row, column, 3]
            scale = ONE / (near + far)
            out_color[y, x, 0] = c0 * scale
            out_color[y, x, 1] = c1 * scale
            out_color[y, x, 2] = c2 * scale
            out_color[y, x, 3] = c3 * scale
            out_disparity[y, x] = near_delta / near if near >= far else far_delta / far
