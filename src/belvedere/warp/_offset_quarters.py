"""Sub-samples of broken cells: each sample beside an edge paints its own quarter of the cell."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.warp._edges import INTACT, slope_toward, usable
from belvedere.warp._offset_lattice import FAR, MARGIN, run_need
from belvedere.warp._offset_word import IN_CELL, STEPS, back_word, front_word, mark

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
MOST = np.float32(1e30)


@inner
def quarter_need(
    w: F4, u: Real, v: Real, du: Real, dv: Real, d00: Real, d01: Real, d10: Real, d11: Real,
    scale_b: Real, first: Real, end: Real, columns: Real, largest: Real,
) -> tuple[Real, Real]:  # fmt: skip
    """`run_need` of the whole cell that a quarter lies in, if it were of one surface.

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
        first: first row of cells that counts.
        end: row after the last.
        columns: of the buffer.
        largest: upper bound, and the answer for a cell that reaches behind the eye.

    Returns:
        How many along u and along v; 0 where the cell misses those rows, or the buffer, altogether.
    """
    r0 = w[0] * u + w[1] * v + w[2]
    s0 = w[4] * u + w[5] * v + w[6]
    t0 = w[8] * u + w[9] * v + w[10]
    ta, tb = t0 + w[11] * d00, t0 + du * w[8] + w[11] * d01
    tc, td = t0 + dv * w[9] + w[11] * d10, t0 + du * w[8] + dv * w[9] + w[11] * d11
    if not min(ta, tb, tc, td) > ZERO:
        most = largest if max(ta, tb, tc, td) > ZERO else ZERO
        return most, most
    ta, tb, tc, td = ONE / ta, ONE / tb, ONE / tc, ONE / td
    xa, ya = (r0 + w[3] * d00) * ta, (s0 + w[7] * d00) * ta
    xb, yb = (r0 + du * w[0] + w[3] * d01) * tb, (s0 + du * w[4] + w[7] * d01) * tb
    xc, yc = (r0 + dv * w[1] + w[3] * d10) * tc, (s0 + dv * w[5] + w[7] * d10) * tc
    xd = (r0 + du * w[0] + dv * w[1] + w[3] * d11) * td
    yd = (s0 + du * w[4] + dv * w[5] + w[7] * d11) * td
    ux, uy = max(abs(xb - xa), abs(xd - xc)), max(abs(yb - ya), abs(yd - yc))
    vx, vy = max(abs(xc - xa), abs(xd - xb)), max(abs(yc - ya), abs(yd - yb))
    total = ux + uy + vx + vy
    if not total < FAR:
        return largest, largest
    # sub-samples lie between the corners, but for float32: its noise grows with the cell
    slack = ONE + np.float32(0.01) * total
    if (
        (max(xa, xb, xc, xd) + MARGIN + slack) * scale_b < ZERO
        or (min(xa, xb, xc, xd) + MARGIN - slack) * scale_b > columns
        or (max(ya, yb, yc, yd) + MARGIN + slack) * scale_b < first
        or (min(ya, yb, yc, yd) + MARGIN - slack) * scale_b > end
    ):
        return ZERO, ZERO
    return run_need(ux, uy, vx, vy, scale_b, largest)


@inner
def fill_quarter(
    w: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int, density: int,
    largest: Real, scale_b: Real, layout: Any, row_first: int, first: Real, end: Real,
    columns: int, out_word: U8,
) -> None:  # fmt: skip
    """Sub-samples of the quarter that (v, u) owns of a broken cell toward (dv, du), each +-1."""
    across = slope_toward(disparity, links, v, u, 0, du)
    along = slope_toward(disparity, links, v, u, dv, 0)
    own = disparity[v, u]
    nu, nv = np.float32(density), np.float32(density)
    u4, v4, right, du4, dv4 = (
        np.float32(u),
        np.float32(v),
        np.float32(columns),
        np.float32(du),
        np.float32(dv),
    )
    if density == 0:
        nu, nv = quarter_need(
            w, u4, v4, du4, dv4, own, own + across, own + along, own + across + along, scale_b,
            first, end, right, largest,
        )  # fmt: skip
        if nu == ZERO:
            return
    places = np.float32(1 << layout.bits)
    # a quarter holds half the lattice of a cell along each axis: the paper's as it is; an adaptive
    # one begins on the sample's own lines, since the lattice beyond them may end a step away
    first_step = HALF if density > 0 else ZERO
    count_u = int(np.ceil(HALF * nu + HALF - first_step))
    count_v = int(np.ceil(HALF * nv + HALF - first_step))
    gap_u = HALF / (np.float32(count_u) - HALF + first_step)
    gap_v = HALF / (np.float32(count_v) - HALF + first_step)
    for j in range(count_v):
        fv = (np.float32(j) + first_step) * gap_v
        for i in range(count_u):
            fu = (np.float32(i) + first_step) * gap_u
            uu, vv = u4 + du4 * fu, v4 + dv4 * fv
            delta = max(own + fu * across + fv * along, ZERO)
            t = w[8] * uu + w[9] * vv + w[10] + w[11] * delta
            if not t > ZERO:
                continue
            scale = ONE / t
            x = ((w[0] * uu + w[1] * vv + w[2] + w[3] * delta) * scale + MARGIN) * scale_b
            y = ((w[4] * uu + w[5] * vv + w[6] + w[7] * delta) * scale + MARGIN) * scale_b
            if not (x >= ZERO and y >= first and x < right and y < end):
                continue
            column, row = int(x), int(y)
            marked = mark(np.uint32(x * places), np.uint32(y * places), layout)
            front = front_word(min(delta * scale, MOST), marked, layout)
            # place in the whole cell, kept on the sample's own side of its middle
            step_u, step_v = int(fu * STEPS), int(fv * STEPS)
            step_u = step_u if du > 0 else (1 << IN_CELL) - max(step_u, 1)
            step_v = step_v if dv > 0 else (1 << IN_CELL) - max(step_v, 1)
            back = back_word(v if dv > 0 else v - 1, u if du > 0 else u - 1, step_v, step_u, layout)
            cell = (row - row_first) * columns + column
            out_word[cell] = max(out_word[cell], (np.uint64(front) << np.uint64(layout.low)) | back)


@inner
def fill_broken(
    w: F4, disparity: F4, links: U1, v_low: int, v_high: int, u_low: int, u_high: int,
    density: int, largest: Real, scale_b: Real, layout: Any, row_first: int, first: Real,
    end: Real, columns: int, out_word: U8,
) -> None:  # fmt: skip
    """Sub-samples of the broken cells of a tile, those beyond the picture's border included."""
    for v in range(v_low - 1 if v_low == 0 else v_low, v_high):
        for u in range(u_low - 1 if u_low == 0 else u_low, u_high):
            if v >= 0 and u >= 0 and links[v, u] & INTACT:
                continue
            for corner in range(4):
                dv, du = corner >> 1, corner & 1
                if usable(disparity, links, v + dv, u + du):
                    fill_quarter(
                        w, disparity, links, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du, density,
                        largest, scale_b, layout, row_first, first, end, columns, out_word,
                    )  # fmt: skip
