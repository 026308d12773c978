"""Where the frames of a walk go: numbered pictures or pieces of a video, written aside."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from belvedere.scene.view import Color
from belvedere.studio._job import RenderJob

VIDEO_SUFFIX = ".mp4"
"""Names that ask for a video; a name without suffix asks for a folder of pictures."""
SEGMENT_FRAMES = 48
"""Frames of a video's pieces, the most work an interruption costs: 1.6 s of video at 30 fps."""
IN_FLIGHT = 4
"""Rendered frames that may wait to be written; bounds the memory."""


class PictureSink:
    """Frames as numbered PNG files in the job's folder."""

    chunk = 1
    workers = 2

    def __init__(self, job: RenderJob) -> None:
        self.folder = job.folder

    def has(self, index: int) -> bool:
        return self._name(index).is_file()

    def write(self, index: int, color: Color, last: bool) -> None:
        from belvedere.scene.io.images import write_color

        del last
        write_color(self._name(index), color)

    def close(self) -> None:
        """Nothing is open between frames."""

    def _name(self, index: int) -> Path:
        return self.folder / f"frame_{index:05d}.png"


class VideoSink:
    """Frames as short videos in the job's folder, one open at a time."""

    chunk = SEGMENT_FRAMES
    workers = 1  # frames must reach the encoder in order

    def __init__(self, job: RenderJob, fps: float) -> None:
        self.folder, self.fps = job.folder, fps
        self._open = contextlib.ExitStack()
        self._writer: Any = None

    def has(self, index: int) -> bool:
        return self._name(index).is_file()

    def write(self, index: int, color: Color, last: bool) -> None:
        from belvedere.scene.io.video import VideoWriter

        if self._writer is None:
            height, width = color.shape[:2]
            piece = VideoWriter(self._name(index), width, height, self.fps, force=True)
            self._writer = self._open.enter_context(piece)
        self._writer.write(color)
        if last:
            self._open.close()  # only now does the piece get its name
            self._writer = None

    def close(self) -> None:
        """Throw an unfinished piece away."""
        self._open.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)

    def segments(self) -> list[Path]:
        return sorted(self.folder.glob(f"segment_*{VIDEO_SUFFIX}"))

    def _name(self, index: int) -> Path:
        return self.folder / f"segment_{index:07d}{VIDEO_SUFFIX}"


@contextlib.contextmanager
def writers(workers: int) -> Iterator[Callable[[Callable[[], None]], None]]:
    """Give ``submit(task)``: runs tasks behind our back, at most `IN_FLIGHT` waiting.

    An interruption waits for what has been handed over: rendered frames are not thrown away. After
    a task that failed none is begun: a video must not go on without one of its frames.
    """
    pending: deque[Future[None]] = deque()
    failed = threading.Event()
    pool = ThreadPoolExecutor(max_workers=workers, thread_name_prefix="belvedere-write")

    def run(task: Callable[[], None]) -> None:
        if failed.is_set():
            return
        try:
            task()
        except BaseException:
            failed.set()
            raise

    def submit(task: Callable[[], None]) -> None:
        while len(pending) >= IN_FLIGHT or (pending and pending[0].done()):
            pending.popleft().result()
        pending.append(pool.submit(run, task))

    try:
        yield submit
        while pending:
            pending.popleft().result()
    finally:
        pool.shutdown(wait=True)
