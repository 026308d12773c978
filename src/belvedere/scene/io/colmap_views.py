"""COLMAP models with their pictures, and with dense depth maps where they are there.

Layouts: the model in the folder itself, ``sparse/`` or ``sparse/0/``; pictures in ``images/``;
depth in ``stereo/depth_maps/NAME.geometric.bin`` (else ``.photometric.bin``), along the axis, in
the reconstruction's units, which are taken as metres. The world's axes stay as they are.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from belvedere.ground.errors import MissingFileError
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.colmap import ColmapImage, ColmapModel, read_model
from belvedere.scene.io.paths import existing, inside
from belvedere.scene.io.pictures import Picture, build_views, view_names
from belvedere.scene.views import ViewSet

CONVENTIONS = Conventions(depth_scale=1.0, pose="world_to_camera", pixel_centers="half")
"""The files' own."""
MODEL_FOLDERS = (".", "sparse", "sparse/0", "colmap/sparse/0")
DEPTH_FOLDER = "stereo/depth_maps"


def model_folder(path: Path) -> Path | None:
    """Where the model of a folder lies, or None."""
    for sub in MODEL_FOLDERS:
        place = path / sub
        for suffix in (".bin", ".txt"):
            if all((place / f"{name}{suffix}").is_file() for name in ("cameras", "images")):
                return place
    return None


def read_colmap(path: str | Path, conventions: Conventions | None = None) -> ViewSet:
    """Read a COLMAP model and its pictures.

    Args:
        path: the workspace (with ``sparse/`` and ``images/``) or the model's own folder.
        conventions: how to read the numbers instead of the files' own way.

    Raises:
        MissingFileError, FileFormatError, UnsafePathError, SceneError: what is wrong in which file.
        MissingDependencyError: distorted pictures without OpenCV.
    """
    root = Path(path)
    place = model_folder(root)
    if place is None:
        raise MissingFileError(f"{root}: no COLMAP model in {', '.join(MODEL_FOLDERS)}")
    model = read_model(place)
    images = _image_folder(root, place)
    names = view_names([image.name for image in model.images])
    pictures = [
        _picture(images, model, image, name)
        for image, name in zip(model.images, names, strict=True)
    ]
    chosen = (conventions or CONVENTIONS).resolved(1.0)
    facts: dict[str, Any] = {"format": "colmap", "path": str(path),
                             "depth_scale": chosen.depth_scale}  # fmt: skip
    return build_views(pictures, chosen, facts)


def _image_folder(root: Path, place: Path) -> Path:
    for base in (root, *place.resolve().parents[:3]):
        if (base / "images").is_dir():
            return base / "images"
    raise MissingFileError(f"{root}: no folder images with the model's pictures: add it")


def _picture(images: Path, model: ColmapModel, image: ColmapImage, name: str) -> Picture:
    where = f"COLMAP image {image.id}"
    camera = model.cameras[image.camera_id]
    lens = camera.lens(f"COLMAP camera {camera.id}")
    color = existing(images, image.name, where)
    depth = None
    maps = images.parent / DEPTH_FOLDER
    for kind in ("geometric", "photometric"):
        candidate = inside(maps, f"{image.name}.{kind}.bin", where)
        if candidate.is_file():
            depth = candidate
            break
    return Picture(where, name, color, depth, lens.intrinsics, image.world_to_camera,
                   camera.width, camera.height, lens)  # fmt: skip
