"""Walking through a prepared building: frame times, holes, and how true the pictures are.

With a comparison every camera is shown twice, by the mode asked for and by ``culling`` (all
polygons of the cells in sight), one after the other, so that both meet the same machine; a frame
of ``culling`` is also the truth that pictures are held against.

Popping is a change between frames that no true motion explains: how much the *error* of a frame
differs from that of the frame before, as root mean square over blocks of `BLOCK` pixels, in
eighth bits of the encoded values. A picture that is wrong in the same way twice does not pop.

Source: spec portal-walkthrough 5 and 6.4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import InputError
from belvedere.ground.progress import Progress, silent
from belvedere.scene import Camera, CameraPath, Frame
from belvedere.studio.metrics import psnr, ssim
from belvedere.walkthrough import FrameStatistics, Mode, Walker, WalkOptions
from belvedere.walkthrough.walkthrough import Walkthrough

F4 = npt.NDArray[np.float32]

BLOCK = 4
"""Pixels a side over which errors are averaged before they are compared: an edge that moves by a
fraction of a pixel is no popping."""
SSIM_EVERY = 4
"""SSIM is measured on each so many-th frame: it costs more than the frame."""
WARM_UP = 3
"""Frames made before the first that is timed: kernels are compiled and buffers made."""

__all__ = ["Compared", "Popping", "WalkResult", "cameras_of", "frames_along", "walk"]


@dataclass(frozen=True, slots=True)
class Compared:
    """A walk held against ``culling`` on the same path."""

    times: tuple[float, ...]
    """Milliseconds of each frame of ``culling``."""
    psnr: float
    """Mean over the frames that differ from `culling`'s at all, dB, on covered pixels."""
    ssim: float
    """Mean over every `SSIM_EVERY`-th frame, on covered pixels."""
    popping: float
    """The largest change of error between two frames."""
    worst: int
    """The frame with most holes, or the least PSNR where none has any."""


@dataclass(frozen=True, slots=True)
class WalkResult:
    """What walking a path took."""

    mode: Mode
    frames: tuple[FrameStatistics, ...]
    """One a frame."""
    size: tuple[int, int]
    """(width, height) pixels."""
    compared: Compared | None = None
    video: Path | None = None

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """(N,) milliseconds."""
        return np.array([frame.ms for frame in self.frames])

    @property
    def median(self) -> float:
        """Milliseconds."""
        return float(np.median(self.times))

    @property
    def p99(self) -> float:
        """Milliseconds that one frame in a hundred exceeds."""
        return float(np.percentile(self.times, 99))

    @property
    def variation(self) -> float:
        """Coefficient of variation: standard deviation over mean."""
        return variation(self.times)

    @property
    def speedup_overall(self) -> float | None:
        """Time of the whole path in ``culling`` over ours."""
        if self.compared is None:
            return None
        return float(np.sum(self.compared.times) / self.times.sum())

    @property
    def speedup_best(self) -> float | None:
        """The largest ratio of one frame's times."""
        if self.compared is None:
            return None
        return float(np.max(np.array(self.compared.times) / self.times))

    def lines(self) -> list[str]:
        """For people: times, what was drawn, holes, and the comparison."""
        width, height = self.size
        mean = {name: float(np.mean([getattr(f, name) for f in self.frames]))
                for name in ("cells", "portals", "references", "holes")}  # fmt: skip
        lines = [
            f"{self.mode}: {len(self.frames)} frames of {width} x {height}, median "
            f"{self.median:.1f} ms ({1e3 / self.median:.0f} frames/s), 99 % below "
            f"{self.p99:.1f} ms, variation {self.variation:.2f}",
            f"  a frame: {mean['cells']:.1f} cells drawn, {mean['portals']:.1f} portals with "
            f"pictures, {mean['references']:.1f} references warped, {100 * mean['holes']:.2f} % "
            "holes",
        ]
        other = self.compared
        if other is not None:
            lines.append(
                f"  against culling ({np.median(other.times):.1f} ms): {self.speedup_overall:.2f}x "
                f"overall, {self.speedup_best:.1f}x at best; PSNR {other.psnr:.1f} dB, SSIM "
                f"{other.ssim:.3f}, popping {other.popping:.1f}"
            )
        return lines

    def as_dict(self) -> dict[str, Any]:
        """For JSON; what was not measured is null."""
        other = self.compared
        return {
            "mode": self.mode,
            "frames": len(self.frames),
            "size": list(self.size),
            "ms": {
                "median": round(self.median, 3),
                "p99": round(self.p99, 3),
                "cv": round(self.variation, 4),
            },
            "stages_ms": {
                name: round(float(np.mean([getattr(f, f"{name}_ms") for f in self.frames])), 3)
                for name in ("look", "draw", "warp", "compose", "fill")
            },
            "holes_mean_percent": round(100 * float(np.mean([f.holes for f in self.frames])), 4),
            "holes_worst_percent": round(100 * max(f.holes for f in self.frames), 4),
            "psnr": None if other is None else _number(other.psnr),
            "ssim": None if other is None else _number(other.ssim),
            "popping": None if other is None else _number(other.popping),
            "speedup_overall": _number(self.speedup_overall),
            "speedup_best": _number(self.speedup_best),
            "culling_ms": None if other is None else {
                "median": round(float(np.median(other.times)), 3),
                "p99": round(float(np.percentile(other.times, 99)), 3),
                "cv": round(variation(np.array(other.times)), 4),
            },
            "video": None if self.video is None else self.video.name,
        }  # fmt: skip


def walk(
    scene: Walkthrough,
    cameras: Sequence[Camera],
    options: WalkOptions | None = None,
    *,
    compare: bool = False,
    video: str | Path | None = None,
    fps: float = 30.0,
    force: bool = False,
    observe: Callable[[int, Frame, Frame | None], None] | None = None,
    progress: Progress = silent,
) -> WalkResult:
    """Walk through a building and say what each frame took.

    Args:
        scene: the prepared building.
        cameras: one a frame, all of one size.
        options: mode and the rest.
        compare: show every camera by ``culling`` too, for ratios of times and for quality.
        video: an ``.mp4`` to write; encoding is not in the times.
        fps: of the video.
        force: replace an existing video.
        observe: called as ``observe(index, frame, truth)`` after each frame; truth is None without
            ``compare``.
        progress: told after each frame.

    Raises:
        InputError: no cameras, or cameras of several sizes.
        OutputError: the video exists without ``force``, or cannot be written.

    Memory: the scene's, and some frames; nothing grows with the path but its numbers.
    """
    if not cameras:
        raise InputError("walk.cameras is empty, expected one for each frame")
    sizes = {camera.size for camera in cameras}
    if len(sizes) > 1:
        raise InputError(f"walk.cameras have {len(sizes)} sizes, expected one: {sorted(sizes)}")
    chosen = options or scene.options
    ours = scene.walker(chosen)
    truth = scene.walker(WalkOptions(mode="culling", reach=chosen.reach)) if compare else None
    _warm([w for w in (ours, truth) if w is not None], cameras)
    meter = _Meter() if compare else None
    stats: list[FrameStatistics] = []
    height, width = cameras[0].size
    progress(0, len(cameras), f"walking ({chosen.mode})")
    with _recording(video, width, height, fps, force) as record:
        for index, camera in enumerate(cameras):
            frame = ours.frame(camera)
            stats.append(ours.statistics)
            exact = None
            if truth is not None and meter is not None:
                exact = truth.frame(camera)
                meter.add(index, frame, exact, ~ours.holes, truth.statistics.ms)
            record(frame)
            if observe is not None:
                observe(index, frame, exact)
            progress(index + 1, len(cameras), f"walking ({chosen.mode})")
    compared = None if meter is None else meter.result([s.holes for s in stats])
    return WalkResult(
        chosen.mode, tuple(stats), (width, height), compared, None if video is None else Path(video)
    )


def cameras_of(
    scene: Walkthrough,
    path: str | Path,
    frames: int,
    size: tuple[int, int] | None = None,
    seed: int = 0,
) -> list[Camera]:
    """The cameras of a walk from one word: ``recorded``, ``random``, or the name of a path file.

    Raises:
        InputError: neither a word nor a file; ``recorded`` where the scene holds no walk.
        PathError: a file that is no path.
    """
    if str(path) == "recorded":
        if scene.path is None:
            raise InputError("this scene holds no recorded walk: try --path random")
        way = scene.path
    elif str(path) == "random":
        from belvedere.walkthrough.tour import random_walk

        way = random_walk(scene.space, scene.home.center, seed)
    elif Path(path).is_file():
        way = CameraPath.load(path)
    else:
        raise InputError(
            f"path is {str(path)!r}, expected recorded, random or the name of a path file"
        )
    return frames_along(way, frames, size)


def frames_along(path: CameraPath, count: int, size: tuple[int, int] | None) -> list[Camera]:
    """``count`` cameras at equal times along a path, both ends included, of ``size`` (w, h)."""
    count = check_integer("walk", "frames", count, 1, 1_000_000)
    way = path if size is None else path.resized(*size)
    last = way.duration if not way.closed else way.duration * (1.0 - 1.0 / count)
    times = way.start + np.linspace(0.0, last, count)
    return [way.camera(float(t)) for t in times]


def variation(times: npt.NDArray[np.float64]) -> float:
    """Standard deviation over mean."""
    return float(times.std() / times.mean()) if len(times) and times.mean() > 0 else 0.0


class Popping:
    """Changes between frames that no true motion explains."""

    def __init__(self) -> None:
        self.largest = 0.0
        """So far."""
        self._before: F4 | None = None

    def add(self, frame: Frame, exact: Frame) -> None:
        """The next frame, and what it should show."""
        error = _blocks(frame.color.astype(np.float32) - exact.color.astype(np.float32))
        if self._before is not None:
            change = error - self._before
            self.largest = max(self.largest, float(np.sqrt(np.mean(change * change))))
        self._before = error


class _Meter:
    """Gathers quality frame by frame."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._psnr: list[float] = []
        self._ssim: list[float] = []
        self._popping = Popping()

    def add(
        self, index: int, frame: Frame, exact: Frame, known: npt.NDArray[np.bool_], ms: float
    ) -> None:
        self._times.append(ms)
        self._psnr.append(psnr(frame.color, exact.color, known))
        if index % SSIM_EVERY == 0:
            self._ssim.append(ssim(frame.color, exact.color, known))
        self._popping.add(frame, exact)

    def result(self, holes: list[float]) -> Compared:
        shown = [value for value in self._psnr if math.isfinite(value)]
        worst = int(np.argmax(holes)) if max(holes) > 0.0 else int(np.argmin(self._psnr))
        return Compared(
            tuple(self._times), float(np.mean(shown)) if shown else math.inf,
            float(np.mean(self._ssim)), self._popping.largest, worst,
        )  # fmt: skip


def _blocks(error: F4) -> F4:
    """(H, W, 3) averaged over blocks; what does not fill a block at the edges is left out."""
    height, width = (n // BLOCK * BLOCK for n in error.shape[:2])
    parts = error[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3)
    return parts.mean(axis=(1, 3))


def _warm(walkers: Sequence[Walker], cameras: Sequence[Camera]) -> None:
    """Make some frames along the path, so that no timed one compiles or reads from disk."""
    for walker in walkers:
        for camera in cameras[:: max(1, len(cameras) // WARM_UP)]:
            walker.frame(camera)
        walker.warm()
        walker.cut()


class _recording:  # noqa: N801 - reads as a verb where it is used
    """A video, or nothing."""

    def __init__(
        self, path: str | Path | None, width: int, height: int, fps: float, force: bool
    ) -> None:
        from belvedere.scene.io.video import VideoWriter

        self._writer = None
        if path is not None:
            self._writer = VideoWriter(path, width, height, fps=fps, force=force)

    def __enter__(self) -> Callable[[Frame], None]:
        if self._writer is None:
            return lambda frame: None
        writer = self._writer.__enter__()
        return lambda frame: writer.write(frame.color)

    def __exit__(self, *what: Any) -> None:
        if self._writer is not None:
            self._writer.__exit__(*what)


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 4)
