"""Video through a real encoder: it plays, it is the same every time, and it is all or nothing."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from belvedere.ground.errors import InputError, OutputError
from belvedere.scene.io import VideoWriter

U1 = npt.NDArray[np.uint8]


def pictures(width: int, height: int, count: int = 6) -> list[U1]:
    """A bright bar that moves over a coloured ramp."""
    frames: list[U1] = []
    for index in range(count):
        frame = np.zeros((height, width, 3), np.uint8)
        frame[..., 0] = np.linspace(30, 220, width)
        frame[..., 1] = np.linspace(200, 40, height)[:, None]
        frame[..., 2] = 80
        frame[:, 8 * index : 8 * index + 8] = (240, 240, 60)
        frames.append(frame)
    return frames


def decode(path: Path) -> tuple[list[Any], Fraction]:
    import av

    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        rate = stream.average_rate
        assert rate is not None
        return frames, Fraction(rate)


def write(path: Path, frames: list[U1], fps: float = 25.0, **options: Any) -> None:
    height, width, _ = frames[0].shape
    with VideoWriter(path, width, height, fps, **options) as video:
        for frame in frames:
            video.write(frame)


def test_pictures_come_back_nearly_and_in_order(tmp_path: Path) -> None:
    frames = pictures(96, 64)
    write(tmp_path / "a.mp4", frames)
    back, rate = decode(tmp_path / "a.mp4")
    assert len(back) == len(frames)
    assert rate == 25
    for a, b in zip(back, frames, strict=True):
        assert np.abs(a.astype(float) - b).mean() < 4  # 4:2:0 blurs colour at the bar's edges
    data = (tmp_path / "a.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # plays while it loads


def test_odd_sizes_are_padded_by_their_edge(tmp_path: Path) -> None:
    frames = pictures(95, 63, 2)
    write(tmp_path / "a.mp4", frames, fps=29.97)
    back, rate = decode(tmp_path / "a.mp4")
    assert back[0].shape == (64, 96, 3)
    assert float(rate) == pytest.approx(29.97, abs=1e-3)
    assert np.abs(back[0][:63, :95].astype(float) - frames[0]).mean() < 4


def test_one_pixel_is_a_video_too(tmp_path: Path) -> None:
    write(tmp_path / "a.mp4", [np.full((1, 1, 3), 128, np.uint8)] * 2)
    assert decode(tmp_path / "a.mp4")[0][0].shape == (2, 2, 3)


def test_the_same_pictures_give_the_same_bytes(tmp_path: Path) -> None:
    for name in "ab":
        write(tmp_path / f"{name}.mp4", pictures(96, 64))
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_linear_and_alpha_pictures_are_taken(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", 16, 16) as video:
        video.write(np.full((16, 16, 3), 0.5, np.float32))
        video.write(np.full((16, 16, 4), 188, np.uint8))
        assert video.frames == 2
    back, _ = decode(tmp_path / "a.mp4")
    assert np.abs(back[0].astype(int) - 188).max() <= 3
    assert np.abs(back[1].astype(int) - 188).max() <= 3


@pytest.mark.parametrize("error", [ValueError("no"), KeyboardInterrupt()])
def test_a_failure_leaves_nothing_and_keeps_what_was_there(
    tmp_path: Path, error: BaseException
) -> None:
    write(tmp_path / "a.mp4", pictures(32, 32))
    before = (tmp_path / "a.mp4").read_bytes()
    with (  # noqa: PT012 - the block is what is tested
        pytest.raises(type(error)),
        VideoWriter(tmp_path / "a.mp4", 32, 32, force=True) as video,
    ):
        video.write(np.zeros((32, 32, 3), np.uint8))
        raise error
    assert (tmp_path / "a.mp4").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_a_video_of_nothing_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    with (
        pytest.raises(InputError, match=r"a\.mp4: no picture was written"),
        VideoWriter(tmp_path / "a.mp4", 32, 32),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("a.avi", 32, 32), "ends in '.avi', expected .mp4"),
        (("a.mp4", 0, 32), "width is 0, expected a whole number from 1"),
        (("a.mp4", 32, 9000), "height is 9000"),
        (("a.mp4", 32, 32, 0.0), "fps is 0"),
        (("a.mp4", 32, 32, float("nan")), "fps is nan"),
    ],
)
def test_a_video_that_cannot_be_is_refused(
    tmp_path: Path, arguments: tuple[Any, ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        VideoWriter(tmp_path / arguments[0], *arguments[1:])


def test_an_existing_video_is_replaced_only_by_force(tmp_path: Path) -> None:
    write(tmp_path / "a.mp4", pictures(32, 32))
    with pytest.raises(OutputError, match="--force"):
        VideoWriter(tmp_path / "a.mp4", 32, 32)
    write(tmp_path / "a.mp4", pictures(32, 32), force=True)


@pytest.mark.parametrize(
    ("color", "message"),
    [
        (np.zeros((16, 32, 3), np.uint8), r"has shape \(16, 32, 3\), expected \(32, 32, n\)"),
        (np.zeros((32, 32, 2), np.uint8), "has 2 channels of uint8"),
        (np.zeros((32, 32, 3), np.int64), "of int64, expected 3 or 4 of uint8"),
    ],
)
def test_pictures_that_do_not_fit_are_refused(tmp_path: Path, color: U1, message: str) -> None:
    with (
        pytest.raises(InputError, match=message),
        VideoWriter(tmp_path / "a.mp4", 32, 32) as video,
    ):
        video.write(color)
    with pytest.raises(InputError, match="outside of its with block"):
        VideoWriter(tmp_path / "a.mp4", 32, 32).write(color)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file sizes there")
def test_a_full_disk_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    code = f"""
import resource, signal
import numpy as np
from belvedere.ground.errors import OutputError
from belvedere.scene.io import VideoWriter
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (16384, 16384))
rng = np.random.default_rng(1)
try:
    with VideoWriter({str(tmp_path / "a.mp4")!r}, 128, 128) as video:
        for _ in range(30):
            video.write(rng.integers(0, 256, (128, 128, 3), dtype=np.uint8))
except OutputError as error:
    print(error)
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "could not be written" in out.stdout or "the disk is full" in out.stdout
    assert list(tmp_path.iterdir()) == []
