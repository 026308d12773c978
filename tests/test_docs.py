"""The documentation is true: its code runs, its figures are drawn by it, its site builds."""

from __future__ import annotations

import doctest
import functools
import importlib
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import belvedere as bv
from belvedere import cli, model
from belvedere.model import build_interior, photograph
from tests.documents import EXAMPLES, PAGES, ROOT, SHOWN_ONLY, Block, blocks, make_captures, page_id

ROOMS = ("belvedere", "belvedere.ground", "belvedere.scene", "belvedere.scene.io",
         "belvedere.warp", "belvedere.model", "belvedere.walkthrough",
         "belvedere.studio")  # fmt: skip
LARGEST_PICTURE = 300_000


@pytest.fixture(scope="module")
def captures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight views of the built-in living room, in the folders that the pages open."""
    folder = tmp_path_factory.mktemp("captures")
    house = build_interior(seed=0, rays=16)
    cameras = house.reference_cameras(48, width=160, height=128)[4:12]
    views = [photograph(house, camera) for camera in cameras]
    make_captures(folder, bv.ViewSet.of(views, [f"view_{k}" for k in range(len(views))]))
    return folder


def run_command(line: str) -> int:
    """The exit status of one line of a console block."""
    words = shlex.split(line, comments=True)
    assert words[0] == "belvedere", f"only belvedere is run, not {line!r}"
    return cli.run(words[1:])


@pytest.mark.parametrize("page", PAGES, ids=page_id)
def test_every_block_of_a_page_runs(
    page: Path,
    captures: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    work = tmp_path / "work"
    if not any(block.runs for block in blocks(page)):
        return
    shutil.copytree(captures, work)
    monkeypatch.chdir(work)
    monkeypatch.setattr(model, "build_interior", functools.cache(build_interior))
    names: dict[str, object] = {"__name__": "__page__"}
    for block in blocks(page):
        if block.printed:
            printed = capsys.readouterr().out
            matches = doctest.OutputChecker().check_output(
                "..." + block.code, "\n" + printed, doctest.ELLIPSIS
            )
            assert matches, f"{block.place}: the page's code printed {printed!r}"
        elif not block.runs:
            continue
        elif block.language == "bash":
            for line in filter(None, map(str.strip, block.code.splitlines())):
                status = run_command(line)
                assert status == 0, f"{block.place}: {line} ended with {status}"
        else:
            exec(compile("\n" * block.line + block.code, str(page), "exec"), names)


def test_every_block_is_run_shown_or_says_why_not() -> None:
    for page in PAGES:
        for block in blocks(page):
            known = block.language in ("python", "bash", *SHOWN_ONLY)
            assert known, f"{block.place}: a block of {block.language!r} is neither run nor shown"
            if block.reason is not None:
                assert len(block.reason) > 10, f"{block.place}: say why it is not run"
        fences = len(re.findall(r"^ *```", page.read_text(encoding="utf-8"), re.MULTILINE))
        assert fences == 2 * len(blocks(page)), f"{page.name}: a fence is not closed"


def test_few_blocks_are_not_run() -> None:
    held_back = [block.place for page in PAGES for block in blocks(page) if block.reason]
    assert len(held_back) <= 4, held_back


def run_code() -> list[Block]:
    return [block for page in PAGES for block in blocks(page) if block.runs]


@pytest.mark.parametrize("room", ROOMS)
def test_every_public_name_has_an_example_that_runs(room: str) -> None:
    code = "\n".join(block.code for block in run_code() if block.language == "python")
    code += "\n".join(example.read_text(encoding="utf-8") for example in EXAMPLES)
    words = set(re.findall(r"\w+", code))
    missing = sorted(set(importlib.import_module(room).__all__) - words)
    assert not missing, f"{room}: no example in docs/, README.md or examples/ uses {missing}"


def test_every_command_has_an_example_that_runs() -> None:
    from belvedere.cli.app import app

    commands = {
        command.name or (command.callback.__name__ if command.callback else "")
        for command in app.registered_commands
    }
    lines = [line for block in run_code() if block.language == "bash"
             for line in block.code.splitlines()]  # fmt: skip
    shown = {words[1] for line in lines if len(words := line.split()) > 1}
    assert commands <= shown, f"no page runs belvedere {sorted(commands - shown)}"


def test_the_figures_are_what_their_script_draws(tmp_path: Path) -> None:
    script = ROOT / "docs" / "figures" / "make_figures.py"
    subprocess.run([sys.executable, str(script), str(tmp_path)], check=True)
    drawn = sorted(tmp_path.glob("*.svg"))
    assert drawn
    for figure in drawn:
        kept = ROOT / "docs" / "figures" / figure.name
        assert kept.read_text(encoding="utf-8") == figure.read_text(encoding="utf-8"), (
            f"{figure.name} differs from its script: run make figures"
        )


def test_the_drawn_house_has_the_rooms_that_the_floors_allow() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = settings["tool"]["importlinter"]["contracts"]
    rooms = [room.strip() for layer in contract["layers"] for room in layer.split("|")]
    drawing = (ROOT / "docs" / "figures" / "floors.svg").read_text(encoding="utf-8")
    table = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for room in (name for name in rooms if not name.startswith("_")):
        assert f">{room}</text>" in drawing, room
        assert f"rooms/{room}.md" in table, room


def test_the_gallery_shows_every_example() -> None:
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    for example in EXAMPLES:
        name = example.relative_to(ROOT).as_posix()
        assert f"python {name}" in page, f"{name} is not in the gallery: run make gallery"
        title = example.read_text(encoding="utf-8").split('"""')[1].splitlines()[0].rstrip(".")
        assert f"## {title}\n" in page, f"{name}: its title changed: run make gallery"
    for name in re.findall(r"gallery/([\w.-]+)", page):
        assert (ROOT / "docs" / "gallery" / name).is_file(), name
    for picture in (ROOT / "docs" / "gallery").iterdir():
        assert picture.stat().st_size <= LARGEST_PICTURE, picture.name


def test_the_bibliography_page_lists_every_entry() -> None:
    keys = re.findall(r"^@\w+\{(\w+),", (ROOT / "docs/bibliography.bib").read_text(), re.MULTILINE)
    page = (ROOT / "docs/bibliography.md").read_text(encoding="utf-8")
    assert keys
    assert [key for key in keys if f"`{key}`" not in page] == []


def test_links_of_the_readme_lead_to_files() -> None:
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md"):
        for link in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
            assert (ROOT / link).exists(), f"{page.name}: {link}"


def test_the_site_builds_without_a_warning_and_fetches_nothing(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    built = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert built.returncode == 0, built.stderr
    assert "WARNING" not in built.stderr, built.stderr
    fetched = re.compile(r'<(?:script|link|img|video|iframe)[^>]*(?:src|href)="(https?:[^"]+)"')
    for room in ROOMS:
        name = room.removeprefix("belvedere.").replace(".", "-")
        page = (tmp_path / "reference" / name / "index.html").read_text(encoding="utf-8")
        words = set(re.findall(r"\w+", page))
        missing = sorted(set(importlib.import_module(room).__all__) - words)
        assert not missing, f"the reference of {room} lacks {missing}"
    for page in tmp_path.rglob("*.html"):
        assert fetched.findall(page.read_text(encoding="utf-8")) == [], page.name


def test_docstrings_become_markdown() -> None:
    prose = runpy.run_path(str(ROOT / "docs" / "griffe_prose.py"))["to_markdown"]
    assert prose("As ``x``::\n\n    a = 1\n") == "As `x`:\n\n    a = 1"
    table = prose("====  ====\na     b\n====  ====\n\nafter")
    assert table.splitlines()[:2] == ["", "```text"]
    assert table.splitlines()[-3:] == ["```", "", "after"]
