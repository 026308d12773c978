"""The field that the warp's picture is compared with: every rival, written as its users would.

Each gets the same references, prepared as its own way wants them, and shows the desired camera.
MPEG's reference view synthesiser (RVS) is missing: there is no package of it to install.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from belvedere.ground.errors import MissingDependencyError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio._bench_compiled import prepare_c, warp_c
from belvedere.studio._bench_meshed import (
    prepare_embree,
    prepare_registered,
    prepare_triangles,
    warp_embree,
    warp_registered,
    warp_triangles,
)
from belvedere.studio._bench_peers import Picture
from belvedere.studio._bench_rival import Rival, depth_of, planar_of
from belvedere.studio._bench_splatted import (
    prepare_numpy,
    prepare_torch,
    warp_inverse_bilinear,
    warp_numpy,
    warp_softmax,
)

PEERS_EXTRA = "pip install 'belvedere[peers]'"


def prepare_cloud(views: Sequence[ReferenceView], threads: int) -> tuple[Any, Any]:
    """Open3D and one point cloud in the world of all references."""
    del threads
    try:
        o3d: Any = import_module("open3d")  # an extra: it may be missing where types are checked
    except ImportError as caught:
        raise MissingDependencyError("Open3D") from caught
    tensor, geometry = o3d.core.Tensor, o3d.t.geometry
    whole = None
    for view in views:
        camera = planar_of(view)
        picture = geometry.Image(tensor.from_numpy(view.color))
        depth = geometry.Image(tensor.from_numpy(depth_of(view)[..., None]))
        cloud = geometry.PointCloud.create_from_rgbd_image(
            geometry.RGBDImage(picture, depth), tensor(camera.intrinsics),
            tensor(camera.world_to_camera), depth_scale=1.0, depth_max=1e6,
        )  # fmt: skip
        whole = cloud if whole is None else whole.append(cloud)
    return o3d, whole


def warp_cloud(prepared: tuple[Any, Any], camera: Camera, threads: int) -> Picture:
    """`project_to_rgbd_image`, which keeps the nearest point of each pixel."""
    del threads
    o3d, cloud = prepared
    seen = cloud.project_to_rgbd_image(
        camera.width, camera.height, o3d.core.Tensor(camera.intrinsics),
        o3d.core.Tensor(camera.world_to_camera), depth_scale=1.0, depth_max=1e6,
    )  # fmt: skip
    color, depth = seen.color.as_tensor().numpy(), seen.depth.as_tensor().numpy()[..., 0]
    shown = np.clip(color * np.float32(255.0) + np.float32(0.5), 0.0, 255.0)
    return Picture(shown.astype(np.uint8), depth)


FIELD: tuple[Rival, ...] = (
    Rival("c-point", "compiled C: points into one z-buffer, the least that can be done (the front "
          "sample's bytes: no blending in linear light, no coverage, no culling)",
          "a C compiler such as gcc or clang, on the path", prepare_c, warp_c, 1),
    Rival("opencv-remap", "OpenCV registerDepth, colour by remap (bilinear); nearest fused",
          PEERS_EXTRA, prepare_registered, warp_registered),
    Rival("opencv-mesh", "OpenCV triangleRasterize of two triangles a pixel; nearest fused",
          PEERS_EXTRA, prepare_triangles, warp_triangles),
    Rival("embree-mesh", "Embree rays at two triangles a pixel; nearest fused",
          "pip install 'belvedere[model]'", prepare_embree, warp_embree),
    Rival("open3d-cloud", "Open3D project_to_rgbd_image of one cloud; its own threads",
          PEERS_EXTRA, prepare_cloud, warp_cloud, 0),
    Rival("torch-softmax", "PyTorch softmax splatting by disparity, references together",
          PEERS_EXTRA, prepare_torch, warp_softmax),
    Rival("torch-splat", "PyTorch inverse-bilinear splatting; nearest fused",
          PEERS_EXTRA, prepare_torch, warp_inverse_bilinear),
    Rival("numpy-splat", "NumPy inverse-bilinear splatting, float64; nearest fused",
          "", prepare_numpy, warp_numpy, 1),
)  # fmt: skip
"""Every rival, the fastest kinds first."""
