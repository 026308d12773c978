"""From a building model to a scene that can be walked through."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")

from belvedere.ground.errors import (
    BelvedereError,
    FileFormatError,
    MissingFileError,
    OutputError,
    SceneError,
)
from belvedere.model import Building, Room, write_glb
from belvedere.scene import Scene
from belvedere.scene.io import read_views
from belvedere.studio.scenes import open_scene
from belvedere.studio.walkthrough import cameras_of, frames_along, walk
from belvedere.walkthrough import (
    CellGraph,
    CellImageOptions,
    FreeSpace,
    PlacementOptions,
    PrepareOptions,
    WalkOptions,
    Walkthrough,
    estimate,
    load_graph,
    prepare,
    save_graph,
)
from tests.walkthrough import plans

QUICK = PrepareOptions(rays=4, references=PlacementOptions(count=2, texels=32))


def digest_of(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def flat(tmp_path_factory) -> Path:
    target = tmp_path_factory.mktemp("prepared") / "flat"
    prepare("built-in:flat", target, options=QUICK, workers=2)
    return target


def test_the_folder_holds_what_it_says(flat: Path) -> None:
    manifest = json.loads((flat / "belvedere.json").read_text())
    assert (manifest["kind"], manifest["version"]) == ("walkthrough", 1)
    counts = manifest["counts"]
    assert counts["cells"] == 2
    assert counts["references"] == sum(
        len(read_views(side)) for side in (flat / "references").iterdir()
    )
    names = {path.name for path in flat.iterdir()}
    assert {
        "cells.json",
        "free.npz",
        "model.glb",
        "model.lit",
        "path.json",
        "plan.png",
        "plan.svg",
    } <= names
    assert not [path for path in flat.rglob("*") if "partial" in path.name]


def test_it_is_a_scene(flat: Path) -> None:
    scene = open_scene(flat)
    assert isinstance(scene, Walkthrough)
    assert isinstance(scene, Scene)
    assert scene.affords.geometry == "global"
    frame = scene.render(scene.home.resized(64, 48))
    assert frame.hole_fraction == 0.0
    assert scene.viewing_region.contains(scene.home.center)


def test_a_preparation_that_was_interrupted_ends_with_the_same_bytes(flat, tmp_path) -> None:
    target = tmp_path / "flat"
    stopped = []

    def stop(done: int, total: int, what: str) -> None:
        if what == "taking references" and done == 1 and not stopped:
            stopped.append(total)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        prepare("built-in:flat", target, options=QUICK, workers=1, progress=stop)
    assert stopped
    assert not target.exists()
    prepare("built-in:flat", target, options=QUICK, workers=1)
    assert digest_of(target) == digest_of(flat)


def test_heavy_cells_are_photographed_from_inside(tmp_path: Path) -> None:
    """Interrupted between two places, it ends with the bytes of an uninterrupted preparation."""
    inside = CellImageOptions(polygons=0, texels=32, spacing=3.0)
    options = replace(QUICK, inside=inside)
    stopped = []

    def stop(done: int, total: int, what: str) -> None:
        if what == "taking pictures inside cells" and done == 1 and not stopped:
            stopped.append(total)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        prepare("built-in:flat", tmp_path / "a", options=options, workers=1, progress=stop)
    made = prepare("built-in:flat", tmp_path / "a", options=options, workers=1)
    prepare("built-in:flat", tmp_path / "b", options=options, workers=2)
    assert digest_of(tmp_path / "a") == digest_of(tmp_path / "b")
    assert made.inside == 6 * stopped[0] > 0
    guess = estimate("built-in:flat", options)
    assert guess.inside % 6 == 0
    assert made.inside / 3 <= guess.inside <= 6 * made.inside
    scene = Walkthrough.open(tmp_path / "a")
    assert sorted(scene.cell_images) == [0, 1]
    walker = scene.walker()
    assert walker.frame(scene.home.resized(96, 72)).hole_fraction == 0.0
    assert walker.statistics.pictured_cells >= 1
    shutil.rmtree(tmp_path / "a" / "references" / "c000-e00" / "images")
    with pytest.raises(BelvedereError, match="c000-e00"):
        Walkthrough.open(tmp_path / "a").cell_images[0].views[0]
    shutil.rmtree(tmp_path / "a" / "references" / "c000-e00")
    with pytest.raises(MissingFileError, match="c000-e00 is missing"):
        Walkthrough.open(tmp_path / "a")
    (tmp_path / "b" / "places.json").unlink()
    with pytest.raises(MissingFileError, match=r"places\.json"):
        Walkthrough.open(tmp_path / "b")


def test_pictures_that_are_gone_and_cells_that_changed_are_noticed(flat: Path, tmp_path) -> None:
    gone = Path(shutil.copytree(flat, tmp_path / "gone"))
    shutil.rmtree(next((gone / "references").iterdir()))
    with pytest.raises(MissingFileError, match=r"references/p\d+-c\d+ is missing"):
        Walkthrough.open(gone)
    changed = Path(shutil.copytree(flat, tmp_path / "changed"))
    graph = load_graph(changed / "cells.json")
    save_graph(CellGraph(graph.cells, graph.portals[::-1]), changed / "cells.json")
    with pytest.raises(SceneError, match="--cells-file"):
        Walkthrough.open(changed)


def test_what_is_there_is_not_overwritten(flat: Path) -> None:
    before = digest_of(flat)
    with pytest.raises(OutputError, match="--force"):
        prepare("built-in:flat", flat, options=QUICK)
    assert digest_of(flat) == before


def test_an_estimate_writes_nothing_and_counts_right(flat: Path, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    guess = estimate("built-in:flat", QUICK)
    counts = json.loads((flat / "belvedere.json").read_text())["counts"]
    assert (guess.cells, guess.portals) == (counts["cells"], counts["portals"])
    assert guess.references >= counts["references"]
    assert guess.minutes > 0.0
    assert guess.summary.startswith("2 cells, 4 portals, at most 4 references, about ")
    assert guess.summary.endswith("less than a minute")
    assert not list(tmp_path.iterdir())


def test_a_model_of_ones_own_is_prepared(interior_mesh, tmp_path) -> None:
    """A GLB that states nothing: its rooms are found, light and a walk are made."""
    model = tmp_path / "mine.glb"
    write_glb(model, interior_mesh)
    made = prepare(model, tmp_path / "scene", options=QUICK)
    assert len(made.cells) >= 3
    assert made.doors >= 3
    scene = Walkthrough.open(tmp_path / "scene")
    assert scene.path is not None
    cameras = frames_along(scene.path, 3, (64, 48))
    assert walk(scene, cameras).frames[0].cells >= 1


def test_rooms_that_are_found_get_lamps(tmp_path: Path) -> None:
    """A building without windows that states no rooms is no cave."""
    model = tmp_path / "closed.glb"
    write_glb(model, plans.two_rooms())
    prepare(model, tmp_path / "scene", options=QUICK)
    scene = Walkthrough.open(tmp_path / "scene")
    assert scene.path is not None
    for frame in map(scene.render, frames_along(scene.path, 3, (48, 36))):
        assert frame.color.mean() > 40


def test_a_model_without_rooms_is_refused_before_it_is_lit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = tmp_path / "slab.glb"
    write_glb(model, plans.slab((0, 0), (5, 5), 0.0))
    monkeypatch.setattr("belvedere.model.light_model", None)
    with pytest.raises(SceneError, match="no floor"):
        prepare(model, tmp_path / "scene", options=QUICK)
    assert list(tmp_path.iterdir()) == [model]


def test_walking_measures_every_frame(flat: Path) -> None:
    scene = Walkthrough.open(flat)
    cameras = cameras_of(scene, "recorded", 6, (96, 72))
    result = walk(scene, cameras, WalkOptions(mode="two"), compare=True)
    found = result.as_dict()
    assert found["frames"] == 6
    assert found["psnr"] > 25.0
    assert found["ssim"] > 0.8
    assert found["speedup_overall"] > 0.0
    assert len(result.lines()) == 3
    plain = walk(scene, cameras, WalkOptions(mode="culling")).as_dict()
    assert plain["psnr"] is None
    assert plain["holes_mean_percent"] == 0.0


def test_a_random_walk_stays_inside(flat: Path) -> None:
    scene = Walkthrough.open(flat)
    eyes = np.array([camera.center for camera in cameras_of(scene, "random", 20, (32, 24), 5)])
    low, high = scene.viewing_region.low, scene.viewing_region.high
    assert ((eyes > low - 0.5) & (eyes < high + 0.5)).all()


def test_free_space_is_read_from_the_scene_or_found_where_it_holds_none(
    flat: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "old"
    shutil.copytree(flat, old)
    (old / "free.npz").unlink()

    def strolled(folder: Path) -> np.ndarray:
        cameras = cameras_of(Walkthrough.open(folder), "random", 9, (32, 24), 3)
        return np.array([camera.camera_to_world for camera in cameras])

    found = strolled(old)
    with monkeypatch.context() as patch:
        patch.setattr(FreeSpace, "of_mesh", None)
        np.testing.assert_array_equal(strolled(flat), found)
    (old / "free.npz").write_bytes((flat / "free.npz").read_bytes()[:5000])
    with pytest.raises(FileFormatError, match=r"free\.npz"):
        strolled(old)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: (f / "cells.json").unlink(), "cells.json"),
        (lambda f: (f / "model.lit").write_bytes(b"BELVLIT2"), "model.lit"),
        (lambda f: (f / "belvedere.json").write_text('{"kind": "walkthrough"}'), "version"),
        (lambda f: (f / "belvedere.json").write_text('{"kind": "walkthrough", "version": 99}'),
         "update belvedere"),
        (lambda f: (f / "belvedere.json").write_text('{"kind": "views"}'), "kind 'views'"),
    ],
)  # fmt: skip
def test_a_spoilt_folder_says_what_is_wrong(flat: Path, tmp_path, change, says: str) -> None:
    spoilt = tmp_path / "spoilt"
    shutil.copytree(flat, spoilt)
    change(spoilt)
    with pytest.raises((SceneError, MissingFileError), match=says):
        Walkthrough.open(spoilt)


def test_what_is_no_prepared_building_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match="there is no such folder"):
        Walkthrough.open(tmp_path / "nowhere")
    with pytest.raises(MissingFileError, match=r"is no prepared building.*belvedere prepare"):
        Walkthrough.open(tmp_path)


def test_models_of_no_use_are_refused(tmp_path, interior_mesh) -> None:
    with pytest.raises(MissingFileError, match="no such file"):
        prepare(tmp_path / "nothing.glb", tmp_path / "scene")
    with pytest.raises(ValueError, match="castle"):
        prepare("built-in:castle", tmp_path / "scene")
    model = tmp_path / "mine.glb"
    write_glb(model, interior_mesh)
    with pytest.raises(SceneError, match="states no rooms"):
        prepare(model, tmp_path / "other", options=PrepareOptions(cells="stated", rays=4))
    far = Building((Room("far", (np.array([[90, 90], [95, 90], [95, 95.0]]),), 0.0, 2.5),))
    model = tmp_path / "far.glb"
    write_glb(model, interior_mesh, far)
    with pytest.raises(SceneError):
        prepare(model, tmp_path / "third", options=PrepareOptions(rays=4))
    assert not (tmp_path / "scene").exists()
