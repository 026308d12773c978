"""The demo's road from house to report, on a house that is a wall with a board before it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import belvedere.model
from belvedere.ground.errors import InputError, OutputError
from belvedere.scene import Camera, CameraModel, ReferenceView
from belvedere.scene.io.detect import read_views
from belvedere.scene.path import CameraPath
from belvedere.studio.demo import README, demo
from tests.studio.tiny_scenes import camera_at, photograph

SMALL: dict[str, Any] = {
    "seconds": 0.5, "fps": 10, "size": (48, 36), "references": 3, "checked": 2,
    "compared": ("point", "splat"),
}  # fmt: skip


class Wall:
    """As much of a house as the demo needs."""

    def reference_cameras(self, count: int, width: int, height: int) -> tuple[Camera, ...]:
        return tuple(camera_at(0.1 * i, width, height) for i in range(count))

    def walk_keyframes(self) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
        return [((x, 0.0, 0.0), (x, 4.0, 0.0)) for x in (0.02, 0.1, 0.18)]


@pytest.fixture(autouse=True)
def wall(monkeypatch: pytest.MonkeyPatch) -> None:
    def take(house: Wall, camera: CameraModel, samples: int, threads: int | None) -> ReferenceView:
        del house, samples, threads
        return photograph(camera)

    monkeypatch.setattr(belvedere.model, "build_interior", lambda seed, threads: Wall())
    monkeypatch.setattr(belvedere.model, "photograph", take)


def test_the_demo_writes_everything_its_readme_tells_of(tmp_path: Path) -> None:
    stages: list[str] = []
    result = demo(tmp_path / "show", **SMALL, progress=lambda _, __, what: stages.append(what))
    names = {path.name for path in (tmp_path / "show").iterdir()}
    assert names == {"README.txt", "demo.json", "path.json", "poster.png", "report", "scene",
                     "walk.mp4"}  # fmt: skip
    told = {line.split()[0].rstrip("/") for line in README.splitlines() if "   " in line[:15]}
    assert names - {"README.txt"} <= told
    assert [path.name for path in tmp_path.iterdir()] == ["show"]
    assert result.video.frames == 5
    assert result.video.output == tmp_path / "show" / "walk.mp4"
    assert result.evaluation.held_out == ("walk_0001", "walk_0003")
    assert list(result.seconds) == ["build", "photograph", "walk", "save", "check"]
    assert list(dict.fromkeys(stages)) == [
        "building the house", "photographing references", "rendering frames",
        "ray casting the truth", "predicting held-out views",
    ]  # fmt: skip


def test_the_scene_and_the_path_it_writes_can_be_opened_again(tmp_path: Path) -> None:
    demo(tmp_path / "show", **SMALL)
    views = read_views(tmp_path / "show" / "scene")
    assert views.names == ("view_00", "view_01", "view_02")
    np.testing.assert_array_equal(views[1].color, photograph(camera_at(0.1)).color)
    path = CameraPath.load(tmp_path / "show" / "path.json")
    assert path.duration == pytest.approx(0.5)
    assert path.size == (36, 48)


def test_predictions_come_from_the_references_alone(tmp_path: Path) -> None:
    result = demo(tmp_path / "show", **SMALL)
    assert result.summary.startswith("5 frames of 48 x 36 warped at ")
    assert json.loads(json.dumps(result.as_dict(), allow_nan=False))["video"]["frames"] == 5
    used = {name for score in result.evaluation.scores for name in score.references}
    assert used <= {"view_00", "view_01", "view_02"}
    record = json.loads((tmp_path / "show" / "demo.json").read_text())
    assert record["video"]["frames"] == 5
    assert len(record["evaluation"]["views"]) == 4


def test_a_demo_is_replaced_only_with_force_and_nothing_else_is(tmp_path: Path) -> None:
    demo(tmp_path / "show", **SMALL)
    with pytest.raises(OutputError, match="exists: pass --force"):
        demo(tmp_path / "show", **SMALL)
    demo(tmp_path / "show", **SMALL, force=True)
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "letters.txt").write_text("mine")
    with pytest.raises(OutputError, match="not a folder that belvedere wrote"):
        demo(tmp_path / "home", **SMALL, force=True)


def test_an_interrupted_demo_leaves_nothing(tmp_path: Path) -> None:
    def stop(done: int, total: int, what: str) -> None:
        if what == "rendering frames" and done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        demo(tmp_path / "show", **SMALL, progress=stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seconds": 0}, "demo.seconds is 0, expected a finite number from 0.1"),
        ({"references": 1}, "demo.references is 1, expected a whole number from 2"),
        ({"checked": 0}, "demo.checked is 0"),
    ],
)
def test_a_demo_that_cannot_be_made_is_refused(tmp_path, change, message: str) -> None:
    with pytest.raises(InputError) as refusal:
        demo(tmp_path / "show", **{**SMALL, **change})
    assert message in str(refusal.value)
