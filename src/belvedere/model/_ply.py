"""PLY, parsed by trimesh.

Colors of vertices and faces are bytes that people saw on a screen: sRGB-encoded. Texture
coordinates count v upwards.

Source: Turk 1994, The PLY polygon file format.
"""

from __future__ import annotations

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import (
    BelvedereError,
    FileFormatError,
    MissingDependencyError,
    SceneError,
)
from belvedere.model._found import Found
from belvedere.model._polygons import triangulated
from belvedere.model._texture_files import decode_texture
from belvedere.model._triangles import Triangles
from belvedere.model.report import Report
from belvedere.scene.io.paths import existing
from belvedere.scene.mesh import Material


def read_ply(path: Path, report: Report) -> Found:
    """The triangles of a PLY file, in its own units and axes.

    Raises:
        FileFormatError: no PLY, truncated.
        MissingDependencyError: trimesh is not installed.
    """
    try:
        from trimesh.exchange.ply import load_ply
    except ImportError as error:
        raise MissingDependencyError.for_extra("trimesh", "model", "read PLY models") from error
    data = path.read_bytes()
    if not data.startswith(b"ply"):
        raise FileFormatError(f"{path}: is not a PLY model (it does not begin with 'ply')")
    header = _header(path, data)
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL)  # what it would say is said by the report
    try:
        found: dict[str, Any] = load_ply(io.BytesIO(data), fix_texture=True, skip_materials=True)
        triangles, materials = _triangles(path, found, header, report)
    except BelvedereError:
        raise
    except Exception as error:  # parsers of foreign bytes raise nearly anything
        raise FileFormatError(
            f"{path}: is a truncated or broken PLY ({error or type(error).__name__}): export it "
            "again"
        ) from error
    finally:
        log.setLevel(level)
    return Found("PLY", triangles, materials, [path.stem])


def _triangles(
    path: Path, found: dict[str, Any], header: list[str], report: Report
) -> tuple[Triangles, list[Material]]:
    points = np.asarray(found.get("vertices", np.zeros((0, 3))), np.float64).reshape(-1, 3)
    polygons = np.asarray(found.get("faces", np.zeros((0, 3))), np.int64)
    polygons = polygons.reshape(-1, polygons.shape[-1] if polygons.ndim == 2 else 3)
    if len(points) and not len(polygons):
        report.note(f"{len(points):,} points without faces: left out")
    if len(polygons) and (polygons.min() < 0 or polygons.max() >= len(points)):
        raise FileFormatError(
            f"{path}: a face names vertex {int(polygons.max())}, but there are {len(points)}: the "
            "file is truncated or broken"
        )
    starts = np.arange(len(polygons) + 1) * polygons.shape[1]
    polygon, corners = triangulated(points, polygons.ravel(), starts)
    faces = polygons.ravel()[corners]
    if found.get("vertex_normals") is not None:
        report.note("vertex normals: not kept, faces are shaded as they lie")
    uv, materials = np.zeros((len(faces), 3, 2), np.float32), _materials(path, header, report)
    values = getattr(found.get("visual"), "uv", None)
    if values is not None and len(values) == len(points):
        uv = (np.asarray(values) * [1.0, -1.0] + [0.0, 1.0]).astype(np.float32)[faces]
    triangles = Triangles(
        points,
        faces,
        np.full(len(faces), len(materials) - 1, np.int32),
        uv,
        _colors(found, faces, polygon, len(points), len(polygons)),
        np.zeros(len(faces), np.int32),
    )
    return triangles, materials


def _header(path: Path, data: bytes) -> list[str]:
    """The header's lines; a file of text is checked for its length, which trimesh does not."""
    head, end, body = data.partition(b"end_header")
    lines = [line.strip() for line in head.decode("latin-1").splitlines()]
    if not end:
        raise FileFormatError(f"{path}: its PLY header has no end: it is truncated, copy it again")
    if any(line.startswith("format ascii") for line in lines):
        words = [line.split() for line in lines if line.startswith("element ")]
        wanted = sum(int(word[2]) for word in words if len(word) == 3 and word[2].isdigit())
        have = sum(1 for line in body.splitlines()[1:] if line.strip())
        if have < wanted:
            raise FileFormatError(
                f"{path}: has {have} lines of data, but its header says {wanted}: it is truncated"
            )
    return lines


def _materials(path: Path, header: list[str], report: Report) -> list[Material]:
    """The one material of a file whose header names a texture; else none."""
    names = [line.split(None, 2)[2] for line in header if line.startswith("comment TextureFile ")]
    if not names:
        return []
    try:
        file = existing(path.parent, names[0].strip(), f"{path.name}: TextureFile")
        return [Material(path.stem, texture=decode_texture(file.read_bytes(), file.name).color)]
    except SceneError as error:
        report.note(f"texture left out: {error}")
        return []


def _colors(
    found: dict[str, Any], faces: npt.NDArray[np.int64], polygon: npt.NDArray[np.int64],
    points: int, polygons: int,
) -> npt.NDArray[np.float32] | None:  # fmt: skip
    for key, count in (("vertex_colors", points), ("face_colors", polygons)):
        values = found.get(key)
        if values is None or len(values) != count or np.ndim(values) != 2:
            continue
        encoded = np.asarray(values)[:, :3]
        scale = 1.0 if encoded.dtype.kind == "f" and encoded.max(initial=0.0) <= 1.0 else 255.0
        linear = srgb_to_linear(np.clip(encoded / scale, 0.0, 1.0)).astype(np.float32)
        return linear[faces] if key == "vertex_colors" else linear[polygon, None].repeat(3, 1)
    return None
