"""Run every example and make the gallery: ``python docs/make_gallery.py``.

Writes ``docs/gallery.md`` from the examples' docstrings and printed lines, and their pictures into
``docs/gallery/`` as WebP (a tenth of the size of PNG, read by every browser). The gallery is
committed; the examples themselves run in the tests.
"""

from __future__ import annotations

import ast
import contextlib
import io
import re
import runpy
import shutil
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

from PIL import Image

from belvedere import model

ROOT = Path(__file__).resolve().parents[1]
GALLERY = ROOT / "docs" / "gallery"
QUALITY = 84
LARGEST_VIDEO = 400_000
HERO = "hero.webp"
"""The picture on the first page and in the README; see `hero`."""


def examples() -> list[Path]:
    """Every example, in order."""
    return sorted((ROOT / "examples").glob("*/*.py"))


def docstring(path: Path) -> tuple[str, str]:
    """An example's title and text."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    title, _, body = text.partition("\n")
    return title.rstrip("."), body.strip()


def run_example(path: Path, output: Path) -> str:
    """What an example prints; its files lie in ``output`` afterwards."""
    output.mkdir(parents=True, exist_ok=True)
    printed, held = io.StringIO(), sys.argv
    sys.argv = [str(path), str(output)]
    try:
        with contextlib.redirect_stdout(printed):
            runpy.run_path(str(path), run_name="__main__")
    finally:
        sys.argv = held
    return printed.getvalue().replace(str(output), "OUTPUT")


def keep_picture(source: Path) -> str:
    """Copy a picture into the gallery; gives its name there."""
    name = f"{source.stem}.webp"
    with Image.open(source) as picture:
        picture.convert("RGB").save(GALLERY / name, quality=QUALITY, method=6)
    return name


def page(path: Path, output: Path) -> str:
    """An example's part of the gallery page."""
    title, body = docstring(path)
    printed = run_example(path, output)
    relative = path.relative_to(ROOT).as_posix()
    text = re.sub(r"\s*\n(?!\n)\s*", " ", body.replace("\n\n", "\0")).replace("\0", "\n\n")
    parts = [f"## {title}", ""]
    for picture in sorted(output.glob("*.png")):
        if f"`{picture.name}`" in body:
            parts += [f"![{title}](gallery/{keep_picture(picture)})", ""]
    for video in sorted(output.glob("*.mp4")):
        if video.stat().st_size <= LARGEST_VIDEO:
            shutil.copy(video, GALLERY / video.name)
            parts += [
                f'<video src="../gallery/{video.name}" controls loop muted playsinline></video>',
                "",
            ]
    parts += [text, "", "```text", printed.rstrip(), "```", ""]
    return "\n".join([*parts, f"`python {relative} out`", ""])


def hero() -> None:
    """The first picture: two references at the left, what lies between them warped at the right."""
    import numpy as np

    import belvedere as bv

    house = model.build_interior(seed=0, rays=256)
    cameras = house.reference_cameras(36, width=1280, height=1024)
    views = [model.photograph(house, cameras[k]) for k in (0, 2)]
    between = cameras[1]
    eye = between.center + 0.06 * between.camera_to_world[:3, 0] + [0.0, 0.0, 0.1]
    pose = bv.Camera.look_at(eye, between.center + 3 * between.forward).camera_to_world
    frame = bv.warp(views, bv.Camera.from_fov(46, pose, width=1380, height=800), fill="background")

    def small(color: np.ndarray, width: int, height: int) -> np.ndarray:
        size = (width, height)
        return np.asarray(Image.fromarray(color).resize(size, Image.Resampling.LANCZOS))

    left = [small(view.color, 244, 195) for view in views]
    sheet = np.full((400, 944, 3), 255, np.uint8)
    sheet[:195, :244], sheet[205:, :244] = left
    sheet[:, 254:] = small(frame.color, 690, 400)
    Image.fromarray(sheet).save(GALLERY / HERO, quality=QUALITY, method=6)


def main() -> None:
    """Make the whole gallery."""
    model.build_interior = lru_cache(model.build_interior)  # one house for all examples
    GALLERY.mkdir(exist_ok=True)
    parts = [
        "# Gallery",
        "",
        "Every picture here was made by belvedere from its built-in house, by the example named",
        "below it. Examples take seconds, and the tests run them all. Rose: no reference saw it.",
        "",
    ]
    with tempfile.TemporaryDirectory() as folder:
        parts += [page(path, Path(folder) / path.parent.name / path.stem) for path in examples()]
    (ROOT / "docs" / "gallery.md").write_text("\n".join(parts).rstrip() + "\n", encoding="utf-8")
    hero()


if __name__ == "__main__":
    main()
