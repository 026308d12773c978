from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from belvedere.ground.errors import SceneError, ViewError
from belvedere.scene import Camera, ReferenceView, ViewEntry, ViewSet

CAMERA = Camera.look_at((0, 0, 0), (0, 1, 0), width=4, height=3)
VIEW_BYTES = 3 * 4 * (3 + 4)


def view(value: int) -> ReferenceView:
    return ReferenceView(CAMERA, np.full((3, 4, 3), value, np.uint8), np.ones((3, 4), np.float32))


def counted(count: int) -> tuple[tuple[ViewEntry, ...], list[int]]:
    """Entries that note each loading of theirs in a list."""
    loads: list[int] = []

    def loader(index: int) -> Callable[[], ReferenceView]:
        def load() -> ReferenceView:
            loads.append(index)
            return view(index)

        return load

    entries = tuple(
        ViewEntry(f"v{i}", CAMERA, True, lambda i=i: view(i).color, loader(i)) for i in range(count)
    )
    return entries, loads


def test_nothing_is_loaded_before_it_is_asked_for() -> None:
    entries, loads = counted(3)
    views = ViewSet(entries)
    assert (len(views), views.names) == (3, ("v0", "v1", "v2"))
    assert views.cameras == (CAMERA,) * 3
    assert views.has_depth
    assert loads == []
    assert views[1].color[0, 0, 0] == 1
    assert loads == [1]


def test_what_was_loaded_is_kept_up_to_the_limit_least_recently_used_first_out() -> None:
    entries, loads = counted(3)
    views = ViewSet(entries, cache_bytes=2 * VIEW_BYTES)
    first, second = views[0], views[1]
    assert views[0] is first  # now view 1 is the one longest unused
    _ = views[2]
    assert views[0] is first
    assert loads == [0, 1, 2]
    assert views[1] is not second
    assert loads == [0, 1, 2, 1]


def test_the_view_asked_for_is_held_however_small_the_limit() -> None:
    entries, loads = counted(2)
    views = ViewSet(entries, cache_bytes=0)
    assert views[0] is views[0]
    _ = views[1]
    _ = views[0]
    assert loads == [0, 1, 0]


def test_negative_indices_count_from_the_end_and_slices_give_smaller_sets() -> None:
    views = ViewSet.of([view(i) for i in range(5)])
    assert views[-1].color[0, 0, 0] == 4
    assert views[1:4].names == ("0001", "0002", "0003")
    assert views[::-2].names == ("0004", "0002", "0000")
    assert views.select([3, 0]).names == ("0003", "0000")
    assert [v.color[0, 0, 0] for v in views] == [0, 1, 2, 3, 4]
    with pytest.raises(IndexError, match=r"ViewSet has 5 views, there is no view 5"):
        _ = views[5]
    with pytest.raises(SceneError, match=r"ViewSet.entries is empty"):
        _ = views[5:]


def test_a_picture_without_depth_shows_its_colour_only() -> None:
    views = ViewSet((ViewEntry("a", CAMERA, False, lambda: view(7).color, None),))
    assert not views.has_depth
    assert views.color(0)[0, 0, 0] == 7
    with pytest.raises(SceneError, match=r"view 'a' has no depth, so it cannot be warped: add a"):
        _ = views[0]


def test_several_threads_get_the_same_pixels() -> None:
    entries, _ = counted(8)
    views = ViewSet(entries, cache_bytes=3 * VIEW_BYTES)
    with ThreadPoolExecutor(4) as pool:
        values = list(pool.map(lambda i: int(views[i % 8].color[0, 0, 0]), range(200)))
    assert values == [i % 8 for i in range(200)]


def test_names_tell_views_apart() -> None:
    with pytest.raises(SceneError, match=r"two views are called 'a': names tell views apart"):
        ViewSet.of([view(0), view(1)], ["a", "a"])
    with pytest.raises(ViewError, match=r"ViewSet.names has 1 names for 2 views"):
        ViewSet.of([view(0), view(1)], ["a"])


def test_sets_that_cannot_be_are_refused() -> None:
    with pytest.raises(SceneError, match=r"ViewSet.entries is empty, expected at least one view"):
        ViewSet.of([])
    with pytest.raises(ViewError, match=r"ViewSet.views\[1\] is a Camera, expected a ReferenceVi"):
        ViewSet.of([view(0), CAMERA])  # type: ignore[list-item]
