"""Which references show a desired camera best: overlap, viewing angle, sharpness, and variety."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import numpy.typing as npt

from belvedere.scene import Camera, CameraModel
from belvedere.warp.manifold import central, is_panoramic

F8 = npt.NDArray[np.float64]

GRID, GRID_ROUND = (8, 6), (24, 8)
"""Desired pixels across and down that stand for the whole picture; for a panorama."""
ANGLE_SCALE = np.radians(12.0)
"""Angle between two rays to one point at which a reference is worth 1/e: its surface looks
different, and more of what the desired view needs is hidden from it."""
SEEN_WORTH = 0.35
"""What seeing a point is still worth when a chosen reference sees it already: another side of the
same surface fills what the first one's foreground hides."""


def choose_references(
    cameras: Sequence[CameraModel],
    desired: CameraModel,
    disparities: npt.ArrayLike,
    count: int,
    exclude: Collection[int] = (),
) -> list[int]:
    """Indices of the best references, best first.

    The desired picture is sampled at a grid of pixels and a few disparities. Each reference is
    worth the share of those points that it has in its picture, each weighted by how nearly the two
    cameras see the point from one direction and from one distance. References after the first count
    less what is seen already.

    Args:
        cameras: of the references: planar, cylinders or spheres.
        desired: camera to be shown.
        disparities: (n,) typical disparities of the scene, 1/metre.
        count: how many references to choose at most.
        exclude: indices that must not be chosen.

    Returns:
        At most ``count`` indices. References that see nothing of the picture come only when no
        other is left, nearest first: something is better than an error, and coverage tells.
    """
    view = central(desired, "desired")
    allowed = [index for index in range(len(cameras)) if index not in set(exclude)]
    if not allowed:
        return []
    worth = _worth(
        [central(cameras[i], "reference") for i in allowed], view, _sample_points(view, disparities)
    )
    distance = np.array(
        [float(np.linalg.norm(cameras[index].center - view.center)) for index in allowed]
    )
    value = np.ones(worth.shape[1])
    left = list(range(len(allowed)))
    chosen: list[int] = []
    while left and len(chosen) < count:
        gains = worth[left] @ value
        best = left[int(np.lexsort((distance[left], -gains))[0])]
        chosen.append(allowed[best])
        left.remove(best)
        seen = np.clip(worth[best], 0.0, 1.0)
        value = value * (1.0 - seen * (1.0 - SEEN_WORTH))
    return chosen


def _sample_points(view: CameraModel, disparities: npt.ArrayLike) -> F8:
    """(n, 3) world points of the desired picture at typical disparities."""
    across, down = GRID_ROUND if is_panoramic(view) else GRID
    u = (np.arange(across) + 0.5) / across * view.width - 0.5
    v = (np.arange(down) + 0.5) / down * view.height - 0.5
    grid_u, grid_v, delta = np.meshgrid(u, v, np.atleast_1d(disparities), indexing="ij")
    return view.unproject(grid_u, grid_v, delta).reshape(-1, 3)


def _worth(cameras: Sequence[CameraModel], view: CameraModel, points: F8) -> F8:
    """(n, points) what each camera's sight of each point is worth, 0 to 1."""
    offset = points[None] - np.array([camera.center for camera in cameras])[:, None]
    inside = _shown(cameras, offset)
    with np.errstate(divide="ignore", invalid="ignore"):
        toward = points - view.center
        far, near = np.linalg.norm(offset, axis=-1), np.linalg.norm(toward, axis=-1)[None]
        cosine = np.einsum("npi,pi->np", offset, toward) / (far * near)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        detail = np.minimum(near / far, 1.0) ** 0.5  # farther away: coarser samples
        worth = np.where(inside, np.exp(-angle / ANGLE_SCALE) * detail, 0.0)
    return np.nan_to_num(worth)


def _shown(cameras: Sequence[CameraModel], offset: F8) -> npt.NDArray[np.bool_]:
    """(n, points) which camera has which point in its picture; offset (n, points, 3) from each."""
    sizes = np.array([(camera.width, camera.height) for camera in cameras], dtype=np.float64)
    u, v = np.empty(offset.shape[:2]), np.empty(offset.shape[:2])
    flat = [n for n, camera in enumerate(cameras) if isinstance(camera, Camera)]
    inverse = [np.linalg.inv(one.matrix) for one in cameras if isinstance(one, Camera)]
    if flat:  # all at once: hundreds of references are usual
        image = np.einsum("nij,npj->npi", np.array(inverse), offset[flat])
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = np.where(image[..., 2:] > 0, image[..., :2] / image[..., 2:], np.nan)
        u[flat], v[flat] = ahead[..., 0], ahead[..., 1]
    for n, camera in enumerate(cameras):
        if not isinstance(camera, Camera):
            u[n], v[n], _ = camera.project(camera.center + offset[n])
    with np.errstate(invalid="ignore"):
        across = (u >= -0.5) & (u <= sizes[:, :1] - 0.5)
        return across & (v >= -0.5) & (v <= sizes[:, 1:] - 0.5)
