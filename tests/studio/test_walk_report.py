"""The page of a walk: the frame with most holes, and the figures of the paper made from it."""

from __future__ import annotations

import base64
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("distributed", reason="needs dask (pip install 'belvedere[cluster]')")

from belvedere.ground.errors import OutputError
from belvedere.studio.difference import HOLE_TINT
from belvedere.studio.walk_report import paper_figures, report_walk
from belvedere.studio.walkthrough import frames_along, walk
from belvedere.walkthrough import (
    PlacementOptions,
    PrepareOptions,
    WalkOptions,
    Walkthrough,
    prepare,
)

PLACING = PlacementOptions(count=1, texels=64)


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> Walkthrough:
    target = tmp_path_factory.mktemp("prepared") / "flat"
    prepare(
        "built-in:flat", target, workers=1,
        options=PrepareOptions(rays=4, placement="arc", references=PLACING),
    )  # fmt: skip
    return Walkthrough.open(target)


def test_the_worst_frame_is_shown_with_its_holes(flat: Walkthrough, tmp_path: Path) -> None:
    assert flat.path is not None
    cameras = frames_along(flat.path, 25, (96, 72))
    results = report_walk(flat, cameras, tmp_path / "report", title="A <flat>")
    numbers = json.loads((tmp_path / "report" / "report.json").read_text())
    holes = [frame.holes for frame in results["one"].frames]
    assert max(holes) > 0.01
    assert numbers["worst_frame"] == int(np.argmax(holes)) > 0

    page = (tmp_path / "report" / "report.html").read_text("utf-8")
    assert "A &lt;flat&gt;" in page
    shown = re.findall(r'<figure><img alt="(.).*?" src="data:image/\w+;base64,(.*?)"', page)
    assert [name for name, _ in shown] == list("ABCD")
    first = np.asarray(Image.open(io.BytesIO(base64.b64decode(shown[0][1]))).convert("RGB"))
    tinted = (np.abs(first.astype(int) - HOLE_TINT).max(axis=2) < 40).mean()  # JPEG blurs them
    assert tinted == pytest.approx(max(holes), abs=0.05)


def test_the_figures_mark_what_no_reference_saw(flat: Walkthrough) -> None:
    assert flat.path is not None
    cameras = frames_along(flat.path, 25, (96, 72))
    walked = walk(flat, cameras[:12], WalkOptions(mode="one"))
    worst = int(np.argmax([frame.holes for frame in walked.frames]))
    figures = paper_figures(flat, cameras, worst)
    assert [caption[0] for caption in figures] == list("ABCD")
    holes = [(picture == np.array(HOLE_TINT, np.uint8)).all(axis=2) for picture in figures.values()]
    for mode, marked in zip(("one", "two", "culling"), holes, strict=False):
        walked = walk(flat, cameras[: worst + 1], WalkOptions(mode=mode))
        assert marked.mean() == pytest.approx(walked.frames[-1].holes)
    assert holes[0].mean() > 0.01 > holes[2].mean() == 0.0
    np.testing.assert_array_equal(holes[3], holes[1])  # the difference says nothing there


def test_a_report_is_not_overwritten(flat: Walkthrough, tmp_path: Path) -> None:
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "mine.txt").write_text("precious")
    with pytest.raises(OutputError):
        report_walk(flat, [flat.home.resized(32, 24)], tmp_path / "report", force=True)
    assert (tmp_path / "report" / "mine.txt").read_text() == "precious"
