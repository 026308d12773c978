"""Depth buffers of rasterisers, as disparity and back.

Depth conventions, Z the depth along the camera's axis in metres (``far`` may be ``math.inf``):

=============  ===================  ====================  ===================================
word           at the near plane    at the far plane      who
=============  ===================  ====================  ===================================
"ndc"          -1                   1                     OpenGL's clip space
"zero_to_one"  0                    1                     Direct3D, Vulkan, WebGPU; and what
                                                          OpenGL's z-buffer holds ("window")
"reversed"     1                    0                     reversed z, for float depth buffers
=============  ===================  ====================  ===================================

The words say what clip space or a buffer holds. "window" is another word for "zero_to_one": what
OpenGL's depth buffer holds with either of its clip spaces. Disparity is linear in all of them, so
they quantise it evenly.

Source: OpenGL 4.6 core, 13.8; spec portal-walkthrough 3.4.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_number
from belvedere.ground.errors import CameraError, InputError

BufferDepth = Literal["window", "ndc", "zero_to_one", "reversed"]

BUFFER_SLACK = 1e-5
"""How far outside its range a z-buffer value may be: rounding of a 16-bit buffer or of float32."""


def disparity_from_zbuffer(
    zbuffer: npt.ArrayLike,
    near: float,
    far: float = math.inf,
    depth: BufferDepth = "window",
    *,
    sky: Literal["infinite", "far"] = "infinite",
) -> npt.NDArray[Any]:
    """Disparity ``1 / Z`` of depth-buffer values; it is linear in them, so nothing is lost.

    Args:
        zbuffer: (...) floating point. Divide 16-bit buffers by 65535, 24-bit ones by 2^24 - 1.
        near: distance of the near plane, metres.
        far: distance of the far plane; ``math.inf`` for none.
        depth: what the buffer holds: "window" (the same as "zero_to_one"), "ndc", "reversed".
        sky: what a pixel exactly at the far value is: "infinite" (disparity 0, the default: nothing
            was drawn there, and the background should not slide when the eye moves) or "far" (a
            surface at ``far``).

    Returns:
        (...) disparity in 1/metre: float32 for float32 input, else float64. NaN stays NaN.

    Raises:
        InputError: whole numbers, or values outside the convention's range (another one is meant).
        CameraError: not 0 < near < far.
    """
    check_choice("zbuffer", "depth", depth, ("window", "ndc", "zero_to_one", "reversed"))
    check_choice("zbuffer", "sky", sky, ("infinite", "far"))
    inverse_near, inverse_far = inverse_planes(near, far)
    values = np.asarray(zbuffer)
    if not np.issubdtype(values.dtype, np.floating):
        raise InputError(
            f"zbuffer is {values.dtype}, expected floating point: divide by the largest value of "
            "its type first (65535 for 16 bits)"
        )
    wide = values.astype(np.float64)
    low = -1.0 if depth == "ndc" else 0.0
    outside = (wide < low - BUFFER_SLACK) | (wide > 1.0 + BUFFER_SLACK)
    if outside.any():
        raise InputError(
            f"zbuffer holds {wide[outside].flat[0]:.6g}, expected {low:g} to 1 for "
            f"depth={depth!r}: is it in another convention, or linear depth already?"
        )
    nearness = {"ndc": (1.0 - wide) / 2, "reversed": wide}.get(depth, 1.0 - wide)
    nearness = np.clip(nearness, 0.0, 1.0)  # 1 at the near plane, 0 at the far plane
    disparity = nearness * inverse_near + (1.0 - nearness) * inverse_far
    if sky == "infinite":
        disparity = np.where(nearness == 0, 0.0, disparity)
    return disparity.astype(np.float32) if values.dtype == np.float32 else disparity


def zbuffer_from_disparity(
    disparity: npt.ArrayLike, near: float, far: float = math.inf, depth: BufferDepth = "window"
) -> npt.NDArray[Any]:
    """Depth-buffer values of disparity ``1 / Z``: the inverse of `disparity_from_zbuffer`.

    Args:
        disparity: (...) 1/metre. 0 and what lies beyond ``far`` get the far value; what is nearer
            than ``near`` gets the near value; NaN stays NaN.
        near: distance of the near plane, metres.
        far: distance of the far plane; ``math.inf`` for none.
        depth: what the buffer is to hold.

    Returns:
        (...) values: float32 for float32 input, else float64.

    Raises:
        CameraError: not 0 < near < far.
    """
    check_choice("zbuffer", "depth", depth, ("window", "ndc", "zero_to_one", "reversed"))
    inverse_near, inverse_far = inverse_planes(near, far)
    values = np.asarray(disparity)
    nearness = (values.astype(np.float64) - inverse_far) / (inverse_near - inverse_far)
    nearness = np.clip(nearness, 0.0, 1.0)
    buffer = {"ndc": 1.0 - 2.0 * nearness, "reversed": nearness}.get(depth, 1.0 - nearness)
    return buffer.astype(np.float32) if values.dtype == np.float32 else buffer


def inverse_planes(near: float, far: float) -> tuple[float, float]:
    """``(1 / near, 1 / far)``.

    Raises:
        CameraError: not 0 < near < far.
    """
    n = check_number("OpenGL", "near", near, 0.0, open_low=True, error=CameraError)
    if math.isnan(far) or not far > n:
        raise CameraError(f"OpenGL.far is {far:g}, expected more than near ({n:g}) or infinity")
    return 1.0 / n, 0.0 if math.isinf(far) else 1.0 / far
