"""Meshes out, as GLB: one file that other tools open too.

The container is written here rather than by trimesh, which has no place for emission above 1,
colors as floats, or extras of a scene.

Source: Khronos Group, glTF 2.0 specification.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_path
from belvedere.ground.color import encode_srgb8
from belvedere.ground.errors import InputError
from belvedere.ground.version import __version__
from belvedere.model._gltf_file import CHUNK_BIN, CHUNK_JSON, MAGIC
from belvedere.model._gltf_read import BUILDING, FACE_ORDER
from belvedere.model._weld import first_equal
from belvedere.model.building import Building
from belvedere.scene.io.atomic import require_free, write_bytes
from belvedere.scene.mesh import Material, Mesh

__all__ = ["write_glb"]

Pictures = Literal["png", "jpeg"]
MOST_BYTES = (1 << 32) - 1
"""A GLB counts its bytes in 32 bits."""
NEAR_M = 1000.0
"""Farther off than this, positions are written relative to a translated node."""
_FLOAT, _UINT = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_REPEAT, _LINEAR, _MIPMAP = 10497, 9729, 9987


def write_glb(
    path: str | Path,
    mesh: Mesh,
    building: Building | None = None,
    force: bool = False,
    *,
    pictures: Pictures = "png",
) -> tuple[str, ...]:
    """Write a mesh as GLB, atomically.

    Positions, texture coordinates, colors and materials are kept in float32, faces in their order;
    `read_model` gives them back. The front of a face stays its front.

    Args:
        path: a name that ends in .glb.
        mesh: metres, +z up; written with +y up, as glTF wants it.
        building: rooms and openings, kept in the scene's extras (docs/formats.md).
        force: replace an existing file.
        pictures: textures as ``"png"``, lossless, or as ``"jpeg"``, smaller.

    Returns:
        What the format could not keep, one line each; empty where it kept everything.

    Raises:
        InputError: another suffix, a mesh without faces, more than 4 GiB.
        OutputError: the file exists without ``force``; the disk is full or read-only.
    """
    file = check_path("write_glb", "path", path)
    check_choice("write_glb", "pictures", pictures, ("png", "jpeg"))
    if file.suffix.lower() != ".glb":
        raise InputError(f"write_glb.path is {file.name!r}, expected a name that ends in .glb")
    if not len(mesh.faces):
        raise InputError("write_glb.mesh has no faces: there is nothing to write")
    require_free(file, force)
    writer = _Writer(mesh, pictures)
    data = writer.glb(building)
    if len(data) > MOST_BYTES:
        raise InputError(f"write_glb: {file.name} would have {len(data)} bytes, a GLB has 4 GiB")
    write_bytes(file, data, force=force)
    return tuple(writer.lost)


class _Writer:
    def __init__(self, mesh: Mesh, pictures: Pictures) -> None:
        self.mesh = mesh
        self.pictures: Pictures = pictures
        self.lost: list[str] = []
        self.chunks: list[bytes] = []
        self.size = 0
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.images: dict[int, int] = {}
        self.json_images: list[dict[str, Any]] = []
        self.extensions: set[str] = set()

    def glb(self, building: Building | None) -> bytes:
        """The whole file."""
        used, material = np.unique(self.mesh.material_index, return_inverse=True)
        materials = [self._material(self.mesh.materials[k]) for k in used]
        center = self.mesh.bounds.mean(axis=0)
        shift = np.rint(center) if np.abs(self.mesh.bounds).max() > NEAR_M else np.zeros(3)
        order = np.argsort(material, kind="stable")
        cuts = np.searchsorted(material[order], np.arange(len(used) + 1))
        primitives = [
            self._primitive(order[cuts[k] : cuts[k + 1]], k, shift) for k in range(len(used))
        ]
        places = self._accessor(order.astype("<u4"), _UINT, "SCALAR", None)
        scene: dict[str, Any] = {"nodes": [0]}
        if building is not None:
            scene["extras"] = {BUILDING: building.as_dict()}
        node: dict[str, Any] = {"mesh": 0, "name": "model"}
        if shift.any():
            node["translation"] = [shift[0], shift[2], -shift[1]]
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"belvedere {__version__}"},
            "scene": 0,
            "scenes": [scene],
            "nodes": [node],
            "meshes": [{"primitives": primitives, "extras": {FACE_ORDER: places}}],
            "materials": materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}],
        }
        if self.json_images:
            document["images"] = self.json_images
            document["samplers"] = [{"wrapS": _REPEAT, "wrapT": _REPEAT, "magFilter": _LINEAR,
                                     "minFilter": _MIPMAP}]  # fmt: skip
            document["textures"] = [
                {"source": k, "sampler": 0} for k in range(len(self.json_images))
            ]
        if self.extensions:
            document["extensionsUsed"] = sorted(self.extensions)
        return self._container(json.dumps(document, separators=(",", ":"), allow_nan=False))

    def _container(self, text: str) -> bytes:
        head = text.encode()
        head += b" " * (-len(head) % 4)
        total = 12 + 8 + len(head) + 8 + self.size
        return b"".join(
            [
                struct.pack("<4sII", MAGIC, 2, total), struct.pack("<II", len(head), CHUNK_JSON),
                head, struct.pack("<II", self.size, CHUNK_BIN), *self.chunks,
            ]
        )  # fmt: skip

    def _primitive(
        self, faces: npt.NDArray[np.int64], material: int, shift: npt.NDArray[np.float64]
    ) -> dict[str, Any]:
        """Corners that agree in everything become one vertex."""
        mesh = self.mesh
        vertex = mesh.faces[faces].reshape(-1).astype(np.int64)
        uv = mesh.uv[faces].reshape(-1, 2)
        key = [vertex[:, None]]
        has_uv = bool(uv.any())
        if has_uv:
            key.append((uv + np.float32(0.0)).view(np.int32).astype(np.int64))
        colors = None if mesh.colors is None else mesh.colors[faces].reshape(-1, 3)
        if colors is not None:
            key.append((colors + np.float32(0.0)).view(np.int32).astype(np.int64))
        first = first_equal(np.concatenate(key, axis=1))
        own = first == np.arange(len(first))
        index = (np.cumsum(own) - 1)[first].astype("<u4")
        place = mesh.vertices[vertex[own]] - shift
        positions = np.stack([place[:, 0], place[:, 2], -place[:, 1]], axis=1).astype("<f4")
        attributes = {
            "POSITION": self._accessor(positions, _FLOAT, "VEC3", _ARRAY_BUFFER, bounds=True)
        }
        if has_uv:
            attributes["TEXCOORD_0"] = self._accessor(
                uv[own].astype("<f4"), _FLOAT, "VEC2", _ARRAY_BUFFER
            )
        if colors is not None:
            attributes["COLOR_0"] = self._accessor(
                colors[own].astype("<f4"), _FLOAT, "VEC3", _ARRAY_BUFFER
            )
        return {
            "attributes": attributes,
            "indices": self._accessor(index, _UINT, "SCALAR", _ELEMENT_BUFFER),
            "material": material,
        }

    def _accessor(
        self, values: npt.NDArray[Any], component: int, kind: str, target: int | None,
        bounds: bool = False,
    ) -> int:  # fmt: skip
        entry: dict[str, Any] = {
            "bufferView": self._view(values.tobytes(), target),
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            entry["min"] = [float(v) for v in values.min(axis=0)]
            entry["max"] = [float(v) for v in values.max(axis=0)]
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def _view(self, data: bytes, target: int | None) -> int:
        view = {"buffer": 0, "byteOffset": self.size, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        self.views.append(view)
        pad = -len(data) % 4
        self.chunks += [data, b"\0" * pad]
        self.size += len(data) + pad
        return len(self.views) - 1

    def _material(self, material: Material) -> dict[str, Any]:
        factor = np.asarray(material.base_color, np.float64)
        if factor.max() > 1.0:
            self.lost.append(f"material {material.name!r}: base color above 1 written as 1")
        surface: dict[str, Any] = {
            "baseColorFactor": [*np.minimum(factor, 1.0).tolist(), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        }
        if material.texture is not None:
            surface["baseColorTexture"] = {"index": self._image(material)}
        out: dict[str, Any] = {
            "name": material.name, "pbrMetallicRoughness": surface, "doubleSided": True
        }  # fmt: skip
        emission = np.asarray(material.emission, np.float64)
        strength = max(float(emission.max()), 1.0)
        if emission.any():
            out["emissiveFactor"] = (emission / strength).tolist()
        if strength > 1.0:
            self.extensions.add("KHR_materials_emissive_strength")
            out["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
        return out

    def _image(self, material: Material) -> int:
        """The texture's place among the images; one that is shared is written once."""
        texture = material.texture
        assert texture is not None
        if id(texture) not in self.images:
            if texture.dtype != np.uint8:
                self.lost.append(f"material {material.name!r}: float texture written as 8 bits")
            data = _encoded(texture, self.pictures)
            self.images[id(texture)] = len(self.json_images)
            self.json_images.append(
                {"bufferView": self._view(data, None), "mimeType": f"image/{self.pictures}",
                 "name": material.name}
            )  # fmt: skip
        return self.images[id(texture)]


def _encoded(texture: npt.NDArray[Any], pictures: Pictures) -> bytes:
    """A whole picture file; quick rather than small."""
    import io

    from PIL import Image

    pixels = texture if texture.dtype == np.uint8 else encode_srgb8(texture)
    buffer = io.BytesIO()
    picture = Image.fromarray(np.ascontiguousarray(pixels))
    if pictures == "png":
        picture.save(buffer, "PNG", compress_level=3)
    else:
        picture.save(buffer, "JPEG", quality=95, subsampling=0)
    return buffer.getvalue()
