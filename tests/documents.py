"""The documentation as the tests see it: pages, their blocks of code, and what the blocks find."""

from __future__ import annotations

import json
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.scene.io import to_cameras_json, to_tum, write_color, write_depth

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
EXAMPLES = sorted((ROOT / "examples").glob("*/*.py"))
SHOWN_ONLY = ("text", "json")
"""Languages of blocks that show something and are not meant to be run."""
_BLOCK = re.compile(
    r"(?:<!-- not run: (?P<reason>.*?) -->\s*\n|(?P<printed><!-- printed -->)\s*\n)?"
    r"^(?P<indent> *)```(?P<language>\S*)\n(?P<code>.*?)^(?P=indent)```\s*$",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    language: str
    code: str
    reason: str | None
    """Why it is not run; None where it is."""
    printed: bool
    """Whether it shows what the page's code has printed, with ... for what may differ."""

    @property
    def runs(self) -> bool:
        """Whether the tests run it."""
        return self.reason is None and self.language in ("python", "bash")

    @property
    def place(self) -> str:
        """Where it stands, for messages."""
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path) -> list[Block]:
    """Every fenced block of a page, in order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block(
            page,
            text.count("\n", 0, match.start("language")) + 1,
            match["language"],
            textwrap.dedent(match["code"]),
            match["reason"],
            match["printed"] is not None,
        )
        for match in _BLOCK.finditer(text)
    ]


def page_id(page: Path) -> str:
    """A page's name in a test's id."""
    return page.relative_to(ROOT).with_suffix("").as_posix()


def make_captures(folder: Path, views: bv.ViewSet) -> None:
    """What the pages' code opens: folders in several layouts, a path, and one wrong folder."""
    bv.save_views(views, folder / "capture")
    to_tum(views, folder / "recording-tum")
    to_cameras_json(views, folder / "mistaken")
    lying = folder / "mistaken" / "cameras.json"
    said = json.loads(lying.read_text()) | {"depth_scale": 1.0}  # millimetres, called metres
    lying.write_text(json.dumps(said))
    bv.CameraPath.of(views.cameras[:3], [0.0, 0.5, 1.0]).save(folder / "walk.json")  # type: ignore[arg-type]

    own = folder / "my-folder"
    poses = {}
    for name, view in zip(views.names[:3], views[:3], strict=True):
        write_color(own / "images" / f"{name}.png", view.color)
        depth = np.where(view.disparity > 0, 1000 / np.maximum(view.disparity, 1e-6), 0)
        write_depth(own / "depth" / f"{name}.png", depth.clip(0, 65535).astype(np.uint16))
        poses[name] = view.camera.camera_to_world.tolist()  # type: ignore[attr-defined]
    (own / "my-poses.json").write_text(json.dumps(poses))

    pair = folder / "stereo-pair"
    for side in ("left", "right"):
        write_color(pair / f"{side}.png", views[0].color)
    write_depth(pair / "disp_left.pfm", np.full(views[0].disparity.shape, 8.0, np.float32))
