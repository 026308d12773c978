"""Kernels of the splat reconstructor: samples as squares round the places where they landed.

A pixel goes to the front surface that reaches it, and of that surface to the sample whose center is
nearest: splats do not push each other aside, textures stay in place, and a nearer surface covers
what shows through its gaps. A sample that landed in the pixel keeps it, unless it is behind.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import bits_of, float_of
from belvedere.warp._scatter import HIGH, PLACES

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]
U4 = npt.NDArray[np.uint32]

HALF = np.float32(0.5)
ZERO = np.float32(0.0)
NOTHING = np.float32(-1.0)
NEVER = np.float32(np.inf)
TURNED = np.float32(0.7072)
"""Half the side, in spacings, of the smallest upright squares that leave no gap round the points of
a square lattice, however it is turned: half the diagonal, and a rounding more."""
GROWN = np.float32(1.001)
"""Growth from which a sample paints more than its pixel; below is float32's noise."""

FAR = np.int32(0x7FFFFFFF)
"""The key of a pixel that stays what it is; see `key_of`."""
NUMBER = np.int32(255)
"""The part of a key that tells the neighbour: footprints have at most 15 x 15 cells, so that the
last number is left for the pixel itself."""


@inner
def key_of(right: Real, down: Real, number: int) -> Real:
    """Squared distance of a center, its last bits replaced by the neighbour's number.

    Bits of floats from 0 on are ordered as the floats are, so the least key is the nearest center.
    """
    squared = np.int32(bits_of(right * right + down * down))
    return np.int32((squared & ~NUMBER) | np.int32(number))


@kernel
def read_row(
    words: I8, places: U4, y: int, halo: int, back: F4, det_h: Real, det_g: Real, size: int,
    out_delta: F4, out_right: F4, out_down: F4, out_half: F4,
) -> Real:  # fmt: skip
    """One row of a layer as floats, and the largest half side in it.

    Args:
        words: (columns,) of the row.
        places: (columns,).
        y: the row's place in the desired view.
        halo: cells left of the desired view.
        back: (12,) matrix from the desired view to the reference.
        det_h: determinant of columns 1, 2, 3 of the warp matrix.
        det_g: determinant of its columns 1, 2, 4.
        size: side of every square; 0: as large as each sample has grown.
        out_delta: (columns,) warped disparity, -1 where there is none.
        out_right: (columns,) place of the sample right of the cell's middle.
        out_down: (columns,) and below it.
        out_half: (columns,) half the side of its square.

    Source: spec image-warping 3.7 (determinant), portal-walkthrough 3.6. ``1 / t`` of a sample is
    the third row of the matrix back, so growth needs nothing but the place in the desired view.
    """
    step = np.float32(1.0) / PLACES
    for x in range(words.shape[0]):
        word, place = words[x], places[x]
        out_delta[x] = float_of(np.uint32(word >> HIGH)) if word >= 0 else NOTHING
        out_right[x] = np.float32(np.int32(place & np.uint32(0xFFFF))) * step - HALF
        out_down[x] = np.float32(np.int32(place >> np.uint32(16))) * step - HALF
    if size > 0:
        return HALF * np.float32(size)
    most = np.int32(0)  # whole numbers have one largest, floats must be told about NaN
    h4, g4, row = np.float32(det_h), np.float32(det_g), np.float32(y)
    b_x, b_0, b_near = back[8], back[9] * row + back[10], back[11]
    b_y, left = back[9], np.int32(halo)
    for x in range(words.shape[0]):
        delta = out_delta[x]
        u = np.float32(np.int32(np.int32(x) - left)) + out_right[x]
        inverse = b_x * u + b_y * out_down[x] + b_0 + b_near * delta
        growth = np.sqrt(abs((h4 * inverse + g4 * delta) * inverse * inverse))
        half = TURNED * growth if growth > GROWN else HALF
        half = half if delta >= ZERO else ZERO
        out_half[x] = half
        most = max(most, np.int32(bits_of(half)))
    return float_of(np.uint32(most))


@inner
def reaches(right: Real, down: Real, half: Real, dx: Real, dy: Real) -> bool:
    """Whether the square of a sample (dx, dy) cells away holds a pixel's middle."""
    return max(abs(right + dx), abs(down + dy)) <= half


@inner
def next_front(delta: F4, right: F4, down: F4, half: F4, row: int, gated: bool, keep: Real,
               out_limit: F4) -> None:  # fmt: skip
    """`find_front` where squares end in the next cells: by far the most frequent."""
    rows, one = delta.shape[0], np.float32(1.0)
    i, k = (row - 1) % rows, (row + 1) % rows
    a, b, c = delta[i], delta[row], delta[k]
    xa, xb, xc, ya, yb, yc = right[i], right[row], right[k], down[i], down[row], down[k]
    ha, hb, hc = half[i], half[row], half[k]
    low = (a.shape[0] - out_limit.shape[0]) // 2 - 1
    a, b, c, xa, xb, xc = a[low:], b[low:], c[low:], xa[low:], xb[low:], xc[low:]
    ya, yb, yc, ha, hb, hc = ya[low:], yb[low:], yc[low:], ha[low:], hb[low:], hc[low:]
    for x in range(out_limit.shape[0]):
        front = NOTHING
        for j in range(3):
            step = np.float32(j - 1)
            if gated:
                above = a[x + j] if reaches(xa[x + j], ya[x + j], ha[x + j], step, -one) else front
                level = b[x + j] if reaches(xb[x + j], yb[x + j], hb[x + j], step, ZERO) else front
                below = c[x + j] if reaches(xc[x + j], yc[x + j], hc[x + j], step, one) else front
            else:
                above, level, below = a[x + j], b[x + j], c[x + j]
            front = max(front, above, level, below)
        bar = front * keep
        out_limit[x] = bar if (front >= ZERO) & (b[x + 1] < bar) else NEVER


@inner
def next_nearest(delta: F4, right: F4, down: F4, half: F4, row: int, gated: bool, limit: F4,
                 out_key: I4) -> None:  # fmt: skip
    """`find_nearest` where squares end in the next cells."""
    rows, one = delta.shape[0], np.float32(1.0)
    i, k = (row - 1) % rows, (row + 1) % rows
    a, b, c = delta[i], delta[row], delta[k]
    xa, xb, xc, ya, yb, yc = right[i], right[row], right[k], down[i], down[row], down[k]
    ha, hb, hc = half[i], half[row], half[k]
    low = (a.shape[0] - limit.shape[0]) // 2 - 1
    a, b, c, xa, xb, xc = a[low:], b[low:], c[low:], xa[low:], xb[low:], xc[low:]
    ya, yb, yc, ha, hb, hc = ya[low:], yb[low:], yc[low:], ha[low:], hb[low:], hc[low:]
    for x in range(out_key.shape[0]):
        best, bar = FAR, limit[x]
        for j in range(3):
            step = np.float32(j - 1)
            above, level, below = a[x + j] >= bar, b[x + j] >= bar, c[x + j] >= bar
            if gated:
                above = above & reaches(xa[x + j], ya[x + j], ha[x + j], step, -one)
                level = level & reaches(xb[x + j], yb[x + j], hb[x + j], step, ZERO)
                below = below & reaches(xc[x + j], yc[x + j], hc[x + j], step, one)
            key = key_of(xa[x + j] + step, ya[x + j] - one, j)
            best = min(best, key if above else FAR)
            key = key_of(xb[x + j] + step, yb[x + j], j + 3)
            best = min(best, key if level else FAR)
            key = key_of(xc[x + j] + step, yc[x + j] + one, j + 6)
            best = min(best, key if below else FAR)
        out_key[x] = best


@inner
def find_front(
    delta: F4, right: F4, down: F4, half: F4, row: int, reach: int, gated: bool, keep: Real,
    out_tall: F4, out_limit: F4,
) -> None:  # fmt: skip
    """The least disparity that is still the surface in front of each pixel.

    Args:
        delta: (n, columns) ring of rows, as the next three.
        right: places of the samples.
        down: places of the samples.
        half: half the sides of their squares.
        row: of the rings, the one to settle.
        reach: cells that squares reach to, of all in the rings.
        gated: whether squares differ, so that each must be asked whether it reaches.
        keep: share of the front's disparity that still is its surface.
        out_tall: (columns,) working memory.
        out_limit: (width,), `NEVER` where the pixel's own sample is in front, or nobody is near.
    """
    count, columns = delta.shape
    width, side = out_limit.shape[0], 2 * reach + 1
    halo = (columns - width) // 2
    out_limit[:] = NOTHING
    if gated:
        for k in range(side * side):
            dy, dx = k // side - reach, k % side - reach
            line, low = (row + dy) % count, halo + dx
            near, across = delta[line, low : low + width], right[line, low : low + width]
            along, wide = down[line, low : low + width], half[line, low : low + width]
            move_x, move_y = np.float32(dx), np.float32(dy)
            for x in range(width):
                held = reaches(across[x], along[x], wide[x], move_x, move_y)
                out_limit[x] = max(out_limit[x], near[x] if held else NOTHING)
    else:
        out_tall[:] = NOTHING
        for dy in range(-reach, reach + 1):
            near = delta[(row + dy) % count]
            for x in range(columns):
                out_tall[x] = max(out_tall[x], near[x])
        for dx in range(-reach, reach + 1):
            near = out_tall[halo + dx : halo + dx + width]
            for x in range(width):
                out_limit[x] = max(out_limit[x], near[x])
    own = delta[row, halo : halo + width]
    for x in range(width):
        bar = out_limit[x] * keep
        out_limit[x] = bar if (out_limit[x] >= ZERO) & (own[x] < bar) else NEVER


@inner
def find_nearest(
    delta: F4, right: F4, down: F4, half: F4, row: int, reach: int, gated: bool, limit: F4,
    out_key: I4,
) -> None:  # fmt: skip
    """Key of the nearest center that reaches each pixel with a disparity of at least its limit.

    Arguments as in `find_front`; out_key is (width,), `FAR` where there is none.
    """
    count, columns = delta.shape
    width, side = out_key.shape[0], 2 * reach + 1
    halo = (columns - width) // 2
    out_key[:] = FAR
    for k in range(side * side):
        dy, dx = k // side - reach, k % side - reach
        line, low = (row + dy) % count, halo + dx
        near, across = delta[line, low : low + width], right[line, low : low + width]
        along, wide = down[line, low : low + width], half[line, low : low + width]
        move_x, move_y = np.float32(dx), np.float32(dy)
        for x in range(width):
            held = near[x] >= limit[x]
            if gated:
                held = held & reaches(across[x], along[x], wide[x], move_x, move_y)
            key = key_of(across[x] + move_x, along[x] + move_y, k)
            out_key[x] = min(out_key[x], key if held else FAR)


@inner
def settle_row(
    delta: F4, right: F4, down: F4, half: F4, row: int, reach: int, gated: bool, keep: Real,
    out_tall: F4, out_limit: F4, out_key: I4,
) -> None:  # fmt: skip
    """Keys of one row's pixels; each way has loops of its own, so that they run on vectors."""
    if reach == 1:
        next_front(delta, right, down, half, row, gated, keep, out_limit)
        next_nearest(delta, right, down, half, row, gated, out_limit, out_key)
    else:
        find_front(delta, right, down, half, row, reach, gated, keep, out_tall, out_limit)
        find_nearest(delta, right, down, half, row, reach, gated, out_limit, out_key)


@kernel
def spread(
    words: I8, places: U4, back: F4, det_h: Real, det_g: Real, size: int, halo: int, row_low: int,
    tolerance: Real, out_word: I8,
) -> None:  # fmt: skip
    """Let each visible sample paint a square: a pixel goes to the front surface that reaches it.

    Args:
        words: (rows + 2 halo, width + 2 halo) from `scatter`.
        places: same shape.
        back: (12,) matrix from the desired view to the reference.
        det_h: determinant of columns 1, 2, 3 of the warp matrix.
        det_g: determinant of its columns 1, 2, 4.
        size: side of every square, pixels; 0: as large as each sample has grown.
        halo: cells round the band, and the farthest that a sample can paint.
        row_low: the band's first row in the desired view.
        tolerance: relative difference in disparity up to which samples are one surface.
        out_word: (rows, width).
    """
    rows, width = out_word.shape
    columns, keep, ring = words.shape[1], np.float32(1.0 - tolerance), 2 * halo + 1
    delta, right = np.empty((ring, columns), np.float32), np.empty((ring, columns), np.float32)
    down, half = np.empty((ring, columns), np.float32), np.zeros((ring, columns), np.float32)
    most, tall = np.zeros(ring, np.float32), np.empty(columns, np.float32)
    limit, key = np.empty(width, np.float32), np.empty(width, np.int32)
    offset = np.zeros(256, np.int64)  # from a pixel's own cell to the one its key names
    cells = words.reshape(-1)
    for y in range(-halo, rows + halo):
        line = (y + halo) % ring
        most[line] = read_row(
            words[y + halo], places[y + halo], row_low + y, halo, back, det_h, det_g, size,
            delta[line], right[line], down[line], half[line],
        )  # fmt: skip
        if y < halo:
            continue
        row, reach = y % ring, int(min(most.max() + HALF, np.float32(halo)))
        if size > 0:
            settle_row(delta, right, down, half, row, reach, False, keep, tall, limit, key)
        else:
            settle_row(delta, right, down, half, row, reach, True, keep, tall, limit, key)
        side = 2 * reach + 1
        for k in range(side * side):
            offset[k] = (k // side - reach) * columns + k % side - reach
        target, first = out_word[y - halo], y * columns + halo
        for x in range(width):
            target[x] = cells[np.uint64(first + x + offset[np.uint64(key[x] & NUMBER)])]
