"""References made ready to be warped, kept for the frames to come."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable

from belvedere.scene import ReferenceView
from belvedere.warp import PreparedView, prepare

KEPT_BYTES = 2 << 30
"""Of prepared references that a walker keeps by default."""
SAMPLE_BYTES = 56
"""Of a prepared sample at most, beside the view's own pixels."""

__all__ = ["ReadyReferences"]


class ReadyReferences:
    """Prepared references by name; those that were not shown for longest are forgotten.

    Memory: about ``kept_bytes``, and at least what one frame shows.
    """

    def __init__(self, kept_bytes: int = KEPT_BYTES) -> None:
        self._limit, self._bytes = kept_bytes, 0
        self._ready: OrderedDict[Hashable, PreparedView] = OrderedDict()
        self._shown: set[Hashable] = set()

    def __len__(self) -> int:
        return len(self._ready)

    @property
    def full(self) -> bool:
        """Whether another one would cost one that is kept."""
        return self._bytes >= self._limit

    def get(self, name: Hashable, load: Callable[[], ReferenceView]) -> PreparedView:
        """The reference of that name; ``load`` gives its view if it is not ready yet."""
        if name not in self._ready:
            self._ready[name] = prepare(load())
            self._bytes += _bytes(self._ready[name])
        self._ready.move_to_end(name)
        self._shown.add(name)
        return self._ready[name]

    def end_frame(self) -> None:
        """Forget what does not fit, but nothing that was asked for since the last call."""
        while self._bytes > self._limit and next(iter(self._ready)) not in self._shown:
            self._bytes -= _bytes(self._ready.popitem(last=False)[1])
        self._shown.clear()


def _bytes(view: PreparedView) -> int:
    return view.view.nbytes + SAMPLE_BYTES * view.disparity.size
