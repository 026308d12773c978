"""The pixels of a set of views, written into the folder that a writer is building.

Every file is written atomically and noted with a digest of what it holds, so that a writer that
was interrupted goes on from what is complete, and only if it holds what it should.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_choice, check_number
from belvedere.ground.errors import SceneError
from belvedere.ground.progress import Progress, silent
from belvedere.scene.camera import Camera
from belvedere.scene.io.atomic import write_bytes
from belvedere.scene.io.depth import (
    INFINITY_CODE,
    encode_colmap_depth,
    quantise_depth,
    write_depth,
)
from belvedere.scene.io.images import write_color
from belvedere.scene.io.paths import file_name
from belvedere.scene.view import Color, ReferenceView
from belvedere.scene.views import ViewSet

ColorFormat = Literal["png", "jpg", "webp", "exr"]
DepthFormat = Literal["png16", "exr", "npy", "pfm", "colmap"]
COLOR_FORMATS = ("png", "jpg", "webp", "exr")
DEPTH_FORMATS = ("png16", "exr", "npy", "pfm")
FLOAT_ADVICE = "use a float depth format (exr, npy, pfm)"
"""What helps where no step fits every depth."""
DEFAULT_STEP = 0.001
"""Metres per number of 16-bit depth: what nerfstudio takes by default."""
NOTES = "belvedere-resume.jsonl"
"""What is complete in a folder that is being built; removed when it is done."""


@dataclass(frozen=True, slots=True)
class SavedViews:
    """What a writer wrote."""

    path: Path
    format: str
    views: int
    resumed: int
    """Of them, taken over from an interrupted call."""
    depth_step: float | None
    """Metres per number of 16-bit depth (it is exact to half of that); None for float depth."""
    notes: tuple[str, ...]
    """What the format could not hold, one sentence each; empty when nothing was lost."""


@dataclass(frozen=True, slots=True)
class PixelPlan:
    """Where and how pixels are written."""

    color_folder: str
    color_suffix: str
    depth_folder: str
    depth_format: DepthFormat
    depth_step: float | None
    infinity: bool = True
    """Whether the layout can say "infinitely far"; where not, such pixels become no sample."""
    depth_advice: str | None = None
    """What helps where depth does not fit 16 bits; None: another step or a float format."""

    @property
    def depth_suffix(self) -> str:
        """Of a depth map's file."""
        return {"png16": ".png", "colmap": ".geometric.bin"}.get(
            self.depth_format, f".{self.depth_format}"
        )


@dataclass(frozen=True, slots=True)
class WrittenFile:
    """A view's files, relative to the scene's folder."""

    name: str
    color: str
    depth: str | None


def planar_cameras(views: ViewSet, layout: str, *, skew: bool = False) -> list[Camera]:
    """Every view's camera, which must be planar, and without skew unless the layout has it.

    Raises:
        SceneError: another kind of camera.
    """
    cameras: list[Camera] = []
    for entry in views.entries:
        camera = entry.camera
        if not isinstance(camera, Camera):
            raise SceneError(
                f"view {entry.name!r} has a {type(camera).__name__}, but {layout} holds planar "
                "cameras only: render planar views of it first"
            )
        k = camera.intrinsics
        if not skew and abs(k[0, 1]) > 1e-9 * k[0, 0]:
            raise SceneError(
                f"view {entry.name!r} has skewed pixels (K[0, 1] = {k[0, 1]:.6g}), which {layout} "
                "cannot hold: write cameras.json, or render an unskewed view first"
            )
        cameras.append(camera)
    return cameras


def color_suffix(views: ViewSet, color_format: str | None) -> str:
    """The suffix to write: as asked, or PNG for bytes and OpenEXR for float colour."""
    if color_format is not None:
        check_choice("save_views", "color_format", color_format, COLOR_FORMATS)
        return f".{color_format}"
    return ".png" if views.color(0).dtype == np.uint8 else ".exr"


def depth_step(views: ViewSet, asked: float | None) -> float:
    """Metres per number of 16-bit depth: ``asked``, or chosen so that every depth fits.

    1 mm where it can be, as other tools take it unasked; a tenth of it, and so on, for a scene
    less than 0.65 m deep; the farthest depth over 65534 for one deeper than 65.5 m. Nothing is
    ever clipped.
    """
    if asked is not None:
        return check_number("save_views", "depth_step", asked, 0.0, open_low=True)
    far = 0.0
    for index, entry in enumerate(views.entries):
        if entry.has_depth:
            disparity = views[index].disparity
            known = disparity[disparity > 0]
            if known.size:
                far = max(far, 1.0 / float(known.min()))
    step = DEFAULT_STEP
    if far > (INFINITY_CODE - 1) * step:
        return far / (INFINITY_CODE - 1.5)
    while 0 < far < 655 * step:
        step /= 10
    return step


def write_pixels(
    views: ViewSet, folder: Path, plan: PixelPlan, progress: Progress = silent
) -> tuple[list[WrittenFile], int, tuple[str, ...]]:
    """Write every view's colour and depth into ``folder``.

    Returns:
        The files, how many views were complete already, and what was lost, in sentences.

    Raises:
        OutputError: see `atomic_write`.
        InputError: a depth that the format cannot hold.
        SceneError: a view's own files are bad.
    """
    complete = _read_notes(folder)
    files: list[WrittenFile] = []
    taken: set[str] = set()
    resumed = lost = clipped = 0
    for index, entry in enumerate(views.entries):
        stem = file_name(entry.name, taken, index)
        color = f"{plan.color_folder}/{stem}{plan.color_suffix}"
        depth = None
        if entry.has_depth:
            base = f"{stem}{plan.color_suffix}" if plan.depth_format == "colmap" else stem
            depth = f"{plan.depth_folder}/{base}{plan.depth_suffix}"
        view = views[index] if entry.has_depth else None
        pixels = view.color if view is not None else views.color(index)
        files.append(WrittenFile(entry.name, color, depth))
        digest = _digest(plan, pixels, view)
        done = complete.get(color) == digest and (folder / color).is_file()
        if done and (depth is None or (folder / depth).is_file()):
            resumed += 1
        else:
            write_color(folder / color, pixels)
            if view is not None and depth is not None:
                _write_view_depth(folder / depth, view, plan)
            _note(folder, color, digest)
        if view is not None and not plan.infinity:
            lost += int((view.disparity == 0).sum())
        if pixels.dtype != np.uint8 and plan.color_suffix != ".exr":
            clipped += 1
        progress(index + 1, len(views), "writing views")
    _finish(folder, files)
    return files, resumed, _notes(lost, clipped, plan)


def depth_of(view: ReferenceView) -> npt.NDArray[np.float64]:
    """(H, W) metres along the axis: 0 no sample, infinity infinitely far."""
    with np.errstate(divide="ignore"):
        depth = 1.0 / view.disparity.astype(np.float64)
    return np.where(np.isnan(depth), 0.0, depth)


def _write_view_depth(path: Path, view: ReferenceView, plan: PixelPlan) -> None:
    depth = depth_of(view)
    if not plan.infinity:
        depth[np.isinf(depth)] = 0.0
    if plan.depth_format == "colmap":
        write_bytes(path, encode_colmap_depth(depth.astype(np.float32)))
    elif plan.depth_format == "png16":
        assert plan.depth_step is not None
        write_depth(path, quantise_depth(depth, plan.depth_step, plan.depth_advice))
    else:
        write_depth(path, depth.astype(np.float32))


def _digest(plan: PixelPlan, color: Color, view: ReferenceView | None) -> str:
    digest = hashlib.blake2b(repr((plan, color.shape, str(color.dtype))).encode(), digest_size=16)
    digest.update(np.ascontiguousarray(color).data)
    if view is not None:
        digest.update(np.ascontiguousarray(view.disparity).data)
    return digest.hexdigest()


def _read_notes(folder: Path) -> dict[str, str]:
    """Colour file -> digest, of what an interrupted call completed."""
    complete: dict[str, str] = {}
    with contextlib.suppress(OSError, UnicodeDecodeError):
        for line in (folder / NOTES).read_text(encoding="utf-8").splitlines():
            with contextlib.suppress(ValueError, TypeError, KeyError):  # a line cut by a crash
                note: dict[str, Any] = json.loads(line)
                complete[note["color"]] = note["digest"]
    return complete


def _note(folder: Path, color: str, digest: str) -> None:
    with (folder / NOTES).open("a", encoding="utf-8") as stream:
        stream.write(json.dumps({"color": color, "digest": digest}) + "\n")
        stream.flush()
        os.fsync(stream.fileno())


def _finish(folder: Path, files: list[WrittenFile]) -> None:
    """Remove the notes, and what an interrupted call with other options left."""
    wanted = {folder / name for file in files for name in (file.color, file.depth) if name}
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_dir():
            with contextlib.suppress(OSError):
                path.rmdir()  # only if it is empty
        elif path not in wanted:
            path.unlink()


def _notes(lost: int, clipped: int, plan: PixelPlan) -> tuple[str, ...]:
    notes: list[str] = []
    if lost:
        notes.append(f"{lost} infinitely far pixels became 'no sample': the format has no word "
                     "for them")  # fmt: skip
    if clipped:
        notes.append(f"linear colour of {clipped} views was clipped to [0, 1] and encoded as "
                     f"8-bit sRGB for {plan.color_suffix}")  # fmt: skip
    return tuple(notes)


def same_intrinsics(cameras: list[Camera]) -> bool:
    """Whether all cameras have one K (to 1e-10 of a focal length) and one size."""
    first = cameras[0].intrinsics
    return all(
        camera.size == cameras[0].size
        and math.isclose(0, np.abs(camera.intrinsics - first).max(), abs_tol=1e-10 * first[0, 0])
        for camera in cameras
    )
