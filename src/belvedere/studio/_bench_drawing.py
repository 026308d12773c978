"""How fast polygons are drawn, beside whatever else draws them or casts rays at them here.

A call draws one frame from each of a model's stations. Ours, OpenGL's and `photograph`'s are lit
pictures with depth; "rays" are told only which face each pixel shows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import BelvedereError, MissingDependencyError
from belvedere.ground.progress import Progress
from belvedere.ground.threads import run_parallel, thread_count
from belvedere.model import (
    LitModel,
    OpenGLRasterizer,
    Rasterizer,
    build_house,
    build_interior,
    photograph,
)
from belvedere.scene import Camera
from belvedere.studio._bench_rows import BenchRow
from belvedere.studio._bench_timing import Contestant, time_interleaved
from belvedere.studio.metrics import psnr

RAYS = 8
"""Rays for each point of light: how bright things are does not change how long they take."""
ROWS = 16
"""Picture rows whose rays a thread casts at once."""
SAME = 1e-4
"""Relative difference of disparity up to which two pictures show one surface."""
STATIONS = (
    ((1.2, 1.5, 1.6), (5.0, 2.3, 1.5), 60.0),
    ((7.0, 3.6, 1.6), (6.8, 7.0, 1.5), 60.0),
    ((5.27, 2.2, 1.6), (9.0, 2.3, 1.2), 100.0),
)
"""In the built-in interior: eye and target in metres, field of view in degrees."""
HOUSE_STATIONS = (0.1, 0.45, 0.8)
"""Along the recorded walk through a built-in house."""

Draw = Callable[[Camera], Any]


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A model, and where it is looked at from."""

    name: str
    model: LitModel
    cameras: tuple[Camera, ...]


def make_subjects(
    size: int, details: Sequence[int] = (1,), threads: int | None = None
) -> list[Subject]:
    """The built-in interior (37,000 faces), and the bungalow (528,000) for each of ``details``."""
    interior = build_interior(seed=0, rays=RAYS, threads=threads)
    cameras = [
        Camera.look_at(eye, target, fov_deg=fov, width=size, height=size)
        for eye, target, fov in STATIONS
    ]
    subjects = [Subject("interior", interior, tuple(cameras))]
    for detail in details:
        house = build_house("bungalow", detail=detail, rays=RAYS, threads=threads)
        walk = house.path
        times = walk.start + walk.duration * np.array(HOUSE_STATIONS)
        cameras = [camera.resized(size, size) for camera in walk.cameras_at_times(times)]
        name = "bungalow" if detail == 1 else f"bungalow x{detail}"
        subjects.append(Subject(name, house, tuple(cameras)))
    return subjects


def _rasterizer(model: LitModel, threads: int) -> Draw:
    return Rasterizer(model, threads).draw


def _opengl(model: LitModel, threads: int) -> Draw:
    return OpenGLRasterizer(model, threads).draw


def _photograph(model: LitModel, threads: int) -> Draw:
    def draw(camera: Camera) -> Any:
        view = photograph(model, camera, 1, threads=threads)
        return view.color, view.disparity

    return draw


def _embree(model: LitModel, threads: int) -> Draw:
    def draw(camera: Camera) -> npt.NDArray[np.int32]:
        face = np.empty(camera.size, dtype=np.int32)

        def look(first: int) -> None:
            rows = slice(first, min(first + ROWS, camera.height))
            v, u = np.mgrid[rows, 0 : camera.width]
            rays = camera.rays(u.ravel(), v.ravel()).astype(np.float32)
            origins = np.broadcast_to(camera.center.astype(np.float32), rays.shape)
            hit = model.caster.cast_piece(np.ascontiguousarray(origins), rays)
            face[rows] = hit["primID"].reshape(-1, camera.width)

        run_parallel(look, range(0, camera.height, ROWS), threads)
        return face

    return draw


def _open3d(model: LitModel, threads: int) -> Draw:
    try:
        o3d: Any = import_module("open3d")  # an extra: it may be missing where types are checked
    except ImportError as caught:
        raise MissingDependencyError("open3d") from caught
    scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
    mesh = model.mesh
    scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))

    def draw(camera: Camera) -> Any:
        rays = camera.rays(*camera.pixel_grid())
        eye = np.broadcast_to(camera.center, rays.shape)
        both = np.concatenate([eye, rays], axis=-1).astype(np.float32)
        return scene.cast_rays(o3d.core.Tensor(both))["primitive_ids"].numpy()

    return draw


RENDERERS: dict[str, tuple[str, Callable[[LitModel, int], Draw], bool]] = {
    "rasterizer": ("Rasterizer: lit picture, disparity, faces", _rasterizer, False),
    "opengl": ("OpenGLRasterizer: the same; its own threads", _opengl, False),
    "photograph": ("photograph, one sample a pixel", _photograph, False),
    "embree-rays": ("Embree: the face each pixel shows, no light", _embree, True),
    "open3d-rays": ("Open3D RaycastingScene: the same", _open3d, True),
}
"""Name -> what it draws, how it is made of a model and a number of threads, whether it is a peer.
The first is the baseline."""


def drawing_rows(
    size: int,
    repeats: int,
    threads: int | None,
    peers: bool,
    progress: Progress,
    details: Sequence[int] = (1,),
) -> tuple[list[BenchRow], str]:
    """Rows of the suite "drawing", ratios within each model, and the name of the baseline."""
    progress(0, 1, "building houses")
    rows: list[BenchRow] = []
    baseline = next(iter(RENDERERS))
    for subject in make_subjects(size, details, threads):
        contestants, missing = _contestants(subject, threads, peers)
        times = time_interleaved(contestants, repeats, progress)
        unit = times[0].median
        truth = _photograph(subject.model, thread_count(threads))
        frames = len(subject.cameras)
        for one, taken in zip(contestants, times, strict=True):
            itself = one.name.startswith("photograph")
            surface, decibels = (None, None) if itself else _judged(one.run(), subject, truth)
            rows.append(
                BenchRow(
                    name=one.name,
                    what=one.what,
                    size=size,
                    threads=one.threads,
                    ms_median=taken.median / frames,
                    ms_min=min(taken.ms) / frames,
                    ms_p90=taken.percentile(90) / frames,
                    ns_per_sample=taken.median * 1e6 / one.samples,
                    ratio=taken.median / unit,
                    compile_s=taken.first_s,
                    same_surface=surface,
                    psnr=decibels,
                    note=one.note,
                )
            )
        rows += missing
    return rows, baseline


def _contestants(
    subject: Subject, threads: int | None, peers: bool
) -> tuple[list[Contestant], list[BenchRow]]:
    most = thread_count(threads)
    numbers = [most, 1] if threads is None and most > 1 else [most]
    found: list[Contestant] = []
    missing: list[BenchRow] = []
    samples = sum(camera.width * camera.height for camera in subject.cameras)
    for renderer, (what, make, is_peer) in RENDERERS.items():
        if is_peer and not peers:
            continue
        for number in numbers if renderer == "rasterizer" else [most]:
            name = f"{renderer}{'/1t' if number != most else ''}/{subject.name}"
            note = ""
            try:
                draw = make(subject.model, number)
            except BelvedereError as refusal:
                missing.append(BenchRow(name, what, None, None, note=str(refusal)))
                continue
            drawer = getattr(draw, "__self__", None)
            if isinstance(drawer, OpenGLRasterizer):
                note = drawer.renderer

            def run(draw: Draw = draw) -> list[Any]:
                return [draw(camera) for camera in subject.cameras]

            found.append(Contestant(name, what, number, run, samples, note))
    return found, missing


def _judged(shown: list[Any], subject: Subject, truth: Draw) -> tuple[float | None, float | None]:
    """Per cent of pixels whose disparity is that of `photograph`, and decibels to its picture."""
    if not isinstance(shown[0], tuple):
        return None, None
    same, decibels = [], []
    for (color, disparity, *_), camera in zip(shown, subject.cameras, strict=True):
        true_color, true_disparity = truth(camera)
        same.append(np.abs(disparity - true_disparity) <= SAME * true_disparity)
        decibels.append(psnr(color, true_color))
    return 100.0 * float(np.mean(same)), float(np.mean(decibels))
