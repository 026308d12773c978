"""Small IFC files put together entity by entity, in any unit, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

Box = tuple[float, float, float, float, float, float]
"""Lowest x, y, z and highest x, y, z, metres."""


class Ifc:
    """A file with one storey whose elements are boxes."""

    def __init__(self, per_metre: float = 1000.0, schema: Any = "IFC4", shift: float = 0.0) -> None:
        import ifcopenshell

        self.file: Any = ifcopenshell.file(schema=schema)
        self.per_metre = per_metre
        self.count = 0
        make = self.file.create_entity
        prefix = {1000.0: "MILLI", 1.0: None}[per_metre]
        length = make("IfcSIUnit", UnitType="LENGTHUNIT", Prefix=prefix, Name="METRE")
        angle = make("IfcSIUnit", UnitType="PLANEANGLEUNIT", Name="RADIAN")
        units = make("IfcUnitAssignment", [length, angle])
        self.context = make(
            "IfcGeometricRepresentationContext", ContextType="Model",
            CoordinateSpaceDimension=3, Precision=1e-5, WorldCoordinateSystem=self.axes((0, 0, 0)),
        )  # fmt: skip
        self.project = self.rooted("IfcProject", "p")
        self.project.RepresentationContexts = [self.context]
        self.project.UnitsInContext = units
        self.storey = self.rooted("IfcBuildingStorey", "Ground floor")
        self.storey.ObjectPlacement = make(
            "IfcLocalPlacement", RelativePlacement=self.axes((shift, shift, 0))
        )
        relation = self.rooted("IfcRelAggregates", "")
        relation.RelatingObject, relation.RelatedObjects = self.project, [self.storey]
        self.styles: dict[str, Any] = {}

    def rooted(self, kind: str, name: str) -> Any:
        self.count += 1
        entity = self.file.create_entity(kind, GlobalId=f"{self.count:022d}")
        if name:
            entity.Name = name
        return entity

    def point(self, *values: float) -> Any:
        return self.file.create_entity(
            "IfcCartesianPoint", [float(v) * self.per_metre for v in values]
        )

    def direction(self, *values: float) -> Any:
        return self.file.create_entity("IfcDirection", [float(v) for v in values])

    def axes(self, at: tuple[float, ...], x: tuple[float, float, float] = (1, 0, 0)) -> Any:
        return self.file.create_entity(
            "IfcAxis2Placement3D", self.point(*at), self.direction(0, 0, 1), self.direction(*x)
        )

    def solid(self, box: Box, style: str = "") -> Any:
        """An extruded rectangle."""
        low, high = np.array(box[:3]), np.array(box[3:])
        center, size = (low + high) / 2, high - low
        make = self.file.create_entity
        flat = make("IfcAxis2Placement2D", self.point(0, 0))
        profile = make(
            "IfcRectangleProfileDef", ProfileType="AREA", Position=flat,
            XDim=float(size[0]) * self.per_metre, YDim=float(size[1]) * self.per_metre,
        )  # fmt: skip
        solid = make(
            "IfcExtrudedAreaSolid", profile, self.axes((center[0], center[1], low[2])),
            self.direction(0, 0, 1), float(size[2]) * self.per_metre,
        )  # fmt: skip
        if style:
            make("IfcStyledItem", Item=solid, Styles=[self.styles[style]])
        return solid

    def style(self, name: str, color: tuple[float, float, float], clear: float = 0.0) -> None:
        make = self.file.create_entity
        rgb = make("IfcColourRgb", None, *color)
        shading = make("IfcSurfaceStyleRendering", SurfaceColour=rgb, Transparency=clear,
                       ReflectanceMethod="FLAT")  # fmt: skip
        self.styles[name] = make("IfcSurfaceStyle", Name=name, Side="BOTH", Styles=[shading])

    def element(
        self, kind: str, name: str, *boxes: Box | tuple[Box, str],
        x: tuple[float, float, float] = (1, 0, 0), at: tuple[float, float, float] = (0, 0, 0),
    ) -> Any:  # fmt: skip
        """A product made of boxes, in its own axes."""
        make = self.file.create_entity
        items = [self.solid(*b) if isinstance(b[1], str) else self.solid(b) for b in boxes]  # type: ignore[arg-type, misc]
        product = self.rooted(kind, name)
        product.ObjectPlacement = make(
            "IfcLocalPlacement", self.storey.ObjectPlacement, self.axes(at, x)
        )
        if items:
            body = make("IfcShapeRepresentation", self.context, "Body", "SweptSolid", items)
            product.Representation = make("IfcProductDefinitionShape", None, None, [body])
        if kind == "IfcSpace":
            relation = self.rooted("IfcRelAggregates", "")
            relation.RelatingObject, relation.RelatedObjects = self.storey, [product]
        return product

    def opening(self, host: Any, name: str, box: Box, filler: Any = None) -> Any:
        hole = self.element("IfcOpeningElement", name, box)
        relation = self.rooted("IfcRelVoidsElement", "")
        relation.RelatingBuildingElement, relation.RelatedOpeningElement = host, hole
        if filler is not None:
            relation = self.rooted("IfcRelFillsElement", "")
            relation.RelatingOpeningElement, relation.RelatedBuildingElement = hole, filler
        return hole

    def write(self, path: Path) -> Path:
        self.file.write(str(path))
        return path


def flat(per_metre: float = 1000.0, schema: str = "IFC4", shift: float = 0.0) -> Ifc:
    """Two rooms of 4 x 4 m side by side along x, a wall with a door between, and a corridor."""
    ifc = Ifc(per_metre, schema, shift)
    ifc.style("plaster", (0.5, 0.5, 0.5))
    ifc.style("wood", (0.8, 0.4, 0.2))
    ifc.style("glass", (0.2, 0.4, 0.6), clear=0.8)
    ifc.element("IfcSlab", "floor", ((-0.2, -0.2, -0.3, 8.4, 6.2, 0.0), "plaster"))
    ifc.element("IfcSlab", "roof", ((-0.2, -0.2, 2.5, 8.4, 6.2, 2.8), "plaster"))
    south = ifc.element("IfcWall", "south", ((-0.2, -0.2, 0.0, 8.4, 0.0, 2.5), "plaster"))
    ifc.element("IfcWall", "west", ((-0.2, 0.0, 0.0, 0.0, 6.2, 2.5), "plaster"))
    ifc.element("IfcWall", "east", ((8.2, 0.0, 0.0, 8.4, 6.2, 2.5), "plaster"))
    middle = ifc.element("IfcWall", "middle", ((4.0, 0.0, 0.0, 4.2, 4.0, 2.5), "plaster"))
    # the door's own x axis runs along the wall (our y), its y axis through it
    door = ifc.element(
        "IfcDoor", "D", ((0.0, -0.1, 0.0, 0.05, 0.1, 2.0), "wood"),
        ((0.85, -0.1, 0.0, 0.9, 0.1, 2.0), "wood"), ((0.0, -0.1, 2.0, 0.9, 0.1, 2.05), "wood"),
        ((0.05, -0.02, 0.0, 0.85, 0.02, 2.0), "wood"), ((0.75, 0.03, 1.0, 0.8, 0.08, 1.05), "wood"),
        x=(0, 1, 0), at=(4.1, 1.0, 0.0),
    )  # fmt: skip
    ifc.opening(middle, "for D", (3.9, 1.0, 0.0, 4.3, 1.9, 2.05), door)
    ifc.opening(middle, "hatch", (3.9, 2.5, 1.0, 4.3, 3.5, 2.0))
    ifc.opening(middle, "pipe", (3.9, 2.2, 2.2, 4.3, 2.3, 2.3))
    ifc.opening(middle, "niche", (3.9, 0.2, 1.0, 4.1, 0.8, 1.6))
    window = ifc.element(
        "IfcWindow", "W", ((0.0, -0.05, 0.0, 1.5, 0.05, 0.06), "wood"),
        ((0.0, -0.01, 0.06, 1.5, 0.01, 1.2), "glass"), at=(1.0, -0.1, 0.9),
    )  # fmt: skip
    ifc.opening(south, "for W", (1.0, -0.3, 0.9, 2.5, 0.1, 2.1), window)
    return ifc


def add_rooms(ifc: Ifc) -> None:
    """The two rooms, and a corridor that is open to both along y = 4."""
    for name, box in (
        ("1", (0.0, 0.0, 0.0, 4.0, 4.0, 2.5)), ("2", (4.2, 0.0, 0.0, 8.2, 4.0, 2.5)),
    ):  # fmt: skip
        ifc.element("IfcSpace", name, box).LongName = "Office"
    ifc.element("IfcSpace", "3", (0.0, 4.0, 0.0, 8.2, 6.0, 2.5)).LongName = "Corridor"
