"""Kernels of the offset-buffer reconstructor: visibility in a finer grid, then one filter.

Colours are linear and have four channels (RGBA, or RGB and padding), so that one sample is one
vector register.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, kernel
from belvedere.warp._edges import intact, joined, slope_toward, usable

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]
Four = tuple[Real, Real, Real, Real]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@kernel
def claim(
    r: Real, s: Real, t: Real, delta: Real, scale_b: Real, bits: int, row_first: int, first: Real,
    end: Real, by_order: bool, out_disparity: F4, out_offset: U1,
) -> int:  # fmt: skip
    """Give a sub-sample at (r, s, t) its cell, if it is visible there.

    Notes its warped disparity and its place in the cell. Rows of cells count from one output pixel
    above the whole desired view; the buffer holds those from row_first on, of which [first, end)
    are open to this sub-sample. Its place is rounded before row_first comes in, so that it is the
    same for every band.

    Returns:
        The flat index of the cell to be coloured, or -1.
    """
    if not t > ZERO:
        return -1
    scale = ONE / t
    # in cells; the buffer has a margin of half an output pixel on every side
    x = (r * scale + ONE) * scale_b
    y = (s * scale + ONE) * scale_b
    columns = out_disparity.shape[1]
    if not (x >= ZERO and y >= first and x < np.float32(columns) and y < end):
        return -1
    column, place_v = int(x), y - np.float32(int(y))
    row = int(y) - row_first
    warped = delta * scale
    if not by_order and warped <= out_disparity[row, column]:
        return -1
    places = np.float32(1 << bits)
    qu, qv = int((x - np.float32(column)) * places), int(place_v * places)
    out_disparity[row, column] = warped
    out_offset[row, column] = (qv << bits) | qu
    return row * columns + column


@kernel
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


@kernel
def cell_density(
    w: F4, u: Real, v: Real, du: Real, dv: Real, d00: Real, d01: Real, d10: Real,
    d11: Real, scale_b: Real, first: Real, end: Real, columns: int, largest: int,
) -> int:  # fmt: skip
    """Sub-samples per axis that leave no cell of the warp buffer empty inside this one.

    A rotated lattice covers every cell when its spacing is at most 1/sqrt(2) cells, so the density
    is sqrt(2) b times the longest side of the warped cell.

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
        The density; 0 where the cell misses those rows, or the buffer, altogether.

    Source: spec offset-buffer-warping 3.3 (the bound for rotated lattices).
    """
    r0 = w[0] * u + w[1] * v + w[2]
    s0 = w[4] * u + w[5] * v + w[6]
    t0 = w[8] * u + w[9] * v + w[10]
    ta, tb = t0 + w[11] * d00, t0 + du * w[8] + w[11] * d01
    tc, td = t0 + dv * w[9] + w[11] * d10, t0 + du * w[8] + dv * w[9] + w[11] * d11
    low = min(ta, tb, tc, td)
    if not low > ZERO:
        return 0 if not max(ta, tb, tc, td) > ZERO else largest
    xa, ya = (r0 + w[3] * d00) / ta, (s0 + w[7] * d00) / ta
    xb, yb = (r0 + du * w[0] + w[3] * d01) / tb, (s0 + du * w[4] + w[7] * d01) / tb
    xc, yc = (r0 + dv * w[1] + w[3] * d10) / tc, (s0 + dv * w[5] + w[7] * d10) / tc
    xd = (r0 + du * w[0] + dv * w[1] + w[3] * d11) / td
    yd = (s0 + du * w[4] + dv * w[5] + w[7] * d11) / td
    ab = (xb - xa) * (xb - xa) + (yb - ya) * (yb - ya)
    cd = (xd - xc) * (xd - xc) + (yd - yc) * (yd - yc)
    ac = (xc - xa) * (xc - xa) + (yc - ya) * (yc - ya)
    bd = (xd - xb) * (xd - xb) + (yd - yb) * (yd - yb)
    side = np.sqrt(max(ab, cd, ac, bd))
    # sub-samples lie between the corners, but for float32: its noise grows with the cell
    slack = ONE + np.float32(0.01) * side
    if (
        (max(xa, xb, xc, xd) + ONE + slack) * scale_b < ZERO
        or (min(xa, xb, xc, xd) + ONE - slack) * scale_b > np.float32(columns)
        or (max(ya, yb, yc, yd) + ONE + slack) * scale_b < first
        or (min(ya, yb, yc, yd) + ONE - slack) * scale_b > end
    ):
        return 0
    if not side < np.float32(largest):
        return largest
    return max(min(int(np.ceil(side * scale_b * np.float32(1.41421356))), largest), 1)


@kernel
def fill_whole_cell(
    w: F4, color: F4, disparity: F4, v: int, u: int, v_step: int, u_step: int, density: int,
    largest: int, scale_b: Real, bits: int, row_first: int, first: Real, end: Real,
    by_order: bool,
    out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Sub-samples of an intact cell: colour and disparity bilinear between its four samples.

    Along a row of sub-samples disparity is affine, and so are r, s and t: three multiply-adds and
    a reciprocal each.
    """
    d00, d01 = disparity[v, u], disparity[v, u + 1]
    d10, d11 = disparity[v + 1, u], disparity[v + 1, u + 1]
    u4 = np.float32(u)
    if density == 0:
        density = cell_density(
            w, u4, np.float32(v), ONE, ONE, d00, d01, d10, d11, scale_b, first, end,
            out_disparity.shape[1], largest,
        )  # fmt: skip
        if density == 0:
            return
    spacing = ONE / np.float32(density)
    for j in range(density):
        fv = (np.float32(j if v_step > 0 else density - 1 - j) + HALF) * spacing
        v4 = np.float32(v) + fv
        left = d00 + fv * (d10 - d00)
        step = d01 + fv * (d11 - d01) - left
        r0 = w[0] * u4 + w[1] * v4 + w[2] + w[3] * left
        s0 = w[4] * u4 + w[5] * v4 + w[6] + w[7] * left
        t0 = w[8] * u4 + w[9] * v4 + w[10] + w[11] * left
        dr, ds, dt = w[0] + w[3] * step, w[4] + w[7] * step, w[8] + w[11] * step
        for i in range(density):
            fu = (np.float32(i if u_step > 0 else density - 1 - i) + HALF) * spacing
            cell = claim(
                r0 + fu * dr, s0 + fu * ds, t0 + fu * dt, left + fu * step,
                scale_b, bits, row_first, first, end, by_order, out_disparity, out_offset,
            )  # fmt: skip
            if cell >= 0:
                c0, c1, c2, c3 = mix(
                    color, v, u, (ONE - fu) * (ONE - fv), fu * (ONE - fv), (ONE - fu) * fv, fu * fv
                )
                out_color[cell, 0] = c0
                out_color[cell, 1] = c1
                out_color[cell, 2] = c2
                out_color[cell, 3] = c3


@kernel
def fill_quarter_cell(
    w: F4, color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int, density: int,
    largest: int, scale_b: Real, bits: int, row_first: int, first: Real, end: Real,
    by_order: bool,
    out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Sub-samples of the quarter that (v, u) owns of a broken cell toward (dv, du), each +-1."""
    across = slope_toward(disparity, links, v, u, 0, du)
    along = slope_toward(disparity, links, v, u, dv, 0)
    tied_u, tied_v = joined(links, v, u, 0, du), joined(links, v, u, dv, 0)
    if density == 0:
        own = disparity[v, u]
        density = cell_density(
            w, np.float32(u), np.float32(v), np.float32(du), np.float32(dv),
            own, own + across, own + along, own + across + along, scale_b, first, end,
            out_disparity.shape[1], largest,
        )  # fmt: skip
        if density == 0:
            return
        density += density & 1  # a quarter holds half the lattice of a cell
    spacing = ONE / np.float32(density)
    for j in range(density // 2):
        fv = (np.float32(j) + HALF) * spacing
        v4 = np.float32(v) + np.float32(dv) * fv
        for i in range(density // 2):
            fu = (np.float32(i) + HALF) * spacing
            u4 = np.float32(u) + np.float32(du) * fu
            delta = max(disparity[v, u] + fu * across + fv * along, ZERO)
            cell = claim(
                w[0] * u4 + w[1] * v4 + w[2] + w[3] * delta,
                w[4] * u4 + w[5] * v4 + w[6] + w[7] * delta,
                w[8] * u4 + w[9] * v4 + w[10] + w[11] * delta,
                delta, scale_b, bits, row_first, first, end, by_order, out_disparity, out_offset,
            )  # fmt: skip
            if cell < 0:
                continue
            for k in range(4):
                own = color[v, u, k]
                value = own
                if tied_u:
                    value += fu * (color[v, u + du, k] - own)
                if tied_v:
                    value += fv * (color[v + dv, u, k] - own)
                out_color[cell, k] = value


@kernel
def fill_offset_buffer(
    w: F4, color: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int,
    height: int, density: int, largest: int, scale_b: int, bits: int, by_order: bool,
    out_color: F4, out_disparity: F4, out_offset: U1,
) -> None:  # fmt: skip
    """Warp every sub-sample that can reach the band into its warp buffer.

    Args:
        w: (12,) warp matrix.
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS).
        row_low: first row of the band.
        row_high: row after its last.
        height: of the whole desired view.
        density: sub-samples per pixel and axis (the paper's a), even; 0: what each cell needs.
        largest: upper bound of what a cell may need.
        scale_b: cells per output pixel and axis (b), even.
        bits: of a place within a cell, per axis (o).
        by_order: later sub-samples win; otherwise the larger disparity.
        out_color: (cells_v * cells_u, 4).
        out_disparity: (cells_v, cells_u), preset to -1.
        out_offset: (cells_v, cells_u) place within the cell, ``qv << bits | qu``.
    """
    b4, row_first = np.float32(scale_b), row_low * scale_b
    row_end = row_first + out_disparity.shape[0]
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
                    fill_whole_cell(
                        w, color, disparity, v, u, v_step, u_step, density, largest, b4, bits,
                        row_first, first4, end4, by_order, out_color, out_disparity, out_offset,
                    )  # fmt: skip
                    continue
                for corner in range(4):
                    dv, du = corner >> 1, corner & 1
                    if usable(disparity, links, v + dv, u + du):
                        fill_quarter_cell(
                            w, color, disparity, links, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du,
                            density, largest, b4, bits, row_first, first4, end4, by_order,
                            out_color, out_disparity, out_offset,
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
