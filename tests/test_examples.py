"""Every example runs, quickly and without a warning, and makes the pictures that it speaks of."""

from __future__ import annotations

import ast
import functools
import re
import runpy
import sys
from pathlib import Path

import pytest

from belvedere import model
from belvedere.scene.io import image_size
from tests.documents import EXAMPLES, ROOT

_one_house = functools.cache(model.build_interior)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_makes_the_pictures_it_speaks_of(
    example: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(model, "build_interior", _one_house)  # built once, from its seed
    monkeypatch.setattr(sys, "argv", [str(example), str(tmp_path)])
    runpy.run_path(str(example), run_name="__main__")

    text = ast.get_docstring(ast.parse(example.read_text(encoding="utf-8"))) or ""
    promised = re.findall(r"`([\w-]+\.(?:png|mp4))`", text)
    assert promised
    for name in promised:
        assert (tmp_path / name).stat().st_size > 0
        if name.endswith(".png"):
            assert min(image_size(tmp_path / name)) > 100
    assert capsys.readouterr().out.strip(), "an example tells what it found"


def test_there_are_examples_of_every_room_that_shows_something() -> None:
    assert {example.parent.name for example in EXAMPLES} >= {"01_scene", "02_warp", "03_studio"}
    assert len(EXAMPLES) >= 8


def test_examples_use_no_data_from_outside() -> None:
    for example in EXAMPLES:
        assert "shared" not in example.read_text(encoding="utf-8"), example.relative_to(ROOT)
