"""Slow twins of the warp, in float64 and in the words of the specs, not of the kernels.

Specs image-warping 3.2-3.7, offset-buffer-warping 3.1-3.6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera

F8 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int64]


def project_samples(
    reference: Camera, desired: Camera, u: npt.ArrayLike, v: npt.ArrayLike, delta: npt.ArrayLike
) -> tuple[F8, F8, F8]:
    """Where samples land, by way of the world: unproject, then project. Disparities above 0.

    X = C1 + ray / delta; in the desired camera's axes X is (x, y, Z); u2 = fx x / Z + cx ...
    """
    points = reference.center + reference.rays(u, v) / np.asarray(delta, float)[..., None]
    seen = (points - desired.center) @ np.linalg.inv(desired.camera_to_world[:3, :3]).T
    image = seen @ desired.intrinsics.T
    depth = np.where(seen[..., 2] > 0, seen[..., 2], np.nan)
    return image[..., 0] / depth, image[..., 1] / depth, 1.0 / depth


def nearest_samples(
    reference: Camera, desired: Camera, disparity: npt.NDArray[np.float32]
) -> tuple[F8, I8]:
    """Unit splats, z-buffer: (H2, W2) warped disparity (NaN: hole), sample seen (or -1)."""
    front = np.full(desired.size, np.nan)
    sample = np.full(desired.size, -1, np.int64)
    height, width = disparity.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    x, y, delta = project_samples(reference, desired, u, v, disparity.astype(float))
    for row, column in np.argwhere(np.isfinite(delta)):
        px, py = math.floor(x[row, column] + 0.5), math.floor(y[row, column] + 0.5)
        if not (0 <= px < desired.width and 0 <= py < desired.height):
            continue
        if not front[py, px] >= delta[row, column]:
            front[py, px] = delta[row, column]
            sample[py, px] = row * width + column
    return front, sample


def paint_in_order(
    reference: Camera, desired: Camera, disparity: npt.NDArray[np.float32]
) -> tuple[F8, I8]:
    """Unit splats without comparing depths: in increasing cosine to the desired eye (spec 3.6)."""
    height, width = disparity.shape
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = reference.rays(u, v)
    cosine = rays @ (desired.center - reference.center) / np.linalg.norm(rays, axis=-1)
    x, y, delta = project_samples(reference, desired, u, v, disparity.astype(float))
    front = np.full(desired.size, np.nan)
    sample = np.full(desired.size, -1, np.int64)
    for index in np.argsort(cosine, axis=None, kind="stable"):
        row, column = divmod(int(index), width)
        if not np.isfinite(delta[row, column]):
            continue
        px, py = math.floor(x[row, column] + 0.5), math.floor(y[row, column] + 0.5)
        if 0 <= px < desired.width and 0 <= py < desired.height:
            front[py, px] = delta[row, column]
            sample[py, px] = index
    return front, sample


def splat_pixel(
    delta: npt.NDArray[np.float32],
    right: F8,
    down: F8,
    half: float,
    reach: int,
    y: int,
    x: int,
    tolerance: float,
) -> tuple[int, int] | None:
    """The cell whose sample a pixel shows when every sample paints a square; None: nobody's.

    Args:
        delta: (H, W) disparity of the sample in each cell, NaN where there is none.
        right: (H, W) its place right of the cell's middle, and down:
        down: below it, cells.
        half: half the side of the squares.
        reach: cells away that are asked.
        y: the pixel's row.
        x: its column.
        tolerance: relative difference in disparity that is still one surface.
    """
    reaching = {}
    for j in range(y - reach, y + reach + 1):
        for i in range(x - reach, x + reach + 1):
            off = (i - x + right[j, i], j - y + down[j, i])
            if not math.isnan(delta[j, i]) and max(abs(off[0]), abs(off[1])) <= half:
                reaching[j, i] = math.hypot(*off)
    if not reaching:
        return None
    limit = max(float(delta[cell]) for cell in reaching) * (1.0 - tolerance)
    if delta[y, x] >= limit:
        return y, x
    front = {cell: away for cell, away in reaching.items() if delta[cell] >= limit}
    return min(front, key=lambda cell: front[cell])


def merge_layers(
    colors: Sequence[npt.NDArray[np.float32]],
    disparities: Sequence[npt.NDArray[np.float32]],
    weights: npt.ArrayLike,
    composite: str,
    tolerance: float,
) -> tuple[F8, F8]:
    """Whole pixels of several references to one: (H, W, C) linear colour, (H, W) disparity.

    "blend": the weighted mean of all that lie within the tolerance of the front; "nearest": the
    first that has anything; "fuzzy": a later one replaces an earlier if it is nearer by more than
    the tolerance (spec offset-buffer-warping 3.4). Holes are 0 and NaN.
    """
    shape = colors[0].shape
    color, disparity = np.zeros(shape), np.full(shape[:2], np.nan)
    for y, x in np.ndindex(shape[:2]):
        seen = [n for n, one in enumerate(disparities) if not math.isnan(one[y, x])]
        if not seen:
            continue
        deltas = {n: float(disparities[n][y, x]) for n in seen}
        if composite == "blend":
            front = max(deltas.values())
            chosen = [n for n in seen if deltas[n] >= front * (1 - tolerance)]
        else:
            best = seen[0]
            for n in seen[1:]:
                if composite == "fuzzy" and deltas[n] > deltas[best] * (1 + tolerance):
                    best = n
            chosen = [best]
        share = np.array([np.asarray(weights)[n] for n in chosen], float)
        share /= share.sum()
        disparity[y, x] = sum(s * deltas[n] for s, n in zip(share, chosen, strict=True))
        color[y, x] = sum(s * colors[n][y, x].astype(float)
                          for s, n in zip(share, chosen, strict=True))  # fmt: skip
    return color, disparity


def filter_weight(x: float, y: float, reading: str, radius: float = 1.0) -> float:
    """Raised cosine at (x, y) output pixels from a pixel's centre (spec offset 3.6).

    ``radius`` narrows the paper's filter, which has 1.
    """
    x, y = x / radius, y / radius
    if reading == "separable":
        if max(abs(x), abs(y)) >= 1.0:
            return 0.0
        return 0.25 * (1.0 + math.cos(math.pi * x)) * (1.0 + math.cos(math.pi * y))
    reach = math.hypot(x, y) / math.sqrt(2.0)
    return 0.0 if reach >= 1.0 else 0.5 * (1.0 + math.cos(math.pi * reach))


def offset_warp(
    matrix: F8,
    color: F8,
    disparity: F8,
    size: tuple[int, int],
    reading: str,
    radius: float,
    density: int,
    scale: int = 2,
    bits: int = 2,
) -> tuple[F8, F8, npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
    """The offset buffer's picture of one unbroken plane (pseudo-code of spec offset 3).

    A cell keeps the nearest surface, told apart by the first seven bits of its disparity. Of that,
    it keeps the sub-sample nearest its middle; of those as near, by steps, the one whose place is
    last in it, and in every second cell the first (ours: the paper keeps the nearest).

    Args:
        matrix: (3, 4) warp matrix.
        color: (H, W, C) linear.
        disparity: (H, W), affine in the pixel's place.
        size: (rows, columns) of the desired view.
        reading: of the filter, "radial" or "separable".
        radius: of the filter, output pixels.
        density: sub-samples per pixel and axis, a.
        scale: cells per output pixel, b.
        bits: offset bits per axis, o.

    Returns:
        (rows, columns, C) colour, (rows, columns) disparity with NaN in holes, coverage, and where
        it is sure: no sub-sample that matters had the place of another in its cell.
    """
    height, width = disparity.shape
    cells: dict[tuple[int, int], tuple[float, float, float, F8, tuple[int, ...]]] = {}
    tied: set[tuple[int, int]] = set()
    places = 1 << bits
    corner, levels = 2 * (places - 1) ** 2, 2 ** min(max(2 * bits - 2, 0), 3) - 1
    for j in range(height * density):
        for i in range(width * density):
            u, v = (i + 0.5) / density - 0.5, (j + 0.5) / density - 0.5
            delta = _on_plane(disparity, u, v)
            r, s, t = matrix @ np.array([u, v, 1.0, delta])
            if t <= 0:
                continue
            x, y = scale * (r / t + 0.5), scale * (s / t + 0.5)
            cell = (math.floor(y), math.floor(x))
            qu, qv = (math.floor((x - cell[1]) * places), math.floor((y - cell[0]) * places))
            away = (2 * qu - places + 1) ** 2 + (2 * qv - places + 1) ** 2
            near = (corner - away) * levels // max(corner - 2, 1)
            sign = -1 if (cell[0] + cell[1]) % 2 else 1
            fraction, exponent = math.frexp(delta / t)
            rank = (exponent, math.floor(fraction * 128), near, sign * qv, sign * qu)
            if cell in cells and cells[cell][4] >= rank:
                if cells[cell][4] == rank:
                    tied.add(cell)
                continue
            tied.discard(cell)
            place_x = (cell[1] + (qu + 0.5) / places) / scale - 0.5
            place_y = (cell[0] + (qv + 0.5) / places) / scale - 0.5
            cells[cell] = (delta / t, place_x, place_y, interpolated(color, u, v), rank)
    out = np.zeros((*size, color.shape[2]))
    depth, coverage = np.full(size, np.nan), np.zeros(size, np.float32)
    sure = np.ones(size, bool)
    reach = scale // 2
    for row in range(size[0]):
        for column in range(size[1]):
            own = [
                (row * scale + j, column * scale + i) for j in range(scale) for i in range(scale)
            ]
            coverage[row, column] = sum(cell in cells for cell in own) / scale**2
            if coverage[row, column] == 0:
                continue
            total, total_delta = 0.0, 0.0
            for j in range(-reach, scale + reach):
                for i in range(-reach, scale + reach):
                    held = cells.get((row * scale + j, column * scale + i))
                    if held is None:
                        continue
                    sure[row, column] &= (row * scale + j, column * scale + i) not in tied
                    weight = filter_weight(held[1] - column, held[2] - row, reading, radius)
                    total += weight
                    total_delta += weight * held[0]
                    out[row, column] += weight * held[3]
            out[row, column] /= total
            depth[row, column] = total_delta / total
    return out, depth, coverage, sure


def _on_plane(disparity: F8, u: float, v: float) -> float:
    """An affine disparity map continued anywhere."""
    du = disparity[0, 1] - disparity[0, 0]
    dv = disparity[1, 0] - disparity[0, 0]
    return float(disparity[0, 0] + u * du + v * dv)


def interpolated(color: F8, u: float, v: float) -> F8:
    """Colour between samples of one surface: bicubic where there are sixteen, else bilinear."""
    height, width = color.shape[:2]
    i, j = math.floor(u), math.floor(v)
    if not (1 <= i <= width - 3 and 1 <= j <= height - 3):
        return _clamped(color, u, v)
    rows = [_catmull_rom(color[j + k, i - 1 : i + 3], u - i) for k in range(-1, 3)]
    return _catmull_rom(np.array(rows), v - j)


def _catmull_rom(samples: F8, f: float) -> F8:
    """The cubic through the middle two of (4, C) samples with the slopes of their neighbours."""
    before, start, end, after = samples
    m0, m1 = (end - before) / 2, (after - start) / 2
    return (
        (2 * f**3 - 3 * f**2 + 1) * start
        + (f**3 - 2 * f**2 + f) * m0
        + (3 * f**2 - 2 * f**3) * end
        + (f**3 - f**2) * m1
    )


def _clamped(color: F8, u: float, v: float) -> F8:
    """Bilinear colour, the outermost samples continued."""
    height, width = color.shape[:2]
    u, v = min(max(u, 0.0), width - 1.0), min(max(v, 0.0), height - 1.0)
    i, j = min(int(u), width - 2), min(int(v), height - 2)
    fu, fv = u - i, v - j
    upper = color[j, i] * (1 - fu) + color[j, i + 1] * fu
    lower = color[j + 1, i] * (1 - fu) + color[j + 1, i + 1] * fu
    return upper * (1 - fv) + lower * fv


def centroid(weight: F8) -> tuple[float, float]:
    """(u, v) of the middle of a picture's brightness."""
    v, u = np.indices(weight.shape)
    return float((weight * u).sum() / weight.sum()), float((weight * v).sum() / weight.sum())


def psnr(a: npt.NDArray[np.uint8], b: npt.NDArray[np.uint8], mask: npt.NDArray[np.bool_]) -> float:
    """Decibels between encoded bytes, over the pixels of the mask."""
    difference = a[mask][:, :3].astype(float) - b[mask][:, :3].astype(float)
    return 10.0 * math.log10(255.0**2 / float((difference**2).mean()))
