"""One word, or a file, becomes a path through any scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from belvedere.ground import InputError, MissingFileError
from belvedere.studio.paths import PRESETS, path_for
from belvedere.warp import DepthViews
from tests.studio.tiny_scenes import Painted, row_of_views


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_starts_a_path_that_sees_the_scene(preset: str) -> None:
    scene = DepthViews(row_of_views(5))
    path = path_for(scene, preset, seconds=3.0)
    assert path.duration == pytest.approx(3.0)
    for camera in path.cameras(7):
        assert scene.render(camera).hole_fraction < 0.5


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_work_for_scenes_without_views(preset: str) -> None:
    assert path_for(Painted(), preset).duration > 0


def test_the_orbit_begins_and_ends_at_the_first_view() -> None:
    scene = DepthViews(row_of_views(3))
    path = path_for(scene, "orbit")
    np.testing.assert_allclose(path.camera(0.0).center, scene.home.center, atol=1e-9)
    np.testing.assert_allclose(path.camera(path.duration).center, scene.home.center, atol=1e-6)


def test_a_size_is_given_to_every_camera(tmp_path: Path) -> None:
    scene = DepthViews(row_of_views(3))
    path_for(scene, "through").save(tmp_path / "path.json")
    path = path_for(scene, tmp_path / "path.json", size=(96, 54))
    assert path.size == (54, 96)


def test_neither_preset_nor_file_is_refused() -> None:
    scene = DepthViews(row_of_views(2))
    with pytest.raises(InputError, match="path is 'spiral', expected one of wobble"):
        path_for(scene, "spiral")
    with pytest.raises(MissingFileError, match=r"no path file spiral\.json"):
        path_for(scene, "spiral.json")
