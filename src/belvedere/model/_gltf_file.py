"""The glTF container: JSON, buffers, accessors. What it says is checked before it is used.

Read here rather than by trimesh, which gives colors as bytes, forgets emission, texture transforms
and second sets of coordinates, and does not say what it left out.

Source: Khronos Group, glTF 2.0 specification, sections 3.6 and 4.4.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import FileFormatError, MissingFileError, UnsafePathError
from belvedere.scene.io.paths import existing

MAGIC = b"glTF"
CHUNK_JSON, CHUNK_BIN = 0x4E4F534A, 0x004E4942
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""NumPy types of glTF's component types."""
SHAPES: dict[str, tuple[int, ...]] = {
    "SCALAR": (), "VEC2": (2,), "VEC3": (3,), "VEC4": (4,), "MAT4": (4, 4)
}  # fmt: skip
MOST_ELEMENTS = 1 << 28
"""Elements that an accessor may claim without data behind it."""
READ_EXTENSIONS = {
    "EXT_mesh_gpu_instancing", "EXT_texture_webp", "KHR_lights_punctual",
    "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion",
    "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness", "KHR_materials_sheen", "KHR_materials_specular",
    "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants",
    "KHR_materials_volume", "KHR_mesh_quantization", "KHR_texture_transform",
    "KHR_texture_basisu",
}  # fmt: skip
"""A file may require these: each is followed, or its loss is reported."""
COMPRESSED = {
    "KHR_draco_mesh_compression": "Draco",
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
}


class GltfFile:
    """A parsed glTF or GLB file."""

    def __init__(self, path: Path) -> None:
        """Read it, with its JSON checked; external buffers are opened when they are asked for.

        Raises:
            FileFormatError: truncated, no glTF, another version, compressed.
        """
        self.path = path
        data = path.read_bytes()
        self._bin: memoryview | None = None
        text = self._chunks(data) if data[:4] == MAGIC else data
        self.json = self._parsed(text)
        self._buffers: dict[int, memoryview] = {}
        self._check_version()

    def entries(self, kind: str) -> list[dict[str, Any]]:
        """A top-level list, such as ``nodes``; empty where there is none."""
        found = self.json.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
            raise self.broken(f"{kind} is no list of objects")
        return found

    def entry(self, kind: str, index: object, where: str) -> dict[str, Any]:
        """An entry of a top-level list; ``where`` names who asks, for messages."""
        found = self.entries(kind)
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(found):
            raise self.broken(f"{where} is {index!r}, but there are {len(found)} {kind}")
        return found[index]

    def broken(self, what: str) -> FileFormatError:
        """The error for something that glTF does not allow."""
        return FileFormatError(f"{self.path}: {what}: export it again")

    def array(self, index: object, where: str) -> npt.NDArray[Any]:
        """The elements of an accessor, (N,), (N, K) or (N, 4, 4); normalised ones as float32.

        Raises:
            FileFormatError: it points outside its buffer or has an unknown type.
        """
        accessor = self.entry("accessors", index, where)
        here = f"accessors[{index}]"
        dtype, shape = self._kind(accessor, here)
        count = self._whole(accessor, "count", here, 0)
        if "bufferView" in accessor:
            found = self._strided(accessor["bufferView"], accessor, dtype, shape, count, here)
        elif count > MOST_ELEMENTS:
            raise self.broken(f"{here} claims {count} elements without data")
        else:
            found = np.zeros((count, *shape), dtype)
        if "sparse" in accessor:
            found = self._sparse(accessor["sparse"], found, dtype, shape, here)
        if shape == (4, 4):
            found = found.transpose(0, 2, 1)  # column-major
        if accessor.get("normalized") and found.dtype.kind in "iu":
            return np.maximum(found / np.float32(np.iinfo(found.dtype).max), -1.0, dtype=np.float32)
        return found

    def view(self, index: object, where: str) -> memoryview:
        """The bytes of a buffer view."""
        view = self.entry("bufferViews", index, where)
        here = f"bufferViews[{index}]"
        for name in COMPRESSED:
            if name in view.get("extensions", {}) and view["extensions"][name].get("buffer") == (
                view.get("buffer")
            ):
                raise self.compressed(name)
        buffer = self._buffer(view.get("buffer"), here)
        first = self._whole(view, "byteOffset", here, 0, 0)
        size = self._whole(view, "byteLength", here, 0)
        if first + size > len(buffer):
            raise FileFormatError(
                f"{self.path}: {here} ends at byte {first + size}, but its buffer has "
                f"{len(buffer)}: the file is truncated, copy it again"
            )
        return buffer[first : first + size]

    def uri(self, uri: object, where: str) -> memoryview:
        """The bytes that a URI gives: embedded ones, or a file in the model's folder.

        Raises:
            UnsafePathError: it leads out of the folder, or to the network.
            MissingFileError: there is no such file.
            FileFormatError: embedded data that is not base64.
        """
        if not isinstance(uri, str):
            raise self.broken(f"{where}.uri is {uri!r:.60}, expected text")
        if uri.startswith("data:"):
            try:
                return memoryview(base64.b64decode(uri.partition(",")[2], validate=True))
            except (binascii.Error, ValueError):
                raise self.broken(f"{where}.uri holds data that is not base64") from None
        if "://" in uri:
            raise UnsafePathError(
                f"{self.path}: {where}.uri is {uri[:80]!r}: nothing is fetched from elsewhere, "
                "download it into the model's folder"
            )
        place = f"{self.path.name}: {where}.uri"
        return memoryview(existing(self.path.parent, unquote(uri), place).read_bytes())

    def _chunks(self, data: bytes) -> bytes:
        """The JSON chunk of a GLB; the binary one is kept."""
        if len(data) < 20:
            raise self._truncated(len(data), 20)
        version, length = struct.unpack_from("<II", data, 4)
        if version != 2:
            raise FileFormatError(
                f"{self.path}: is GLB version {version}, only 2 is read: export it as glTF 2.0"
            )
        if length > len(data):
            raise self._truncated(len(data), length)
        text, at = None, 12
        while at + 8 <= length:
            size, kind = struct.unpack_from("<II", data, at)
            if at + 8 + size > length:
                raise self._truncated(length, at + 8 + size)
            chunk = memoryview(data)[at + 8 : at + 8 + size]
            if text is None and kind == CHUNK_JSON:
                text = bytes(chunk)
            elif self._bin is None and kind == CHUNK_BIN:
                self._bin = chunk
            at += 8 + size
        if text is None:
            raise self.broken("has no JSON chunk")
        return text

    def _truncated(self, have: int, want: int) -> FileFormatError:
        return FileFormatError(
            f"{self.path}: has {have} bytes, but says it has {want}: it is truncated, copy or "
            "export it again"
        )

    def _parsed(self, text: bytes) -> dict[str, Any]:
        try:
            found = json.loads(text.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise FileFormatError(
                f"{self.path}: is not glTF ({error}): expected a GLB or its JSON, export it again"
            ) from None
        if not isinstance(found, dict) or "asset" not in found:
            raise FileFormatError(
                f"{self.path}: is JSON but not glTF (it has no 'asset'): is it another file's name?"
            )
        return found

    def _check_version(self) -> None:
        asset = self.json["asset"]
        version = str(asset.get("version", "")) if isinstance(asset, dict) else ""
        if not version.startswith("2"):
            raise FileFormatError(
                f"{self.path}: is glTF {version or 'without a version'}, only 2.x is read: export "
                "it as glTF 2.0"
            )
        required = self.json.get("extensionsRequired", [])
        for name in required if isinstance(required, list) else []:
            if name in COMPRESSED:
                raise self.compressed(name)
            if name not in READ_EXTENSIONS:
                raise FileFormatError(
                    f"{self.path}: requires the extension {name!r}, which is not read: export it "
                    "without"
                )

    def compressed(self, name: str) -> FileFormatError:
        """The error for a file that cannot be read without decompressing it."""
        return FileFormatError(
            f"{self.path}: is compressed by {COMPRESSED[name]} ({name}), which is not read: export "
            "it without compression (gltf-transform copy, or Blender's exporter with Compression "
            "off)"
        )

    def _whole(
        self, entry: dict[str, Any], key: str, where: str, low: int, default: int | None = None
    ) -> int:
        value = entry.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < low:
            raise self.broken(f"{where}.{key} is {value!r}, expected a whole number >= {low}")
        return value

    def _kind(
        self, accessor: dict[str, Any], where: str
    ) -> tuple[np.dtype[Any], tuple[int, ...]]:  # fmt: skip
        component, kind = accessor.get("componentType"), accessor.get("type")
        if component not in COMPONENTS or kind not in SHAPES:
            raise self.broken(f"{where} holds {kind!r} of {component!r}, which glTF does not have")
        return np.dtype(COMPONENTS[component]), SHAPES[kind]

    def _strided(
        self, view: object, entry: dict[str, Any], dtype: np.dtype[Any], shape: tuple[int, ...],
        count: int, where: str,
    ) -> npt.NDArray[Any]:  # fmt: skip
        data = self.view(view, f"{where}.bufferView")
        first = self._whole(entry, "byteOffset", where, 0, 0)
        size = dtype.itemsize * int(np.prod(shape, dtype=np.int64))
        stride = self._whole(self.entry("bufferViews", view, where), "byteStride", where, 0, 0)
        stride = stride or size
        if count and first + stride * (count - 1) + size > len(data):
            raise FileFormatError(
                f"{self.path}: {where} needs {first + stride * (count - 1) + size} bytes, but its "
                f"view has {len(data)}: the file is truncated, copy it again"
            )
        inner = (dtype.itemsize * 4, dtype.itemsize) if len(shape) == 2 else (dtype.itemsize,)
        strides = (stride, *inner[: len(shape)])
        return np.ndarray((count, *shape), dtype, data, first if count else 0, strides)

    def _sparse(
        self, sparse: Any, base: npt.NDArray[Any], dtype: np.dtype[Any], shape: tuple[int, ...],
        where: str,
    ) -> npt.NDArray[Any]:  # fmt: skip
        here = f"{where}.sparse"
        try:
            count, places, values = sparse["count"], sparse["indices"], sparse["values"]
            kind = np.dtype(COMPONENTS[places["componentType"]])
            at = self._strided(places["bufferView"], places, kind, (), count, here)
            new = self._strided(values["bufferView"], values, dtype, shape, count, here)
        except (KeyError, TypeError) as error:
            raise self.broken(f"{here} is incomplete ({error})") from None
        if count and int(at.max()) >= len(base):
            raise self.broken(f"{here} replaces element {int(at.max())} of {len(base)}")
        out = base.copy()
        out[at] = new
        return out

    def _buffer(self, index: object, where: str) -> memoryview:
        buffer = self.entry("buffers", index, f"{where}.buffer")
        assert isinstance(index, int)
        if index not in self._buffers:
            if "uri" in buffer:
                self._buffers[index] = self.uri(buffer["uri"], f"buffers[{index}]")
            elif index == 0 and self._bin is not None:
                self._buffers[index] = self._bin
            else:
                raise MissingFileError(
                    f"{self.path}: buffers[{index}] has no data: the file is incomplete, export it "
                    "again"
                )
        return self._buffers[index]
