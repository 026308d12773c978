"""A set of posed pictures, loaded when they are looked at.

What scene folders, RGB-D captures and stereo pairs all are before anything is done with them. The
pixels stay on disk until a view is asked for; the most recent ones are kept, up to a stated number
of bytes, so that a capture larger than memory can be walked through.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, overload

from belvedere.ground.errors import SceneError, ViewError
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.view import Color, ReferenceView

CACHE_BYTES = 1 << 30
"""Bytes of pixels a set keeps in memory by default (1 GiB: some 400 views of 512 x 512 x uint8)."""


@dataclass(frozen=True, slots=True)
class ViewEntry:
    """One picture of a set, before its pixels are read."""

    name: str
    """Unique in the set; a file's stem or path as its source writes it."""
    camera: CameraModel
    has_depth: bool
    load_color: Callable[[], Color]
    """Reads (H, W, 3|4) colour."""
    load: Callable[[], ReferenceView] | None
    """Reads colour and disparity; None when the picture has no depth."""


@dataclass(eq=False)
class ViewSet:
    """An ordered, named set of posed pictures. ``views[i]`` loads one; slices give smaller sets.

    Memory: at most ``cache_bytes`` of pixels, and at least the view asked for. Safe to use from
    several threads.
    """

    entries: tuple[ViewEntry, ...]
    facts: dict[str, Any] = field(default_factory=dict)
    """What its reader found worth telling: format, depth scale, crop, provenance (JSON values)."""
    cache_bytes: int = CACHE_BYTES
    _cache: OrderedDict[int, ReferenceView] = field(default_factory=OrderedDict, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def __post_init__(self) -> None:
        if not self.entries:
            raise SceneError("ViewSet.entries is empty, expected at least one view")
        seen: set[str] = set()
        for entry in self.entries:
            if entry.name in seen:
                raise SceneError(
                    f"ViewSet: two views are called {entry.name!r}: names tell views apart, "
                    "rename or remove one"
                )
            seen.add(entry.name)

    @classmethod
    def of(cls, views: Iterable[ReferenceView], names: Sequence[str] | None = None) -> ViewSet:
        """A set of views that are in memory already.

        Raises:
            ViewError: an element is no `ReferenceView`, or names and views differ in number.
        """
        held = list(views)
        titles = list(names) if names is not None else [f"{i:04d}" for i in range(len(held))]
        if len(titles) != len(held):
            raise ViewError(f"ViewSet.names has {len(titles)} names for {len(held)} views")
        for index, view in enumerate(held):
            if not isinstance(view, ReferenceView):
                raise ViewError(
                    f"ViewSet.views[{index}] is a {type(view).__name__}, expected a ReferenceView"
                )
        return cls(
            tuple(
                ViewEntry(title, view.camera, True, lambda v=view: v.color, lambda v=view: v)
                for title, view in zip(titles, held, strict=True)
            )
        )

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[ReferenceView]:
        return (self[index] for index in range(len(self)))

    @overload
    def __getitem__(self, index: int) -> ReferenceView: ...

    @overload
    def __getitem__(self, index: slice) -> ViewSet: ...

    def __getitem__(self, index: int | slice) -> ReferenceView | ViewSet:
        """Load view ``index`` (negative counts from the end); a slice gives a smaller set.

        Raises:
            IndexError: there is no such view.
            SceneError: the view has no depth, or its files are bad; the slice is empty.
        """
        if isinstance(index, slice):
            return self.select(range(len(self))[index])
        try:
            position = range(len(self))[index]
        except IndexError:
            raise IndexError(f"ViewSet has {len(self)} views, there is no view {index}") from None
        with self._lock:
            held = self._cache.get(position)
            if held is not None:
                self._cache.move_to_end(position)
                return held
        entry = self.entries[position]
        if entry.load is None:
            raise SceneError(
                f"view {entry.name!r} has no depth, so it cannot be warped: add a depth map per "
                "picture, or use its colour alone (ViewSet.color)"
            )
        view = entry.load()
        with self._lock:
            self._cache[position] = view
            held_bytes = sum(v.nbytes for v in self._cache.values())
            while held_bytes > self.cache_bytes and len(self._cache) > 1:
                _, dropped = self._cache.popitem(last=False)
                held_bytes -= dropped.nbytes
        return view

    def color(self, index: int) -> Color:
        """The colour of view ``index``, depth or no depth."""
        return self.entries[index].load_color()

    @property
    def names(self) -> tuple[str, ...]:
        """Every view's name."""
        return tuple(entry.name for entry in self.entries)

    @property
    def cameras(self) -> tuple[CameraModel, ...]:
        """Every view's camera; reads no pixels."""
        return tuple(entry.camera for entry in self.entries)

    @property
    def has_depth(self) -> bool:
        """Whether every view has depth."""
        return all(entry.has_depth for entry in self.entries)

    def select(self, indices: Iterable[int]) -> ViewSet:
        """The set of some of the views, in the order given."""
        return ViewSet(
            tuple(self.entries[index] for index in indices), dict(self.facts), self.cache_bytes
        )
