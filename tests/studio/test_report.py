"""The report: one page that needs nothing else, and a file for programs."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import InputError, OutputError
from belvedere.scene import ViewSet
from belvedere.studio import evaluate as evaluate_module
from belvedere.studio import report as report_module
from belvedere.studio._chart import Line, psnr_chart, short_names
from belvedere.studio._pictures import MAX_VIEWS, PictureCollector, data_uri, shrink
from belvedere.studio.report import evaluate_to_report
from tests.studio.tiny_scenes import copying, row_of_views


@pytest.fixture(autouse=True)
def no_warp(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports are tested with a predictor that needs no kernels."""
    monkeypatch.setattr(evaluate_module, "_warp_predictor", lambda *_: copying)


def make(folder: Path, views: ViewSet | None = None, **options: Any) -> str:
    evaluate_to_report(
        views or row_of_views(5), folder / "out", title="A <b>row</b> & more",
        command=["belvedere", "evaluate", "my scene"], repeats=1, **options,
    )  # fmt: skip
    return (folder / "out" / "report.html").read_text("utf-8")


class Checker(HTMLParser):
    """Every tag closed in its turn, and every address the page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.addresses += [v or "" for k, v in attrs if k in ("src", "href", "action", "srcset")]
        if tag not in ("meta", "img", "br", "link", "path", "circle", "polygon", "line"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in ("path", "circle", "polygon", "line"):
            assert self.open.pop() == tag


def test_the_page_is_well_formed_and_loads_nothing_from_outside(tmp_path: Path) -> None:
    page = make(tmp_path, reconstructions=("point", "splat"))
    checker = Checker()
    checker.feed(page)
    assert checker.open == []
    assert len(checker.addresses) == 2 * (1 + 2 * 3)
    assert all(address.startswith("data:image/webp;base64,") for address in checker.addresses)
    assert not re.search(r"https?://|url\(|@import", page)


def test_text_from_outside_is_escaped(tmp_path: Path) -> None:
    views = row_of_views(5)
    names = ["<script>alert(1)</script>", *views.names[1:]]
    page = make(tmp_path, ViewSet.of(list(views), names), hold_out=4)
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "A &lt;b&gt;row&lt;/b&gt; &amp; more" in page
    assert "belvedere evaluate &#x27;my scene&#x27;" in page


def test_the_json_holds_every_number_and_the_machine(tmp_path: Path) -> None:
    make(tmp_path)
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert (data["schema"], data["version"]) == ("belvedere.report", 1)
    assert data["title"] == "A <b>row</b> & more"
    assert data["machine"]["threads"] >= 1
    assert [row["view"] for row in data["evaluation"]["views"]] == ["view_00", "view_04"]
    assert data["evaluation"]["summary"][0]["views"] == 2
    assert data["evaluation"]["options"]["hold_out"] == 4


def test_a_report_is_not_overwritten_without_force(tmp_path: Path) -> None:
    make(tmp_path)
    with pytest.raises(OutputError, match="exists: pass --force"):
        make(tmp_path)
    assert "view_04" in make(tmp_path, force=True)


def test_a_folder_that_is_no_report_is_not_replaced_even_with_force(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "precious.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"not a folder that belvedere wrote"):
        make(tmp_path, force=True)
    assert (tmp_path / "out" / "precious.txt").read_text() == "mine"


def test_a_report_that_fails_half_way_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(report_module, "write_json", broken)
    with pytest.raises(KeyboardInterrupt):
        make(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_pictures_of_many_views_are_a_sample_and_fit_the_page() -> None:
    names = [f"{i:03d}" for i in range(100)]
    collector = PictureCollector(names, 5)
    assert len(collector.shown) == MAX_VIEWS
    assert collector.shown[0] == "000"
    assert collector.shown[-1] == "099"
    noise = np.random.default_rng(1).integers(0, 256, (300, 360, 3), dtype=np.uint8)
    count = MAX_VIEWS * (1 + 3 * 5)
    assert len(data_uri(noise, 4_000_000 // count)) * count < 6_000_000


def test_small_copies_average_light_not_codes() -> None:
    stripes = np.zeros((8, 8, 3), np.uint8)
    stripes[:, ::2] = 255
    assert abs(int(shrink(stripes, 4)[0, 0, 0]) - 188) <= 1  # half the light, not half the code


def test_the_chart_has_a_mark_for_each_measured_view_and_none_for_gaps() -> None:
    line = Line("a", (20.0, float("nan"), float("inf")), 0)
    chart = psnr_chart(["x", "y", "z"], [line], 400)
    assert chart.count("<circle") == 2
    assert "z: a identical" in chart


@pytest.mark.parametrize("width", [340, 400, 760])
@pytest.mark.parametrize("values", [(27.5, 29.1), (29.4, 29.5), (-3.2, 104.0), (20.0, 40.0), ()])
def test_no_text_of_the_chart_begins_left_of_it(values: tuple[float, ...], width: int) -> None:
    chart = psnr_chart([f"v{i}" for i in range(len(values))], [Line("a", values, 0)], width)
    ticks = re.findall(r'<text class="tick" x="([\d.-]+)"[^>]*text-anchor="(\w+)">([^<]*)<', chart)
    assert sum("dB" in text for _, _, text in ticks) == 1
    for x, anchor, text in ticks:
        wide = 7.5 * len(text)  # a wide face at 13 pixels
        assert float(x) - wide * {"end": 1.0, "middle": 0.5}[anchor] >= 0, text


def test_a_wrong_reconstruction_is_refused_before_the_report_that_exists(tmp_path: Path) -> None:
    make(tmp_path)
    with pytest.raises(InputError, match="'foo'"):
        make(tmp_path, reconstructions=("foo",))


@pytest.mark.parametrize(
    ("names", "short"),
    [
        (["left", "right"], ["left", "right"]),
        (["frame_00012.png", "frame_00345.png"], ["00012", "00345"]),
        (["a/long/name/of/a/folder", "another one altogether"], ["1", "2"]),
        (["only-one-long-name"], ["1"]),
    ],
)
def test_chart_labels_are_short_and_tell_views_apart(names: list[str], short: list[str]) -> None:
    assert short_names(names) == short
