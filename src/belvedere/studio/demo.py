"""The whole road in one call: a house is built, photographed, walked through and checked.

Everything is generated: no network, no GPU, no display. The house is ray-cast, so the truth of
every frame can be had, and the report compares warped frames of the walk with it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from belvedere.ground.checks import check_integer, check_number
from belvedere.ground.progress import Progress, silent
from belvedere.ground.wording import counted
from belvedere.scene import Camera, ReferenceView, ViewSet
from belvedere.scene.io.atomic import check_replaceable, staged_folder, write_bytes
from belvedere.scene.io.json_files import write_json
from belvedere.scene.path import CameraPath, Keyframe
from belvedere.studio.machine import describe_machine
from belvedere.studio.report import evaluate_to_report
from belvedere.studio.scores import Evaluation
from belvedere.studio.walk import RenderResult, cameras_along, render_path

if TYPE_CHECKING:
    from belvedere.model import Interior

RECORD = "demo.json"
"""Marks a folder that the demo wrote, and may therefore replace."""
WALK_FOV_DEG = 60.0
"""The walker's field of view, upright; the references' is wider."""
SAMPLES = 2
"""Rays per pixel side of references and truths."""


@dataclass(frozen=True, slots=True)
class DemoResult:
    """What the demo made, and how long each stage took."""

    output: Path
    """The folder."""
    video: RenderResult
    evaluation: Evaluation
    seconds: dict[str, float]
    """By stage, in order; saving the scene runs beside the walk and counts only its rest."""

    @property
    def total_seconds(self) -> float:
        """All stages; starting Python is not in it."""
        return sum(self.seconds.values())

    @property
    def summary(self) -> str:
        """One line: the walk's frames, what one costs, its holes, and the time of it all."""
        video = self.video
        cost = "" if video.ms is None else f" at {video.ms:.0f} ms each"
        return (
            f"{counted(video.frames, 'frame')} of {video.size[0]} x {video.size[1]} warped{cost}, "
            f"{100 * video.hole_fraction:.2f}% holes (filled), {self.total_seconds:.1f} s in all"
        )

    def as_dict(self) -> dict[str, Any]:
        """What ``demo.json`` holds of the result, for JSON."""
        return {
            "output": self.output.name,
            "seconds": self.seconds,
            "total_seconds": round(self.total_seconds, 2),
            "video": self.video.as_dict(),
            "evaluation": self.evaluation.as_dict(),
        }


def demo(
    output: str | Path = "belvedere-demo",
    *,
    seed: int = 0,
    seconds: float = 10.0,
    fps: float = 24.0,
    size: tuple[int, int] = (640, 512),
    references: int = 20,
    checked: int = 4,
    reconstruction: str = "inverse",
    compared: Sequence[str] = ("point", "splat", "mesh", "offset", "inverse"),
    threads: int | None = None,
    force: bool = False,
    progress: Progress = silent,
) -> DemoResult:
    """Build the built-in house, walk through it by warping, and write all of it down.

    ``output`` gets ``walk.mp4``, ``poster.png``, ``report/`` (frames of the walk against ray-cast
    truth), ``scene/`` (the references, as any tool opens them), ``path.json`` (the walk),
    ``README.txt`` (what to try next) and ``demo.json``. It is there complete, or not at all.

    Args:
        output: folder to make.
        seed: of the house's textures, books and pictures.
        seconds: length of the walk.
        fps: frames a second.
        size: (width, height) of references and video.
        references: pictures taken of the house, at least 2.
        checked: frames of the walk that are compared with the truth.
        reconstruction: what the video is warped with.
        compared: what the report compares.
        threads: how many to use.
        force: replace an earlier demo.
        progress: told stage by stage.

    Raises:
        OutputError: the folder exists without ``force``, or cannot be written.
        InputError: a count or size out of range.
        MissingDependencyError: the extra ``model`` (ray casting) is not installed.

    Memory: some 400 MB for the house, 2.3 MB for each reference of the default size.
    """
    check_number("demo", "seconds", seconds, 0.1, 3600.0)
    check_integer("demo", "references", references, 2, 10_000)
    check_integer("demo", "checked", checked, 1, 1000)
    target = Path(output).absolute()
    check_replaceable(target, force, RECORD)
    from belvedere.model import build_interior
    from belvedere.warp import DepthViews

    laps = _Laps()
    progress(0, 1, "building the house")
    house = build_interior(seed, threads=threads)
    progress(1, 1, "building the house")
    laps.end("build")
    cameras = house.reference_cameras(references, *size)
    names = [f"view_{index:02d}" for index in range(references)]
    held = _photograph(house, cameras, threads, progress, "photographing references")
    views = ViewSet.of(held, names)
    laps.end("photograph")
    path = walk_path(house, seconds, size)
    scene = DepthViews(
        views, references=2, threads=threads, reconstruction=reconstruction, fill="background"
    )
    with staged_folder(target, force=force, owned_by=RECORD) as folder:
        with ThreadPoolExecutor(1, "belvedere-save") as background:
            saving = background.submit(_save_scene, views, folder / "scene", path)
            video = render_path(scene, path, folder / "walk.mp4", fps=fps, progress=progress)
            laps.end("walk")
            saving.result()
        laps.end("save")
        evaluation = _check(
            house, views, cameras_along(path, fps), checked, folder / "report", compared, threads,
            progress, seed,
        )  # fmt: skip
        laps.end("check")
        _finish(folder, target.name, scene, path, video, evaluation, laps.seconds, seed)
    video = replace(video, output=Path(output) / video.output.name)
    return DemoResult(Path(output), video, evaluation, laps.seconds)


def walk_path(house: Interior, seconds: float, size: tuple[int, int]) -> CameraPath:
    """The built-in walk as a path of ``seconds``, pictures of ``size`` (width, height)."""
    poses = house.walk_keyframes()
    times = np.linspace(0.0, seconds, len(poses))
    return CameraPath(
        tuple(
            Keyframe(
                float(when),
                Camera.look_at(eye, look, fov_deg=WALK_FOV_DEG, width=size[0], height=size[1]),
            )
            for when, (eye, look) in zip(times, poses, strict=True)
        )
    )


class _Laps:
    """Seconds of each stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def end(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage] = round(now - self._last, 3)
        self._last = now


def _photograph(
    house: Interior,
    cameras: Sequence[Camera],
    threads: int | None,
    progress: Progress,
    what: str,
) -> list[ReferenceView]:
    from belvedere.model import photograph

    held = []
    progress(0, len(cameras), what)
    for camera in cameras:
        held.append(photograph(house, camera, SAMPLES, threads=threads))
        progress(len(held), len(cameras), what)
    return held


def _save_scene(views: ViewSet, folder: Path, path: CameraPath) -> None:
    from belvedere.scene.io.save import save_views

    save_views(views, folder)
    path.save(folder.parent / "path.json")


def _check(
    house: Interior,
    views: ViewSet,
    cameras: Sequence[Any],
    checked: int,
    output: Path,
    compared: Sequence[str],
    threads: int | None,
    progress: Progress,
    seed: int,
) -> Evaluation:
    """Compare frames of the walk, evenly taken from within it, with ray-cast truth."""
    places = np.linspace(0, len(cameras), checked + 2)[1:-1].astype(int)
    places = np.unique(np.clip(places, 0, len(cameras) - 1))
    truths = _photograph(
        house, [cameras[i] for i in places], threads, progress, "ray casting the truth"
    )
    both = ViewSet.of([*views, *truths], [*views.names, *(f"walk_{index:04d}" for index in places)])
    both.facts["pictures"] = f"the built-in house, seed {seed}, ray-cast with Embree"
    both.facts["truth"] = "frames of the walk, ray-cast; exact depth"
    return evaluate_to_report(
        both,
        output,
        title="A walk through the built-in house",
        command="belvedere demo" + (f" --seed {seed}" if seed else ""),
        hold_out=[len(views) + place for place in range(len(truths))],
        reconstructions=compared,
        repeats=1,
        threads=threads,
        progress=progress,
    )


def _finish(
    folder: Path,
    name: str,
    scene: Any,
    path: CameraPath,
    video: RenderResult,
    evaluation: Evaluation,
    seconds: dict[str, float],
    seed: int,
) -> None:
    """The poster, what to try next, and the record."""
    from belvedere.scene.io.frames import save_frame

    camera = path.camera(path.start + POSTER_AT * path.duration)
    save_frame(scene.render(camera, reconstruction="inverse"), folder / "poster.png")
    write_bytes(folder / "README.txt", README.format(folder=name).encode())
    record = {
        "schema": "belvedere.demo",
        "version": 1,
        "seed": seed,
        "seconds": seconds,
        "video": video.as_dict(),
        "evaluation": evaluation.as_dict(),
        "machine": describe_machine().as_dict(),
    }
    write_json(folder / RECORD, record)


POSTER_AT = 0.03
"""Where on the walk the poster is taken, 0 to 1."""

README = """\
belvedere demo
==============

walk.mp4      a walk through three rooms; every frame is warped from 2 pictures of scene/
poster.png    the beginning of the walk, warped with the reconstruction `inverse`
report/       open report.html: frames of the walk beside the ray-cast truth, with the numbers
scene/        the pictures: colour, depth, poses (transforms.json; other tools open it too)
path.json     the walk: keyframes, which you may edit
demo.json     how long each stage took, and on which machine

What to try next (from the folder that holds this one):

    belvedere info {folder}/scene
    belvedere render {folder}/scene --path {folder}/path.json -r mesh -o again.mp4
    belvedere render {folder}/scene --path wobble --seconds 4 -o wobble.mp4
    belvedere evaluate {folder}/scene -r all -o scene-report

and with pictures of your own, any folder with poses and depth (nerfstudio, COLMAP, TUM RGB-D,
Open3D, a rectified stereo pair):

    belvedere info MY_CAPTURE
    belvedere evaluate MY_CAPTURE -o my-report
"""
