"""The shapes of an IFC's elements, as ifcopenshell cuts them into triangles."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]
I8 = npt.NDArray[np.int64]
_NO_MATTER = ("IfcSpace", "IfcOpeningElement", "IfcVirtualElement", "IfcSpatialZone", "IfcGrid",
              "IfcAnnotation", "IfcPort", "IfcStructuralActivity", "IfcStructuralItem")  # fmt: skip
"""Kinds of products that are no matter: air, holes, lines of a drawing, loads."""


@dataclass(frozen=True, slots=True)
class Style:
    """What a face looks like."""

    name: str
    """Of the surface style."""
    color: tuple[float, float, float]
    """As in the file: picked on a screen, so sRGB-encoded."""
    transparency: float
    """1 lets all light through."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """An element's triangles, metres, +z up, in the IFC's world."""

    id: int
    """Of the element in the file."""
    vertices: F8
    """(N, 3) positions."""
    faces: I8
    """(M, 3) vertex indices."""
    style: I8
    """(M,) index into ``styles``, or -1."""
    item: I8
    """(M,) which item of the representation each face is of."""
    styles: tuple[Style, ...]
    """That the faces index."""
    axes: F8
    """(3, 3) the element's own axes, as rows."""

    @property
    def corners(self) -> F8:
        """(M, 3, 3) positions of the faces' corners."""
        return self.vertices[self.faces]


def solid_products(model: Any) -> list[Any]:
    """Products with a representation that are matter, in the order of their ids."""
    nothing = {p.id() for kind in _NO_MATTER for p in _by_type(model, kind)}
    found = [p for p in _by_type(model, "IfcProduct") if p.Representation is not None]
    return sorted((p for p in found if p.id() not in nothing), key=lambda p: p.id())


def shapes_of(model: Any, products: Iterable[Any]) -> dict[int, Shape]:
    """The shapes of products, by id; those without triangles are missing.

    Nothing between the calls of the iterator may fail: its threads outlive an exception.
    """
    from ifcopenshell import geom

    wanted = list(products)
    if not wanted:
        return {}
    iterator = geom.iterator(geom.settings(), model, os.cpu_count() or 1, include=wanted)
    found: dict[int, Shape] = {}
    names: dict[str, str] = {}
    more = iterator.initialize()
    while more:
        shape = _shape(model, iterator.get(), names)
        if len(shape.faces):
            found[shape.id] = shape if shape.id not in found else _joined(found[shape.id], shape)
        more = iterator.next()
    return dict(sorted(found.items()))


def _by_type(model: Any, kind: str) -> list[Any]:
    """Instances of a class and its children; none where the file's schema lacks the class."""
    try:
        return list(model.by_type(kind))
    except RuntimeError:
        return []


def _shape(model: Any, found: Any, names: dict[str, str]) -> Shape:
    geometry = found.geometry
    matrix = np.array(found.transformation.matrix, np.float64).reshape(4, 4).T
    points = np.frombuffer(geometry.verts_buffer, np.float64).reshape(-1, 3)
    styles = tuple(_style(model, material, names) for material in geometry.materials)
    faces = np.frombuffer(geometry.faces_buffer, np.int32).reshape(-1, 3).astype(np.int64)
    return Shape(
        int(found.id),
        points @ matrix[:3, :3].T + matrix[:3, 3],
        faces,
        np.frombuffer(geometry.material_ids_buffer, np.int32).astype(np.int64),
        np.frombuffer(geometry.item_ids_buffer, np.int32).astype(np.int64),
        styles,
        matrix[:3, :3].T.copy(),
    )


def _style(model: Any, material: Any, names: dict[str, str]) -> Style:
    name = str(material.name)
    if name not in names:
        names[name] = _style_name(model, name)
    red, green, blue = (float(v) if math.isfinite(v) else 0.8 for v in material.diffuse.components)
    clear = float(material.transparency)
    return Style(names[name], (red, green, blue), clear if math.isfinite(clear) else 0.0)


def _style_name(model: Any, name: str) -> str:
    """What people call a style that ifcopenshell calls by the id of its rendering."""
    kind, _, number = name.rpartition("-")
    if not kind.startswith("IfcSurfaceStyle") or not number.isdigit():
        return name
    entity = model.by_id(int(number))
    owners = [entity, *model.get_inverse(entity)]
    called = [o.Name for o in owners if o.is_a("IfcSurfaceStyle") and o.Name]
    return str(called[0]) if called else name


def _joined(a: Shape, b: Shape) -> Shape:
    """Two shapes of one element, from two representations."""
    style = np.where(b.style >= 0, b.style + len(a.styles), -1)
    return Shape(
        a.id,
        np.concatenate([a.vertices, b.vertices]),
        np.concatenate([a.faces, b.faces + len(a.vertices)]),
        np.concatenate([a.style, style]),
        np.concatenate([a.item, b.item]),
        (*a.styles, *b.styles),
        a.axes,
    )
