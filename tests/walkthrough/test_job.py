"""The record of a preparation."""

from __future__ import annotations

import pytest

from belvedere.ground.errors import OutputError
from belvedere.walkthrough.job import PrepareJob

JOB = {"model": "house.glb", "digest": "abc", "options": {"texels": 256}}


def start(target, description=JOB, force=False):
    return PrepareJob.working_on(target, description, force)


def interrupted(target, error) -> None:
    with start(target) as job:
        (job.folder / "piece").write_text("whole")
        raise error("stop")


def test_the_folder_appears_when_all_is_done(tmp_path) -> None:
    target = tmp_path / "scene"
    with start(target) as job:
        (job.folder / "belvedere.json").write_text("{}")
        (job.folder / "references").mkdir()
        (job.folder / "references" / ".x.belvedere-partial.png").write_text("half")
        assert not target.exists()
    left = sorted(p.relative_to(target).as_posix() for p in target.rglob("*"))
    assert left == ["belvedere.json", "references"]
    assert [p.name for p in tmp_path.iterdir()] == ["scene"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError, OutputError])
def test_what_was_complete_is_found_again_whatever_ended_the_call(tmp_path, error) -> None:
    target = tmp_path / "scene"
    with pytest.raises(error):
        interrupted(target, error)
    assert not target.exists()
    with start(target) as job:
        assert (job.folder / "piece").read_text() == "whole"


def test_a_call_that_made_nothing_leaves_nothing(tmp_path) -> None:
    with pytest.raises(RuntimeError), start(tmp_path / "scene"):
        raise RuntimeError("no floor")
    assert list(tmp_path.iterdir()) == []


def test_another_job_is_not_mixed_with_it(tmp_path) -> None:
    target = tmp_path / "scene"
    with pytest.raises(KeyboardInterrupt):
        interrupted(target, KeyboardInterrupt)
    other = JOB | {"options": {"texels": 128}}
    with pytest.raises(OutputError, match="another options waits"), start(target, other):
        pass
    with start(target, other, force=True) as job:
        assert not (job.folder / "piece").exists()


def test_a_folder_without_a_record_is_not_trusted(tmp_path) -> None:
    target = tmp_path / "scene"
    folder = tmp_path / ".scene.belvedere-partial"
    folder.mkdir()
    (folder / "job.json").write_text('{"model": ')
    (folder / "piece").write_text("whole")
    with start(target) as job:
        assert not (job.folder / "piece").exists()


def test_what_is_there_is_not_overwritten(tmp_path) -> None:
    target = tmp_path / "scene"
    with start(target) as job:
        (job.folder / "belvedere.json").write_text("{}")
    with pytest.raises(OutputError, match="--force"), start(target):
        pass
    with start(target, force=True) as job:
        (job.folder / "belvedere.json").write_text("{}")
    mine = tmp_path / "letters"
    mine.mkdir()
    (mine / "diary.txt").write_text("dear")
    with pytest.raises(OutputError, match="not a folder that belvedere wrote"):
        start(mine, force=True).__enter__()
    assert (mine / "diary.txt").read_text() == "dear"


def test_two_calls_do_not_work_on_one_folder(tmp_path) -> None:
    target = tmp_path / "scene"
    with (
        start(target),
        pytest.raises(OutputError, match="another process"),
        start(target),
    ):
        pass
