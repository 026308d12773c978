"""Lit models as files: geometry, charts, light and textures in one, mapped into memory to read.

    magic      8 bytes  "BELVLIT2"
    version    uint32   1
    length     uint32   bytes of the header
    size       uint64   bytes of the whole file
    check      uint32   CRC-32 of the header
    check      uint32   CRC-32 of everything after the header's padding
    header     JSON     arrays (name, type, shape, offset) and materials
    arrays              each at a multiple of 64 bytes, little-endian

The same model gives the same bytes. Nothing in a file is ever run.
"""

from __future__ import annotations

import json
import mmap
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import BelvedereError, FileFormatError, MissingFileError
from belvedere.model.charts import Charts
from belvedere.model.lattice import Lattice
from belvedere.model.light import LightMap
from belvedere.model.photograph import LitModel
from belvedere.scene.io.atomic import atomic_write
from belvedere.scene.mesh import Material, Mesh

MAGIC = b"BELVLIT2"
VERSION = 1
HEAD = struct.Struct("<8sIIQII")
ALIGN = 64
MOST_HEADER = 1 << 26
_TYPES = {"<f8", "<f4", "<i4", "|u1", "|b1"}

__all__ = ["load_lit_model", "save_lit_model"]


def save_lit_model(path: str | Path, model: LitModel, *, force: bool = True) -> Path:
    """Write a lit model, whole or not at all. Of a `House` only the lit model is kept.

    Args:
        path: the file.
        model: what to write.
        force: replace an existing file.

    Raises:
        OutputError: it exists without ``force``, or cannot be written.
    """
    arrays = _arrays(model)
    table: list[dict[str, Any]] = []
    offset = 0
    for name, array in arrays.items():
        table.append(
            {"name": name, "type": array.dtype.str, "shape": array.shape, "offset": offset}
        )
        offset += _padded(array.nbytes)
    textures = _textures(model.mesh)
    header = json.dumps(
        {
            "arrays": table,
            "covered": bool(model.charts.covered),
            "materials": [_material(m, textures) for m in model.mesh.materials],
        },
        separators=(",", ":"),
    ).encode()
    start = _padded(HEAD.size + len(header))
    check = 0
    for array in arrays.values():
        check = zlib.crc32(_filled(array), check)
    head = HEAD.pack(MAGIC, VERSION, len(header), start + offset, zlib.crc32(header), check)
    with atomic_write(path, force=force) as temporary, temporary.open("wb") as file:
        file.write((head + header).ljust(start, b"\0"))
        for array in arrays.values():
            file.write(_filled(array))
    return Path(path)


def load_lit_model(path: str | Path) -> LitModel:
    """Read what `save_lit_model` wrote; arrays lie in the mapped file, changes stay in memory.

    Raises:
        MissingFileError: no such file.
        FileFormatError: another kind of file, a newer version, a truncated or damaged file.
    """
    place = Path(path)
    if not place.is_file():
        raise MissingFileError(f"{place}: no such file")
    with place.open("rb") as file:
        header, start, data = _opened(place, file)
    try:
        arrays = _mapped(header, start, data)
        return _model(header, arrays)
    except FileFormatError:
        raise
    except (BelvedereError, KeyError, TypeError, ValueError, IndexError) as error:
        raise FileFormatError(
            f"{place}: the parts of this lit model do not fit: {error}"
        ) from error


def _opened(place: Path, file: Any) -> tuple[dict[str, Any], int, Any]:
    """The header, where the arrays begin, and the mapped file; everything checked."""
    head = file.read(HEAD.size)
    if len(head) < HEAD.size or not head.startswith(MAGIC):
        raise FileFormatError(f"{place}: is no lit model of belvedere (its first bytes differ)")
    _, version, length, size, header_check, check = HEAD.unpack(head)
    if version > VERSION or version < 1:
        raise FileFormatError(
            f"{place}: is of version {version}, and this belvedere knows up to {VERSION}: "
            "update belvedere"
        )
    actual = place.stat().st_size
    start = _padded(HEAD.size + length)
    if actual != size or length > MOST_HEADER or start > size:
        raise FileFormatError(
            f"{place}: has {actual} bytes, expected {size}: it was cut off or damaged; write it "
            "again"
        )
    text = file.read(length)
    data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
    if zlib.crc32(text) != header_check or zlib.crc32(memoryview(data)[start:]) != check:
        raise FileFormatError(f"{place}: is damaged (its checksum differs): write it again")
    try:
        header = json.loads(text)
        if not isinstance(header["arrays"], list) or not isinstance(header["materials"], list):
            raise TypeError("its tables are no lists")
    except (ValueError, KeyError, TypeError) as error:
        raise FileFormatError(f"{place}: its header is damaged: {error}") from error
    return header, start, data


def _mapped(header: dict[str, Any], start: int, data: Any) -> dict[str, npt.NDArray[Any]]:
    arrays = {}
    for entry in header["arrays"]:
        kind, shape = str(entry["type"]), tuple(int(n) for n in entry["shape"])
        if kind not in _TYPES or min(shape, default=0) < 0 or int(entry["offset"]) < 0:
            raise ValueError(f"array {entry['name']!r} is of type {kind} and shape {shape}")
        count = int(np.prod(shape, dtype=object))
        at = start + int(entry["offset"])
        if at + count * np.dtype(kind).itemsize > len(data):
            raise ValueError(f"array {entry['name']!r} reaches past the end of the file")
        flat = np.frombuffer(data, dtype=kind, count=count, offset=at)
        arrays[str(entry["name"])] = flat.reshape(shape)
    return arrays


def _model(header: dict[str, Any], arrays: dict[str, npt.NDArray[Any]]) -> LitModel:
    materials = tuple(
        Material(
            str(entry["name"]),
            _color(entry["base_color"]),
            None if entry["texture"] is None else arrays[f"texture{entry['texture']}"],
            _color(entry["emission"]),
        )
        for entry in header["materials"]
    )
    mesh = Mesh(
        arrays["vertices"], arrays["faces"], arrays["material_index"], arrays["uv"], materials,
        arrays.get("colors"),
    )  # fmt: skip
    names = ("corners", "normals", "material", "of_face", "st", "cutouts")
    charts = Charts(
        *(arrays[f"chart_{name}"] for name in names), joined=arrays.get("chart_joined"),
        covered=bool(header["covered"]), two_sided=arrays.get("chart_two_sided"),
    )  # fmt: skip
    soft = Lattice(arrays["soft_first"], arrays["soft_shape"])
    sun = Lattice(arrays["sun_first"], arrays["sun_shape"])
    light = LightMap(soft, arrays["soft"], sun, arrays["sun"], arrays["sun_color"])
    _check(mesh, charts, light)
    return LitModel(mesh, charts, light)


def _check(mesh: Mesh, charts: Charts, light: LightMap) -> None:
    """Refuse what would make a kernel look past the end of an array."""
    faces, count = len(mesh.faces), len(charts.corners)
    shapes = (
        ("chart_corners", charts.corners, (count, 4, 3)),
        ("chart_normals", charts.normals, (count, 4, 3)),
        ("chart_material", charts.material, (count,)),
        ("chart_of_face", charts.of_face, (faces,)),
        ("chart_st", charts.st, (faces, 3, 2)),
        ("chart_cutouts", charts.cutouts, (len(charts.cutouts), 5)),
        ("chart_joined", charts.joined, (count,)),
        ("chart_two_sided", charts.two_sided, (count,)),
        ("soft", light.soft, (light.soft_lattice.size, 3)),
        ("sun", light.sun, (light.sun_lattice.size,)),
        ("sun_color", light.sun_color, (3,)),
    )
    for name, array, shape in shapes:
        if array is not None and array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
    for name, index, limit in (
        ("chart_of_face", charts.of_face, count),
        ("chart_material", charts.material, len(mesh.materials)),
    ):
        if len(index) and (index.min() < 0 or index.max() >= limit):
            raise ValueError(f"{name} names {int(index.max())} of {limit}")
    for lattice, total in (
        (light.soft_lattice, len(light.soft)),
        (light.sun_lattice, len(light.sun)),
    ):
        if lattice.first.shape != (count,) or lattice.shape.shape != (count, 2):
            raise ValueError("a lattice has not one row for each chart")
        size = lattice.shape.astype(np.int64).prod(axis=1)
        if count and (lattice.shape.min() < 1 or (lattice.first != np.cumsum(size) - size).any()):
            raise ValueError("a lattice's rows do not follow one another")
        if int(size.sum()) != total:
            raise ValueError("a lattice and its light differ in size")


def _arrays(model: LitModel) -> dict[str, npt.NDArray[Any]]:
    mesh, charts, light = model.mesh, model.charts, model.light
    f8, f4, i4 = "<f8", "<f4", "<i4"
    held: dict[str, tuple[Any, str]] = {
        "vertices": (mesh.vertices, f8), "faces": (mesh.faces, i4),
        "material_index": (mesh.material_index, i4), "uv": (mesh.uv, f4),
        "chart_corners": (charts.corners, f8), "chart_normals": (charts.normals, f8),
        "chart_material": (charts.material, i4), "chart_of_face": (charts.of_face, i4),
        "chart_st": (charts.st, f4), "chart_cutouts": (charts.cutouts, f8),
        "soft_first": (light.soft_lattice.first, i4), "soft_shape": (light.soft_lattice.shape, i4),
        "soft": (light.soft, f4), "sun_first": (light.sun_lattice.first, i4),
        "sun_shape": (light.sun_lattice.shape, i4), "sun": (light.sun, f4),
        "sun_color": (light.sun_color, f4),
    }  # fmt: skip
    for name, found, kind in (("colors", mesh.colors, f4), ("chart_joined", charts.joined, "|b1"),
                              ("chart_two_sided", charts.two_sided, "|b1")):  # fmt: skip
        if found is not None:
            held[name] = (found, kind)
    arrays = {name: np.ascontiguousarray(a, dtype=kind) for name, (a, kind) in held.items()}
    for k, texture in enumerate(_textures(mesh)):
        kind = "|u1" if texture.dtype == np.uint8 else f4
        arrays[f"texture{k}"] = np.ascontiguousarray(texture, dtype=kind)
    return arrays


def _textures(mesh: Mesh) -> list[npt.NDArray[Any]]:
    """Each texture once, in the order of the materials."""
    found: list[npt.NDArray[Any]] = []
    for material in mesh.materials:
        texture = material.texture
        if texture is not None and not any(texture is other for other in found):
            found.append(texture)
    return found


def _material(material: Material, textures: list[npt.NDArray[Any]]) -> dict[str, Any]:
    which = [k for k, texture in enumerate(textures) if texture is material.texture]
    return {
        "name": material.name,
        "base_color": [float(c) for c in material.base_color],
        "emission": [float(c) for c in material.emission],
        "texture": which[0] if which else None,
    }


def _color(value: Any) -> tuple[float, float, float]:
    r, g, b = (float(c) for c in value)
    return r, g, b


def _padded(size: int) -> int:
    return -(-size // ALIGN) * ALIGN


def _filled(array: npt.NDArray[Any]) -> bytes:
    """An array's bytes up to the next multiple of 64."""
    return array.tobytes().ljust(_padded(array.nbytes), b"\0")
