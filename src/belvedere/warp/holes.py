"""Filling holes, only when asked and never without saying which pixels were invented."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.errors import InputError
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.scene import Frame
from belvedere.warp.manifold import is_panoramic, unrolled
from belvedere.warp.prepare import linear_rgba
from belvedere.warp.reconstruct import SURFACE_TOLERANCE

SOFTENINGS = 2
"""Times that filled pixels are averaged with their neighbours at each level."""

WORTH_THREADS = 1 << 15
"""Pixels of a level from which on it is shared among threads."""

Level = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]


def fill_background(
    frame: Frame, tolerance: float = SURFACE_TOLERANCE, threads: int | None = None
) -> Frame:
    """Continue the farther of the surfaces round each hole into it.

    What a hole hides is nearly always the background: the foreground ends at the hole's edge. The
    picture is halved again and again, each block keeping the farthest surface it shows, until no
    hole is left; then each missing pixel is interpolated from the coarser level. Small holes are
    closed by their nearest surroundings, large ones smoothly: at every level filled pixels are
    averaged with their neighbours.

    Args:
        frame: as `warp` gives it.
        tolerance: relative difference in disparity up to which pixels are one surface.
        threads: how many to use; the result does not depend on it.

    Returns:
        A frame whose ``filled`` mask is True where colour was invented; coverage still says 0
        there. A frame without any covered pixel comes back as it is, with an empty mask.

    Raises:
        InputError: what is given is no frame.

    Memory: 44 bytes a pixel.
    """
    if not isinstance(frame, Frame):
        raise InputError(
            f"fill_background.frame is a {type(frame).__name__}, expected a Frame, as warp gives it"
        )
    from belvedere.warp import _holes

    if is_panoramic(frame.camera):
        return fill_all_round(frame, tolerance, threads)
    holes = np.isnan(frame.disparity)
    if not holes.any() or holes.all():
        return replace(frame, filled=np.zeros_like(holes))
    colors = [np.array(linear_rgba(frame.color, threads))]
    disparities = [frame.disparity.copy()]
    while np.isnan(disparities[-1]).any():
        size = tuple(-(-side // 2) for side in disparities[-1].shape)
        fine = colors[-1], disparities[-1]
        color, disparity = np.empty((*size, 4), np.float32), np.empty(size, np.float32)

        def shrink(
            band: tuple[int, int], fine: Level = fine, coarse: Level = (color, disparity)
        ) -> None:
            rows, source = slice(*band), slice(2 * band[0], 2 * band[1])
            _holes.shrink_background(
                fine[0][source], fine[1][source], tolerance, coarse[0][rows], coarse[1][rows]
            )

        run_parallel(shrink, row_bands(size[0], _bands(size, threads)), threads)
        colors.append(color)
        disparities.append(disparity)
    for level in range(len(colors) - 2, -1, -1):
        missing = np.isnan(disparities[level])
        bands = row_bands(missing.shape[0], _bands(missing.shape, threads))

        def fill(band: tuple[int, int], level: int = level) -> None:
            _holes.fill_from_coarser(
                colors[level + 1],
                disparities[level + 1],
                tolerance,
                *band,
                colors[level],
                disparities[level],
            )

        run_parallel(fill, bands, threads)
        rows, columns = np.nonzero(missing)
        soft = np.empty((len(rows), 4), np.float32), np.empty(len(rows), np.float32)
        for _ in range(SOFTENINGS):
            _holes.soften_filled(
                colors[level], disparities[level], missing, rows, columns, tolerance, *soft
            )
            colors[level][rows, columns], disparities[level][rows, columns] = soft
    color = frame.color.copy()
    color[holes] = from_linear(colors[0][holes][:, None], frame.color)[:, 0]
    return replace(frame, color=color, disparity=disparities[0], filled=holes)


def fill_all_round(frame: Frame, tolerance: float, threads: int | None) -> Frame:
    """`fill_background` of a panorama, which goes on beyond both sides of its picture."""
    width, beyond = frame.camera.width, -(-frame.camera.width // 4)
    columns = np.mod(np.arange(-beyond, width + beyond), width)
    color, disparity, coverage = (
        np.ascontiguousarray(held[:, columns])
        for held in (frame.color, frame.disparity, frame.coverage)
    )
    wide = Frame(unrolled(frame.camera, beyond), color, disparity, coverage)
    filled = fill_background(wide, tolerance, threads)
    own = np.s_[:, beyond : beyond + width]
    mask = np.zeros(frame.camera.size, bool) if filled.filled is None else filled.filled[own]
    return Frame(
        frame.camera, filled.color[own].copy(), filled.disparity[own].copy(), frame.coverage,
        mask.copy(),
    )  # fmt: skip


def _bands(size: tuple[int, ...], threads: int | None) -> int:
    """Into how many bands a level is cut: a small one is done before a thread wakes."""
    return thread_count(threads) if size[0] * size[1] > WORTH_THREADS else 1


def from_linear(linear: npt.NDArray[np.float32], like: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """(H, W, 4) linear colour as another picture has it: its type and its channels."""
    from belvedere.warp import _compose

    if like.dtype != np.uint8:
        return linear[..., : like.shape[2]]
    encoded = np.empty((*linear.shape[:2], like.shape[2]), np.uint8)
    _compose.encode(linear, LINEAR_TO_SRGB8, encoded)
    return encoded
