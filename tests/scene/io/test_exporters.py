"""Every pair of layouts: from one to the other and back gives the same cameras and depth."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera, ReferenceView, ViewSet
from belvedere.ground.errors import InputError, OutputError, SceneError
from belvedere.scene.io import read_views, write_views
from belvedere.scene.io.exporters import WRITERS
from belvedere.scene.views import ViewEntry

LAYOUTS = [name for name in WRITERS if name != "transforms"]  # our folder is one
STEP = {"belvedere": 0.001, "cameras.json": 0.001, "colmap": 0.0, "colmap-text": 0.0, "tum": 0.0002}


def assert_same(back: ViewSet, views: ViewSet, step: float) -> None:
    assert back.names == views.names
    for a, b in zip(back, views, strict=True):
        assert isinstance(a.camera, Camera)
        assert isinstance(b.camera, Camera)
        np.testing.assert_allclose(a.camera.matrix, b.camera.matrix, rtol=0, atol=1e-9)
        np.testing.assert_allclose(a.camera.center, b.camera.center, rtol=0, atol=1e-9)
        assert a.camera.size == b.camera.size
        np.testing.assert_array_equal(a.color, b.color)
        np.testing.assert_array_equal(np.isnan(a.disparity), np.isnan(b.disparity))
        known = b.disparity > 0
        np.testing.assert_allclose(1 / a.disparity[known].astype(float),
                                   1 / b.disparity[known].astype(float),
                                   rtol=5e-7, atol=0.5001 * step)  # fmt: skip


@pytest.mark.parametrize(("first", "second"), list(itertools.product(LAYOUTS, LAYOUTS)))
def test_from_one_layout_to_another_and_back_is_the_same(
    tmp_path: Path, make_views: Any, first: str, second: str
) -> None:
    views = make_views(depth=(0.7, 8.0))
    write_views(views, tmp_path / "a", first)
    write_views(read_views(tmp_path / "a"), tmp_path / "b", second)
    write_views(read_views(tmp_path / "b"), tmp_path / "c", first)
    # float32 disparity itself moves a depth by 5e-7 of it; more than the steps would hide nothing
    assert_same(read_views(tmp_path / "a"), views, STEP[first])
    assert_same(read_views(tmp_path / "b"), views, STEP[first] + STEP[second])
    assert_same(read_views(tmp_path / "c"), views, 2 * STEP[first] + STEP[second])


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_is_recognised_by_what_lies_in_its_folder(
    tmp_path: Path, views: ViewSet, layout: str
) -> None:
    done = write_views(views, tmp_path / "a", layout)
    assert done.format == layout
    assert read_views(tmp_path / "a").facts["format"] == layout.removesuffix("-text")


@pytest.mark.parametrize("layout", [name for name in LAYOUTS if name != "tum"])
def test_a_camera_each_comes_back(tmp_path: Path, make_views: Any, layout: str) -> None:
    views = make_views(focals=(9.0, 10.0, 11.5))
    write_views(views, tmp_path / "a", layout)
    assert_same(read_views(tmp_path / "a"), views, STEP[layout])


@pytest.mark.parametrize("layout", LAYOUTS)
def test_pictures_without_depth_come_back(tmp_path: Path, views: ViewSet, layout: str) -> None:
    bare = ViewSet(tuple(ViewEntry(e.name, e.camera, False, e.load_color, None)
                         for e in views.entries))  # fmt: skip
    write_views(bare, tmp_path / "a", layout)
    back = read_views(tmp_path / "a")
    assert not back.has_depth
    assert back.facts["frames_with_depth"] == 0
    assert "depth_scale" not in back.facts
    for index in range(3):
        np.testing.assert_array_equal(back.color(index), views.color(index))
        np.testing.assert_allclose(back.cameras[index].center, views.cameras[index].center,
                                   atol=1e-9)  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_infinitely_far_survives_or_its_loss_is_told(
    tmp_path: Path, make_views: Any, layout: str
) -> None:
    views = make_views(far=True)
    done = write_views(views, tmp_path / "a", layout)
    back = read_views(tmp_path / "a")
    if layout in ("belvedere", "cameras.json"):
        assert done.notes == ()
        for a, b in zip(back, views, strict=True):
            np.testing.assert_array_equal(a.disparity == 0, b.disparity == 0)
    else:
        assert done.notes == ("12 infinitely far pixels became 'no sample': the format has no "
                              "word for them",)  # fmt: skip
        assert all(np.isnan(view.disparity[1, :4]).all() for view in back)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_names_survive_or_their_loss_is_told(tmp_path: Path, views: ViewSet, layout: str) -> None:
    odd = ViewSet.of(list(views), ["plain", "with space", "ü"])
    done = write_views(odd, tmp_path / "a", layout)
    names = read_views(tmp_path / "a").names
    if layout in ("belvedere", "cameras.json"):
        assert names == odd.names
    else:
        assert names == ("plain", "00001", "00002")
        assert "2 views are called after their files" in done.notes[-1]


def test_cameras_json_holds_skewed_pixels(tmp_path: Path) -> None:
    k = np.array([[10.0, 0.5, 3.3], [0, 10.0, 2.2], [0, 0, 1]])
    view = ReferenceView(Camera.from_intrinsics(k, np.eye(4), 6, 4),
                         np.zeros((4, 6, 3), np.uint8), np.ones((4, 6), np.float32))  # fmt: skip
    write_views(ViewSet.of([view]), tmp_path / "a", "cameras.json", depth_format="exr")
    camera = read_views(tmp_path / "a").cameras[0]
    assert isinstance(camera, Camera)
    np.testing.assert_allclose(camera.intrinsics, k, atol=1e-12)


def test_tum_refuses_what_it_cannot_hold(tmp_path: Path, make_views: Any) -> None:
    with pytest.raises(SceneError, match="one camera for all pictures, but these differ"):
        write_views(make_views(focals=(9.0, 10.0, 11.0)), tmp_path / "a", "tum")
    with pytest.raises(InputError, match=r"16 bits hold 13\.1068 m in steps of 0\.0002 m"):
        write_views(make_views(depth=(1.0, 20.0)), tmp_path / "a", "tum")
    views = make_views()
    bare = views.entries[0]
    mixed = ViewSet((ViewEntry(bare.name, bare.camera, False, bare.load_color, None),
                     *views.entries[1:]))  # fmt: skip
    with pytest.raises(SceneError, match="depth for every picture or none"):
        write_views(mixed, tmp_path / "a", "tum")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("layout", LAYOUTS)
def test_what_exists_is_replaced_only_by_force(tmp_path: Path, views: ViewSet, layout: str) -> None:
    write_views(views, tmp_path / "a", layout)
    with pytest.raises(OutputError, match="--force"):
        write_views(views, tmp_path / "a", layout)
    write_views(views, tmp_path / "a", layout, force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def same_when_read(layout: str, depth_format: str) -> bool:
    """Whether a layout takes a depth format."""
    if layout in ("belvedere", "cameras.json"):
        return True
    return layout == "tum" and depth_format == "png16"


@pytest.mark.parametrize("color_format", ["png", "webp"])
@pytest.mark.parametrize("depth_format", ["png16", "exr", "npy", "pfm"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_takes_a_depth_format_or_refuses_it_by_name(
    tmp_path: Path, make_views: Any, layout: str, depth_format: str, color_format: str
) -> None:
    views = make_views(depth=(0.7, 8.0))
    options = {"depth_format": depth_format, "color_format": color_format}
    if same_when_read(layout, depth_format):
        write_views(views, tmp_path / "a", layout, **options)
        step = STEP[layout] if depth_format == "png16" else 0.0
        assert_same(read_views(tmp_path / "a"), views, step)
        return
    with pytest.raises(InputError, match=rf"depth_format.*layout '{layout}'"):
        write_views(views, tmp_path / "a", layout, **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("layout", LAYOUTS)
def test_an_option_that_no_layout_has_is_refused_by_name(
    tmp_path: Path, views: ViewSet, layout: str
) -> None:
    with pytest.raises(InputError, match=rf"write_views\.sharpness: the layout '{layout}' does"):
        write_views(views, tmp_path / "a", layout, sharpness=3)
    assert list(tmp_path.iterdir()) == []


def test_advice_about_depth_that_does_not_fit_works_for_its_layout(
    tmp_path: Path, make_views: Any
) -> None:
    deep = make_views(depth=(1.0, 20.0))
    with pytest.raises(InputError, match=r"write another layout \(belvedere, cameras\.json or col"):
        write_views(deep, tmp_path / "a", "tum")
    for layout in ("belvedere", "cameras.json", "colmap"):
        write_views(deep, tmp_path / layout, layout)
    disparity = np.full((4, 6), 1e-4, np.float32)
    disparity[0, 0] = 1e4
    camera = Camera.look_at((0, 0, 0), (0, 1, 0), width=6, height=4)
    both = ViewSet.of([ReferenceView(camera, np.zeros((4, 6, 3), np.uint8), disparity)])
    for layout in ("belvedere", "cameras.json"):
        with pytest.raises(InputError, match=r"\(no sample\): use a float depth format \(exr"):
            write_views(both, tmp_path / f"{layout}-both", layout)
        write_views(both, tmp_path / f"{layout}-both", layout, depth_format="npy")


def test_what_is_no_path_is_refused(views: ViewSet) -> None:
    nothing: Any = None
    with pytest.raises(InputError, match=r"write_views\.path is None, expected the name of a file"):
        write_views(views, nothing)


def test_an_unknown_layout_is_refused(tmp_path: Path, views: ViewSet) -> None:
    with pytest.raises(InputError, match=r"layout is 'obj', expected one of 'belvedere'"):
        write_views(views, tmp_path / "a", "obj")
