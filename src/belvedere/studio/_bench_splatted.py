"""Forward splatting as the learning literature does it, in NumPy and in PyTorch on the processor.

Every sample adds to the four pixels round where it lands, by bilinear weights times how near it is:

- softmax splatting: ``exp(alpha * metric)``, the metric here being disparity; all references are
  accumulated together (Niklaus and Liu 2020);
- inverse-bilinear splatting: ``exp(-50 * log(1 + z) / max)`` of depths clipped to 1000 metres, as
  the "pose warping" code that goes round does; it knows one picture, so several are fused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import MissingDependencyError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio._bench_peers import Picture, splat_numpy
from belvedere.studio._bench_rival import depth_of, fuse_nearest, planar_of

F8 = npt.NDArray[np.float64]

ALPHA_M = 20.0
"""Metres: softmax splatting's factor of disparity; of 5, 10, 20, 30, 50 and 100 the one whose
pictures are best at the stations. Larger ones have fewer wrong depths: 2 % at 100, not 9 %."""
SMALLEST_EXPONENT = -80.0
"""Least exponent of a weight, so that the farthest samples do not vanish from ``float32``."""
DEPTH_SHARPNESS = 50.0
"""The inverse-bilinear exponent's factor."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """One reference as PyTorch wants it."""

    camera: Camera
    points: Any
    """(3, n) camera-space positions of its samples, ``float32``."""
    color: Any
    """(n, 3) ``float32``, 0 to 255."""


def torch_module() -> Any:
    """PyTorch.

    Raises:
        MissingDependencyError: it is not installed.
    """
    try:
        return import_module("torch")  # an extra: it may be missing where types are checked
    except ImportError as caught:
        raise MissingDependencyError("PyTorch") from caught


def prepare_numpy(views: Sequence[ReferenceView], threads: int) -> list[tuple[Camera, F8, F8]]:
    """Each reference's camera, (n,) depth and (n, 3) colours in float64."""
    del threads
    return [
        (planar_of(one), depth_of(one).astype(np.float64).ravel(),
         one.color.reshape(-1, 3).astype(np.float64)) for one in views
    ]  # fmt: skip


def warp_numpy(prepared: list[tuple[Camera, F8, F8]], camera: Camera, threads: int) -> Picture:
    """Each reference splatted, then the nearest of them."""
    del threads
    return fuse_nearest([splat_numpy(*one, camera) for one in prepared])


def prepare_torch(views: Sequence[ReferenceView], threads: int) -> list[Points]:
    """Points and colours as tensors."""
    torch = torch_module()
    torch.set_num_threads(threads)
    prepared = []
    for view in views:
        camera, depth = planar_of(view), depth_of(view).ravel()
        known = depth > 0  # without depth a sample would land where the reference's eye is
        v, u = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1)
        pixels = np.stack([u, v, np.ones_like(u)]).astype(np.float32)
        inverse = np.linalg.inv(camera.intrinsics).astype(np.float32)
        points = torch.from_numpy((inverse @ pixels * depth)[:, known])
        color = torch.from_numpy(view.color.reshape(-1, 3)[known].astype(np.float32))
        prepared.append(Points(camera, points, color))
    return prepared


def warp_softmax(prepared: list[Points], camera: Camera, threads: int) -> Picture:
    """Softmax splatting of all references together."""
    torch = torch_module()
    torch.set_num_threads(threads)
    with torch.inference_mode():
        landed = [_land(torch, one, camera) for one in prepared]
        nearest = max(float((1.0 / z).max()) for _, _, z, _ in landed if z.numel())
        total = _empty(torch, camera)
        for x, y, z, color in landed:
            exponent = ALPHA_M * (1.0 / z - nearest)
            importance = torch.exp(exponent.clamp_min(SMALLEST_EXPONENT))
            _accumulate(torch, total, camera, x, y, importance, z, color)
        return _resolve(torch, total, camera)


def warp_inverse_bilinear(prepared: list[Points], camera: Camera, threads: int) -> Picture:
    """Inverse-bilinear splatting of each reference, then the nearest of them."""
    torch = torch_module()
    torch.set_num_threads(threads)
    pictures = []
    with torch.inference_mode():
        for one in prepared:
            x, y, z, color = _land(torch, one, camera)
            nearness = torch.log1p(z.clamp(0.0, 1000.0))
            importance = torch.exp(-DEPTH_SHARPNESS * nearness / nearness.max())
            total = _empty(torch, camera)
            _accumulate(torch, total, camera, x, y, importance, z, color)
            pictures.append(_resolve(torch, total, camera))
    return fuse_nearest(pictures)


def _land(torch: Any, one: Points, camera: Camera) -> tuple[Any, Any, Any, Any]:
    """Where samples land (x, y), their depth and colour; those outside are left out."""
    move = camera.intrinsics @ (camera.world_to_camera @ one.camera.camera_to_world)[:3]
    matrix = torch.from_numpy(move.astype(np.float32))
    image = torch.addmm(matrix[:, 3:], matrix[:, :3], one.points)
    z = image[2]
    x, y = image[0] / z, image[1] / z
    keep = (z > 0) & (x > -1) & (x < camera.width) & (y > -1) & (y < camera.height)
    return x[keep], y[keep], z[keep], one.color[keep]


def _empty(torch: Any, camera: Camera) -> Any:
    """Colour, depth and weight sums with a border of a pixel, so that no corner is asked about."""
    return torch.zeros(((camera.height + 2) * (camera.width + 2), 5))


def _accumulate(
    torch: Any, total: Any, camera: Camera, x: Any, y: Any, weight: Any, z: Any, color: Any
) -> None:
    """Every sample into four pixels."""
    width = camera.width + 2
    left, top = x.floor(), y.floor()
    first = (top + 1).long() * width + (left + 1).long()
    values = torch.cat([color, z[:, None], torch.ones_like(z)[:, None]], dim=1)
    for dy in (0, 1):
        for dx in (0, 1):
            share = weight * (1.0 - (x - left - dx).abs()) * (1.0 - (y - top - dy).abs())
            total.index_add_(0, first + dy * width + dx, values * share[:, None])


def _resolve(torch: Any, total: Any, camera: Camera) -> Picture:
    grid = total.view(camera.height + 2, camera.width + 2, 5)[1:-1, 1:-1]
    weight = grid[..., 4:]
    mean = torch.where(weight > 0, grid[..., :4] / weight, 0.0)
    return Picture(mean[..., :3].round().to(torch.uint8).numpy(), mean[..., 3].contiguous().numpy())
