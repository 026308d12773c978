"""Wavefront OBJ with its MTL.

Read here rather than by trimesh, which reorders faces, joins the names of objects, takes negative
indices from the end of the file and cuts concave polygons wrongly. Numbers are parsed by NumPy in
runs of like lines.

``Kd`` is a color as people picked it on a screen, so it is taken as sRGB-encoded, as are the
textures and the colors of vertices, unless a program wrote it that is known to write it linear;
``Ke`` is light and taken as linear.

Source: Wavefront Advanced Visualizer, appendix B1 (object files) and B2 (material files).
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import FileFormatError
from belvedere.model._found import Found
from belvedere.model._mtl import MaterialFiles
from belvedere.model._polygons import triangulated
from belvedere.model._triangles import Triangles
from belvedere.model.report import Report

I8 = npt.NDArray[np.int64]
_QUIET = {"vn", "vp", "s", "mg", "cstype", "deg", "bmat", "step", "end", "parm", "trim", "scrv",
          "hole", "sp", "ctech", "stech", "bevel", "c_interp", "d_interp", "lod", "maplib",
          "shadow_obj", "trace_obj", "con"}  # fmt: skip
_LEFT_OUT = {"l": "lines", "p": "points", "curv": "free-form curves", "curv2": "free-form curves",
             "surf": "free-form surfaces", "usemap": "maps named by usemap"}  # fmt: skip


def read_obj(path: Path, report: Report) -> Found:
    """The triangles of an OBJ file, in its own units and axes.

    Raises:
        FileFormatError: no OBJ, a line that cannot be read, an index that points nowhere.
    """
    text = path.read_bytes().decode("utf-8-sig", errors="replace").replace("\\\r\n", " ")
    reader = _Reader(path, report)
    reader.read(text.replace("\\\n", " "))
    return reader.found()


class _Reader:
    def __init__(self, path: Path, report: Report) -> None:
        self.path, self.report = path, report
        self.files = MaterialFiles(path.parent, report)
        self.vertices: list[str] = []
        self.coordinates: list[str] = []
        self.faces: list[str] = []
        self.runs: list[tuple[int, int, int, int, int]] = []
        """First face, vertices and coordinates so far, material, object."""
        self.materials: list[str] = []
        self.things: list[str] = []
        self.normals = False
        self.known = 0

    def read(self, text: str) -> None:
        """Sort the lines by what they are; a run of faces shares what stands above it."""
        material = thing = -1
        before = ""
        for line in text.splitlines():
            word, _, rest = line.lstrip().partition(" ")
            if "\t" in word:
                word, _, rest = line.lstrip().replace("\t", " ").partition(" ")
            if word == "v":
                self.vertices.append(rest)
            elif word == "f":
                if before != "f":
                    self.runs.append((
                        len(self.faces), len(self.vertices), len(self.coordinates), material, thing
                    ))  # fmt: skip
                self.faces.append(rest)
            elif word == "vt":
                self.coordinates.append(rest)
            elif word == "usemtl":
                material = _index(self.materials, rest.strip())
            elif word in ("o", "g"):
                thing = _index(self.things, rest.strip() or "default")
            elif word == "mtllib":
                self.files.add(rest.strip())
            elif word == "vn":
                self.normals = True
            elif word in _LEFT_OUT:
                self.report.note(f"{_LEFT_OUT[word]}: left out")
            elif word and not word.startswith("#") and word not in _QUIET:
                self.report.note(f"lines that begin with {word[:20]!r}: not understood, left out")
                continue
            else:
                continue
            self.known += 1
            before = word

    def found(self) -> Found:
        """What has been read, as triangles."""
        if not self.known:
            raise FileFormatError(
                f"{self.path}: is not an OBJ model (no line of it begins with v, f or the like): "
                "is it another kind of text?"
            )
        points, colors = self._points()
        coordinates = _table(self.coordinates, self.path, "vt")
        uv_values = np.zeros((len(coordinates), 2))
        uv_values[:, : min(coordinates.shape[1], 2)] = coordinates[:, :2]
        uv_values[:, 1] = 1.0 - uv_values[:, 1]  # OBJ's v runs up, a picture's rows run down
        corners, starts = self._corners(len(points), len(uv_values))
        polygon, faces = triangulated(points, corners[:, 0], starts)
        run = np.searchsorted([r[0] for r in self.runs], polygon, side="right") - 1
        runs = np.array(self.runs, np.int64).reshape(-1, 5)
        uv = np.zeros((len(faces), 3, 2), np.float32)
        if len(uv_values):
            at = corners[faces, 1]
            uv = np.where(np.expand_dims(at >= 0, 2), uv_values[at], 0.0).astype(np.float32)
        if self.normals:
            self.report.note("vertex normals: not kept, faces are shaded as they lie")
        materials = [self.files.get(name) for name in self.materials]
        material = runs[run, 3]
        triangles = Triangles(
            points,
            corners[faces, 0],
            material.astype(np.int32),
            uv,
            None if colors is None else colors[corners[faces, 0]],
            (runs[run, 4] + 1).astype(np.int32),
        )
        clear = np.array([m in self.files.clear for m in self.materials] + [False])[material]
        for k in np.unique(material[clear]):
            count = int((material == k).sum())
            self.report.note(
                f"material {self.materials[k]!r}: lets light through, its {count:,} faces left out"
            )
        names = [self.path.stem, *self.things]
        return Found("OBJ", triangles.kept(~clear), materials, names)

    def _points(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float32] | None]:
        table = _table(self.vertices, self.path, "v")
        if len(table) and table.shape[1] < 3:
            raise FileFormatError(
                f"{self.path}: vertices have {table.shape[1]} numbers, expected 3"
            )
        points = table[:, :3] if len(table) else np.zeros((0, 3))
        if table.shape[1] < 6:
            return points, None
        encoded = table[:, 3:6]
        bare = np.asarray(~np.isfinite(encoded).all(axis=1))
        if np.nanmax(encoded, initial=0.0) > 1.0:
            encoded = encoded / 255.0
        colors = srgb_to_linear(np.clip(np.where(bare[:, None], 1.0, encoded), 0.0, 1.0))
        return points, colors.astype(np.float32)

    def _corners(self, points: int, coordinates: int) -> tuple[I8, I8]:
        """(C, 2) vertex and coordinate (-1: none) of each corner; (F + 1,) where faces begin."""
        words = [face.partition("#")[0].split() for face in self.faces]
        starts = np.cumsum([0, *map(len, words)]).astype(np.int64)
        flat = [word for face in words for word in face]
        table = _index_table(flat, self.path)
        first = np.array([r[0] for r in self.runs] + [len(words)], np.int64)
        so_far = np.repeat(
            np.array([r[1:3] for r in self.runs], np.int64).reshape(-1, 2),
            np.diff(starts[first]),
            axis=0,
        )
        index = np.where(table > 0, table - 1, np.where(table < 0, so_far + table, -1))
        for k, (what, count) in enumerate(
            (("vertex", points), ("texture coordinate", coordinates))
        ):
            wrong = (index[:, k] >= count) | ((index[:, k] < 0) & ((table[:, k] != 0) | (k == 0)))
            if wrong.any():
                at = int(np.searchsorted(starts, np.flatnonzero(wrong)[0], side="right")) - 1
                raise FileFormatError(
                    f"{self.path}: face {at + 1} ({self.faces[at].strip()[:60]}) names a {what} "
                    f"that is not there: the file has {count}; is it truncated?"
                )
        return index, starts


def _index(names: list[str], name: str) -> int:
    if name in names[-1:]:
        return len(names) - 1
    if name not in names:
        names.append(name)
    return names.index(name)


def _table(lines: list[str], path: Path, what: str) -> npt.NDArray[np.float64]:
    """(N, K) numbers of lines; K is the largest count, NaN where a line has fewer."""
    if not lines:
        return np.zeros((0, 3))
    try:
        flat = np.array(" ".join(lines).split(), np.float64)
        width, rest = divmod(len(flat), len(lines))
        counts = {line.count(" ") for line in (lines[0].strip(), lines[-1].strip())}
        if rest == 0 and counts == {width - 1}:
            return flat.reshape(-1, width)
    except ValueError:
        pass  # told below, with the line
    return _ragged(lines, path, what)


def _ragged(lines: Iterable[str], path: Path, what: str) -> npt.NDArray[np.float64]:
    rows: list[Any] = []
    for number, line in enumerate(lines):
        try:
            rows.append([float(word) for word in line.partition("#")[0].split()])
        except ValueError:
            raise FileFormatError(
                f"{path}: the {what} line number {number + 1} is {line.strip()[:60]!r}, expected "
                "numbers"
            ) from None
    width = max(len(row) for row in rows)
    out = np.full((len(rows), max(width, 1)), np.nan)
    for k, row in enumerate(rows):
        out[k, : len(row)] = row
    return out


def _index_table(words: list[str], path: Path) -> I8:
    """(C, 2) vertex and texture index of ``v``, ``v/t``, ``v//n`` or ``v/t/n``; 0 is none."""
    out = np.zeros((len(words), 2), np.int64)
    if not words:
        return out
    try:
        marks = {word.count("/") for word in words}
        if len(marks) == 1 and not any("//" in word or word[-1] == "/" for word in words):
            flat = np.array("/".join(words).split("/"), np.int64).reshape(len(words), -1)
            out[:, : min(flat.shape[1], 2)] = flat[:, :2]
            return out
        for k, word in enumerate(words):
            parts = word.split("/")
            out[k, 0] = int(parts[0])
            if len(parts) > 1 and parts[1]:
                out[k, 1] = int(parts[1])
    except (ValueError, OverflowError) as error:
        raise FileFormatError(f"{path}: a face has an index that is no number ({error})") from None
    return out
