"""MTL, the material files of OBJ models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import srgb_to_linear
from belvedere.ground.errors import FileFormatError, MissingFileError, SceneError, UnsafePathError
from belvedere.model._texture_files import TextureFile, decode_texture
from belvedere.model._triangles import NO_MATERIAL
from belvedere.model.report import Report
from belvedere.scene.io.paths import existing
from belvedere.scene.mesh import Material

CLEAR = 0.5
"""Materials less opaque than this are left out, so that windows can be looked through."""
LINEAR_WRITERS = ("# blender", "mikedh/trimesh")
"""Programs, by the comment they begin with, that write ``Kd`` linear; all others: sRGB."""
_LINEAR = "#linear"
_OPTION_WORDS = {"-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-texres": 1,
                 "-imfchan": 1, "-bm": 1, "-boost": 1, "-type": 1, "-mm": 2, "-o": 3, "-s": 3,
                 "-t": 3}  # fmt: skip
_QUIET = {"newmtl", "kd", "ke", "d", "tr", "map_kd", "ka", "ks", "ns", "ni", "illum", "tf",
          "map_ke"}  # fmt: skip


class MaterialFiles:
    """The materials of an OBJ's ``mtllib`` files, decoded when they are first asked for."""

    def __init__(self, folder: Path, report: Report) -> None:
        self._folder, self._report = folder, report
        self._entries: dict[str, dict[str, str]] = {}
        self._asked: list[str] = []
        self._images: dict[str, TextureFile | None] = {}
        self.clear: set[str] = set()
        """Names of materials that let most light through; complete once they were asked for."""

    def add(self, rest: str) -> None:
        """Read what a ``mtllib`` line names: one file, or several without spaces in their names."""
        names = [rest] if self._find(rest) is not None else rest.split()
        for name in names:
            if name in self._asked:
                continue
            self._asked.append(name)
            path = self._find(name)
            if path is None:
                self._report.note(f"material file {name!r}: not in the model's folder, not read")
            else:
                self._parse(path)

    def get(self, name: str) -> Material:
        """The material called ``name``; light grey, said in the report, where no file has it."""
        entry = self._entries.get(name)
        if entry is None:
            self._report.note("a material that no material file describes: painted light grey")
            return Material(name, NO_MATERIAL.base_color)
        if self._opacity(entry, name) < CLEAR:
            self.clear.add(name)
        texture = self._texture(entry["map_kd"]) if "map_kd" in entry else None
        color = self._color(entry, "kd", name, (1.0, 1.0, 1.0) if texture else (0.8, 0.8, 0.8))
        if texture is not None and not color.any():
            self._report.note(f"material {name!r}: black under its texture, taken as white")
            color = np.ones(3)
        linear = np.clip(color, 0.0, 1.0)
        if _LINEAR not in entry:
            linear = srgb_to_linear(linear)
        glow = np.maximum(self._color(entry, "ke", name, (0.0, 0.0, 0.0)), 0.0)
        if "map_ke" in entry and (texture := self._texture(entry["map_ke"])) is not None:
            self._report.note("emissive textures: their mean is given off everywhere")
            glow = texture.mean * (glow if glow.any() else 1.0)
            texture = self._texture(entry["map_kd"]) if "map_kd" in entry else None
        return Material(
            name,
            (float(linear[0]), float(linear[1]), float(linear[2])),
            None if texture is None else texture.color,
            (float(glow[0]), float(glow[1]), float(glow[2])),
        )

    def _find(self, name: str) -> Path | None:
        """A file in the model's folder; one that lies elsewhere is looked for there by its name."""
        relative = name.strip().strip('"').replace("\\", "/")
        for candidate in (relative, relative.rsplit("/", 1)[-1]):
            try:
                return existing(self._folder, candidate, name)
            except (MissingFileError, UnsafePathError, SceneError):
                continue
        return None

    def _parse(self, path: Path) -> None:
        entry: dict[str, str] = {}
        text = path.read_bytes().decode("utf-8-sig", errors="replace")
        linear = any(name in text[:200].lower() for name in LINEAR_WRITERS)
        for line in text.splitlines():
            word, _, rest = line.strip().replace("\t", " ").partition(" ")
            word, rest = word.lower(), rest.strip()
            if word == "newmtl":
                entry = self._entries.setdefault(rest, {})
                if linear:
                    entry[_LINEAR] = ""
            elif word and not word.startswith("#"):
                entry[word] = rest
                if word.startswith(("map_", "bump", "disp", "decal", "refl", "norm")) and (
                    word not in _QUIET
                ):
                    self._report.note(f"{word} textures: not used")

    def _opacity(self, entry: dict[str, str], name: str) -> float:
        for key, of_value in (("d", lambda v: v), ("tr", lambda v: 1.0 - v)):
            if key in entry:
                try:
                    value = of_value(float(entry[key].split()[-1]))
                except (ValueError, IndexError):
                    self._report.note(f"material {name!r}: {key} {entry[key]!r} is no number")
                    return 1.0
                if CLEAR <= value < 0.999:
                    self._report.note(f"material {name!r}: {value:.0%} opaque, drawn opaque")
                return value
        return 1.0

    def _color(
        self, entry: dict[str, str], key: str, name: str, default: tuple[float, float, float]
    ) -> npt.NDArray[np.float64]:
        if key not in entry:
            return np.array(default)
        try:
            values = [float(word) for word in entry[key].split()]
            if len(values) == 1:
                values *= 3
            if len(values) >= 3 and np.isfinite(values[:3]).all():
                return np.array(values[:3])
        except ValueError:
            pass  # said below
        self._report.note(f"material {name!r}: {key} {entry[key][:40]!r} is no color, not used")
        return np.array(default)

    def _texture(self, rest: str) -> TextureFile | None:
        """What a ``map_Kd`` line shows; options before the name are reported."""
        words = rest.split()
        skip = 0
        while skip < len(words) and words[skip] in _OPTION_WORDS:
            most = _OPTION_WORDS[words[skip]]
            self._report.note(f"texture option {words[skip]}: not used")
            skip += 1
            while most and skip < len(words) and _is_value(words[skip], most):
                skip, most = skip + 1, most - 1
        name = rest if not skip else " ".join(words[skip:])
        if name not in self._images:
            self._images[name] = self._decoded(name)
        return self._images[name]

    def _decoded(self, name: str) -> TextureFile | None:
        path = self._find(name)
        if path is None:
            self._report.note(
                f"texture {name!r}: not in the model's folder, the base color is shown instead"
            )
            return None
        try:
            return decode_texture(path.read_bytes(), path.name)
        except FileFormatError as error:
            self._report.note(f"texture left out: {error}")
            return None


def _is_value(word: str, most: int) -> bool:
    """Whether a word belongs to the option before it; single ones take any word."""
    if most == 1 and word in ("on", "off"):
        return True
    try:
        float(word)
    except ValueError:
        return False
    return True
