"""Video: H.264 in MP4, which every browser and phone plays, through the encoder of the PyAV wheel.

8-bit 4:2:0, BT.709, index at the front (it plays while it loads). 4:2:0 needs even sides: an odd
picture is padded by repeating its last column or row. The same frames give the same bytes: one
fixed number of encoder threads, no time stamps of the clock.
"""

from __future__ import annotations

import contextlib
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number, check_shape
from belvedere.ground.color import color_to_srgb8
from belvedere.ground.errors import InputError
from belvedere.scene.io.atomic import atomic_write, output_error, require_free

THREADS = 2
"""Of the encoder: fixed, since x264's output depends on their number."""
MAX_VIDEO_SIDE = 8192
"""Pixels: what H.264 decoders take."""
CRF = 18
"""x264's constant rate factor: visually lossless."""
_BT709 = 1
_LIMITED = 1


class VideoWriter:
    """Writes pictures of one size into an MP4 file that is there complete, or not at all.

    ::

        with VideoWriter("walk.mp4", 640, 512, fps=30) as video:
            for camera in path:
                video.write(scene.render(camera).color)
    """

    def __init__(
        self,
        path: str | Path,
        width: int,
        height: int,
        fps: float = 30.0,
        *,
        crf: int = CRF,
        force: bool = False,
    ) -> None:
        """Check everything before the first picture is rendered.

        Args:
            path: ends in ``.mp4``.
            width: pixels across.
            height: pixels down.
            fps: pictures a second.
            crf: quality, 0 (best) to 51.
            force: replace an existing file.

        Raises:
            InputError: another suffix, a size or rate that no video has.
            OutputError: the file exists without ``force``.
        """
        self.path = Path(path)
        if self.path.suffix.lower() != ".mp4":
            raise InputError(f"{self.path} ends in {self.path.suffix!r}, expected .mp4")
        self.width = check_integer("VideoWriter", "width", width, 1, MAX_VIDEO_SIDE)
        self.height = check_integer("VideoWriter", "height", height, 1, MAX_VIDEO_SIDE)
        rate = check_number("VideoWriter", "fps", fps, 0.1, 1000.0)
        self.fps = Fraction(rate).limit_denominator(1001)
        self.crf = check_integer("VideoWriter", "crf", crf, 0, 51)
        self.force = force
        self.frames = 0
        """Pictures written."""
        self._stack = contextlib.ExitStack()
        self._container: Any = None
        self._stream: Any = None
        require_free(self.path, force)

    def __enter__(self) -> VideoWriter:
        import av

        temporary = self._stack.enter_context(atomic_write(self.path, force=self.force))
        try:
            self._open(av, temporary)
        except BaseException as error:
            self._stack.__exit__(type(error), error, error.__traceback__)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        import av

        try:
            if kind is None:
                if self.frames == 0:
                    raise InputError(f"{self.path}: no picture was written into the video")
                with self._refusals(av):
                    self._container.mux(self._stream.encode(None))
                    self._container.close()
            else:
                with contextlib.suppress(Exception):
                    self._container.close()
        except BaseException as own:
            with contextlib.suppress(Exception):
                self._container.close()
            self._stack.__exit__(type(own), own, own.__traceback__)
            raise
        self._stack.__exit__(kind, error, trace)

    def write(self, color: npt.NDArray[Any]) -> None:
        """Append a picture.

        Args:
            color: (height, width, 3|4) ``uint8`` sRGB or ``float32`` linear; alpha is dropped
                (it is premultiplied: over black).

        Raises:
            InputError: another size or type, or outside of ``with``.
            OutputError: the disk is full.
        """
        if self._container is None:
            raise InputError("VideoWriter.write outside of its with block: enter it first")
        picture = np.asarray(color)
        check_shape("VideoWriter.write", "color", picture, (self.height, self.width, None))
        if picture.shape[2] not in (3, 4) or picture.dtype not in (np.uint8, np.float32):
            raise InputError(
                f"VideoWriter.write.color has {picture.shape[2]} channels of {picture.dtype}, "
                "expected 3 or 4 of uint8 (sRGB) or float32 (linear)"
            )
        import av
        from av.video.reformatter import Colorspace, Interpolation

        rgb = color_to_srgb8(picture[..., :3])
        rgb = np.pad(rgb, ((0, self.height % 2), (0, self.width % 2), (0, 0)), mode="edge")
        with self._refusals(av):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(rgb), format="rgb24")
            frame = frame.reformat(
                format="yuv420p",
                dst_colorspace=Colorspace.ITU709,
                interpolation=Interpolation.BICUBIC,
            )
            frame.pts = self.frames
            frame.time_base = 1 / self.fps
            self._container.mux(self._stream.encode(frame))
        self.frames += 1

    def _open(self, av: Any, temporary: Path) -> None:
        with self._refusals(av):
            self._container = av.open(
                str(temporary), "w", format="mp4",
                options={"movflags": "+faststart", "fflags": "+bitexact"},
            )  # fmt: skip
            stream = self._container.add_stream("libx264", rate=self.fps)
            stream.width = self.width + self.width % 2
            stream.height = self.height + self.height % 2
            stream.pix_fmt = "yuv420p"
            stream.time_base = 1 / self.fps
            stream.options = {"crf": str(self.crf), "preset": "veryfast"}
            context = stream.codec_context
            context.thread_count = THREADS
            context.colorspace = context.color_primaries = context.color_trc = _BT709
            context.color_range = _LIMITED
            self._stream = stream

    @contextlib.contextmanager
    def _refusals(self, av: Any) -> Any:
        try:
            yield
        except av.error.FFmpegError as error:
            raise output_error(self.path, OSError(error.errno, str(error.strerror))) from error
