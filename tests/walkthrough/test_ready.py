"""References kept ready."""

from __future__ import annotations

import numpy as np

from belvedere.scene import Camera, ReferenceView
from belvedere.walkthrough.ready import SAMPLE_BYTES, ReadyReferences


def view() -> ReferenceView:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), width=16, height=12, fov_deg=60)
    color = np.zeros((12, 16, 3), np.uint8)
    return ReferenceView(camera, color, np.ones((12, 16), np.float32))


EACH = view().nbytes + SAMPLE_BYTES * 12 * 16


def test_each_is_prepared_once() -> None:
    ready, loads = ReadyReferences(), []
    for name in "abab":
        ready.get(name, lambda name=name: loads.append(name) or view())
    assert loads == ["a", "b"]
    assert ready.get("a", view) is ready.get("a", view)


def test_the_longest_unseen_is_forgotten_first() -> None:
    ready = ReadyReferences(kept_bytes=2 * EACH)
    for name in "abac":
        ready.get(name, view)
        ready.end_frame()
    loads: list[str] = []
    for name in "acb":
        ready.get(name, lambda name=name: loads.append(name) or view())
    assert loads == ["b"]


def test_what_one_frame_shows_is_kept_whatever_it_takes() -> None:
    ready = ReadyReferences(kept_bytes=0)
    held = [ready.get(name, view) for name in "abc"]
    assert [ready.get(name, view) for name in "abc"] == held
    ready.end_frame()
    ready.get("c", view)
    ready.end_frame()
    assert len(ready) == 1


def test_it_says_when_it_is_full() -> None:
    ready = ReadyReferences(kept_bytes=EACH)
    assert not ready.full
    ready.get("a", view)
    assert ready.full
