"""Filling holes, only when asked and never without saying which pixels were invented."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.errors import InputError
from belvedere.ground.threads import run_parallel, thread_count
from belvedere.scene import Frame
from belvedere.warp.prepare import linear_rgba, row_bands
from belvedere.warp.reconstruct import SURFACE_TOLERANCE

SOFTENINGS = 2
"""Times that filled pixels are averaged with their neighbours at each level."""

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

    Memory: 64 bytes a pixel.
    """
    if not isinstance(frame, Frame):
        raise InputError(
            f"fill_background.frame is a {type(frame).__name__}, expected a Frame, as warp gives it"
        )
    from belvedere.warp import _compose, _holes

    holes = np.isnan(frame.disparity)
    if not holes.any() or holes.all():
        return Frame(
            frame.camera, frame.color, frame.disparity, frame.coverage, np.zeros_like(holes)
        )
    count = thread_count(threads)
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

        run_parallel(shrink, row_bands(size[0], count), threads)
        colors.append(color)
        disparities.append(disparity)
    for level in range(len(colors) - 2, -1, -1):
        missing = np.isnan(disparities[level])
        bands = row_bands(missing.shape[0], count)

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
        for _ in range(SOFTENINGS):
            rough = colors[level], disparities[level]
            colors[level], disparities[level] = rough[0].copy(), rough[1].copy()

            def soften(
                band: tuple[int, int],
                rough: Level = rough,
                smooth: Level = (colors[level], disparities[level]),
                missing: npt.NDArray[np.bool_] = missing,
            ) -> None:
                _holes.soften_filled(*rough, missing, tolerance, *band, *smooth)

            run_parallel(soften, bands, threads)
    if frame.color.dtype == np.uint8:
        encoded = np.empty_like(frame.color)
        _compose.encode(colors[0], LINEAR_TO_SRGB8, encoded)
    else:
        encoded = colors[0][..., : frame.color.shape[2]]
    return Frame(
        frame.camera,
        np.where(holes[..., None], encoded, frame.color),
        disparities[0],
        frame.coverage,
        holes,
    )
