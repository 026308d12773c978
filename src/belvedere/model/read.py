"""Any building model in: glTF, OBJ, PLY or IFC becomes triangles in metres, +z up."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_number, check_path
from belvedere.ground.errors import FileFormatError, InputError, MissingFileError
from belvedere.model._found import Found
from belvedere.model._plausible import NAMES, UNITS, guess_unit, guess_up
from belvedere.model._triangles import Triangles, as_mesh, cleaned
from belvedere.model.building import Building
from belvedere.model.imported import ImportedModel, ModelSource
from belvedere.model.report import Report
from belvedere.scene.io.json_files import read_json

F8 = npt.NDArray[np.float64]
Up = Literal["x", "y", "z"]
Doors = Literal["open", "closed"]

MODEL_SUFFIXES = (".glb", ".gltf", ".obj", ".ply", ".ifc")
"""File names that `read_model` reads."""
FAR_M = 2000.0
"""Coordinates beyond this are recentred: float32, for casting rays, has 0.2 mm steps there."""
SIDE_FILE = ".building.json"
_TURNS: dict[str, list[list[int]]] = {
    "x": [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
    "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],  # glTF: its -z is our +y
    "z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
}
"""World from file for each axis that points up there: rotations, never mirrors."""

__all__ = ["MODEL_SUFFIXES", "read_model"]


def read_model(
    path: str | Path,
    *,
    units: str | float | None = None,
    up: Up | None = None,
    keep_origin: bool = False,
    doors: Doors = "open",
) -> ImportedModel:
    """Read a building model.

    Args:
        path: a .glb, .gltf, .obj, .ply or .ifc file.
        units: ``"m"``, ``"cm"``, ``"mm"``, ``"ft"``, ``"in"``, or metres per unit. None: what the
            format says (glTF: metres; IFC: its own), else a guess by the model's headroom or size.
        up: the axis of the file that points up. None: what the format says (glTF: y; IFC: z), else
            a guess by its floors.
        keep_origin: leave coordinates as they are, however large.
        doors: of an IFC; ``"open"`` leaves the leaves of doors out, so that one sees through.

    Returns:
        The mesh, what the model states of its rooms, where its origin lies, and a report of all
        that was left out, changed or guessed. A file ``NAME.building.json`` beside ``NAME.glb``
        takes the place of what the model states itself (docs/formats.md).

    Raises:
        MissingFileError: there is no such file, or one that it cannot do without.
        FileFormatError: an unknown suffix, a folder, empty, truncated, broken, without triangles.
        UnsafePathError: it needs a file outside its own folder.
        InputError: units or up make no sense, or contradict an IFC's own.
        MissingDependencyError: trimesh (PLY) or ifcopenshell (IFC) is not installed.
    """
    file = check_path("read_model", "path", path)
    check_choice("read_model", "doors", doors, ("open", "closed"))
    if up is not None:
        check_choice("read_model", "up", up, ("x", "y", "z"))
    stated = _metres_per_unit(units)
    kind = _suffix(file)
    if kind == ".ifc" and (units is not None or up is not None):
        raise InputError("read_model: an IFC states its own units and axes: leave out units and up")
    report = Report()
    found = _reader(kind, doors)(file, report)
    faces = len(found.triangles.faces)
    vertices = len(found.triangles.vertices)
    triangles = cleaned(found.triangles, report)
    if not len(triangles.faces):
        said = "; ".join(report.lines)
        raise FileFormatError(
            f"{file}: has no triangles to show{f' ({said})' if said else ''}: is it the right file?"
        )
    source = _convert(triangles, found.format, kind, stated, up, report)
    building = _building(file, found.building, report)
    origin = np.zeros(3) if keep_origin else _far_origin(triangles.vertices)
    _say_where(triangles.vertices, origin, keep_origin, report)
    triangles.vertices = triangles.vertices - origin
    mesh = as_mesh(triangles, found.materials, report)
    return ImportedModel(
        mesh,
        None if building is None else _moved(building, origin),
        origin,
        report.lines,
        replace(source, vertices=vertices, faces=faces),
        tuple(found.things),
        triangles.thing,
    )


def _suffix(file: Path) -> str:
    if file.is_dir():
        raise FileFormatError(
            f"{file}: is a folder, expected a model file ({', '.join(MODEL_SUFFIXES)})"
        )
    kind = file.suffix.lower()
    if kind not in MODEL_SUFFIXES:
        raise FileFormatError(
            f"{file}: models of the kind {file.suffix!r} are not read, only "
            f"{', '.join(MODEL_SUFFIXES)}: convert it"
        )
    if not file.exists():
        raise MissingFileError(f"no model file {file}: check the name")
    if os.path.getsize(file) == 0:
        raise FileFormatError(f"{file}: is empty (0 bytes): copy or export it again")
    return kind


def _reader(kind: str, doors: Doors) -> Callable[[Path, Report], Found]:
    if kind in (".glb", ".gltf"):
        from belvedere.model._gltf_read import read_gltf

        return read_gltf
    if kind == ".obj":
        from belvedere.model._obj import read_obj

        return read_obj
    if kind == ".ply":
        from belvedere.model._ply import read_ply

        return read_ply
    from belvedere.model.ifc import read_ifc

    return lambda file, report: read_ifc(file, report, doors)


def _metres_per_unit(units: str | float | None) -> float | None:
    if units is None:
        return None
    if isinstance(units, str):
        check_choice("read_model", "units", units, tuple(UNITS))
        return UNITS[units]
    return check_number("read_model", "units", units, 0.0, 1e6, open_low=True)


def _convert(
    triangles: Triangles, name: str, kind: str, stated: float | None, up: Up | None, report: Report
) -> ModelSource:
    """Turn and scale the vertices to metres, +z up, in place; say what was guessed."""
    guessed: list[str] = []
    known = {".glb": "y", ".gltf": "y", ".ifc": "z"}.get(kind)
    axis = up or known
    if axis is None:
        axis = guess_up(triangles.vertices, triangles.faces)
        guessed.append("up")
        report.note(
            f"up axis: taken as {axis} by its largest level faces; if wrong, give up= (--up)"
        )
    if axis != "z":
        triangles.vertices = triangles.vertices @ np.array(_TURNS[axis], np.float64).T
    if stated is not None:
        words, factor = f"{stated:g} m per unit, as asked for", stated
    elif known is not None:
        words, factor = "metres by definition" if kind != ".ifc" else "the file's own", 1.0
    else:
        guess = guess_unit(triangles.vertices, triangles.faces)
        words, factor = f"taken as {NAMES[guess.unit]}", UNITS[guess.unit]
        guessed.append("units")
        report.note(f"units: {words}, because {guess.why}; if wrong, give units= (--units)")
    triangles.vertices = triangles.vertices * factor
    longest = float(np.ptp(triangles.vertices, axis=0).max())
    if "units" not in guessed and not 0.5 <= longest <= 5000.0:
        report.note(
            f"size: the longest side is {longest:.4g} m, odd for a building; if the units are "
            "wrong, pass units="
        )
    return ModelSource(name, factor, words, axis, tuple(guessed), 0, 0)


def _building(file: Path, stated: Any, report: Report) -> Building | None:
    """What the side file says; else what the model states itself."""
    side = file.with_name(file.stem + SIDE_FILE)
    if side.is_file():
        if stated is not None:
            report.note(f"rooms: taken from {side.name}, not from the model")
        return Building.from_dict(read_json(side).data, side.name)
    if stated is None or isinstance(stated, Building):
        return stated
    return Building.from_dict(stated, f"{file.name}: extras.belvedere_building")


def _far_origin(vertices: F8) -> F8:
    """(3,) whole metres near the middle of what stands far off; zeros for what does not."""
    if np.abs(vertices).max() <= FAR_M:
        return np.zeros(3)
    middle = np.rint(np.median(vertices, axis=0))
    return np.where(np.abs(middle) > FAR_M / 2, middle, 0.0)


def _say_where(vertices: F8, origin: F8, keep_origin: bool, report: Report) -> None:
    far = float(np.abs(vertices - origin).max())
    if origin.any():
        report.note(
            f"coordinates: {', '.join(f'{v:.0f}' for v in origin)} m subtracted, they were too "
            "large for single precision"
        )
    if far > FAR_M:
        step = float(np.spacing(np.float32(far))) * 1000.0
        report.note(
            f"coordinates: up to {far:.4g} m, where single precision has steps of {step:.2g} mm"
            + ("" if not keep_origin else "; keep_origin=False would subtract an origin")
        )


def _moved(building: Building, origin: F8) -> Building:
    if not origin.any():
        return building
    rooms = tuple(
        replace(
            room,
            rings=tuple(ring - origin[:2] for ring in room.rings),
            floor=room.floor - float(origin[2]),
            ceiling=room.ceiling - float(origin[2]),
        )
        for room in building.rooms
    )
    openings = tuple(replace(o, corners=o.corners - origin) for o in building.openings)
    return Building(rooms, openings)
