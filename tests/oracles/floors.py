"""Slow twins of the loops over columns and layers: written from what they mean."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import numpy.typing as npt

F8 = npt.NDArray[np.float64]


def nearest_wall(free: npt.NDArray[np.bool_], spacing: float) -> F8:
    """Distance from each free square's middle to the nearest edge of a square that is not.

    On one level, where every free neighbour is linked. Squares outside the picture are in the way.
    """
    wide = np.pad(free, 1)
    walls = np.argwhere(~wide) - 1.0
    result = np.full(free.shape, np.nan)
    for v, u in np.argwhere(free):
        result[v, u] = (np.hypot(*(walls - [v, u]).T).min() - 0.5) * spacing
    return result


def connected(link: npt.NDArray[np.int32]) -> list[frozenset[int]]:
    """The sets of places that links join."""
    left, sets = set(range(len(link))), []
    while left:
        queue, found = deque([min(left)]), {min(left)}
        while queue:
            for m in link[queue.popleft()]:
                if m >= 0 and int(m) not in found:
                    found.add(int(m))
                    queue.append(int(m))
        sets.append(frozenset(found))
        left -= found
    return sets


def sampled_spans(
    triangles: F8, spacing: float, rng: np.random.Generator, samples: int
) -> dict[tuple[int, int], tuple[float, float]]:
    """Lowest and highest point of each triangle's samples over each square (one triangle)."""
    spans: dict[tuple[int, int], Any] = {}
    for corners in triangles:
        w = rng.dirichlet(np.ones(3), samples)
        edge = np.zeros((samples, 3))
        t = rng.random(samples)
        edge[np.arange(samples), np.arange(samples) % 3] = t
        edge[np.arange(samples), (np.arange(samples) + 1) % 3] = 1 - t
        for x, y, z in np.concatenate([w, edge, np.eye(3)]) @ corners:
            key = (int(x // spacing), int(y // spacing))
            low, high = spans.get(key, (z, z))
            spans[key] = (min(low, z), max(high, z))
    return spans
