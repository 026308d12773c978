"""Walking a path: what is written is complete, and an interrupted walk goes on."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from belvedere.ground.errors import InputError, OutputError
from belvedere.scene import Camera, CameraModel, Frame
from belvedere.scene.io.images import read_color
from belvedere.scene.path import CameraPath, Keyframe
from belvedere.studio import _sinks
from belvedere.studio.walk import cameras_along, render_path
from tests.studio.tiny_scenes import Painted, camera_at, photograph


def row(count: int) -> list[Camera]:
    return [camera_at(0.01 * i) for i in range(count)]


class Interrupted(Painted):
    """Ctrl-C comes when frame number ``at`` is asked for."""

    def __init__(self, at: int) -> None:
        super().__init__()
        self.at = at

    def render(self, camera: CameraModel) -> Frame:
        if self.rendered == self.at:
            raise KeyboardInterrupt
        return super().render(camera)


# The job's identity is the scene's class name among others, so both scenes are one scene here.
Interrupted.__name__ = Painted.__name__


def decode(path: Path) -> list[np.ndarray]:
    import av

    with av.open(str(path)) as video:
        return [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]


def times(path: Path) -> list[float]:
    import av

    with av.open(str(path)) as video:
        return [frame.time or 0.0 for frame in video.decode(video=0)]


def hidden(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path.name.startswith(".")]


def test_a_folder_holds_numbered_frames_that_equal_the_renders(tmp_path: Path) -> None:
    steps: list[tuple[int, int, str]] = []
    result = render_path(Painted(), row(3), tmp_path / "walk", progress=lambda *s: steps.append(s))
    names = sorted(path.name for path in (tmp_path / "walk").iterdir())
    assert names == ["frame_00000.png", "frame_00001.png", "frame_00002.png", "render.json"]
    for index, camera in enumerate(row(3)):
        shown = read_color(tmp_path / "walk" / names[index])
        np.testing.assert_array_equal(shown, photograph(camera).color)
    assert (result.frames, result.rendered, result.reused) == (3, 3, 0)
    assert result.hole_fraction == result.worst_hole_fraction == pytest.approx(1 / 36, abs=1e-6)
    assert [(d, t) for d, t, _ in steps] == [(0, 3), (1, 3), (2, 3), (3, 3)]
    record = json.loads((tmp_path / "walk" / "render.json").read_text())
    assert record["state"] == "complete"
    assert hidden(tmp_path) == []


def test_a_video_holds_every_frame_in_order_at_even_times(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(_sinks.VideoSink, "chunk", 4)
    cameras = [camera_at(0.05 * i) for i in range(10)]
    render_path(Painted(), cameras, tmp_path / "walk.mp4", fps=25)
    pictures = decode(tmp_path / "walk.mp4")
    assert len(pictures) == 10
    np.testing.assert_allclose(np.diff(times(tmp_path / "walk.mp4")), 1 / 25, atol=1e-6)
    truths = [photograph(camera).color.astype(float) for camera in cameras]
    for index, picture in enumerate(pictures):
        errors = [np.abs(picture - truth).mean() for truth in truths]
        assert int(np.argmin(errors)) == index
        assert errors[index] < 6
    assert hidden(tmp_path) == []


def test_a_joined_video_equals_its_pieces_and_keeps_their_colour_tags(
    tmp_path, monkeypatch
) -> None:
    import av

    from belvedere.studio._segments import join_segments

    monkeypatch.setattr(_sinks.VideoSink, "chunk", 100)
    cameras = row(9)
    render_path(Painted(), cameras[:5], tmp_path / "a.mp4")
    render_path(Painted(), cameras[5:], tmp_path / "b.mp4")
    join_segments([tmp_path / "a.mp4", tmp_path / "b.mp4"], tmp_path / "joined.mp4")
    pieces = decode(tmp_path / "a.mp4") + decode(tmp_path / "b.mp4")
    np.testing.assert_array_equal(decode(tmp_path / "joined.mp4"), pieces)
    with av.open(str(tmp_path / "a.mp4")) as one, av.open(str(tmp_path / "joined.mp4")) as two:
        first, second = (video.streams.video[0] for video in (one, two))
        assert second.codec_context.colorspace == first.codec_context.colorspace
        assert second.codec_context.color_range == first.codec_context.color_range
        assert second.average_rate == first.average_rate == 30


@pytest.mark.parametrize(("name", "chunk"), [("walk", 1), ("walk.mp4", 3)])
def test_an_interrupted_walk_leaves_nothing_under_its_name_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, chunk: int
) -> None:
    monkeypatch.setattr(_sinks.VideoSink, "chunk", 3)
    cameras = row(8)
    with pytest.raises(KeyboardInterrupt):
        render_path(Interrupted(at=5), cameras, tmp_path / name)
    assert not (tmp_path / name).exists()
    scene = Painted()
    result = render_path(scene, cameras, tmp_path / name)
    assert result.reused == 5 // chunk * chunk
    assert scene.rendered == result.rendered == 8 - result.reused
    assert result.hole_fraction == pytest.approx(1 / 36, abs=1e-6)
    if name.endswith(".mp4"):
        assert len(decode(tmp_path / name)) == 8
    else:
        assert len(list((tmp_path / name).glob("frame_*.png"))) == 8
    assert hidden(tmp_path) == []


def test_a_resumed_walk_gives_the_bytes_of_an_uninterrupted_one(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(_sinks.VideoSink, "chunk", 3)
    cameras = row(8)
    render_path(Painted(), cameras, tmp_path / "whole.mp4")
    with pytest.raises(KeyboardInterrupt):
        render_path(Interrupted(at=5), cameras, tmp_path / "resumed.mp4")
    render_path(Painted(), cameras, tmp_path / "resumed.mp4")
    whole, resumed = ((tmp_path / f"{n}.mp4").read_bytes() for n in ("whole", "resumed"))
    assert whole == resumed


@pytest.mark.parametrize(("name", "reused"), [("walk", 5), ("walk.mp4", 0)])
def test_a_walk_whose_process_is_killed_goes_on(tmp_path: Path, name: str, reused: int) -> None:
    script = f"""
import os, signal, time
from pathlib import Path
from tests.studio.tiny_scenes import Painted, camera_at
from belvedere.studio.walk import render_path

class Killed(Painted):
    def render(self, camera):
        if self.rendered == 5:
            time.sleep(0.5)  # what was handed over is written
            os.kill(os.getpid(), signal.SIGKILL)
        return super().render(camera)

Killed.__name__ = "Painted"
render_path(Killed(), [camera_at(0.01 * i) for i in range(8)], Path({str(tmp_path / name)!r}))
"""
    root = Path(__file__).parents[2]
    ended = subprocess.run([sys.executable, "-c", script], cwd=root, timeout=60, check=False)
    assert ended.returncode == -signal.SIGKILL
    assert not (tmp_path / name).exists()
    result = render_path(Painted(), row(8), tmp_path / name)
    assert (result.reused, result.frames) == (reused, 8)
    assert hidden(tmp_path) == []


def test_a_killed_walk_whose_half_frame_is_left_goes_on_without_it(tmp_path: Path) -> None:
    cameras = row(4)
    with pytest.raises(KeyboardInterrupt):
        render_path(Interrupted(at=2), cameras, tmp_path / "walk")
    work = hidden(tmp_path)[0]
    (work / ".frame_00002.1-1.belvedere-partial.png").write_bytes(b"half")
    render_path(Painted(), cameras, tmp_path / "walk")
    assert len(list((tmp_path / "walk").iterdir())) == 5


def test_another_job_does_not_go_on_from_an_interrupted_one(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        render_path(Interrupted(at=3), row(4), tmp_path / "walk", options={"scene": "a"})
    with pytest.raises(OutputError) as refusal:
        render_path(Painted(), row(5), tmp_path / "walk", fps=25, options={"scene": "b"})
    text = str(refusal.value)
    assert "an interrupted render of another job waits to be resumed" in text
    assert "frames 4 then, 5 now" in text
    assert "fps 30.0 then, 25.0 now" in text
    assert "another path" in text
    assert "scene 'a' then, 'b' now" in text
    result = render_path(Painted(), row(5), tmp_path / "walk", fps=25, force=True)
    assert result.reused == 0


def test_without_resume_a_walk_starts_anew(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        render_path(Interrupted(at=3), row(4), tmp_path / "walk")
    assert render_path(Painted(), row(4), tmp_path / "walk", resume=False).rendered == 4


@pytest.mark.parametrize("name", ["walk", "walk.mp4"])
def test_a_finished_walk_is_replaced_only_with_force(tmp_path: Path, name: str) -> None:
    render_path(Painted(), row(3), tmp_path / name)
    with pytest.raises(OutputError, match="exists: pass --force"):
        render_path(Painted(), row(2), tmp_path / name)
    assert render_path(Painted(), row(2), tmp_path / name, force=True).frames == 2


def test_a_folder_of_somebody_else_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "summer.jpg").write_bytes(b"dear")
    with pytest.raises(OutputError, match="not a folder that belvedere wrote"):
        render_path(Painted(), row(2), tmp_path / "photos", force=True)
    assert (tmp_path / "photos" / "summer.jpg").read_bytes() == b"dear"


def test_a_failing_scene_keeps_the_frames_it_has_given(tmp_path: Path) -> None:
    class Failing(Interrupted):
        def render(self, camera: CameraModel) -> Frame:
            try:
                return super().render(camera)
            except KeyboardInterrupt:
                raise OSError(28, "No space left on device") from None

    Failing.__name__ = Painted.__name__
    with pytest.raises(OutputError, match="the disk is full"):
        render_path(Failing(at=3), row(4), tmp_path / "walk")
    assert render_path(Painted(), row(4), tmp_path / "walk").reused == 3


def test_a_path_gives_duration_times_rate_cameras_and_keeps_its_ends() -> None:
    path = CameraPath((Keyframe(0.0, camera_at(0.0)), Keyframe(2.0, camera_at(1.0))))
    cameras = cameras_along(path, fps=10)
    assert len(cameras) == 20
    np.testing.assert_allclose(cameras[0].center, [0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(cameras[-1].center, [1, 0, 0], atol=1e-12)
    assert len(cameras_along(path, fps=10, frames=7)) == 7
    assert cameras_along(path, fps=10, size=(24, 18))[0].size == (18, 24)


@pytest.mark.parametrize(
    ("path", "output", "options", "message"),
    [
        ([], "walk", {}, "render_path.path has 0 cameras, expected at least 1"),
        (row(2), "walk", {"frames": 3}, "render_path.path has 2 cameras, expected 3"),
        (row(2), "walk.avi", {}, "render_path.output is 'walk.avi', expected a video (name.mp4)"),
        (row(2), "walk", {"fps": 0}, "render_path.fps is 0, expected a finite number from 0.1"),
        (row(2), "walk", {"size": (0, 5)}, "render_path.width is 0"),
        ([camera_at(0), camera_at(0, 24, 18)], "walk", {}, "has cameras of 2 sizes, expected one"),
    ],
)
def test_a_walk_that_cannot_be_done_is_refused(tmp_path, path, output, options, message) -> None:
    with pytest.raises(InputError) as refusal:
        render_path(Painted(), path, tmp_path / output, **options)
    assert message in str(refusal.value)
    assert list(tmp_path.iterdir()) == []
