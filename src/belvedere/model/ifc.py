"""IFC, the exchange format of building design: geometry by element, spaces as rooms.

Spaces are air, so they become rooms and not surfaces. Colors are those of the surface styles,
picked on a screen and so taken as sRGB; what is more than half transparent is left out.

Source: ISO 16739; buildingSMART, IFC2x3, IFC4 and IFC4.3.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import BelvedereError, FileFormatError, MissingDependencyError
from belvedere.model._found import Found
from belvedere.model._ifc_doors import moving_faces
from belvedere.model._ifc_joins import joins_of
from belvedere.model._ifc_openings import Hole, holes_of, openings_of, space_boundaries
from belvedere.model._ifc_rooms import rooms_of
from belvedere.model._ifc_shapes import Shape, Style, shapes_of, solid_products
from belvedere.model._triangles import Triangles
from belvedere.model.building import Building
from belvedere.model.report import Report
from belvedere.scene.mesh import Material

CLEAR = 0.5
"""Faces more transparent than this are left out, so that windows can be looked through."""
_START, _END = b"ISO-10303-21;", b"END-ISO-10303-21;"


def read_ifc(path: Path, report: Report, doors: str = "open") -> Found:
    """The triangles and the building of an IFC file, metres, +z up.

    Args:
        path: an .ifc file (STEP text).
        report: told what is left out.
        doors: ``"open"`` leaves the leaves of doors out, ``"closed"`` keeps them.

    Raises:
        MissingDependencyError: ifcopenshell is not installed.
        FileFormatError: no IFC, truncated, without geometry.
    """
    model = _opened(path)
    products = solid_products(model)
    shapes = shapes_of(model, products)
    report.count(
        len(products) - len(shapes), "element", "elements", "without a shape that can be cut into "
        "triangles: left out",
    )  # fmt: skip
    air = [*model.by_type("IfcSpace"), *model.by_type("IfcOpeningElement")]
    everything = shapes | shapes_of(model, [p for p in air if p.Representation is not None])
    holes = holes_of(model, everything, report)
    moving = _moving(holes, everything, report) if doors == "open" else {}
    triangles, materials, names = _triangles(model, shapes, moving, report)
    building = _building(model, everything, holes, triangles, report)
    return Found(str(model.schema), triangles, materials, names, building)


def _opened(path: Path) -> Any:
    try:
        import ifcopenshell
    except ImportError as error:
        raise MissingDependencyError.for_extra("ifcopenshell", "ifc", "read IFC models") from error
    with path.open("rb") as file:
        head = file.read(4096)
        file.seek(max(path.stat().st_size - 4096, 0))
        tail = file.read()
    if _START not in head:
        raise FileFormatError(
            f"{path}: is not an IFC (it does not begin with {_START.decode()}): export it as IFC "
            "in STEP text; XML and ZIP are not read"
        )
    if _END not in tail:
        raise FileFormatError(f"{path}: is truncated (it has no {_END.decode()}): copy it again")
    try:
        return ifcopenshell.open(str(path))
    except BelvedereError:
        raise
    except Exception as error:  # parsers of foreign text raise nearly anything
        raise FileFormatError(f"{path}: is a broken IFC ({error}): export it again") from error


def _moving(
    holes: list[Hole], shapes: dict[int, Shape], report: Report
) -> dict[int, npt.NDArray[np.bool_]]:
    """For each door which of its faces are leaves."""
    found = {
        hole.element.id(): moving_faces(shapes[hole.element.id()], hole.frame)
        for hole in holes
        if hole.kind == "door" and hole.element.id() in shapes
    }
    report.count(
        sum(bool(m.any()) for m in found.values()), "door", "doors", "without leaves, so that one "
        'sees through: doors="closed" keeps them',
    )  # fmt: skip
    return found


def _triangles(
    model: Any, shapes: dict[int, Shape], moving: dict[int, npt.NDArray[np.bool_]], report: Report
) -> tuple[Triangles, list[Material], list[str]]:
    materials: list[Material] = []
    place: dict[Style, int] = {}
    parts: list[Triangles] = []
    names: list[str] = []
    clear: dict[str, int] = {}
    for shape in shapes.values():
        keep = ~moving.get(shape.id, np.zeros(len(shape.faces), bool))
        index = np.full(len(shape.styles) + 1, -1, np.int32)
        for k, style in enumerate(shape.styles):
            if style.transparency > CLEAR:
                through = keep & (shape.style == k)
                clear[style.name] = clear.get(style.name, 0) + int(through.sum())
                keep &= ~through
                continue
            if style not in place:
                place[style] = len(materials)
                linear = srgb_to_linear(np.clip(np.array(style.color), 0.0, 1.0))
                r, g, b = (float(v) for v in linear)
                materials.append(Material(style.name, (r, g, b)))
            index[k] = place[style]
        element = model.by_id(shape.id)
        count = len(shape.faces)
        parts.append(
            Triangles(
                shape.vertices, shape.faces, index[shape.style],
                np.zeros((count, 3, 2), np.float32), None, np.full(count, len(names), np.int32),
            ).kept(keep)
        )  # fmt: skip
        names.append(f"{element.is_a()} {element.Name or shape.id}")
    for name, count in clear.items():
        report.count(count, "face", "faces", f"of {name!r} let light through: left out")
    return Triangles.joined(parts), materials, names


def _building(
    model: Any, shapes: dict[int, Shape], holes: list[Hole], triangles: Triangles, report: Report
) -> Building | None:
    spaces = sorted(model.by_type("IfcSpace"), key=lambda s: s.id())
    rooms = rooms_of(spaces, shapes, report)
    if not rooms:
        report.note("rooms: the IFC has no spaces, so it states no rooms")
        return None
    openings = openings_of(holes, rooms, space_boundaries(model), report)
    listed = list(rooms.values())
    joins = joins_of(listed, triangles.vertices[triangles.faces])
    return Building(tuple(listed), (*openings, *joins))
