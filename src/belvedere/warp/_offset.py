"""Kernels that fill the offset buffer: visibility in a grid finer than the picture.

Cells of four samples are taken a run at a time, all cells of one row of a tile: the lattice of
sub-samples is laid over the whole run, so that landing them is arithmetic on whole vectors, and
then each cell's sub-samples claim their places in the order of the sheet.

Colours are linear and have four channels (RGBA, or RGB and padding), so that one sample is one
vector register.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import add4, bits_of, float_of, load4, scale4, store4
from belvedere.warp._edges import INTACT, SMOOTH, joined, slope_toward, usable
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]
U8 = npt.NDArray[np.uint64]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
TWO, THREE = np.float32(2.0), np.float32(3.0)
FOUR, FIVE = np.float32(4.0), np.float32(5.0)
SPARE = np.float32(1.2)
"""Sub-samples along a cell's side, for each that covering needs: with none to spare, predictions of
photographs lose 0.4 dB; with more, little is gained."""
RUN = TILE
"""Cells of a run, at most."""
PLACE = np.uint32(14)
"""Bits of a word below the place: they number a cell's sub-samples."""
FAR = np.uint32(22)
"""Bits of a word below the place's distance from the middle of its cell."""
HIGH = np.uint64(32)
"""Bits of a word below the disparity."""
EMPTY = np.uint64(0xBF800000) << HIGH
"""The word of an empty cell: disparity -1."""


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
def land_corners(
    w: F4, disparity: F4, v: int, u_low: int, count: int, out_x: F4, out_y: F4, out_delta: F4
) -> None:
    """Where ``count`` samples of row v land, in pixels, and their disparities, 0 where missing.

    One behind the eye lands at infinity: no lattice is fine enough for its cells.
    """
    v4 = np.float32(v)
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for i in range(count):
        u, delta = np.float32(u_low + i), disparity[v, u_low + i]
        delta = delta if delta >= ZERO else ZERO
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t if t > ZERO else np.float32(np.inf)
        out_x[i] = (w[0] * u + r0 + w[3] * delta) * scale
        out_y[i] = (w[4] * u + s0 + w[7] * delta) * scale
        out_delta[i] = delta


@inner
def run_lattice(
    xa: F4, ya: F4, xb: F4, yb: F4, count: int, intact: U1, scale_b: Real, first: Real, end: Real,
    columns: int, largest: int,
) -> tuple[int, int]:  # fmt: skip
    """Sub-samples along u and v that leave no cell of the warp buffer empty inside a run.

    As `cell_lattice`, of the neediest intact cell.

    Args:
        xa: where the upper corners land, pixels.
        ya: ...
        xb: and the lower ones.
        yb: ...
        count: cells.
        intact: (count,) 0 where a cell does not count.
        scale_b: cells of the buffer per output pixel.
        first: first row of cells that counts.
        end: row after the last.
        columns: of the buffer.
        largest: upper bound, and the answer for a run that reaches behind the eye.

    Returns:
        How many; 0 where the run misses those rows, or the buffer, altogether.
    """
    ux_most, uy_most, vx_most, vy_most = ZERO, ZERO, ZERO, ZERO
    u_most, v_most = ZERO, ZERO
    left, right = np.float32(np.inf), np.float32(-np.inf)
    top, bottom = np.float32(np.inf), np.float32(-np.inf)
    bad = False
    for i in range(count):
        if not intact[i]:
            continue
        x00, x01, x10, x11 = xa[i], xa[i + 1], xb[i], xb[i + 1]
        y00, y01, y10, y11 = ya[i], ya[i + 1], yb[i], yb[i + 1]
        ux, uy = max(abs(x01 - x00), abs(x11 - x10)), max(abs(y01 - y00), abs(y11 - y10))
        vx, vy = max(abs(x10 - x00), abs(x11 - x01)), max(abs(y10 - y00), abs(y11 - y01))
        bad |= not (ux + uy + vx + vy < np.float32(1e9))
        ux_most, uy_most = max(ux_most, ux), max(uy_most, uy)
        vx_most, vy_most = max(vx_most, vx), max(vy_most, vy)
        u_most, v_most = max(u_most, ux * ux + uy * uy), max(v_most, vx * vx + vy * vy)
        left, right = min(left, x00, x01, x10, x11), max(right, x00, x01, x10, x11)
        top, bottom = min(top, y00, y01, y10, y11), max(bottom, y00, y01, y10, y11)
    if bad:
        return largest, largest
    u_most, v_most = np.sqrt(u_most), np.sqrt(v_most)
    # sub-samples lie between the corners, but for float32: its noise grows with the cell
    slack = ONE + np.float32(0.01) * max(u_most, v_most)
    if (
        (right + ONE + slack) * scale_b < ZERO or (left + ONE - slack) * scale_b > columns
        or (bottom + ONE + slack) * scale_b < first or (top + ONE - slack) * scale_b > end
    ):  # fmt: skip
        return 0, 0
    ux_most, uy_most = scale_b * ux_most, scale_b * uy_most
    vx_most, vy_most = scale_b * vx_most, scale_b * vy_most
    nu = lattice_size(max(ux_most + uy_most, SPARE * scale_b * u_most), largest)
    nv = lattice_size(max(vx_most + vy_most, SPARE * scale_b * v_most), largest)
    nu4, nv4 = np.float32(nu), np.float32(nv)
    excess = max(ux_most / nu4 + vx_most / nv4, uy_most / nu4 + vy_most / nv4)
    if excess > ONE:  # sheared cells
        nu, nv = lattice_size(nu4 * excess, largest), lattice_size(nv4 * excess, largest)
    return nu, nv


@inner
def lay_lattice(nu: int, nv: int, out_at: I4, out_fu: F4, out_fv: F4) -> None:
    """Places of a whole cell's sub-samples, 0 to 1, and their column and row in the lattice.

    Every second one first, along both axes: neighbours mostly claim one cell of the buffer, and
    each would wait for what the other has just written there.
    """
    n = 0
    for part in range(4):
        for j in range(part >> 1, nv, 2):
            for i in range(part & 1, nu, 2):
                out_at[n, 0], out_at[n, 1] = i, j
                out_fu[n] = (np.float32(i) + HALF) / np.float32(nu)
                out_fv[n] = (np.float32(j) + HALF) / np.float32(nv)
                n += 1


@inner
def lay_cubics(n: int, out_weights: F4) -> None:
    """(n, 4) weights of the samples at -1, 0, 1, 2 for each place along a lattice's side.

    Catmull and Rom's cubic: it passes through the samples and keeps quadratics.
    """
    for i in range(n):
        f = (np.float32(i) + HALF) / np.float32(n)
        out_weights[i, 0] = HALF * f * (f * (TWO - f) - ONE)
        out_weights[i, 1] = HALF * (f * f * (THREE * f - FIVE) + TWO)
        out_weights[i, 2] = HALF * f * (f * (FOUR - THREE * f) + ONE)
        out_weights[i, 3] = HALF * f * f * (f - ONE)


@inner
def land_run(
    w: F4, u_low: int, v: int, upper: F4, lower: F4, scale_b: Real, bits: int, row_first: int,
    first: Real, end: Real, columns: int, nowhere: int, count: int, fus: F4, fvs: F4,
    out_cell: U4, out_word: U8,
) -> None:  # fmt: skip
    """Cell (or ``nowhere``) and word of the sub-samples of a run, (count, RUN) each.

    A word is the warped disparity's bits, then the mark of the place, then the sub-sample's number.
    Disparity is bilinear in upper and lower, (RUN + 1,) disparities of the corners. Straight-line
    arithmetic on purpose: it vectorises.
    """
    places, right = np.float32(1 << bits), np.float32(columns)
    low, wide, none = np.uint32(row_first), np.uint32(columns), np.uint32(nowhere)
    low4 = np.float32(row_first)
    for k in range(count):
        fu, fv = fus[k], fvs[k]
        v4 = np.float32(v) + fv
        r0 = w[1] * v4 + w[2]
        s0 = w[5] * v4 + w[6]
        t0 = w[9] * v4 + w[10]
        number = np.uint64(k)
        for i in range(RUN):
            u = np.float32(u_low + i) + fu
            left = upper[i] + fv * (lower[i] - upper[i])
            delta = left + fu * (upper[i + 1] + fv * (lower[i + 1] - upper[i + 1]) - left)
            t = w[8] * u + t0 + w[11] * delta
            scale = ONE / t
            x = ((w[0] * u + r0 + w[3] * delta) * scale + ONE) * scale_b
            y = ((w[4] * u + s0 + w[7] * delta) * scale + ONE) * scale_b
            inside = (t > ZERO) & (x >= ZERO) & (y >= first) & (x < right) & (y < end)
            x = x if inside else ZERO
            y = y if inside else low4
            column, row = np.floor(x), np.floor(y)
            cell = np.uint32((np.uint32(np.int32(row)) - low) * wide + np.uint32(np.int32(column)))
            out_cell[k, i] = cell if inside else none
            out_word[k, i] = word(delta * scale, mark(x - column, y - row, places)) | number


@inner
def mark(at_u: Real, at_v: Real, places: Real) -> Real:
    """How far from its cell's middle a place is, before the place itself: smaller is better.

    ``distance << 8 | place``, whole numbers in float32: exact below 2^24, and it vectorises. With
    one place a cell knows no distances: that is the paper's warp buffer without offsets.

    Args:
        at_u: where in its cell a sub-sample is, 0 to 1.
        at_v: ...
        places: along each axis of a cell.
    """
    qu, qv = np.floor(at_u * places), np.floor(at_v * places)
    off_u, off_v = TWO * qu + ONE - places, TWO * qv + ONE - places
    return np.float32(128.0) * (off_u * off_u + off_v * off_v) + qv * places + qu


@inner
def word(warped: Real, marked: Real) -> Real:
    """What a cell holds of the sub-sample it sees; see `land_run`."""
    low = np.uint32(np.uint32(np.int32(marked)) << PLACE)
    return (np.uint64(bits_of(warped)) << HIGH) | np.uint64(low)


@inner
def claim(cell: Real, own: Real, by_order: bool, keep: Real, out_word: U8) -> bool:
    """Whether a sub-sample becomes what its cell sees; leaves its word there if so.

    Of several on one surface a cell keeps the one nearest its middle: the first or the last would
    lie toward one side of every cell, and the whole picture with them. Selects instead of
    branches on purpose: which of them wins is noise to a branch predictor.

    Args:
        cell: flat index of the cell.
        own: its word, see `land_run`.
        by_order: later surfaces win; otherwise the larger disparity.
        keep: ratio of two disparities from which on they are one surface.
        out_word: (cells,), `EMPTY` where nothing was seen.
    """
    old = out_word[cell]
    warped, held = float_of(np.uint32(own >> HIGH)), float_of(np.uint32(old >> HIGH))
    nearer = warped > held
    low, high = (held, warped) if nearer else (warped, held)
    same = low >= high * keep
    wins = (same & (np.uint32(own) >> FAR < np.uint32(old) >> FAR)) | (~same & (nearer | by_order))
    out_word[cell] = own if wins else old
    return wins


@inner
def fill_whole_cell(
    color: F4, sample: int, stride: int, i: int, count: int, by_order: bool, keep: Real,
    smooth: bool, nu: int, at: I4, fus: F4, fvs: F4, cubic_u: F4, cubic_v: F4, cells: U4,
    words: U8, winners: U4, columns: F4, out_color: F4, out_word: U8,
) -> None:  # fmt: skip
    """Let the sub-samples of cell i of a run claim theirs, then colour those still standing."""
    for k in range(count):
        claim(cells[k, i], words[k, i], by_order, keep, out_word)
    standing = np.uint32(0)
    for k in range(count):
        winners[standing] = np.uint32(k)
        standing += np.uint32(out_word[cells[k, i]] == words[k, i])
    if smooth:
        color_smooth(
            color, sample, stride, i, standing, nu, at, cubic_u, cubic_v, cells, winners,
            columns, out_color,
        )  # fmt: skip
        return
    c00, c01 = load4(color, sample), load4(color, sample + 1)
    c10, c11 = load4(color, sample + stride), load4(color, sample + stride + 1)
    for n in range(standing):
        k = winners[n]
        fu, fv = fus[k], fvs[k]
        top = add4(scale4(c00, ONE - fu), scale4(c01, fu))
        low = add4(scale4(c10, ONE - fu), scale4(c11, fu))
        store4(out_color, cells[k, i], add4(scale4(top, ONE - fv), scale4(low, fv)))


@inner
def color_smooth(
    color: F4, sample: int, stride: int, i: int, standing: Real, nu: int, at: I4, cubic_u: F4,
    cubic_v: F4, cells: U4, winners: U4, columns: F4, out_color: F4,
) -> None:  # fmt: skip
    """Bicubic colours of the sub-samples still standing: columns of the lattice first.

    columns is (4 * most,) fours to work in.
    """
    for row in range(4):
        first = sample + (row - 1) * stride
        ca, cb, cc, cd = (
            load4(color, first - 1), load4(color, first), load4(color, first + 1),
            load4(color, first + 2),
        )  # fmt: skip
        for m in range(nu):
            left = add4(scale4(ca, cubic_u[m, 0]), scale4(cb, cubic_u[m, 1]))
            right = add4(scale4(cc, cubic_u[m, 2]), scale4(cd, cubic_u[m, 3]))
            store4(columns, 4 * m + row, add4(left, right))
    for n in range(standing):
        k = winners[n]
        m, j = 4 * at[k, 0], at[k, 1]
        upper = add4(
            scale4(load4(columns, m), cubic_v[j, 0]), scale4(load4(columns, m + 1), cubic_v[j, 1])
        )
        lower = add4(
            scale4(load4(columns, m + 2), cubic_v[j, 2]),
            scale4(load4(columns, m + 3), cubic_v[j, 3]),
        )
        store4(out_color, cells[k, i], add4(upper, lower))


@inner
def fill_quarter_cell(
    w: F4, color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int, density: int,
    largest: int, scale_b: Real, bits: int, row_first: int, first: Real, end: Real, columns: int,
    by_order: bool, keep: Real, out_color: F4, out_word: U8,
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
            at_u, at_v = x - np.float32(column), y - np.float32(row)
            cell = np.uint32((row - row_first) * columns + column)
            own_word = word(delta * scale, mark(at_u, at_v, size))
            if not claim(cell, own_word, by_order, keep, out_word):
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
    tolerance: Real, columns: int, out_color: F4, out_word: U8,
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
        density: sub-samples per pixel and axis (the paper's a), even; 0: what each run needs.
        largest: upper bound of what a run may need.
        scale_b: cells per output pixel and axis (b), even.
        bits: of a place within a cell, per axis (o).
        by_order: later surfaces win; otherwise the larger disparity.
        tolerance: relative difference in disparity up to which sub-samples are on one surface.
        columns: cells across.
        out_color: (cells_v * cells_u + 1, 4); the last cell takes what lands outside.
        out_word: (cells_v * cells_u + 1,) see `land_run`; preset to EMPTY.
    """
    b4, row_first = np.float32(scale_b), row_low * scale_b
    keep = np.float32(1.0 - tolerance)
    nowhere = out_word.size - 1
    row_end = row_first + nowhere // columns
    rows, stride = disparity.shape
    most = max(density, largest) ** 2
    fus, fvs = np.empty(most, np.float32), np.empty(most, np.float32)
    cells, words = np.empty((most, RUN), np.uint32), np.empty((most, RUN), np.uint64)
    winners, at = np.empty(most + 1, np.uint32), np.empty((most, 2), np.int32)
    side = max(density, largest)
    cubic_u, cubic_v = np.empty((side, 4), np.float32), np.empty((side, 4), np.float32)
    work = np.empty((4 * side, 4), np.float32)
    ends = np.zeros((6, RUN + 2), np.float32)
    whole = np.zeros(RUN + 1, np.uint8)
    nu, nv, laid_nu, laid_nv = density, density, 0, 0
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        # what float32 lands outside the tile's float64 bounds is noise: the same for every band
        first = max((tiles[n, 6] + 1) * scale_b, row_first) if tiles[n, 6] > 0 else row_first
        end = min(tiles[n, 7] * scale_b, row_end) if tiles[n, 7] < height else row_end
        first4, end4 = np.float32(first), np.float32(end)
        u_low, u_high, u_step, v_step = tiles[n, 0], tiles[n, 1], tiles[n, 2], tiles[n, 5]
        u_first = u_low - 1 if u_low == 0 else u_low
        v_first = tiles[n, 3] - 1 if tiles[n, 3] == 0 else tiles[n, 3]
        across = min(u_high, stride - 1) - u_low
        for j in range(tiles[n, 4] - v_first):
            v = v_first + j if v_step > 0 else tiles[n, 4] - 1 - j
            count = 0
            if 0 <= v < rows - 1:
                any_whole = False
                for i in range(across):
                    whole[i] = links[v, u_low + i] & INTACT
                    any_whole |= whole[i] != 0
                if any_whole:
                    land_corners(w, disparity, v, u_low, across + 1, ends[0], ends[1], ends[2])
                    land_corners(w, disparity, v + 1, u_low, across + 1, ends[3], ends[4], ends[5])
                    nu, nv = run_lattice(
                        ends[0], ends[1], ends[3], ends[4], across, whole, b4, first4, end4,
                        columns, largest,
                    )  # fmt: skip
                    if density > 0 and nu > 0:
                        nu, nv = density, density
                    count = nu * nv
                if count > 0:
                    if nu != laid_nu or nv != laid_nv:
                        lay_lattice(nu, nv, at, fus, fvs)
                        lay_cubics(nu, cubic_u)
                        lay_cubics(nv, cubic_v)
                        laid_nu, laid_nv = nu, nv
                    land_run(
                        w, u_low, v, ends[2], ends[5], b4, bits, row_first, first4, end4, columns,
                        nowhere, count, fus, fvs, cells, words,
                    )  # fmt: skip
            for i in range(u_high - u_first):
                u = u_first + i if u_step > 0 else u_high - 1 - i
                if v >= 0 and u >= 0 and links[v, u] & INTACT:
                    fill_whole_cell(
                        color, v * stride + u, stride, u - u_low, count, by_order, keep,
                        (links[v, u] & SMOOTH) != 0, nu, at, fus, fvs, cubic_u, cubic_v,
                        cells, words, winners, work, out_color, out_word,
                    )  # fmt: skip
                    continue
                for corner in range(4):
                    dv = corner >> 1 if v_step > 0 else 1 - (corner >> 1)
                    du = corner & 1 if u_step > 0 else 1 - (corner & 1)
                    if usable(disparity, links, v + dv, u + du):
                        fill_quarter_cell(
                            w, color, disparity, links, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du,
                            density, largest, b4, bits, row_first, first4, end4, columns,
                            by_order, keep, out_color, out_word,
                        )  # fmt: skip
