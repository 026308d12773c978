"""Which clusters of triangles a frame draws, in which order, and in which batches. Private."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from belvedere.ground.scratch import scratch
from belvedere.ground.threads import run_parallel
from belvedere.scene import Camera

if TYPE_CHECKING:
    from belvedere.model.rasterize import DrawList

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]
I8 = npt.NDArray[np.int64]

FIRST_BATCH, LAST_BATCH = 1 << 15, 1 << 18
"""Triangles that are drawn before it is asked what they hide; each batch is twice the last."""
FEW = 1 << 16
"""Triangles of which it is not asked."""


CULLED = 1 << 12
"""Clusters that a thread culls at a time."""


class DrawPlan:
    """The clusters of several lists that a camera may see, roughly the nearest first."""

    def __init__(
        self,
        camera: Camera,
        origin: F8,
        lists: Sequence[tuple[DrawList, F8 | None]],
        threads: int | None = 1,
    ) -> None:
        from belvedere.model import _raster_setup

        self.inverse, self.eye = np.linalg.inv(camera.matrix), camera.center - origin
        picture = np.array([0, camera.width - 1, 0, camera.height - 1], dtype=np.int32)
        border = camera.edge_planes
        sizes = [len(drawn.low) for drawn, _ in lists]
        ends = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        rects = np.empty((ends[-1], 4), dtype=np.int32)
        near, cut = np.empty(ends[-1]), np.empty(ends[-1], dtype=np.bool_)
        count = np.empty(ends[-1], dtype=np.int64)
        jobs: list[tuple[DrawList, F8, int, slice]] = []
        for (drawn, planes), (start, end) in zip(lists, pairwise(ends), strict=True):
            limits = border if planes is None else np.vstack([border, planes])
            count[start:end] = np.diff(drawn.first_face)
            jobs += [
                (drawn, limits, start, slice(first, min(first + CULLED, end - start)))
                for first in range(0, end - start, CULLED)
            ]

        def cull(job: tuple[DrawList, F8, int, slice]) -> None:
            drawn, limits, start, part = job
            into = slice(start + part.start, start + part.stop)
            _raster_setup.cull_clusters(
                drawn.low[part], drawn.high[part], self.eye, limits, self.inverse, picture,
                rects[into], near[into], cut[into],
            )  # fmt: skip

        run_parallel(cull, jobs, threads)
        seen = np.flatnonzero((rects[:, 1] >= rects[:, 0]) & (rects[:, 3] >= rects[:, 2]))
        order = seen[np.argsort(_farness(near[seen]), kind="stable")]
        self.rects, self.near = rects[order], near[order]
        """(P, 4) and (P,), see `_raster_setup.cull_clusters`."""
        self._list = np.searchsorted(ends, order, side="right") - 1
        self.cluster = order - ends[self._list]
        """(P,) number in its list."""
        self.count = np.zeros(len(order), dtype=np.int64)
        """(P,) records of each cluster, once they are set up."""
        self._faces = count[order]
        self._most = count[order] * np.where(cut[order], _raster_setup.MOST_PIECES, 1)

    def batches(self) -> list[tuple[int, int]]:
        """First cluster and the one after the last of what is drawn together; one at least."""
        total = np.cumsum(self._faces)
        if not len(total) or total[-1] <= FEW:
            return [(0, len(total))]
        ends, size = [0], FIRST_BATCH
        while ends[-1] < len(total):
            done = total[ends[-1] - 1] if ends[-1] else 0
            ends.append(max(int(np.searchsorted(total, done + size, side="right")), ends[-1] + 1))
            size = min(2 * size, LAST_BATCH)
        return list(pairwise(ends))

    def make_room(self, first: int, last: int) -> tuple[I8, I4]:
        """(P,) where the records of a batch's clusters begin, and memory for the records."""
        from belvedere.model import _raster_setup

        room = np.zeros(len(self.cluster), dtype=np.int64)
        most = self._most[first:last]
        room[first:last] = np.cumsum(most) - most
        return room, scratch("raster records", (int(most.sum()), _raster_setup.RECORD), np.int32)

    def parts(self, first: int, last: int, threads: int) -> list[tuple[int, I8]]:
        """A batch in pieces for threads: a list's number, and which clusters of it."""
        parts: list[tuple[int, I8]] = []
        for each in np.unique(self._list[first:last]).tolist():
            places = first + np.flatnonzero(self._list[first:last] == each)
            pieces = 1 if threads == 1 else min(4 * threads, len(places))
            parts += [(each, piece) for piece in np.array_split(places, pieces)]
        return parts


def _farness(near: F8) -> npt.NDArray[np.uint16]:
    """Disparities' order from large to small in 16 bits, which sort in a tenth of the time."""
    bits = near.astype(np.float32).view(np.uint32)  # of positive floats in the same order
    return ~(bits >> np.uint32(16)).astype(np.uint16)
