"""A lit model in one file: polygons, textures and baked light, as they lie in memory.

::

    8 bytes   magic "BELVLIT1"
    8 bytes   length of the header, little-endian
    header    JSON: version, materials, arrays {name: [type, shape, offset, bytes]}, digest
    arrays    little-endian, each beginning at a multiple of 64 bytes

Reading maps the file, so a house of half a million polygons is there in the time that its tables
take. The same model gives the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import os
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

MAGIC = b"BELVLIT1"
VERSION = 1
ALIGN = 64
MOST_HEADER = 1 << 26
"""Bytes of a header that we are willing to believe in."""

A = npt.NDArray[Any]

__all__ = ["load_lit_model", "save_lit_model"]


def save_lit_model(path: str | Path, model: LitModel, *, force: bool = True) -> Path:
    """Write a lit model, atomically.

    Raises:
        OutputError: it exists without ``force``, or cannot be written.
    """
    arrays = _arrays(model)
    header: dict[str, Any] = {
        "version": VERSION,
        "covered": model.charts.covered,
        "materials": [
            {"name": m.name, "base_color": list(m.base_color), "emission": list(m.emission),
             "texture": m.texture is not None}
            for m in model.mesh.materials
        ],
        "arrays": {},
    }  # fmt: skip
    place = 0
    for name, array in arrays.items():
        header["arrays"][name] = [array.dtype.str, list(array.shape), place, array.nbytes]
        place += -(-array.nbytes // ALIGN) * ALIGN
    header["bytes"] = place
    header["digest"] = _digest(arrays)
    text = json.dumps(header).encode()
    text += b" " * (-(len(text) + 16) % ALIGN)
    target = Path(path)
    with atomic_write(target, force=force) as temporary, temporary.open("wb") as file:
        file.write(MAGIC + len(text).to_bytes(8, "little") + text)
        for array in arrays.values():
            file.write(array.data)
            file.write(b"\0" * (-array.nbytes % ALIGN))
    return target


def load_lit_model(path: str | Path) -> LitModel:
    """Read what `save_lit_model` wrote. The arrays are mapped, not to be written to.

    Raises:
        MissingFileError: no such file.
        FileFormatError: not such a file, truncated, of a newer version, or with parts that do not
            fit together.
    """
    file = Path(path)
    if not file.is_file():
        raise MissingFileError(f"{file}: no such file")
    header, start = _header(file)
    if header.get("version") != VERSION:
        raise FileFormatError(
            f"{file}: is of version {header.get('version')!r}, this belvedere reads {VERSION}: "
            "prepare the scene again"
        )
    try:
        size = os.path.getsize(file)
        if size < start + int(header["bytes"]):
            raise FileFormatError(
                f"{file}: ends too early, at {size} bytes of {start + header['bytes']}: it is "
                "truncated, prepare the scene again"
            )
        whole = np.memmap(file, np.uint8, "r", offset=start)
        arrays = {
            name: whole[place : place + count].view(np.dtype(kind)).reshape(shape)
            for name, (kind, shape, place, count) in header["arrays"].items()
        }
        return _model(header, arrays)
    except BelvedereError as error:
        raise FileFormatError(f"{file}: {error}") from error
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FileFormatError(
            f"{file}: its parts do not fit together ({error}): prepare the scene again"
        ) from error


def _header(file: Path) -> tuple[dict[str, Any], int]:
    with file.open("rb") as stream:
        start = stream.read(16)
        if len(start) < 16 or start[:8] != MAGIC:
            raise FileFormatError(f"{file}: is no lit model of belvedere's")
        length = int.from_bytes(start[8:], "little")
        text = stream.read(length) if length <= MOST_HEADER else b""
    try:
        header = json.loads(text)
    except ValueError as error:
        raise FileFormatError(f"{file}: its header is damaged: prepare the scene again") from error
    if not isinstance(header, dict):
        raise FileFormatError(f"{file}: its header is damaged: prepare the scene again")
    return header, 16 + length


def _arrays(model: LitModel) -> dict[str, A]:
    mesh, charts, light = model.mesh, model.charts, model.light
    arrays: dict[str, A | None] = {
        "vertices": mesh.vertices, "faces": mesh.faces, "material_index": mesh.material_index,
        "uv": mesh.uv, "colors": mesh.colors, "corners": charts.corners,
        "normals": charts.normals, "material": charts.material, "of_face": charts.of_face,
        "st": charts.st, "cutouts": charts.cutouts, "two_sided": charts.two_sided,
        "joined": charts.joined,
        "soft_first": light.soft_lattice.first, "soft_shape": light.soft_lattice.shape,
        "soft": light.soft, "sun_first": light.sun_lattice.first,
        "sun_shape": light.sun_lattice.shape, "sun": light.sun, "sun_color": light.sun_color,
    }  # fmt: skip
    for k, material in enumerate(mesh.materials):
        arrays[f"texture{k}"] = material.texture
    held = {k: np.ascontiguousarray(v) for k, v in arrays.items() if v is not None}
    return {k: v.astype(v.dtype.newbyteorder("<"), copy=False) for k, v in held.items()}


def _model(header: dict[str, Any], arrays: dict[str, A]) -> LitModel:
    materials = tuple(
        Material(
            str(m["name"]), tuple(m["base_color"]), arrays[f"texture{k}"] if m["texture"] else None,
            tuple(m["emission"]),
        )
        for k, m in enumerate(header["materials"])
    )  # fmt: skip
    mesh = Mesh(
        arrays["vertices"], arrays["faces"], arrays["material_index"], arrays["uv"], materials,
        arrays.get("colors"),
    )  # fmt: skip
    charts = Charts(
        arrays["corners"], arrays["normals"], arrays["material"], arrays["of_face"], arrays["st"],
        arrays["cutouts"], joined=arrays.get("joined"), covered=bool(header["covered"]),
        two_sided=arrays.get("two_sided"),
    )  # fmt: skip
    light = LightMap(
        Lattice(arrays["soft_first"], arrays["soft_shape"]), arrays["soft"],
        Lattice(arrays["sun_first"], arrays["sun_shape"]), arrays["sun"], arrays["sun_color"],
    )  # fmt: skip
    count, faces = len(charts.corners), len(mesh.faces)
    fits = (
        charts.of_face.shape == (faces,) and charts.st.shape == (faces, 3, 2)
        and (not faces or (charts.of_face.min() >= 0 and charts.of_face.max() < count))
        and light.soft_lattice.shape.shape == light.sun_lattice.shape.shape == (count, 2)
        and light.soft.shape == (light.soft_lattice.size, 3)
        and light.sun.shape == (light.sun_lattice.size,)
    )  # fmt: skip
    if not fits:
        raise ValueError("charts and light are of different sizes")
    return LitModel(mesh, charts, light)


def _digest(arrays: dict[str, A]) -> str:
    digest = hashlib.blake2b(digest_size=16)
    for name, array in arrays.items():
        digest.update(f"{name} {array.dtype.str} {array.shape};".encode())
        digest.update(array.data)
    return digest.hexdigest()
