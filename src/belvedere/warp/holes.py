"""Filling holes, only when asked and never without saying which pixels were invented."""

from __future__ import annotations

import numpy as np

from belvedere.ground.color import color_to_linear
from belvedere.scene import Frame
from belvedere.warp.reconstruct import SURFACE_TOLERANCE


def fill_background(frame: Frame, tolerance: float = SURFACE_TOLERANCE) -> Frame:
    """Continue the farther of the surfaces round each hole into it.

    What a hole hides is nearly always the background: the foreground ends at the hole's edge. Each
    hole takes the farthest disparity met in eight directions and the colours there, weighted by
    one over the squared distance.

    Args:
        frame: as `warp` gives it.
        tolerance: relative difference in disparity up to which borders are one surface.

    Returns:
        A frame whose ``filled`` mask is True where colour was invented; coverage still says 0
        there. A frame without any covered pixel comes back as it is, with an empty mask.

    Memory: 32 bytes a pixel.
    """
    from belvedere.ground.color import color_to_srgb8
    from belvedere.warp import _holes

    holes = np.isnan(frame.disparity)
    if not holes.any() or holes.all():
        return Frame(
            frame.camera, frame.color, frame.disparity, frame.coverage, np.zeros_like(holes)
        )
    steps = np.empty((_holes.SIDES, *holes.shape), np.int32)
    _holes.nearest_covered(frame.disparity, steps)
    linear = color_to_linear(frame.color)
    color, disparity = linear.copy(), frame.disparity.copy()
    _holes.fill_from_background(linear, frame.disparity, steps, tolerance, color, disparity)
    filled = holes & ~np.isnan(disparity)
    if frame.color.dtype == np.uint8:
        color = np.where(filled[..., None], color_to_srgb8(color), frame.color)
    return Frame(frame.camera, color, disparity, frame.coverage, filled)
