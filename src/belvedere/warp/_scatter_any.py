"""Kernels of the scattering reconstructors between any two central cameras.

All samples land once, whatever the band; then each band picks what it shows. The order that needs
no depths is the angle from the direction of the desired eye: in the plane of any epipolar line what
is nearer to that eye is seen closer to its direction, so samples painted from the antipode in to
the eye hide one another rightly on every manifold (`order_key`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import load4, store4, zero4
from belvedere.warp._landing import SOURCE, TARGET, Geometry, direction, project, reach

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
U2 = npt.NDArray[np.uint16]

NOWHERE = -1
RANKS = 65535
"""Steps from the antipode to the eye: a hundredth of a pixel of a panorama 1200 wide."""
ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TURNED = 0.7072
"""As in `_scatter`."""


@inner
def place_of(g: Geometry, x: Real, y: Real, width: int, height: int) -> int:
    """Flat index of the pixel whose square holds (x, y), or `NOWHERE`."""
    if not abs(x) + abs(y) < 1e9:
        return NOWHERE
    i, j = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
    if g[TARGET] != 0.0 and i >= width:
        i = 0
    if g[TARGET] == 2.0:  # the pole itself lies on the border of the last row
        j = min(max(j, 0), height - 1)
    if i < 0 or j < 0 or i >= width or j >= height:
        return NOWHERE
    return j * width + i


@kernel
def land_samples(
    g: Geometry, disparity: F4, own: tuple[int, int, int, int], row_low: int, row_high: int,
    width: int, height: int, out_places: F4, out_cells: I4,
) -> None:  # fmt: skip
    """Land rows [row_low, row_high) of a reference's own samples.

    Args:
        g: geometry.
        disparity: (H, W).
        own: first row, row after the last, first column, column after the last.
        row_low: counted from the first own row.
        row_high: same.
        width: of the desired view.
        height: of it.
        out_places: (3, n) x, y and warped disparity of each own sample, NaN where it has no image.
        out_cells: (n,) pixel it lands in, or `NOWHERE`.
    """
    across = own[3] - own[2]
    for row in range(row_low, row_high):
        for column in range(across):
            i = row * across + column
            v, u = own[0] + row, own[2] + column
            delta = np.float64(disparity[v, u])
            a, b, c = reach(g, np.float64(u), np.float64(v), delta)
            x, y, scale = project(g, TARGET, a, b, c)
            out_cells[i] = place_of(g, x, y, width, height)
            out_places[0, i], out_places[1, i], out_places[2, i] = x, y, delta * scale


@kernel
def rank_samples(
    g: Geometry, rays: F8, toward: F8, own: tuple[int, int, int, int], row_low: int, row_high: int,
    out_rank: U2,
) -> None:  # fmt: skip
    """How near each own sample is to the direction of the desired eye, 0 to `RANKS`.

    rays is (3, 3), the reference's frame in the world, toward (3,) the unit direction of the eye
    from the reference's center, out_rank (n,).
    """
    across = own[3] - own[2]
    for row in range(row_low, row_high):
        for column in range(across):
            v, u = np.float64(own[0] + row), np.float64(own[2] + column)
            a, b, c = direction(g, SOURCE, u, v)
            square, cosine = 0.0, 0.0
            for axis in range(3):
                d = rays[axis, 0] * a + rays[axis, 1] * b + rays[axis, 2] * c
                square += d * d
                cosine += d * toward[axis]
            cosine = min(max(cosine / np.sqrt(square), -1.0), 1.0)
            rank = (1.0 - np.arccos(cosine) / np.pi) * RANKS + 0.5
            out_rank[row * across + column] = np.uint16(rank)


@kernel
def sort_by_rank(rank: U2, out_order: I4) -> None:
    """Numbers of the samples by their ranks, equal ones as they come; both (n,)."""
    begin = np.zeros(RANKS + 2, np.int32)
    for i in range(rank.size):
        begin[np.int64(rank[i]) + 1] += 1
    for k in range(RANKS + 1):
        begin[k + 1] += begin[k]
    for i in range(rank.size):
        k = np.int64(rank[i])
        out_order[begin[k]] = i
        begin[k] += 1


@kernel
def scatter(
    cells: I4, places: F4, order: I4, row_low: int, own: tuple[int, int, int, int], stride: int,
    out_sample: I4, out_disparity: F4,
) -> None:  # fmt: skip
    """Each sample goes to the one pixel whose square holds it.

    Args:
        cells: (n,) from `land_samples`.
        places: (3, n).
        order: (n,) from `sort_by_rank`: later samples win. Empty: the larger disparity wins.
        row_low: first row of the band.
        own: as in `land_samples`.
        stride: width of the reference's picture.
        out_sample: (rows, width) index in the reference's picture, preset to -1.
        out_disparity: (rows, width) preset to -1.
    """
    rows, width = out_sample.shape
    low, high = row_low * width, (row_low + rows) * width
    across = own[3] - own[2]
    flat_sample, flat_disparity = out_sample.reshape(-1), out_disparity.reshape(-1)
    by_order = order.size > 0
    for k in range(cells.size):
        i = order[k] if by_order else k
        cell = cells[i]
        if cell < low or cell >= high:
            continue
        if by_order or places[2, i] > flat_disparity[cell - low]:
            flat_disparity[cell - low] = places[2, i]
            flat_sample[cell - low] = (own[0] + i // across) * stride + own[2] + i % across


@kernel
def measure_halves(
    g: Geometry, disparity: F4, own: tuple[int, int, int, int], row_low: int, row_high: int,
    largest: Real, places: F4, out_halves: F4,
) -> None:  # fmt: skip
    """Half the side of the square that each sample has grown to, in rows of the desired view.

    A sample counts as a square facing the reference eye, as tall as its row: on a sphere's upper
    rows samples crowd along the row, but no closer to the next one. Areas on the unit plane,
    cylinder or sphere are ``det(Y, Yu, Yv) / |Y|^3``.

    largest is the most that comes out; out_halves is (n,).
    """
    across = own[3] - own[2]
    pixel = 1.0 if g[TARGET] == 0.0 else g[TARGET + 2] * g[TARGET + 4]
    for row in range(row_low, row_high):
        for column in range(across):
            i = row * across + column
            u, v = np.float64(own[2] + column), np.float64(own[0] + row)
            a, b, c = direction(g, SOURCE, u, v)
            ua, ub, va, vb, vc = 1.0, 0.0, 0.0, 1.0, 0.0
            if g[SOURCE] != 0.0:
                flat = np.sqrt(a * a + b * b)
                step, up = g[SOURCE + 2], g[SOURCE + 4]
                ua, ub = step * b / flat, -step * a / flat
                va, vb, vc = 0.0, 0.0, -up
                if g[SOURCE] == 2.0:
                    va, vb, vc = up * c * a / flat, up * c * b / flat, -up * flat
            delta = np.float64(disparity[own[0] + row, own[2] + column])
            y0, y1, y2 = reach(g, u, v, delta)
            u0, u1, u2 = g[0] * ua + g[1] * ub, g[4] * ua + g[5] * ub, g[8] * ua + g[9] * ub
            v0 = g[0] * va + g[1] * vb + g[2] * vc
            v1 = g[4] * va + g[5] * vb + g[6] * vc
            v2 = g[8] * va + g[9] * vb + g[10] * vc
            area = y0 * (u1 * v2 - u2 * v1) + y1 * (u2 * v0 - u0 * v2) + y2 * (u0 * v1 - u1 * v0)
            scale = np.float64(places[2, i]) / delta if delta > 0.0 else ZERO
            if not delta > 0.0:
                _, _, scale = project(g, TARGET, y0, y1, y2)
            growth = np.sqrt(abs(area) * scale * scale * scale / pixel)
            out_halves[i] = min(max(TURNED * growth, 0.5), largest)


@inner
def box_of(
    g: Geometry, x: Real, y: Real, half: Real, stretched: bool, width: int
) -> tuple[int, int, int, int]:
    """Left, right, top, bottom pixel of a splat; columns may lie beyond the seam."""
    wide = half
    if g[TARGET] != 0.0:
        if stretched and g[TARGET] == 2.0:
            flat = np.cos((g[TARGET + 3] - y) * g[TARGET + 4])
            wide = half / flat if half < 0.5 * width * flat else 0.5 * width
        wide = min(wide, 0.5 * (width - 1))
    return (
        int(np.ceil(x - wide)), int(np.floor(x + wide)),
        int(np.ceil(y - half)), int(np.floor(y + half)),
    )  # fmt: skip


@kernel
def splat(
    g: Geometry, cells: I4, places: F4, halves: F4, stretched: bool, seen: I4, seen_low: int,
    row_low: int, own: tuple[int, int, int, int], stride: int, tolerance: Real,
    front: F4, nearest: F4, out_sample: I4, out_disparity: F4,
) -> None:  # fmt: skip
    """Each visible sample paints a square: a pixel goes to the front surface that reaches it.

    Among samples of one surface the nearest center wins, as in `_scatter.spread`.

    Args:
        g: geometry.
        cells: (n,) from `land_samples`.
        places: (3, n).
        halves: (n,) half the sides; one number for all if there is only one.
        stretched: whether squares grow wider where a sphere's columns crowd.
        seen: (rows and more, width) samples by `scatter`; one that lost its pixel paints nothing.
        seen_low: its first row.
        row_low: first row of the band.
        own: as in `land_samples`.
        stride: width of the reference's picture.
        tolerance: relative difference in disparity up to which samples are one surface.
        front: (rows, width) to work in.
        nearest: (rows, width) to work in.
        out_sample: (rows, width).
        out_disparity: (rows, width), -1 = uncovered.
    """
    rows, width = out_sample.shape
    across = own[3] - own[2]
    keep = ONE - np.float32(tolerance)
    last_seen = seen_low + seen.shape[0]
    front.fill(-1.0)
    nearest.fill(np.inf)
    out_sample.fill(NOWHERE)
    out_disparity.fill(-1.0)
    for turn in range(2):  # first what is in front, then who comes nearest to the pixel
        for i in range(cells.size):
            x, y, delta = places[0, i], places[1, i], places[2, i]
            half = np.float64(halves[i] if halves.size > 1 else halves[0])
            if not (y + half >= row_low and y - half < row_low + rows):
                continue
            index = (own[0] + i // across) * stride + own[2] + i % across
            cell = cells[i]
            if (
                cell >= 0 and seen_low <= cell // width < last_seen
                and seen[cell // width - seen_low, cell % width] != index
            ):  # fmt: skip
                continue
            left, right, top, bottom = box_of(
                g, np.float64(x), np.float64(y), half, stretched, width
            )
            if g[TARGET] == 0.0:
                left, right = max(left, 0), min(right, width - 1)
            for j in range(max(top - row_low, 0), min(bottom - row_low + 1, rows)):
                for far in range(left, right + 1):
                    k = far % width if g[TARGET] != 0.0 else far
                    if turn == 0:
                        front[j, k] = max(front[j, k], delta)
                        continue
                    dx, dy = np.float32(far) - x, np.float32(j + row_low) - y
                    distance = dx * dx + dy * dy
                    if delta >= front[j, k] * keep and distance < nearest[j, k]:
                        nearest[j, k] = distance
                        out_sample[j, k], out_disparity[j, k] = index, delta


@kernel
def gather(color: F4, sample: I4, out_color: F4) -> None:
    """Fetch the colour of the sample each pixel sees; 0 where there is none.

    color is (H, W, 4) linear, sample (rows, width), out_color (rows, width, 4).
    """
    rows, width = sample.shape
    for y in range(rows):
        for x in range(width):
            held, index = sample[y, x], y * width + x
            store4(out_color, index, load4(color, held) if held >= 0 else zero4())
