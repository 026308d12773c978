"""OpenGL's and glTF's cameras and depth buffers, both ways.

OpenGL's camera axes are x right, y **up**, z **backward**; ours are x right, y down, z forward. A
pose given here as ``camera_to_world`` has OpenGL's axes (a glTF node's world matrix, the inverse
of a view matrix). Clip space is left-handed with y up; pixel (0, 0) is the picture's upper left,
so images read with ``glReadPixels`` are flipped upside down first.

**The classic mistake.** A frustum ``glFrustum(l, r, b, t, n, f)`` draws its image plane at the
near distance n, and the z-buffer then holds, exactly linearly, ``n / Z``. A camera whose image
plane is at unit depth (every `Camera`) needs ``1 / Z``. Mix the two, and every surface is off by
the factor n: with n = 0.1 the scene shrinks to a tenth and still looks plausible from the
reference's own place. So nothing here gives or takes ``n / Z``: `camera_from_frustum` rescales the
plane to unit depth, and `disparity_from_zbuffer` divides by n.

Depth conventions ("ndc", "zero_to_one", "reversed") are told in `belvedere.scene.zbuffer`, which
also reads and writes depth buffers.

Source: OpenGL 4.6 core, 13.6; glTF 2.0, 5.12; specs image-warping 2 and portal-walkthrough 3.4.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import (
    as_array,
    check_choice,
    check_finite,
    check_image_size,
    check_number,
    check_pose,
    check_shape,
)
from belvedere.ground.errors import CameraError
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import F8
from belvedere.scene.pose import OPENCV_FROM_OPENGL, invert_pose
from belvedere.scene.zbuffer import inverse_planes

ClipDepth = Literal["ndc", "zero_to_one", "reversed"]

ROW_TOLERANCE = 1e-6
"""Rounding that the exact zeros and ones of a float32 projection matrix may have suffered."""


# ---- poses ----------------------------------------------------------------


def camera_to_world_from_view_matrix(view_matrix: npt.ArrayLike) -> F8:
    """(4, 4) pose with OpenGL's axes from a view matrix (world to eye, ``gluLookAt``'s).

    Raises:
        CameraError: the matrix is not rigid (see `check_pose`).
    """
    return invert_pose(check_pose("opengl", "view_matrix", view_matrix))


def opengl_pose(camera: Camera) -> F8:
    """(4, 4) camera_to_world of a camera, with OpenGL's axes. Its inverse is the view matrix."""
    return camera.camera_to_world @ OPENCV_FROM_OPENGL


# ---- frustum ----------------------------------------------------------------


def camera_from_frustum(
    left: float,
    right: float,
    bottom: float,
    top: float,
    near: float,
    camera_to_world: npt.ArrayLike,
    *,
    width: int,
    height: int,
) -> Camera:
    """The camera of ``glFrustum(left, right, bottom, top, near, far)``, off-axis or not.

    Args:
        left: metres on the near plane from the axis to the picture's left edge; likewise others.
        right: see ``left``.
        bottom: see ``left``.
        top: see ``left``.
        near: distance of that plane, metres.
        camera_to_world: (4, 4) pose with OpenGL's axes.
        width: pixels across.
        height: pixels down.

    Raises:
        CameraError: an empty or mirrored frustum, a pose that is not rigid.
    """
    check_image_size("Camera", width, height)
    sides = as_array("frustum", "sides", [left, right, bottom, top])
    check_finite("frustum", "sides", sides, CameraError)
    n = check_number("frustum", "near", near, 0.0, open_low=True, error=CameraError)
    if not (right > left and top > bottom):
        raise CameraError(
            f"frustum: left {left}, right {right}, bottom {bottom}, top {top} enclose nothing: "
            "expected left < right and bottom < top"
        )
    pose = check_pose("frustum", "camera_to_world", camera_to_world)
    across, along = (right - left) / width, (top - bottom) / height
    plane = np.array(  # columns: pixel right, pixel down, to pixel (0, 0); OpenGL's axes
        [
            [across, 0.0, left + 0.5 * across],
            [0.0, -along, top - 0.5 * along],
            [0.0, 0.0, -n],
        ]
    )
    return Camera.from_matrix(pose[:3, :3] @ plane, pose[:3, 3], width=width, height=height)


def frustum_from_camera(camera: Camera, near: float) -> tuple[float, float, float, float]:
    """``(left, right, bottom, top)`` for ``glFrustum``, metres on the plane at ``near``.

    Raises:
        CameraError: the camera's pixels are skewed, which no frustum says: use
            `projection_matrix`.
    """
    n = check_number("frustum", "near", near, 0.0, open_low=True, error=CameraError)
    k = camera.intrinsics
    _refuse_skew(k, "a frustum", "projection_matrix says it")
    left = -(k[0, 2] + 0.5) / k[0, 0] * n
    right = (camera.width - 0.5 - k[0, 2]) / k[0, 0] * n
    top = (k[1, 2] + 0.5) / k[1, 1] * n
    bottom = -(camera.height - 0.5 - k[1, 2]) / k[1, 1] * n
    return float(left), float(right), float(bottom), float(top)


# ---- projection matrix ----------------------------------------------------------------


def projection_matrix(
    camera: Camera, near: float, far: float = math.inf, depth: ClipDepth = "ndc"
) -> F8:
    """(4, 4) matrix from OpenGL's eye space to clip space; multiplies column vectors.

    Args:
        camera: planar camera; off-axis and skewed ones are fine.
        near: distance of the near plane, metres.
        far: distance of the far plane; ``math.inf`` for none.
        depth: clip space's depth, see `belvedere.scene.zbuffer`.

    Raises:
        CameraError: not 0 < near < far.
    """
    check_choice("projection_matrix", "depth", depth, ("ndc", "zero_to_one", "reversed"))
    inverse_near, inverse_far = inverse_planes(near, far)
    k, w, h = camera.intrinsics, camera.width, camera.height
    matrix = np.zeros((4, 4))
    matrix[0, :3] = 2 * k[0, 0] / w, -2 * k[0, 1] / w, 1 - (2 * k[0, 2] + 1) / w
    matrix[1, 1:3] = 2 * k[1, 1] / h, (2 * k[1, 2] + 1) / h - 1
    matrix[3, 2] = -1.0
    # depth = p + q / Z runs from its value at near to its value at far
    at_near, at_far = {"ndc": (-1, 1), "zero_to_one": (0, 1), "reversed": (1, 0)}[depth]
    q = (at_near - at_far) / (inverse_near - inverse_far)
    matrix[2, 2:] = -(at_far - q * inverse_far), q
    return matrix


def camera_from_projection(
    projection: npt.ArrayLike, camera_to_world: npt.ArrayLike, *, width: int, height: int
) -> Camera:
    """The camera of a perspective projection matrix, whatever its depth convention.

    Args:
        projection: (4, 4) from OpenGL's eye space to clip space, for column vectors: its last row
            is (0, 0, -1, 0). Transpose what a row-vector library gives.
        camera_to_world: (4, 4) pose with OpenGL's axes; of a view matrix, see
            `camera_to_world_from_view_matrix`.
        width: pixels across.
        height: pixels down.

    Raises:
        CameraError: an orthographic, transposed, mirrored or y-down (Vulkan) matrix.
    """
    check_image_size("Camera", width, height)
    m = _checked_projection(projection)
    if m[0, 0] <= 0 or m[1, 1] <= 0:
        raise CameraError(
            f"projection has {m[0, 0]:.6g} and {m[1, 1]:.6g} on its diagonal, expected positive "
            "numbers: negate row 1 of a matrix with y downwards (Vulkan)"
        )
    k = [
        [0.5 * width * m[0, 0], -0.5 * width * m[0, 1], 0.5 * width * (1 - m[0, 2]) - 0.5],
        [0.0, 0.5 * height * m[1, 1], 0.5 * height * (1 + m[1, 2]) - 0.5],
        [0.0, 0.0, 1.0],
    ]
    pose = check_pose("camera_from_projection", "camera_to_world", camera_to_world)
    return Camera.from_intrinsics(k, pose @ OPENCV_FROM_OPENGL, width, height)


def planes_from_projection(
    projection: npt.ArrayLike, depth: ClipDepth = "ndc"
) -> tuple[float, float]:
    """``(near, far)`` of a perspective projection matrix, metres; far may be infinity.

    Raises:
        CameraError: no perspective matrix, or its planes make no sense under ``depth``.
    """
    check_choice("projection", "depth", depth, ("ndc", "zero_to_one", "reversed"))
    m = _checked_projection(projection)
    a, b = m[2, 2], m[2, 3]  # depth = -a + b / Z
    at_near, at_far = {"ndc": (-1, 1), "zero_to_one": (0, 1), "reversed": (1, 0)}[depth]
    inverse_near, inverse_far = (at_near + a) / b if b else 0.0, (at_far + a) / b if b else 0.0
    if abs(inverse_far) <= 1e-7 * abs(inverse_near):  # float32 matrices round -1 to -0.9999999
        inverse_far = 0.0
    if not 0 <= inverse_far < inverse_near:
        raise CameraError(
            f"projection with depth={depth!r} has 1/near {inverse_near:.6g} and 1/far "
            f"{inverse_far:.6g}, expected 1/near > 1/far >= 0: is depth another convention?"
        )
    return 1.0 / inverse_near, math.inf if inverse_far == 0 else 1.0 / inverse_far


# ---- glTF ----------------------------------------------------------------


def camera_from_gltf(
    yfov: float,
    camera_to_world: npt.ArrayLike,
    *,
    aspect_ratio: float | None = None,
    width: int,
    height: int,
) -> Camera:
    """The camera of glTF's ``perspective``; its planes do not matter to a picture.

    Args:
        yfov: vertical field of view, radians.
        camera_to_world: (4, 4) world matrix of the camera's node (OpenGL's axes), without scale.
        aspect_ratio: width over height of the field of view; None: that of the picture, so that
            pixels are square.
        width: pixels across.
        height: pixels down.

    Raises:
        CameraError: an angle or ratio out of range, a pose that is not rigid.
    """
    check_image_size("Camera", width, height)
    angle = check_number("glTF", "yfov", yfov, 0.0, math.radians(179.99), open_low=True,
                         error=CameraError)  # fmt: skip
    ratio = width / height if aspect_ratio is None else aspect_ratio
    ratio = check_number("glTF", "aspectRatio", ratio, 0.0, open_low=True, error=CameraError)
    top = math.tan(angle / 2)
    right = top * ratio
    return camera_from_frustum(
        -right, right, -top, top, 1.0, camera_to_world, width=width, height=height
    )


def gltf_from_camera(camera: Camera, near: float, far: float = math.inf) -> dict[str, Any]:
    """A glTF ``camera`` object (``type`` and ``perspective``); its node's matrix is `opengl_pose`.

    Raises:
        CameraError: an off-axis or skewed camera, which glTF cannot say; not 0 < near < far.
    """
    inverse_planes(near, far)
    k, w, h = camera.intrinsics, camera.width, camera.height
    _refuse_skew(k, "a glTF camera", "render with square pixels")
    off = math.hypot(k[0, 2] - (w - 1) / 2, k[1, 2] - (h - 1) / 2)
    if off > 1e-6 * max(w, h):
        raise CameraError(
            f"glTF: the camera's axis meets the picture {off:.4g} pixels off its middle, which a "
            "glTF camera cannot say: crop it symmetrically, or keep projection_matrix beside it"
        )
    perspective: dict[str, float] = {
        "yfov": 2.0 * math.atan(0.5 * h / k[1, 1]),
        "aspectRatio": float(w * k[1, 1] / (h * k[0, 0])),
        "znear": float(near),
    }
    if math.isfinite(far):
        perspective["zfar"] = float(far)
    return {"type": "perspective", "perspective": perspective}


# ---- checks ----------------------------------------------------------------


def _checked_projection(projection: npt.ArrayLike) -> F8:
    """A perspective (4, 4) whose last row is (0, 0, -1, 0), as OpenGL's and glTF's are.

    Scaled ones are refused, though they draw the same: a transposed symmetric perspective is a
    scaled one in everything but its meaning.
    """
    m = as_array("opengl", "projection", projection)
    check_shape("opengl", "projection", m, (4, 4), error=CameraError)
    check_finite("opengl", "projection", m, CameraError)
    if np.abs(m[3] - [0.0, 0.0, -1.0, 0.0]).max() > ROW_TOLERANCE:
        hint = ""
        if np.abs(m[3, :3]).max() <= ROW_TOLERANCE and m[3, 3] > 0:
            hint = ": it is orthographic, use OrthographicCamera"
        elif np.abs(m[:, 3] - [0.0, 0.0, -1.0, 0.0]).max() <= ROW_TOLERANCE:
            hint = ": it is transposed (row vectors), pass its .T"
        elif np.abs(m[3] - [0.0, 0.0, 1.0, 0.0]).max() <= ROW_TOLERANCE:
            hint = ": its eye space looks along +z, negate column 2"
        raise CameraError(
            f"opengl.projection has the last row {m[3].tolist()}, expected [0, 0, -1, 0]{hint}"
        )
    slant = np.abs([m[0, 3], m[1, 0], m[1, 3], m[2, 0], m[2, 1]]).max()
    if slant > ROW_TOLERANCE * max(abs(m[0, 0]), abs(m[1, 1])):
        raise CameraError(
            f"opengl.projection has the rows {m[0].tolist()}, {m[1].tolist()} and {m[2].tolist()}, "
            "expected (x, x, x, 0), (0, x, x, 0) and (0, 0, x, x): split the view matrix off it"
        )
    return m


def _refuse_skew(k: F8, what: str, remedy: str) -> None:
    if abs(k[0, 1]) > 1e-9 * k[0, 0]:
        raise CameraError(f"Camera has skew {k[0, 1]:.6g}, which {what} cannot say: {remedy}")
