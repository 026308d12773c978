"""Fading references in and out, so that a change of the set does not show as a flash."""

from __future__ import annotations

from collections.abc import Sequence

from belvedere.warp.features import feature_channels
from belvedere.warp.prepare import PreparedView

LEAVING_VIEWS = 8
"""References on their way out that are kept at most; of more, the faintest go at once."""


class Fading:
    """How much each reference of a changing set counts, frame after frame.

    A reference that enters gains a ``frames``-th of its weight with every frame; one that leaves
    stays in the set and loses as much until nothing is left. The first set counts in full.

    Memory: the references of the last set and up to `LEAVING_VIEWS` others are kept alive.
    """

    def __init__(self, frames: int) -> None:
        self.frames = frames
        self._held: dict[int, tuple[PreparedView, int]] = {}

    def step(self, views: Sequence[PreparedView]) -> tuple[list[PreparedView], list[float]]:
        """The next frame's set.

        Args:
            views: the references wanted from now on, at least one.

        Returns:
            Those and after them the ones that are leaving, the strongest first; and the factor by
            which each one's weight is to be multiplied, above 0.
        """
        wanted = {id(view) for view in views}
        start = 0 if self._held else self.frames
        held = {
            id(view): (view, min(self._held.get(id(view), (view, start))[1] + 1, self.frames))
            for view in views
        }
        leaving = [
            (view, level - 1)
            for key, (view, level) in self._held.items()
            if key not in wanted and level > 1 and _alike(view, views[0])
        ]
        leaving = sorted(leaving, key=lambda one: -one[1])[:LEAVING_VIEWS]
        self._held = held | {id(view): (view, level) for view, level in leaving}
        shown = [*views, *(view for view, _ in leaving)]
        return shown, [self._held[id(view)][1] / self.frames for view in shown]

    def forget(self) -> None:
        """Let the next set count in full at once."""
        self._held.clear()


def _alike(one: PreparedView, other: PreparedView) -> bool:
    """Whether two references can be blended."""
    return (
        one.color.dtype == other.color.dtype
        and one.color.shape[2] == other.color.shape[2]
        and feature_channels([one]) == feature_channels([other])
    )
