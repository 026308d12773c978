"""Every command does its job and says what it wrote where."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from belvedere.scene import CameraPath
from belvedere.scene.io import read_views
from tests.cli.conftest import Program


def test_help_teaches_every_command(program: Program) -> None:
    top = program("--help")
    assert top.status == 0
    for name in ("demo", "info", "render", "evaluate", "convert", "prepare", "walk", "bench"):
        assert name in top.out
        page = program(name, "--help")
        assert page.status == 0
        assert "--" in page.out


def test_help_lists_options_under_headings(program: Program) -> None:
    page = program("prepare", "--help").out
    order = [page.index(words) for words in (
        "\nArguments:", "\n  MODEL", "\nOutput:", "  -o, --output",
        "\nCells and references:", "  --texels",
        "\nHow to read the model:", "  --units", "\nWho does the work:", "  --cluster",
    )]  # fmt: skip
    assert order == sorted(order)


def test_version_is_printed(program: Program) -> None:
    from belvedere import __version__

    assert program("--version").out.strip() == f"belvedere {__version__}"


def test_info_tells_what_a_scene_is(program: Program, kept_capture: Path) -> None:
    told = program("info", kept_capture)
    assert told.status == 0
    assert "6 views, with depth" in told.out
    assert "48x36" in told.out
    assert "movement continuous, geometry local, lighting fixed" in told.out
    assert "check" in told.out


def test_info_as_json_is_json_and_holds_the_check(program: Program, kept_capture: Path) -> None:
    told = json.loads(program("info", kept_capture, "--json").out)
    assert told["views"] == told["views_with_depth"] == 6
    assert told["affords"]["movement"] == "continuous"
    assert told["check"]["verdict"] in ("agree", "cannot tell")


def test_info_lists_views_when_asked(program: Program, kept_capture: Path) -> None:
    told = program("info", kept_capture, "--views", "--no-check")
    assert sum("48x36  at (" in line for line in told.out.splitlines()) == 6


@pytest.mark.parametrize("preset", ["wobble", "through", "orbit", "dolly"])
def test_render_makes_pictures_along_every_preset(
    program: Program, kept_capture: Path, tmp_path: Path, preset: str
) -> None:
    told = program("render", kept_capture, "--path", preset, "--frames", 3, "-o", tmp_path / "walk")
    assert told.status == 0, told.err
    assert "3 frames" in told.out
    pictures = sorted((tmp_path / "walk").glob("frame_*.png"))
    assert len(pictures) == 3
    with Image.open(pictures[0]) as picture:
        assert picture.size == (48, 36)


def test_render_makes_a_video(program: Program, kept_capture: Path, tmp_path: Path) -> None:
    import av

    video = tmp_path / "walk.mp4"
    told = program("render", kept_capture, "--frames", 5, "--size", "64x48", "-o", video, "--json")
    assert told.status == 0, told.err
    assert json.loads(told.out)["frames"] == 5
    with av.open(str(video)) as container:
        frames = list(container.decode(video=0))
    assert [(frame.width, frame.height) for frame in frames] == [(64, 48)] * 5


def test_render_makes_one_picture_from_a_path_file(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    views = read_views(kept_capture)
    path = tmp_path / "path.json"
    CameraPath.of([views.cameras[2]], [0.0]).save(path)  # type: ignore[list-item]
    picture = tmp_path / "view.png"
    told = program("render", kept_capture, "--path", path, "-o", picture, "-r", "point",
                   "--references", 1)  # fmt: skip
    assert told.status == 0, told.err
    with Image.open(picture) as image:
        np.testing.assert_array_equal(np.asarray(image), views.color(2))


def test_render_explains_a_picture_in_false_colours_beside_it(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "view.png"
    told = program("render", kept_capture, "-o", picture, "--explain", "--json")
    assert told.status == 0, told.err
    written = json.loads(told.out)["explained"]
    assert [Path(one).name for one in written] == [
        "view.source.png", "view.holes.png", "view.error.png"
    ]  # fmt: skip
    with Image.open(picture) as image:
        width, height = image.size
    for one in written:
        with Image.open(one) as image:
            assert image.width == width
            assert image.height > height  # the legend below it
    told = program("render", kept_capture, "-o", tmp_path / "other.png", "--explain")
    assert "other.error.png explain it" in told.out.replace("\n", " ")
    (tmp_path / "third.holes.png").write_bytes(b"precious")
    told = program("render", kept_capture, "-o", tmp_path / "third.png", "--explain")
    assert told.status == 2
    assert not (tmp_path / "third.png").exists()
    told = program("render", kept_capture, "-o", tmp_path / "walk.mp4", "--explain")
    assert told.status == 2
    assert "--explain goes with one picture, but the output is walk.mp4" in told.err


def test_photographs_without_depth_cannot_be_explained(
    program: Program, capture: Path, tmp_path: Path
) -> None:
    record = json.loads((capture / "transforms.json").read_text())
    for frame in record["frames"]:
        del frame["depth_file_path"]
    (capture / "transforms.json").write_text(json.dumps(record))
    told = program("render", capture, "-o", tmp_path / "view.png", "--explain")
    assert told.status == 2
    assert "--explain needs depth, which the views of capture do not have" in told.err


def test_rendering_does_not_overwrite_without_force(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "view.png"
    picture.write_bytes(b"precious")
    told = program("render", kept_capture, "-o", picture)
    assert told.status == 2
    assert "--force" in told.err
    assert picture.read_bytes() == b"precious"
    assert program("render", kept_capture, "-o", picture, "--force").status == 0
    assert picture.read_bytes() != b"precious"


def test_evaluate_writes_a_report_and_prints_the_table(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    told = program("evaluate", kept_capture, "-o", tmp_path / "report", "--hold-out", 3,
                   "-r", "point,offset", "--repeats", 1)  # fmt: skip
    assert told.status == 0, told.err
    assert "point" in told.out
    assert "offset" in told.out
    assert "dB" in told.out
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["schema"] == "belvedere.report"
    assert "<html" in (tmp_path / "report" / "report.html").read_text()


@pytest.mark.parametrize("layout", ["belvedere", "cameras.json", "colmap", "colmap-text", "tum"])
def test_convert_writes_what_can_be_read_again(
    program: Program, kept_capture: Path, tmp_path: Path, layout: str
) -> None:
    told = program("convert", kept_capture, tmp_path / "copy", "--to", layout)
    assert told.status == 0, told.err
    copy, original = read_views(tmp_path / "copy"), read_views(kept_capture)
    assert len(copy) == 6
    for ours, theirs in zip(original.cameras, copy.cameras, strict=True):
        np.testing.assert_allclose(theirs.center, ours.center, atol=1e-6)


@pytest.mark.parametrize(
    ("layout", "depth_format", "status"),
    [("colmap", "pfm", 2), ("colmap-text", "png16", 2), ("tum", "npy", 2), ("tum", "png16", 0),
     ("cameras.json", "pfm", 0), ("belvedere", "npy", 0)],
)  # fmt: skip
def test_convert_takes_a_depth_format_or_refuses_it_by_name(
    program: Program,
    kept_capture: Path,
    tmp_path: Path,
    layout: str,
    depth_format: str,
    status: int,
) -> None:
    told = program("convert", kept_capture, tmp_path / "copy", "--to", layout,
                   "--depth-format", depth_format)  # fmt: skip
    assert told.status == status, told.err
    assert (tmp_path / "copy").exists() == (status == 0)
    if status:
        assert "depth_format" in told.err
        assert f"layout '{layout}'" in told.err


def test_one_is_singular(program: Program, kept_capture: Path, tmp_path: Path) -> None:
    told = program("render", kept_capture, "--frames", 1, "-o", tmp_path / "walk")
    assert "walk: 1 frame, 48x36" in told.out


def test_a_time_beyond_the_path_is_refused_with_its_length(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    told = program("render", kept_capture, "--seconds", 4, "--at", 4.5, "-o", tmp_path / "a.png")
    assert told.status == 2
    assert "--at 4.5 lies beyond the path, which is 4 s long" in told.err
    assert not list(tmp_path.glob("*"))
    told = program("render", kept_capture, "--seconds", 4, "--at", 4, "-o", tmp_path / "a.png")
    assert told.status == 0, told.err


def test_a_wrong_reconstruction_is_refused_first(
    program: Program, kept_capture: Path, tmp_path: Path
) -> None:
    (tmp_path / "report").mkdir()
    told = program("evaluate", kept_capture, "-r", "foo", "-o", tmp_path / "report")
    assert told.status == 2
    assert "'foo'" in told.err
    assert "exists" not in told.err


def test_convert_mends_a_wrong_scale_for_good(
    program: Program, cameras_json_capture: Path, tmp_path: Path
) -> None:
    told = program("convert", cameras_json_capture, tmp_path / "mended", "--depth-scale", 0.01)
    assert told.status == 0, told.err
    wrong, mended = read_views(cameras_json_capture), read_views(tmp_path / "mended")
    ratio = wrong[0].disparity / mended[0].disparity
    np.testing.assert_allclose(ratio, 0.01 / wrong.facts["depth_scale"], rtol=1e-3)


def test_a_building_is_prepared_and_walked(program: Program, tmp_path: Path) -> None:
    """The whole road on a small scale, as scripts read it."""
    pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")
    scene = tmp_path / "flat"
    words = ("prepare", "built-in:flat", "--rays", 4, "--references", 2, "--texels", 32)
    guess = json.loads(program(*words, "--dry-run", "--json").out)
    assert guess["cells"] == 2
    made = json.loads(program(*words, "-o", scene, "--json").out)
    assert set(made) >= {
        "cells",
        "portals",
        "doors",
        "references",
        "bytes",
        "seconds",
        "cell_names",
    }
    assert made["cells"] == 2 == len(made["cell_names"])
    assert made["bytes"] == sum(p.stat().st_size for p in scene.rglob("*") if p.is_file())
    again = program(*words, "-o", scene)
    assert again.status == 2
    assert "--force" in again.err
    told = program(
        "walk", scene, "--frames", 3, "--size", "96x72", "--compare", "--json",
        "-o", tmp_path / "walk.mp4", "--report", tmp_path / "report",
    )  # fmt: skip
    found = json.loads(told.out)
    assert (found["mode"], found["frames"]) == ("two", 3)
    assert set(found["ms"]) == {"median", "p99", "cv"}
    assert found["speedup_overall"] > 0
    assert (tmp_path / "walk.mp4").stat().st_size > 1000
    page = (tmp_path / "report" / "report.html").read_text()
    assert page.count("<img") == 4
    alone = json.loads(program("walk", scene, "--frames", 2, "--size", "96x72", "--json").out)
    assert alone["psnr"] is None
    assert "walkthrough" in program("info", scene).out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["prepare", "nothing.glb"], "nothing.glb"),
        (["prepare", "built-in:castle"], "castle"),
        (["prepare", "built-in:flat", "--cluster", "tcp://x:1", "--workers", "2"], "leave it out"),
        (["walk", "nowhere"], "nowhere"),
        (["walk", ".", "--path", "random"], "belvedere.json"),
    ],
)
def test_buildings_of_no_use_are_refused(
    program: Program, tmp_path: Path, monkeypatch, words: list[str], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    told = program(*words)
    assert told.status == 2
    assert says in told.err
    assert "Traceback" not in told.err
    assert len(told.err.strip().splitlines()) <= 3
