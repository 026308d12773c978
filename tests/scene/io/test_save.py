"""Our scene folder: it comes back as it went, it resumes, and nothing half-written opens."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere import Camera, ReferenceView, ViewSet
from belvedere.ground.errors import BelvedereError, InputError, OutputError, SceneError
from belvedere.scene.io import read_views, save_views
from belvedere.scene.io.atomic import staging_path
from belvedere.scene.io.save import discard_partial
from belvedere.scene.views import ViewEntry


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def fingerprints(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(f.relative_to(folder)): hashlib.md5(f.read_bytes()).hexdigest() for f in files}


def edit(file: Path, **changes: Any) -> None:
    data = json.loads(file.read_text())
    data.update(changes)
    file.write_text(json.dumps(data))


def assert_same(back: ViewSet, views: ViewSet, depth_atol: float = 0.0) -> None:
    assert back.names == views.names
    for a, b in zip(back, views, strict=True):
        assert isinstance(a.camera, Camera)
        assert isinstance(b.camera, Camera)
        np.testing.assert_allclose(a.camera.matrix, b.camera.matrix, atol=1e-12)
        np.testing.assert_allclose(a.camera.center, b.camera.center, atol=1e-12)
        assert a.camera.size == b.camera.size
        np.testing.assert_array_equal(a.color, b.color)
        np.testing.assert_array_equal(np.isnan(a.disparity), np.isnan(b.disparity))
        np.testing.assert_array_equal(a.disparity == 0, b.disparity == 0)
        known = b.disparity > 0
        np.testing.assert_allclose(1 / a.disparity[known], 1 / b.disparity[known],
                                   rtol=3e-7, atol=depth_atol)  # fmt: skip


@pytest.mark.parametrize("depth_format", ["png16", "exr", "npy", "pfm"])
@pytest.mark.parametrize("color_format", ["png", "webp"])
def test_views_come_back_with_their_holes_and_what_is_infinitely_far(
    tmp_path: Path, make_views: Any, depth_format: Any, color_format: Any
) -> None:
    views = make_views(far=True)
    done = save_views(views, tmp_path / "scene", color_format=color_format,
                      depth_format=depth_format)  # fmt: skip
    back = read_views(tmp_path / "scene")
    assert_same(back, views)  # the depths lie on a grid of 1 mm, so 16 bits lose nothing
    assert back.facts["format"] == "belvedere"
    assert (done.views, done.resumed, done.notes) == (3, 0, ())
    assert names(tmp_path) == ["scene"]
    assert names(tmp_path / "scene") == ["belvedere.json", "depth", "images", "transforms.json"]


def test_linear_colour_goes_into_exr_by_itself(tmp_path: Path, make_views: Any) -> None:
    views = make_views(linear=True)
    save_views(views, tmp_path / "scene")
    assert_same(read_views(tmp_path / "scene"), views)
    assert (tmp_path / "scene" / "images" / "v00.exr").is_file()


def test_linear_colour_clipped_for_png_is_told(tmp_path: Path, make_views: Any) -> None:
    done = save_views(make_views(linear=True), tmp_path / "scene", color_format="png")
    assert done.notes == ("linear colour of 3 views was clipped to [0, 1] and encoded as 8-bit "
                          "sRGB for .png",)  # fmt: skip


def test_opaque_alpha_survives(tmp_path: Path, make_views: Any) -> None:
    views = make_views(alpha=True)
    save_views(views, tmp_path / "scene")
    assert_same(read_views(tmp_path / "scene"), views)
    with pytest.raises(InputError, match="JPEG holds no alpha"):
        save_views(views, tmp_path / "jpg", color_format="jpg")
    assert names(tmp_path) == ["scene"]


@pytest.mark.parametrize(
    ("depth", "step"),
    [((0.5, 8.0), 0.001), ((0.01, 0.5), 0.0001), ((0.001, 0.04), 0.00001), ((1.0, 500.0), None)],
)
def test_the_depth_step_is_chosen_so_that_everything_fits(
    tmp_path: Path, make_views: Any, depth: tuple[float, float], step: float | None
) -> None:
    views = make_views(depth=depth)
    done = save_views(views, tmp_path / "scene")
    assert done.depth_step is not None
    if step is not None:
        assert done.depth_step == pytest.approx(step)
    assert_same(read_views(tmp_path / "scene"), views, depth_atol=0.5001 * done.depth_step)


def test_a_step_that_cannot_hold_the_depth_is_refused_and_nothing_is_left(
    tmp_path: Path, views: ViewSet
) -> None:
    with pytest.raises(InputError, match="use a larger step or a float depth format"):
        save_views(views, tmp_path / "scene", depth_step_m=1e-5)
    assert names(tmp_path) == []


def test_views_without_depth_are_saved_without(tmp_path: Path, views: ViewSet) -> None:
    bare = views.entries[1]
    mixed = ViewSet((views.entries[0], ViewEntry(bare.name, bare.camera, False, bare.load_color,
                                                 None)))  # fmt: skip
    save_views(mixed, tmp_path / "scene")
    back = read_views(tmp_path / "scene")
    assert [entry.has_depth for entry in back.entries] == [True, False]
    np.testing.assert_array_equal(back.color(1), views.color(1))


def test_odd_names_are_kept_though_their_files_are_called_otherwise(
    tmp_path: Path, views: ViewSet
) -> None:
    odd = ViewSet.of(list(views), ["a/b", "..", "Küche: hinten"])
    save_views(odd, tmp_path / "scene")
    assert read_views(tmp_path / "scene").names == odd.names


def test_a_camera_each_and_a_camera_for_all_both_come_back(tmp_path: Path, make_views: Any) -> None:
    for focals in ((), (9.0, 10.0, 11.0)):
        views = make_views(focals=focals)
        save_views(views, tmp_path / f"s{len(focals)}")
        assert_same(read_views(tmp_path / f"s{len(focals)}"), views)
        root = json.loads((tmp_path / f"s{len(focals)}" / "transforms.json").read_text())
        assert ("fl_x" in root) == (not focals)


def test_the_same_views_give_the_same_bytes(tmp_path: Path, make_views: Any) -> None:
    for name in "ab":
        save_views(make_views(), tmp_path / name)
    assert fingerprints(tmp_path / "a") == fingerprints(tmp_path / "b")


# ---- unknown keys, versions --------------------------------------------------------------------


def test_unknown_keys_survive_a_rewrite_but_for_files_that_are_not_copied(
    tmp_path: Path, views: ViewSet
) -> None:
    scene = tmp_path / "scene"
    save_views(views, scene)
    root = json.loads((scene / "transforms.json").read_text())
    root |= {"aabb_scale": 4, "ply_file_path": "points.ply"}
    root["frames"][1]["sharpness"] = 31.5
    (scene / "transforms.json").write_text(json.dumps(root))
    edit(scene / "belvedere.json", mood="calm")
    save_views(read_views(scene), scene, force=True)  # into itself
    after = json.loads((scene / "transforms.json").read_text())
    assert after["aabb_scale"] == 4
    assert "ply_file_path" not in after
    assert [frame.get("sharpness") for frame in after["frames"]] == [None, 31.5, None]
    manifest = json.loads((scene / "belvedere.json").read_text())
    assert manifest["mood"] == "calm"
    assert manifest["kind"] == "views"
    assert_same(read_views(scene), views)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"version": 2}, r"version is 2, but this belvedere reads up to 1.*upgrade belvedere"),
        ({"version": 0}, "version is 0, expected a whole number from 1"),
        ({"version": None}, "has no 'version'"),
        ({"kind": "walkthrough"}, "kind is 'walkthrough', expected 'views'"),
        ({"units": "feet"}, "units is 'feet', expected 'metres'"),
    ],
)
def test_a_folder_of_another_time_or_kind_is_refused(
    tmp_path: Path, views: ViewSet, changes: dict[str, Any], message: str
) -> None:
    save_views(views, tmp_path / "scene")
    edit(tmp_path / "scene" / "belvedere.json", **changes)
    with pytest.raises(SceneError, match=message):
        read_views(tmp_path / "scene")


# ---- refusals ----------------------------------------------------------------------------------


def test_an_existing_scene_is_replaced_only_by_force(tmp_path: Path, make_views: Any) -> None:
    save_views(make_views(), tmp_path / "scene")
    other = make_views(count=2, seed=8)
    with pytest.raises(OutputError, match="scene exists: pass --force"):
        save_views(other, tmp_path / "scene")
    save_views(other, tmp_path / "scene", force=True)
    assert_same(read_views(tmp_path / "scene"), other)
    assert names(tmp_path) == ["scene"]
    assert names(tmp_path / "scene" / "images") == ["v00.png", "v01.png"]


def test_somebody_elses_folder_is_not_replaced_even_by_force(
    tmp_path: Path, views: ViewSet
) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="not a folder that belvedere wrote"):
        save_views(views, tmp_path, force=True)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_only_planar_unskewed_cameras_fit(tmp_path: Path) -> None:
    k = [[10.0, 0.5, 3], [0, 10.0, 2], [0, 0, 1]]
    color, disparity = np.zeros((4, 6, 3), np.uint8), np.ones((4, 6), np.float32)
    skewed = ViewSet.of(
        [ReferenceView(Camera.from_intrinsics(k, np.eye(4), 6, 4), color, disparity)]
    )
    with pytest.raises(SceneError, match=r"view '0000' has skewed pixels .* write cameras\.json"):
        save_views(skewed, tmp_path / "scene")
    from belvedere.scene import SphereCamera

    sphere = SphereCamera.__new__(SphereCamera)
    entry = ViewEntry("round", sphere, False, lambda: color, None)
    with pytest.raises(SceneError, match=r"view 'round' has a SphereCamera, .* planar"):
        save_views(ViewSet((entry,)), tmp_path / "scene")
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [({"color_format": "bmp"}, "color_format is 'bmp'"),
     ({"depth_format": "png8"}, "depth_format is 'png8'"),
     ({"depth_step_m": -1.0}, "depth_step is -1")],
)  # fmt: skip
def test_unknown_options_are_refused(
    tmp_path: Path, views: ViewSet, options: Any, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        save_views(views, tmp_path / "scene", **options)
    assert names(tmp_path) == []


# ---- interruption ------------------------------------------------------------------------------


def stop_after(count: int) -> Any:
    def progress(done: int, total: int, what: str) -> None:
        assert (total, what) == (3, "writing views")
        if done == count:
            raise KeyboardInterrupt

    return progress


def test_an_interrupted_save_leaves_nothing_that_opens_and_is_resumed(
    tmp_path: Path, views: ViewSet
) -> None:
    scene, partial = tmp_path / "scene", staging_path(tmp_path / "scene")
    with pytest.raises(KeyboardInterrupt):
        save_views(views, scene, progress=stop_after(2))
    assert not scene.exists()
    with pytest.raises(BelvedereError):
        read_views(partial)
    done = save_views(views, scene)
    assert done.resumed == 2
    save_views(views, tmp_path / "straight")
    assert fingerprints(scene) == fingerprints(tmp_path / "straight")
    assert names(tmp_path) == ["scene", "straight"]


def test_a_resumed_save_takes_over_only_what_is_still_right(
    tmp_path: Path, make_views: Any, views: ViewSet
) -> None:
    scene, partial = tmp_path / "scene", staging_path(tmp_path / "scene")
    with pytest.raises(KeyboardInterrupt):
        save_views(views, scene, progress=stop_after(2))
    (partial / "images" / "v01.png").unlink()
    with (partial / "belvedere-resume.jsonl").open("a") as notes:
        notes.write('{"color": "images/v0')  # cut by the crash
    assert save_views(views, scene).resumed == 1
    assert_same(read_views(scene), views)

    other = make_views(seed=9)
    with pytest.raises(KeyboardInterrupt):
        save_views(views, scene, force=True, progress=stop_after(2), depth_format="npy")
    assert save_views(other, scene, force=True).resumed == 0  # other pixels, other format
    assert_same(read_views(scene), other)
    assert not list(scene.rglob("*.npy"))


def test_what_an_interruption_left_can_be_discarded(tmp_path: Path, views: ViewSet) -> None:
    with pytest.raises(KeyboardInterrupt):
        save_views(views, tmp_path / "scene", progress=stop_after(1))
    assert discard_partial(tmp_path / "scene")
    assert not discard_partial(tmp_path / "scene")
    assert names(tmp_path) == []


def test_an_interrupted_replacement_keeps_the_old_scene(tmp_path: Path, make_views: Any) -> None:
    views = make_views()
    save_views(views, tmp_path / "scene")
    with pytest.raises(KeyboardInterrupt):
        save_views(make_views(seed=3), tmp_path / "scene", force=True, progress=stop_after(2))
    assert_same(read_views(tmp_path / "scene"), views)


def test_a_killed_process_leaves_nothing_that_opens(tmp_path: Path) -> None:
    code = f"""
import os
import numpy as np
from belvedere import Camera, ReferenceView, ViewSet
from belvedere.scene.io import save_views
camera = Camera.look_at((0, -2, 1), (0, 0, 1), width=6, height=4)
view = ReferenceView(camera, np.zeros((4, 6, 3), np.uint8), np.ones((4, 6), np.float32))
save_views(ViewSet.of([view] * 3), {str(tmp_path / "scene")!r},
           progress=lambda done, total, what: os._exit(9) if done == 2 else None)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.returncode == 9, done.stderr
    assert not (tmp_path / "scene").exists()
    assert os.listdir(tmp_path) == [".scene.belvedere-partial"]


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file sizes there")
def test_a_full_disk_is_named_and_leaves_nothing(tmp_path: Path) -> None:
    code = f"""
import resource, signal
import numpy as np
from belvedere import Camera, ReferenceView, ViewSet
from belvedere.ground.errors import OutputError
from belvedere.scene.io import save_views
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
camera = Camera.look_at((0, -2, 1), (0, 0, 1), width=100, height=100)
noise = np.random.default_rng(1).integers(0, 256, (100, 100, 3), dtype=np.uint8)
view = ReferenceView(camera, noise, np.ones((100, 100), np.float32))
try:
    save_views(ViewSet.of([view]), {str(tmp_path / "scene")!r})
except OutputError as error:
    print(error)
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "the disk is full" in out.stdout
    assert names(tmp_path) == []
