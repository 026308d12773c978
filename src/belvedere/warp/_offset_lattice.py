"""How dense a lattice of sub-samples must be, and where it lies between the samples."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import bits_of, float_of
from belvedere.warp._offset_word import IN_CELL, LAST_STEP, STEPS

F4 = npt.NDArray[np.float32]
U4 = npt.NDArray[np.uint32]
U8 = npt.NDArray[np.uint64]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
INFINITY = np.float32(np.inf)
FAR = np.float32(1e9)
"""Pixels; what lands further, or has no place, is behind the eye."""
SPARE = np.float32(1.002)
"""How much denser than need be: rows of sub-samples exactly a cell apart may, once rounded, leave
one out."""
MARGIN = np.float32(1.5)
"""Output pixels from the warp buffer's first cell to the centre of the first pixel: there is a
whole pixel more on every side of the view."""


@inner
def land_corners(
    w: F4, row: F4, v: int, u_low: int, count: int, out_x: F4, out_y: F4, out_delta: F4
) -> None:
    """Where samples of row v land, in pixels, and their disparities, 0 where missing.

    They are the first ``count`` of row, which begins in column u_low. One behind the eye lands at
    infinity: no lattice is fine enough for its cells.
    """
    v4, u4 = np.float32(v), np.float32(u_low)
    r0, s0, t0 = w[1] * v4 + w[2], w[5] * v4 + w[6], w[9] * v4 + w[10]
    for i in range(count):
        u, delta = u4 + np.float32(np.int32(i)), row[i]
        delta = delta if delta >= ZERO else ZERO
        t = w[8] * u + t0 + w[11] * delta
        scale = ONE / t if t > ZERO else INFINITY
        out_x[i] = (w[0] * u + r0 + w[3] * delta) * scale
        out_y[i] = (w[4] * u + s0 + w[7] * delta) * scale
        out_delta[i] = delta


@inner
def larger_bits(most: Real, a: Real, b: Real, mask: Real) -> Real:
    """The largest of most and the sizes of a and b, as bits; those count where mask is set.

    Sizes are in the order of their bits, and the largest of whole numbers vectorises.
    """
    here, there = np.uint32(bits_of(abs(a)) & mask), np.uint32(bits_of(abs(b)) & mask)
    larger = here if here > there else there
    return np.uint32(larger if larger > most else most)


@inner
def bounds(values: F4, count: int) -> tuple[Real, Real]:
    """The least and the greatest of some landing places, to a pixel below and above."""
    low, high = np.int32(FAR), np.int32(-FAR)
    for i in range(count):
        value = values[i]
        value = value if value > -FAR else -FAR
        value = value if value < FAR else FAR
        whole = np.int32(value)
        low = np.int32(whole if whole < low else low)
        high = np.int32(whole if whole > high else high)
    return np.float32(low) - ONE, np.float32(high) + ONE


@inner
def covering_need(ux: Real, uy: Real, vx: Real, vy: Real, largest: Real) -> tuple[Real, Real]:
    """Sub-samples along u and v, no whole numbers, that leave no cell of the buffer empty.

    Rows of sub-samples a step along v apart, a step along u apart in each row, however the rows are
    shifted: any parallelogram of the two steps holds one. So every cell of the buffer holds one if
    the parallelogram's bounding box is no larger than a cell: along x and along y the two steps
    add up to at most one. (For a square turned by 45 degrees that is the known 1/sqrt(2).)

    Args:
        ux: how far along x the cell's side along u reaches, in cells of the buffer.
        uy: along y.
        vx: the side along v.
        vy: ...
        largest: upper bound.

    Source: spec offset-buffer-warping 3.3 (the bound for rotated lattices).
    """
    nu, nv = max(ux + uy, ONE), max(vx + vy, ONE)
    excess = max(ux / nu + vx / nv, uy / nu + vy / nv, ONE)  # of a sheared cell
    return min(nu * excess, largest), min(nv * excess, largest)


@inner
def longest_sides(
    xa: F4, ya: F4, xb: F4, yb: F4, count: int, intact: U4
) -> tuple[Real, Real, Real, Real]:
    """How far along x and along y the sides of the cells of a run reach at most, pixels.

    Args:
        xa: where the upper corners land, pixels.
        ya: ...
        xb: and the lower ones.
        yb: ...
        count: cells.
        intact: (count,) all bits set where a cell counts, else 0.

    Returns:
        Sides along u: x and y; sides along v: x and y. Their sum is not below `FAR` for a run that
        reaches behind the eye.
    """
    none = np.uint32(0)
    ux, uy, vx, vy = none, none, none, none
    for i in range(count):
        mask = intact[i]
        ux = larger_bits(ux, xa[i + 1] - xa[i], xb[i + 1] - xb[i], mask)
        uy = larger_bits(uy, ya[i + 1] - ya[i], yb[i + 1] - yb[i], mask)
        vx = larger_bits(vx, xb[i] - xa[i], xb[i + 1] - xa[i + 1], mask)
        vy = larger_bits(vy, yb[i] - ya[i], yb[i + 1] - ya[i + 1], mask)
    return float_of(ux), float_of(uy), float_of(vx), float_of(vy)


@inner
def run_need(
    ux: Real, uy: Real, vx: Real, vy: Real, scale: Real, largest: Real
) -> tuple[Real, Real]:
    """Sub-samples along u and v that leave no cell of a grid empty inside a run.

    What its neediest cell needs along each axis.

    Args:
        ux: from `longest_sides`.
        uy: ...
        vx: ...
        vy: ...
        scale: cells of the grid per output pixel.
        largest: upper bound, and the answer for a run that reaches behind the eye.
    """
    if not ux + uy + vx + vy < FAR:
        return largest, largest
    scale *= SPARE
    return covering_need(scale * ux, scale * uy, scale * vx, scale * vy, largest)


@inner
def even_need(ux: Real, uy: Real, vx: Real, vy: Real, largest: Real) -> tuple[int, Real]:
    """As `run_need` for a grid of output pixels, but a whole number along u, the same in each cell.

    What is more than needed along u allows fewer along v.
    """
    ux, uy, vx, vy = SPARE * ux, SPARE * uy, SPARE * vx, SPARE * vy
    side = max(ux, uy)
    if not ux + uy + vx + vy < FAR or not side < largest - ONE:
        return int(largest), largest
    slots, nv = 0, INFINITY
    for more in range(1, 3):
        count = np.float32(int(side) + more)
        along = max(vx / (ONE - ux / count), vy / (ONE - uy / count), ONE)
        if count * along < np.float32(slots) * nv or slots == 0:
            slots, nv = int(count), along
    return slots, min(nv, largest)


@inner
def may_meet(
    left: Real, right: Real, top: Real, bottom: Real, size: Real, scale_b: Real, first: Real,
    end: Real, columns: Real,
) -> bool:  # fmt: skip
    """Whether a run can meet the rows of cells [first, end) and the columns of the buffer.

    Args:
        left: bound of where its corners land, pixels.
        right: ...
        top: ...
        bottom: ...
        size: of its largest cell, pixels.
        scale_b: cells of the buffer per output pixel.
        first: first row of cells.
        end: row after the last.
        columns: of the buffer.
    """
    # sub-samples lie between the corners, but for float32: its noise grows with the cell
    slack = ONE + np.float32(0.01) * size
    return not (
        (right + MARGIN + slack) * scale_b < ZERO or (left + MARGIN - slack) * scale_b > columns
        or (bottom + MARGIN + slack) * scale_b < first or (top + MARGIN - slack) * scale_b > end
    )  # fmt: skip


@inner
def rows_of_run(start: Real, need: Real, at_end: bool) -> tuple[Real, Real]:
    """How the rows of sub-samples go on from run to run, down a tile.

    Args:
        start: from the run's upper end to its first row, in steps between rows.
        need: steps across the run.
        at_end: whether a tile ends with it: then its last row lies half a step before the end at
            most, since the next tile begins half a step after.

    Returns:
        Steps across the run, maybe more; and from its end to the next run's first row, in steps.
    """
    if at_end:
        need = start + np.ceil(need - start + HALF) - HALF
    return need, start + max(np.ceil(need - start), ZERO) - need


@inner
def lay_columns(
    count: int, padded: int, cells: int, out_cell: U4, out_at: F4, out_fu: F4, out_number: U8
) -> None:
    """Spread ``count`` sub-samples evenly over a run of so many cells, and some more beyond it.

    Args:
        count: how many.
        padded: with those beyond, which belong to the last cell.
        cells: of the run.
        out_cell: (padded,) cell of each.
        out_at: (padded,) samples from the run's start.
        out_fu: (padded,) place in its cell, 0 to 1.
        out_number: (padded,) cell and place as a word has them.
    """
    step = np.float32(cells) / np.float32(count)
    for m in range(padded):
        at = (np.float32(m) + HALF) * step
        cell = min(np.uint32(at), np.uint32(cells - 1))
        fu = at - np.float32(cell)
        out_cell[m], out_at[m], out_fu[m] = cell, at, fu
        number = (np.uint64(cell) << np.uint64(2 * IN_CELL)) | np.uint64(nearest_step(fu))
        out_number[m] = number << np.uint64(1)


@inner
def nearest_step(f: Real) -> int:
    """A place between two samples, 0 to 1, in steps of 2^-IN_CELL."""
    return int(min(f * STEPS + HALF, LAST_STEP))
