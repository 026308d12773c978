"""Walking a path through a scene: a video, or a folder of numbered pictures.

However the job ends, what stands under the output's name is complete. Until then the work lies in a
hidden folder beside it, ``.NAME.belvedere-partial``:

- pictures: ``frame_00000.png`` ..., each written whole or not at all;
- a video: pieces of `_sinks.SEGMENT_FRAMES` frames, each a complete small video that starts with a
  key frame. At the end they are joined by copying packets, nothing is encoded twice. (The
  alternatives: one long encoding, which Ctrl-C throws away whole, or keeping every frame as PNG,
  which costs more time than the encoding itself.)

and a ``render.json`` that says which job they belong to. After Ctrl-C, a kill or a full disk the
same call goes on from the complete pieces; another job under the same name is refused. Rendering
and writing overlap: one thread encodes what the other ones have rendered.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from belvedere.ground.checks import check_image_size, check_integer, check_number
from belvedere.ground.color import color_to_srgb8
from belvedere.ground.errors import InputError, OutputError
from belvedere.ground.progress import Progress, silent
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.io.atomic import (
    check_replaceable,
    require_free,
    staging_path,
    swap_folder,
    sync_folder,
    writing,
)
from belvedere.scene.path import CameraPath
from belvedere.scene.scene import Scene
from belvedere.scene.view import Color, Frame
from belvedere.studio._job import RECORD, RenderJob, describe_job
from belvedere.studio._segments import join_segments
from belvedere.studio._sinks import VIDEO_SUFFIX, PictureSink, VideoSink, writers


@dataclass(frozen=True, slots=True)
class RenderResult:
    """What walking a path gave."""

    output: Path
    """The video, or the folder of pictures."""
    frames: int
    """Frames it holds."""
    rendered: int
    """Frames rendered by this call."""
    reused: int
    """Frames found complete from an interrupted call."""
    size: tuple[int, int]
    """(width, height) pixels."""
    fps: float
    """Frames a second."""
    seconds: float
    """This call, writing included."""
    ms: float | None
    """Median milliseconds of rendering one frame, writing excluded; None if none was rendered."""
    hole_fraction: float
    """Mean share of pixels that no reference saw (the scene may have filled them)."""
    worst_hole_fraction: float
    """The largest share of one frame."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON; the output by its name alone."""
        return {
            "output": self.output.name,
            "frames": self.frames,
            "rendered": self.rendered,
            "reused": self.reused,
            "size": list(self.size),
            "fps": self.fps,
            "seconds": round(self.seconds, 3),
            "ms": None if self.ms is None else round(self.ms, 3),
            "hole_fraction": round(self.hole_fraction, 6),
            "worst_hole_fraction": round(self.worst_hole_fraction, 6),
        }


def render_path(
    scene: Scene,
    path: CameraPath | Sequence[CameraModel],
    output: str | Path,
    *,
    fps: float = 30.0,
    frames: int | None = None,
    size: tuple[int, int] | None = None,
    options: Mapping[str, Any] | None = None,
    force: bool = False,
    resume: bool = True,
    progress: Progress = silent,
) -> RenderResult:
    """Render a scene along a path into a video or a folder of pictures.

    Holes are shown as the scene shows them: build it with ``fill="background"`` for a video that
    people look at. Their share is in the result either way.

    Args:
        scene: anything that can be looked at.
        path: a path, or the cameras of the frames themselves.
        output: ``walk.mp4`` for a video, a name without suffix for a folder of
            ``frame_00000.png`` ....
        fps: frames a second.
        frames: how many; None takes the path's duration times ``fps``, or every camera given.
        size: (width, height) pixels; None keeps the cameras' own.
        options: what else tells this job from others (scene, reconstruction ...), JSON values. It
            is written to the record, and resuming with other options is refused.
        force: replace an existing output, or the rest of another interrupted job.
        resume: go on from an interrupted call's complete frames; False starts anew.
        progress: told after each frame.

    Returns:
        Counts, times and holes.

    Raises:
        InputError: an output of another kind, counts out of range.
        OutputError: the output exists, belongs to another job, or cannot be written.

    Memory: some `_sinks.IN_FLIGHT` frames and what the scene keeps; nothing grows with the path's
    length.
    """
    started = time.perf_counter()
    rate = check_number("render_path", "fps", fps, 0.1, 1000.0)
    cameras = cameras_along(path, rate, frames, size)
    target = Path(os.path.abspath(output))
    is_video = _is_video(target)
    if is_video:
        require_free(target, force)
        if target.is_dir():
            raise OutputError(f"{target} is a folder, expected the name of a video to write")
    else:
        check_replaceable(target, force, RECORD)
    description = describe_job(scene, cameras, rate, "video" if is_video else "pictures", options)
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        job = RenderJob.begin(staging_path(target), target, description, force, resume)
        sink = VideoSink(job, rate) if is_video else PictureSink(job)
        todo = [chunk for chunk in _chunks(len(cameras), sink.chunk) if not sink.has(chunk[0])]
        times = _render(scene, cameras, todo, sink, job, progress)
        _finish(sink, job, target, is_video)
    holes = [value for value in job.holes if value is not None]
    rendered = sum(len(chunk) for chunk in todo)
    return RenderResult(
        output=Path(output),
        frames=len(cameras),
        rendered=rendered,
        reused=len(cameras) - rendered,
        size=(cameras[0].width, cameras[0].height),
        fps=rate,
        seconds=time.perf_counter() - started,
        ms=1e3 * statistics.median(times) if times else None,
        hole_fraction=statistics.fmean(holes) if holes else 0.0,
        worst_hole_fraction=max(holes, default=0.0),
    )


def cameras_along(
    path: CameraPath | Sequence[CameraModel],
    fps: float,
    frames: int | None = None,
    size: tuple[int, int] | None = None,
) -> list[CameraModel]:
    """The camera of every frame of a walk: the path's ends included, evenly in time.

    Args:
        path: a path, or cameras that are taken as they are.
        fps: frames a second.
        frames: how many; None takes the path's duration times ``fps``.
        size: (width, height) to give every camera.

    Raises:
        InputError: no camera, a number of frames that does not fit the cameras given.
    """
    if frames is not None:
        check_integer("render_path", "frames", frames, 1, 10_000_000)
    if isinstance(path, CameraPath):
        count = frames if frames is not None else max(round(path.duration * fps), 1)
        cameras: list[CameraModel] = list(path.cameras(count))
    else:
        cameras = list(path)
        if not cameras or (frames is not None and frames != len(cameras)):
            raise InputError(
                f"render_path.path has {len(cameras)} cameras, expected "
                f"{frames if frames is not None else 'at least 1'}: pass a CameraPath to have "
                "cameras placed along it"
            )
    if size is not None:
        width, height = check_image_size("render_path", *size)
        cameras = [camera.resized(width, height) for camera in cameras]
    sizes = {camera.size for camera in cameras}
    if len(sizes) > 1:
        raise InputError(
            f"render_path.path has cameras of {len(sizes)} sizes, expected one: pass size=(w, h)"
        )
    return cameras


def _render(
    scene: Scene,
    cameras: Sequence[CameraModel],
    todo: Sequence[range],
    sink: PictureSink | VideoSink,
    job: RenderJob,
    progress: Progress,
) -> list[float]:
    """Render the frames of the chunks and hand them to the sink; seconds of each render."""
    total, what = len(cameras), "rendering frames"
    done = total - sum(len(chunk) for chunk in todo)
    times: list[float] = []
    progress(done, total, what)
    with _ending(sink, job), writers(sink.workers) as submit:
        for chunk in todo:
            for index in chunk:
                began = time.perf_counter()
                frame = scene.render(cameras[index])
                times.append(time.perf_counter() - began)
                job.holes[index] = round(frame.hole_fraction, 6)
                last = index == chunk[-1]
                submit(lambda i=index, f=frame, end=last: sink.write(i, _shown(f), end))
                done += 1
                progress(done, total, what)
            job.save_now_and_then()
    return times


@contextlib.contextmanager
def _ending(sink: PictureSink | VideoSink, job: RenderJob) -> Iterator[None]:
    """However the rendering ends, leave a record that the next call can go on from."""
    try:
        yield
    except BaseException:
        sink.close()
        with contextlib.suppress(OSError):  # the first error is the one to tell
            job.save()
        raise
    job.save()


def _finish(sink: PictureSink | VideoSink, job: RenderJob, target: Path, is_video: bool) -> None:
    """Give the complete work its name."""
    job.complete()
    if not is_video:
        swap_folder(job.folder, target)
        sync_folder(target.parent)
        return
    assert isinstance(sink, VideoSink)
    joined = job.folder / f"joined{VIDEO_SUFFIX}"
    segments = sink.segments()
    if len(segments) == 1:
        joined = segments[0]
    else:
        join_segments(segments, joined)
        with joined.open("rb+") as file:
            os.fsync(file.fileno())
    os.replace(joined, target)
    sync_folder(target.parent)
    job.remove()


def _chunks(count: int, length: int) -> list[range]:
    return [range(start, min(start + length, count)) for start in range(0, count, length)]


def _shown(frame: Frame) -> Color:
    """(H, W, 3) ``uint8`` for the encoder."""
    return color_to_srgb8(frame.color)[..., :3]


def _is_video(target: Path) -> bool:
    if target.suffix.lower() == VIDEO_SUFFIX:
        return True
    if target.suffix and not target.is_dir():
        raise InputError(
            f"render_path.output is {target.name!r}, expected a video (name{VIDEO_SUFFIX}) or the "
            "name of a folder for pictures, which has no suffix"
        )
    return False
