"""Floor plans: what was found, for a person to see and correct.

One plan for each storey, side by side: walls as the mesh is cut 1.2 m above the floor, cells as
soft colours with names and areas, portals with their names, a scale bar and the axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_number
from belvedere.ground.errors import InputError
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.cells import OUTSIDE, Cell, CellGraph, Portal
from belvedere.walkthrough.drawing import Area, Color, Drawing, Label, Lines, text_width
from belvedere.walkthrough.leaves import named_doors, without
from belvedere.walkthrough.outlines import area_of, inner_point

F8 = npt.NDArray[np.float64]

CUT_M = 1.2
"""Where walls are cut, above the storey's floor."""
INK, WALL, FAINT = (35, 38, 44), (196, 198, 204), (120, 124, 132)
PORTAL_INK: dict[str, Color] = {
    "door": (176, 74, 32),
    "opening": (118, 92, 168),
    "window": (36, 118, 190),
}
MARK_INK = (204, 24, 60)
WALL_M = 0.3
"""How wide a band of wall is drawn round a cell; what the slice shows lies on top."""
FOOT_PX, AXES_PX, KEY_PX = 24.0, 136.0, 46.0
"""Widths in the line below the plans: before the scale bar, of the axes, of a key but its word."""
GOLDEN = 0.618033988749895

__all__ = ["Mark", "Plan", "draw_plan"]


@dataclass(frozen=True, slots=True)
class Mark:
    """Something to show on a plan: a reference view, the visitor."""

    position: tuple[float, float, float]
    """World metres."""
    direction: tuple[float, float] = (0.0, 0.0)
    """Where it looks, in plan; zero for a dot."""
    name: str = ""
    """Written beside it."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A drawn floor plan."""

    drawing: Drawing
    """What it consists of."""

    @property
    def svg(self) -> str:
        """The plan as SVG text."""
        return self.drawing.svg()

    def image(self, scale: float = 1.0) -> npt.NDArray[np.uint8]:
        """(H, W, 3) sRGB pixels."""
        return self.drawing.image(check_number("Plan.image", "scale", scale, 0.1, 8.0))

    def save(self, path: str | Path) -> Path:
        """Write .svg or .png, told by the name, atomically.

        Raises:
            InputError: another ending.
            OutputError: the file cannot be written.
        """
        from belvedere.scene.io import atomic_write, write_color

        file = Path(path)
        if file.suffix.lower() == ".png":
            write_color(file, self.image())
        elif file.suffix.lower() == ".svg":
            with atomic_write(file) as temporary:
                Path(temporary).write_text(self.svg, encoding="utf-8")
        else:
            raise InputError(f"Plan.save.path is {str(file)!r}: it must end in .svg or .png")
        return file


def draw_plan(
    graph: CellGraph, mesh: Mesh, *, marks: Sequence[Mark] = (), pixels_per_metre: float = 48.0
) -> Plan:
    """Draw the floor plans of a building.

    Args:
        graph: its cells and portals.
        mesh: its triangles, whose cut gives the walls; it may be empty.
        marks: points with directions to draw over it, each on the storey it is in.
        pixels_per_metre: how large; less is taken where the picture would exceed 8000 pixels.

    Raises:
        InputError: a scale that is not from 2 to 500 pixels a metre.
    """
    pixels_per_metre = check_number("draw_plan", "pixels_per_metre", pixels_per_metre, 2.0, 500.0)
    storeys = sorted({cell.storey for cell in graph.cells})
    levels = [_level(graph, storey) for storey in storeys]
    low = np.min([cell.low[:2] for cell in graph.cells], axis=0) - 0.9
    high = np.max([cell.high[:2] for cell in graph.cells], axis=0) + 0.9
    room = high - low
    scale = min(pixels_per_metre, 8000.0 / (room[0] * len(storeys)), 8000.0 / float(room[1]))
    lacks = max(_foot_width(scale) / len(storeys) - room[0] * scale, 0.0) / scale
    beside = np.array([lacks / 2.0, 0.0])
    low, high = low - beside, high + beside
    wide, tall = (high - low) * scale
    head, foot = 46.0, 64.0
    drawing = Drawing(math.ceil(wide * len(storeys)), math.ceil(tall + head + foot))
    open_mesh = without(mesh, named_doors(mesh))
    for k, (storey, level) in enumerate(zip(storeys, levels, strict=True)):
        above = levels[k + 1] if k + 1 < len(levels) else np.inf
        sheet = _Sheet(drawing, low, high, scale, (k * wide, head))
        sheet.draw(graph, open_mesh, storey, level, above)
        shown = [m for m in marks if level - 0.3 <= m.position[2] < above - 0.3]
        sheet.marks(shown)
        title = f"storey {storey}, floor at {level:.2f} m"
        drawing.items.append(Label((k * wide + wide / 2.0, 24.0), title, 20.0, INK))
    _foot(drawing, scale, tall + head + 22.0)
    return Plan(drawing)


def _level(graph: CellGraph, storey: int) -> float:
    """The floor of a storey: that of most of its area."""
    own = [cell for cell in graph.cells if cell.storey == storey]
    order = sorted(own, key=lambda cell: cell.floor)
    area = np.cumsum([area_of(cell.rings) for cell in order])
    return order[int(np.searchsorted(area, area[-1] / 2.0))].floor


def _soft(index: int) -> Color:
    """A light colour; neighbours in number are far apart in hue."""
    hue = (0.08 + index * GOLDEN) % 1.0
    light = 0.90 if index % 2 else 0.86
    chroma = 0.16
    rgb = [light + chroma * math.cos(2 * math.pi * (hue - k / 3.0)) * 0.55 for k in range(3)]
    return tuple(round(255 * min(max(c, 0.0), 1.0)) for c in rgb)  # type: ignore[return-value]


class _Sheet:
    """One storey on the drawing."""

    def __init__(
        self, drawing: Drawing, low: F8, high: F8, scale: float, at: tuple[float, float]
    ) -> None:
        self.drawing, self.low, self.high, self.scale, self.at = drawing, low, high, scale, at
        self.boxes: list[tuple[float, float, float, float]] = []

    def to_picture(self, points: npt.ArrayLike) -> F8:
        p = np.asarray(points, dtype=np.float64)[..., :2]
        x = (p[..., 0] - self.low[0]) * self.scale + self.at[0]
        y = (self.high[1] - p[..., 1]) * self.scale + self.at[1]
        return np.stack([x, y], axis=-1)

    def draw(self, graph: CellGraph, mesh: Mesh, storey: int, level: float, above: float) -> None:
        here = [
            (k, cell)
            for k, cell in enumerate(graph.cells)
            if cell.storey == storey or cell.floor < level + CUT_M < cell.ceiling
        ]
        # those from below first: what has its floor here lies over them
        here.sort(key=lambda entry: (entry[1].storey == storey, entry[0]))
        add = self.drawing.items.append
        rings = [(k, tuple(self.to_picture(r) for r in cell.rings)) for k, cell in here]
        for _, ring in rings:
            add(Area(ring, WALL, 2.0 * WALL_M * self.scale))
        for k, ring in rings:
            add(Area(ring, _soft(k)))
        walls = _slice(mesh, level + CUT_M)
        if len(walls):
            add(Lines(self.to_picture(walls), INK, max(0.025 * self.scale, 1.0)))
        portals = [
            p for p in graph.portals if level - 0.3 <= float(p.corners[:, 2].mean()) < above - 0.3
        ]
        for portal in portals:
            self._portal(portal)
        for _, cell in here:
            self._cell_label(cell)
        self._portal_labels(portals)

    def _portal(self, portal: Portal) -> None:
        add = self.drawing.items.append
        color = PORTAL_INK[portal.kind]
        corners = self.to_picture(portal.corners)
        if abs(portal.normal[2]) > 0.5:  # a hole in a floor
            ends = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
            add(Lines(_dashed(ends), color, 1.6))
            add(Lines(_dashed(corners[[[0, 2], [1, 3]]]), color, 0.8))
            return
        a, b = _ends(corners)
        thick = 0.07 * self.scale
        add(Lines(np.array([[a, b]]), (255, 255, 255), 2.2 * thick))
        across = np.array([b[1] - a[1], a[0] - b[0]])
        length = float(np.hypot(*across))
        across = across / max(length, 1e-9)
        if (
            across @ (portal.normal[:2] * [1.0, -1.0]) < 0.0
        ):  # doors are drawn open to the first cell
            across = -across
        if portal.kind == "door":
            add(Lines(np.array([[a, b]]), color, 1.0))
            turn = np.linspace(0.0, np.pi / 2.0, 13)[:, None]
            arc = a + np.cos(turn) * (b - a) + np.sin(turn) * across * length
            add(Lines(np.stack([arc[:-1], arc[1:]], axis=1), color, 1.0))
            add(Lines(np.array([[a, a + across * length]]), color, 2.6))
        elif portal.kind == "window":
            shift = 0.45 * thick * across
            add(Lines(np.array([[a - shift, b - shift], [a + shift, b + shift]]), color, 1.4))
        else:
            add(Lines(_dashed(np.array([[a, b]])), color, 2.2))

    def _cell_label(self, cell: Cell) -> None:
        """Name and area, in the widest place of the room, smaller where the room is narrow."""
        x, y = self.to_picture(inner_point(cell.rings, 0.15)[0])
        name, area = cell.name, f"{area_of(cell.rings):.1f} m"
        room = (cell.high - cell.low)[0] * self.scale * 0.92
        size = 15.0
        width = max(text_width(name, size), text_width(area + "2", 0.85 * size))
        size = max(min(size, size * room / width), 7.0)
        small = 0.85 * size
        lines: list[Label] = []
        for dy in (0.0, 1.4, -1.4, 2.8, -2.8, 4.2, -4.2, 0.0):
            middle = float(y) + dy * size
            lines = [
                Label((float(x), middle - 0.6 * size), name, size, INK, (255, 255, 255)),
                Label((float(x), middle + 0.6 * size), area, small, FAINT, (255, 255, 255)),
            ]
            if all(self._overlap(line.box) == 0.0 for line in lines):
                break
        for line in lines:
            self._put(line)
        # Pillow's own letters have no superscript two
        beside = float(x) + text_width(area, small) / 2.0 + 0.2 * small
        at = (beside, lines[1].at[1] - 0.3 * small)
        self._put(Label(at, "2", 0.62 * small, FAINT, (255, 255, 255)))

    def _portal_labels(self, portals: list[Portal]) -> None:
        groups: list[list[Portal]] = []
        for portal in portals:  # sashes one above another are one line in a plan
            for group in groups:
                near = np.linalg.norm(group[0].center[:2] - portal.center[:2]) < 0.15
                if near and group[0].kind == portal.kind:
                    group.append(portal)
                    break
            else:
                groups.append([portal])
        for group in groups:
            portal = group[0]
            text = portal.name if len(portal.name) <= 22 else portal.name[:20].rstrip() + "…"
            if len(group) > 1:
                text += f" +{len(group) - 1}"
            center = self.to_picture(portal.center)
            normal = portal.normal[:2] * [1.0, -1.0]
            if portal.cells[1] == OUTSIDE:
                normal = -normal
            if np.hypot(*normal) < 0.5:
                normal = np.array([0.0, 1.0])
            self._place(text, center, normal, PORTAL_INK[portal.kind])

    def _place(self, text: str, center: F8, normal: F8, color: Color) -> None:
        """Put a label near a point: the first place of a spiral that nothing else takes."""
        along = np.array([-normal[1], normal[0]])
        best: tuple[float, Label] | None = None
        for size in (10.5, 9.0, 7.5):
            half = text_width(text, size) / 2.0
            base = abs(normal[0]) * half + abs(normal[1]) * 0.6 * size + 6.0
            for away in (0.0, 12.0, 24.0, 40.0, 60.0):
                for side in (1.0, -1.0):
                    for shift in (0.0, 14.0, -14.0, 30.0, -30.0):
                        x, y = center + normal * side * (base + away) + along * shift
                        label = Label((float(x), float(y)), text, size, color, (255, 255, 255))
                        cost = self._overlap(label.box)
                        if cost == 0.0 and self._on_sheet(label.box):
                            self._put(label)
                            return
                        if best is None or cost < best[0]:
                            best = (cost, label)
        assert best is not None
        self._put(best[1])

    def _put(self, label: Label) -> None:
        self.boxes.append(label.box)
        self.drawing.items.append(label)

    def _overlap(self, box: tuple[float, float, float, float]) -> float:
        total = 0.0
        for other in self.boxes:
            w = min(box[2], other[2]) - max(box[0], other[0])
            h = min(box[3], other[3]) - max(box[1], other[1])
            total += max(w, 0.0) * max(h, 0.0)
        return total

    def _on_sheet(self, box: tuple[float, float, float, float]) -> bool:
        right = self.at[0] + (self.high[0] - self.low[0]) * self.scale
        return box[0] >= self.at[0] and box[2] <= right

    def marks(self, marks: Sequence[Mark]) -> None:
        """Points with directions."""
        for mark in marks:
            at = self.to_picture(np.array(mark.position))
            turn = np.linspace(0.0, 2.0 * np.pi, 13)
            dot = at + 3.2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
            self.drawing.items.append(Area((dot,), MARK_INK))
            way = np.array([mark.direction[0], -mark.direction[1]])
            length = float(np.hypot(*way))
            if length > 0.0:
                tip = at + way / length * 16.0
                self.drawing.items.append(Lines(np.array([[at, tip]]), MARK_INK, 1.6))
            if mark.name:
                self._place(mark.name, at, np.array([0.0, 1.0]), MARK_INK)


def _ends(corners: F8) -> tuple[F8, F8]:
    """The two ends of an upright rectangle as it shows in plan."""
    far = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    a, b = np.unravel_index(int(np.argmax(far)), far.shape)
    return corners[min(a, b)], corners[max(a, b)]


def _dashed(ends: F8, dash: float = 6.0) -> F8:
    """Strokes cut into dashes."""
    parts = []
    for a, b in ends:
        count = max(int(np.hypot(*(b - a)) / dash / 2.0), 1)
        t = (np.arange(count) + 0.25) / count
        start = a + t[:, None] * (b - a)
        parts.append(np.stack([start, start + (b - a) * 0.5 / count], axis=1))
    return np.concatenate(parts)


def _slice(mesh: Mesh, height: float) -> F8:
    """(N, 2, 2) where the plane z = height cuts the triangles."""
    if not len(mesh.faces):
        return np.zeros((0, 2, 2))
    corners = mesh.vertices[mesh.faces]
    above = corners[:, :, 2] > height
    corners = corners[above.any(axis=1) & ~above.all(axis=1)]
    above = corners[:, :, 2] > height
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    row = np.arange(len(corners))
    a, b, c = (corners[row, (lone + k) % 3] for k in range(3))
    ends = []
    for other in (b, c):
        t = (height - a[:, 2]) / (other[:, 2] - a[:, 2])
        ends.append(a[:, :2] + t[:, None] * (other - a)[:, :2])
    segments = np.stack(ends, axis=1)
    long = np.hypot(*(segments[:, 1] - segments[:, 0]).T) > 0.005
    return segments[long]


def _foot_width(scale: float) -> float:
    """Pixels that the line below the plans takes, see `_foot`."""
    keys = sum(KEY_PX + text_width(kind, 12.0) for kind in PORTAL_INK)
    return FOOT_PX + 5.0 * scale + AXES_PX + keys


def _foot(drawing: Drawing, scale: float, y: float) -> None:
    """Five metres in black and white, which way the axes go, and what the colours stand for."""
    x = FOOT_PX
    for k in range(5):
        a, b = x + k * scale, x + (k + 1) * scale
        ring = np.array([[a, y], [b, y], [b, y + 6.0], [a, y + 6.0]])
        drawing.items.append(Area((ring,), INK if k % 2 == 0 else (255, 255, 255), 0.0))
    for up in (0.0, 6.0):
        ends = np.array([[[x, y + up], [x + 5 * scale, y + up]]])
        drawing.items.append(Lines(ends, INK, 1.0))
    for k in (0, 1, 2, 5):
        text = f"{k} m" if k == 5 else str(k)
        drawing.items.append(Label((x + k * scale, y + 17.0), text, 11.0, INK))
    cx, cy = x + 5 * scale + 56.0, y + 16.0
    arrows = [[[cx, cy], [cx + 26, cy]], [[cx + 26, cy], [cx + 20, cy - 4]]]
    arrows += [[[cx + 26, cy], [cx + 20, cy + 4]], [[cx, cy], [cx, cy - 26]]]
    arrows += [[[cx, cy - 26], [cx - 4, cy - 20]], [[cx, cy - 26], [cx + 4, cy - 20]]]
    drawing.items.append(Lines(np.array(arrows, dtype=np.float64), INK, 1.4))
    drawing.items.append(Label((cx + 35.0, cy), "x", 12.0, INK))
    drawing.items.append(Label((cx + 10.0, cy - 26.0), "y", 12.0, INK))
    at = x + 5 * scale + AXES_PX
    for kind, color in PORTAL_INK.items():
        drawing.items.append(Lines(np.array([[[at, cy], [at + 18.0, cy]]]), color, 3.0))
        width = text_width(kind, 12.0)
        drawing.items.append(Label((at + 26.0 + width / 2.0, cy), kind, 12.0, INK))
        at += KEY_PX + width
