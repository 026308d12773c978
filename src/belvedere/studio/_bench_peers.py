"""The same job by other means: one posed RGB-D picture in, the desired camera's picture out.

Every peer is written as a competent user of that library would, states what it does in ``what``,
and is judged by `agreement` with our own point warp of the same run: a fast wrong picture is no
rival. What does not depend on the desired camera (arrays handed over, depth from disparity) is
prepared outside the timing, as it is for ours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import MissingDependencyError
from belvedere.scene import Camera, Frame, ReferenceView

F4 = npt.NDArray[np.float32]

SAME_SURFACE = 0.01
"""Relative difference in disparity up to which two pictures show one surface in a pixel."""
SAME_COLOR = 8
"""Levels, of 255, that a channel may differ by and still count as one colour."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """What a peer's warp gives."""

    color: npt.NDArray[Any]
    """(H, W, 3) ``uint8``, or ``float32`` in [0, 1] sRGB-encoded as Open3D keeps it."""
    depth: F4
    """(H, W) z-depth, metres; 0 or NaN where nothing landed."""


@dataclass(frozen=True, slots=True, eq=False)
class Peer:
    """One way of doing the job."""

    name: str
    what: str
    """What is called, in one line."""
    install: str
    """What to install when it is missing."""
    make: Callable[[ReferenceView, Camera, int], Callable[[], Picture]]
    """``make(view, camera, threads)`` gives the timed call; ImportError if a library is missing."""
    threads: int | None
    """How many threads it uses; None: as many as it is told."""


def agreement(picture: Picture, frame: Frame) -> tuple[float, float]:
    """How far a peer's picture and ours are the same, in per cent.

    Returns:
        The share of pixels that are holes in both or show one surface in both, and the share of
        commonly covered pixels whose colours are the same, within `SAME_COLOR`.
    """
    depth = np.nan_to_num(picture.depth)
    theirs, ours = depth > 0, frame.coverage > 0
    both = theirs & ours
    ratio = np.where(both, np.nan_to_num(frame.disparity) * depth, 1.0)
    same = (theirs == ours) & (np.abs(ratio - 1.0) <= SAME_SURFACE)
    color = picture.color
    if color.dtype == np.float32:
        color = np.round(color * 255.0)
    apart = np.abs(color[both].astype(int) - frame.color[both].astype(int)).max(axis=-1, initial=0)
    alike = float(np.mean(apart <= SAME_COLOR)) if both.any() else 0.0
    return 100.0 * float(np.mean(same)), 100.0 * alike


# ---- NumPy -----------------------------------------------------------------------------------


def _numpy_inputs(view: ReferenceView, camera: Camera) -> tuple[F4, F4, F4, F4]:
    from belvedere.warp import warp_matrix

    matrix = warp_matrix(_planar(view), camera).astype(np.float32)
    height, width = view.disparity.shape
    u, v = np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)[:, None]
    return matrix, u, v, view.disparity


def _planar(view: ReferenceView) -> Camera:
    assert isinstance(view.camera, Camera)
    return view.camera


def _numpy_land(
    matrix: F4, u: F4, v: F4, delta: F4, size: tuple[int, int]
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], F4]:
    """Flat pixels and warped disparities of the samples that land, and which samples they are."""
    height, width = size
    with np.errstate(divide="ignore", invalid="ignore"):
        r, s, t = (m[0] * u + (m[1] * v + m[2]) + m[3] * delta for m in matrix)
        scale = np.float32(1.0) / t
        x, y = np.floor(r * scale + np.float32(0.5)), np.floor(s * scale + np.float32(0.5))
        inside = (t > 0) & (x >= 0) & (x < width) & (y >= 0) & (y < height)
        sample = np.flatnonzero(inside)
        column, row = x.ravel()[sample].astype(np.intp), y.ravel()[sample].astype(np.intp)
        return row * width + column, sample, (delta * scale).ravel()[sample]


def make_numpy_maximum(view: ReferenceView, camera: Camera, threads: int) -> Callable[[], Picture]:
    """Z-buffer by `np.maximum.at`; the samples that equal it paint."""
    del threads
    inputs, colors = _numpy_inputs(view, camera), view.color.reshape(-1, view.color.shape[2])

    def run() -> Picture:
        cell, sample, delta = _numpy_land(*inputs, camera.size)
        front = np.zeros(camera.height * camera.width, np.float32)
        np.maximum.at(front, cell, delta)
        wins = front[cell] == delta
        color = np.zeros((front.size, colors.shape[1]), colors.dtype)
        color[cell[wins]] = colors[sample[wins]]
        return _numpy_picture(color, front, camera)

    return run


def make_numpy_sorted(view: ReferenceView, camera: Camera, threads: int) -> Callable[[], Picture]:
    """Z-buffer by `np.lexsort` on pixel and disparity; the last of each pixel's run paints."""
    del threads
    inputs, colors = _numpy_inputs(view, camera), view.color.reshape(-1, view.color.shape[2])

    def run() -> Picture:
        cell, sample, delta = _numpy_land(*inputs, camera.size)
        order = np.lexsort((delta, cell))
        cell, sample, delta = cell[order], sample[order], delta[order]
        last = np.flatnonzero(np.append(cell[1:] != cell[:-1], True))
        front = np.zeros(camera.height * camera.width, np.float32)
        color = np.zeros((front.size, colors.shape[1]), colors.dtype)
        front[cell[last]], color[cell[last]] = delta[last], colors[sample[last]]
        return _numpy_picture(color, front, camera)

    return run


def make_numpy_splat(view: ReferenceView, camera: Camera, threads: int) -> Callable[[], Picture]:
    """Bilinear splatting: each sample adds to four pixels, near ones weigh exponentially more.

    What most published NumPy forward warps do: points unprojected, moved and projected as 3-vectors
    in float64, colour and depth accumulated with `np.add.at`, divided by the weights.
    """
    del threads
    reference, depth = _planar(view), _depth(view).astype(np.float64).ravel()
    colors = view.color.reshape(-1, view.color.shape[2]).astype(np.float64)
    return lambda: splat_numpy(reference, depth, colors, camera)


def splat_numpy(
    reference: Camera,
    depth: npt.NDArray[np.float64],
    colors: npt.NDArray[np.float64],
    camera: Camera,
) -> Picture:
    """(n,) depths and (n, 3) colours of a reference's pixels, splatted into the desired camera."""
    height, width = camera.size
    move = np.linalg.inv(camera.camera_to_world) @ reference.camera_to_world
    k_inverse, k = np.linalg.inv(reference.intrinsics), camera.intrinsics
    u, v = np.meshgrid(np.arange(reference.width), np.arange(reference.height))
    pixels = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    points = (pixels @ k_inverse.T) * depth[:, None] @ move[:3, :3].T + move[:3, 3]
    z = points[:, 2]
    image = points @ k.T
    keep = (depth > 0) & (z > 0)
    x, y = image[keep, 0] / image[keep, 2], image[keep, 1] / image[keep, 2]
    nearness = np.log1p(z[keep])
    importance = np.exp(-50.0 * nearness / nearness.max())
    values = np.concatenate([colors[keep], z[keep, None], np.ones((len(x), 1))], axis=1)
    total = np.zeros((height + 2, width + 2, values.shape[1]))
    x0, y0 = np.floor(x), np.floor(y)
    for dy in range(2):
        for dx in range(2):
            row = np.clip(y0 + dy + 1, 0, height + 1).astype(np.intp)
            column = np.clip(x0 + dx + 1, 0, width + 1).astype(np.intp)
            weight = (1.0 - abs(x - x0 - dx)) * (1.0 - abs(y - y0 - dy)) * importance
            np.add.at(total, (row, column), values * weight[:, None])
    total = total[1:-1, 1:-1]
    with np.errstate(invalid="ignore"):
        mean = total[..., :-1] / total[..., -1:]
    mean = np.nan_to_num(mean)
    return Picture(np.rint(mean[..., :3]).astype(np.uint8), mean[..., 3].astype(np.float32))


def _numpy_picture(color: npt.NDArray[Any], front: F4, camera: Camera) -> Picture:
    with np.errstate(divide="ignore"):
        depth = np.where(front > 0, np.float32(1.0) / front, np.float32(0.0))
    return Picture(color.reshape(*camera.size, -1), depth.reshape(camera.size))


# ---- Open3D ----------------------------------------------------------------------------------


def make_open3d(view: ReferenceView, camera: Camera, threads: int) -> Callable[[], Picture]:
    """RGB-D image to point cloud in the world, projected into the desired camera."""
    del threads
    try:
        o3d: Any = import_module("open3d")  # an extra: it may be missing where types are checked
    except ImportError as caught:
        raise MissingDependencyError("Open3D") from caught
    tensor, geometry = o3d.core.Tensor, o3d.t.geometry
    reference = _planar(view)
    depth = _depth(view)
    color_image = geometry.Image(tensor.from_numpy(view.color))
    depth_image = geometry.Image(tensor.from_numpy(depth[..., None]))
    given = tensor(reference.intrinsics), tensor(np.linalg.inv(reference.camera_to_world))
    wanted = tensor(camera.intrinsics), tensor(np.linalg.inv(camera.camera_to_world))
    farthest = {"depth_scale": 1.0, "depth_max": 1e6}

    def run() -> Picture:
        rgbd = geometry.RGBDImage(color_image, depth_image)
        cloud = geometry.PointCloud.create_from_rgbd_image(rgbd, *given, **farthest)
        seen = cloud.project_to_rgbd_image(camera.width, camera.height, *wanted, **farthest)
        color, depth = seen.color.as_tensor().numpy(), seen.depth.as_tensor().numpy()
        return Picture(color, depth[..., 0])

    return run


def _depth(view: ReferenceView) -> F4:
    with np.errstate(divide="ignore"):
        depth = np.float32(1.0) / view.disparity
    return np.where(np.isfinite(depth), depth, np.float32(0.0))


# ---- OpenCV ----------------------------------------------------------------------------------


def opencv_functions(*names: str) -> tuple[Any, list[Any]]:
    """OpenCV and functions of its depth module, which moved to the top level in version 5."""
    try:
        import cv2
    except ImportError as caught:
        raise MissingDependencyError("OpenCV") from caught
    rgbd = getattr(cv2, "rgbd", None)
    found = [getattr(cv2, name, None) or getattr(rgbd, name, None) for name in names]
    if None in found:
        raise MissingDependencyError(f"OpenCV's {names[found.index(None)]}")
    return cv2, found


def _opencv_cameras(reference: Camera, camera: Camera) -> tuple[Any, Any, Any]:
    """K of both, and the motion desired_from_reference; zeros exact, as OpenCV asks."""
    motion = np.linalg.inv(camera.camera_to_world) @ reference.camera_to_world
    return np.round(reference.intrinsics, 9), np.round(camera.intrinsics, 9), motion


def make_opencv_register(
    view: ReferenceView, camera: Camera, threads: int
) -> Callable[[], Picture]:
    """`registerDepth` moves the depth, then each pixel's colour is looked up with `remap`."""
    cv2, (register,) = opencv_functions("registerDepth")
    reference, depth = _planar(view), _depth(view)

    def run() -> Picture:
        cv2.setNumThreads(threads)
        return register_and_look_up(cv2, register, reference, view.color, depth, camera)

    return run


def register_and_look_up(
    cv2: Any,
    register: Any,
    reference: Camera,
    color: npt.NDArray[Any],
    depth: F4,
    camera: Camera,
    dilate: bool = False,
) -> Picture:
    """Depth moved forwards by OpenCV, then every pixel's colour fetched from where it came."""
    here, there, motion = _opencv_cameras(reference, camera)
    size, straight = (camera.width, camera.height), np.zeros(4)
    moved = register(here, there, straight, motion, depth, size, depthDilation=dilate)
    back = np.linalg.inv(motion)
    turn = (here @ back[:3, :3] @ np.linalg.inv(there)).astype(np.float32)
    shift = (here @ back[:3, 3]).astype(np.float32)
    u = np.arange(camera.width, dtype=np.float32)
    v = np.arange(camera.height, dtype=np.float32)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        r, s, t = (turn[n, 0] * u + (turn[n, 1] * v + turn[n, 2]) for n in range(3))
        scale = np.float32(1.0) / (t * moved + shift[2])
        x, y = (r * moved + shift[0]) * scale, (s * moved + shift[1]) * scale
    looked_up = cv2.remap(color, x, y, cv2.INTER_LINEAR)
    looked_up[~(moved > 0)] = 0
    return Picture(looked_up, moved)


def make_opencv_frame(view: ReferenceView, camera: Camera, threads: int) -> Callable[[], Picture]:
    """`warpFrame`, which lands samples in the pixel to the upper left of where they fall."""
    cv2, (warp_frame,) = opencv_functions("warpFrame")
    here, _, motion = _opencv_cameras(_planar(view), camera)
    depth, mask = _depth(view), np.full(view.disparity.shape, 255, np.uint8)

    def run() -> Picture:
        cv2.setNumThreads(threads)
        moved, color, _ = warp_frame(depth, view.color, mask, motion, here)
        return Picture(color, moved)

    return run


PEERS: tuple[Peer, ...] = (
    Peer("numpy", "vectorised float32, z-buffer by np.maximum.at", "", make_numpy_maximum, 1),
    Peer("numpy-sort", "vectorised float32, z-buffer by np.lexsort", "", make_numpy_sorted, 1),
    Peer("numpy-splat", "float64 3-vectors, bilinear splatting with np.add.at", "",
         make_numpy_splat, 1),
    Peer(
        "open3d", "PointCloud.create_from_rgbd_image, project_to_rgbd_image; its own threads",
        "pip install 'belvedere[peers]'", make_open3d, 0,
    ),
    Peer(
        "opencv", "registerDepth, then colour looked up backwards with remap (bilinear)",
        "pip install 'belvedere[peers]'", make_opencv_register, None,
    ),
    Peer(
        "opencv-warpframe", "warpFrame: nearest pixel to the upper left, half a pixel off",
        "pip install 'belvedere[peers]'", make_opencv_frame, None,
    ),
)  # fmt: skip
"""Every rival; ``threads`` 0 means as many as the machine has, whatever it is told."""
