"""A scene's facts: what it is, what it affords, how big it is, whether its views agree."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from belvedere.scene.io import save_views, write_views
from belvedere.studio.inspect import inspect_scene, median_depth
from tests.studio.tiny_scenes import row_of_views


def test_facts_of_a_small_scene(tmp_path: Path) -> None:
    save_views(row_of_views(4), tmp_path / "scene")
    facts = inspect_scene(tmp_path / "scene")
    assert facts.sizes == ["48x36"]
    assert facts.affords.movement == "continuous"
    assert facts.disk_bytes == sum(
        file.stat().st_size for file in (tmp_path / "scene").rglob("*") if file.is_file()
    )
    assert median_depth(facts) == pytest.approx(4.0, rel=0.01)  # the wall
    assert facts.check is not None
    json.dumps(facts.as_dict(), allow_nan=False)


def test_the_eyes_span_what_they_span_and_the_stored_unit_is_metres(tmp_path: Path) -> None:
    views = row_of_views(4)
    save_views(views, tmp_path / "scene")
    facts = inspect_scene(tmp_path / "scene", check=False)
    centers = [camera.center for camera in views.cameras]
    assert facts.eye_span == pytest.approx(tuple(np.ptp(centers, axis=0)))
    assert facts.stored_unit == pytest.approx(0.001)


def test_numbers_that_are_metres_or_disparity_have_no_stored_unit(
    tmp_path: Path, shared_data: Path
) -> None:
    write_views(row_of_views(2), tmp_path / "colmap", "colmap")
    assert inspect_scene(tmp_path / "colmap", check=False).stored_unit is None
    pair = inspect_scene(shared_data / "stereo-middlebury-cones", check=False)
    assert pair.stored_unit is None
    assert pair.eye_span[0] == pytest.approx(0.16)
    assert pair.eye_span[1:] == (0.0, 0.0)


def test_the_check_can_be_left_out(tmp_path: Path) -> None:
    save_views(row_of_views(2), tmp_path / "scene")
    assert inspect_scene(tmp_path / "scene", check=False).check is None


def test_a_scene_without_depth_has_no_depth_facts(shared_data: Path) -> None:
    facts = inspect_scene(shared_data / "posed-castle-p19")
    assert facts.affords.movement == "discrete"
    assert median_depth(facts) is None
    assert facts.check is None
    json.dumps(facts.as_dict(), allow_nan=False)
