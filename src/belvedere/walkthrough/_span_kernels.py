"""Loops over columns of solid spans and over the floors between them. Private."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel

A = npt.NDArray[Any]


@kernel
def _clip(points: A, count: int, axis: int, at: float, keep: float, out_points: A) -> int:
    """The part of a convex polygon where ``keep * (p[axis] - at) >= 0``; returns its corners."""
    n = 0
    for k in range(count):
        m = k + 1 if k + 1 < count else 0
        a, b = keep * (points[k, axis] - at), keep * (points[m, axis] - at)
        if a >= 0.0:
            out_points[n] = points[k]
            n += 1
        if (a > 0.0 and b < 0.0) or (a < 0.0 and b > 0.0):
            t = a / (a - b)
            for c in range(3):
                out_points[n, c] = points[k, c] + t * (points[m, c] - points[k, c])
            out_points[n, axis] = at
            n += 1
    return n


@kernel
def touch_columns(
    corners: A, upward: A, spacing: float, nx: int, ny: int, writing: bool,
    out_first: A, out_low: A, out_high: A, out_up: A,
) -> None:  # fmt: skip
    """Every column that a triangle touches, and between which heights it does.

    Args:
        corners: (M, 3, 3) triangles, metres from the grid's corner.
        upward: (M,) whether a triangle's front looks up.
        spacing: side of a column, metres.
        nx: columns along x.
        ny: columns along y.
        writing: False counts into ``out_first[column + 1]``; True files the spans from
            ``out_first[column]`` on, which it moves forward.
        out_first: (nx * ny + 1,) counts or places.
        out_low: lower ends of the spans, metres.
        out_high: their upper ends.
        out_up: whether the triangle's front looks up.
    """
    one, two, row, cell = np.empty((9, 3)), np.empty((9, 3)), np.empty((9, 3)), np.empty((9, 3))
    for f in range(corners.shape[0]):
        ylow = min(corners[f, 0, 1], corners[f, 1, 1], corners[f, 2, 1])
        yhigh = max(corners[f, 0, 1], corners[f, 1, 1], corners[f, 2, 1])
        for j in range(max(int(ylow / spacing), 0), min(int(yhigh / spacing), ny - 1) + 1):
            one[:3] = corners[f]
            n = _clip(one, 3, 1, j * spacing, 1.0, two)
            n = _clip(two, n, 1, (j + 1) * spacing, -1.0, row)
            if n == 0:
                continue
            xlow, xhigh = row[0, 0], row[0, 0]
            for k in range(1, n):
                xlow, xhigh = min(xlow, row[k, 0]), max(xhigh, row[k, 0])
            for i in range(max(int(xlow / spacing), 0), min(int(xhigh / spacing), nx - 1) + 1):
                m = _clip(row, n, 0, i * spacing, 1.0, two)
                m = _clip(two, m, 0, (i + 1) * spacing, -1.0, cell)
                if m == 0:
                    continue
                column = j * nx + i
                if not writing:
                    out_first[column + 1] += 1
                    continue
                low, high = cell[0, 2], cell[0, 2]
                for k in range(1, m):
                    low, high = min(low, cell[k, 2]), max(high, cell[k, 2])
                at = out_first[column]
                out_low[at], out_high[at], out_up[at] = low, high, upward[f]
                out_first[column] = at + 1


@kernel
def merge_spans(first: A, join: float, out_low: A, out_high: A, out_up: A, out_count: A) -> None:
    """Sort each column's spans and join those nearer than ``join``, in place."""
    for column in range(first.shape[0] - 1):
        a, b = first[column], first[column + 1]
        for k in range(a + 1, b):
            low, high, up = out_low[k], out_high[k], out_up[k]
            m = k - 1
            while m >= a and out_low[m] > low:
                out_low[m + 1], out_high[m + 1], out_up[m + 1] = out_low[m], out_high[m], out_up[m]
                m -= 1
            out_low[m + 1], out_high[m + 1], out_up[m + 1] = low, high, up
        n = 0
        for k in range(a, b):
            last = a + n - 1
            if n > 0 and out_low[k] <= out_high[last] + join:
                if out_high[k] > out_high[last] or (
                    out_high[k] == out_high[last] and out_up[k] and not out_up[last]
                ):
                    out_high[last], out_up[last] = out_high[k], out_up[k]
            else:
                out_low[a + n], out_high[a + n], out_up[a + n] = out_low[k], out_high[k], out_up[k]
                n += 1
        out_count[column] = n


@kernel
def find_floors(
    first: A, low: A, high: A, up: A, head: float, writing: bool,
    out_first: A, out_floor: A, out_ceiling: A, out_up: A,
) -> None:  # fmt: skip
    """The gaps above spans in which a person can stand; the uppermost has no ceiling (inf)."""
    n = 0
    for column in range(first.shape[0] - 1):
        if writing:
            out_first[column] = n
        for k in range(first[column], first[column + 1]):
            ceiling = low[k + 1] if k + 1 < first[column + 1] else math.inf
            if ceiling - high[k] >= head:
                if writing:
                    out_floor[n], out_ceiling[n], out_up[n] = high[k], ceiling, up[k]
                n += 1
    out_first[first.shape[0] - 1] = n


@kernel
def link_floors(
    column: A, first: A, floor: A, ceiling: A, nx: int, ny: int, step: float, head: float,
    out_link: A,
) -> None:  # fmt: skip
    """For each floor the neighbours (-x, +x, -y, +y) that a person can step to; -1: none."""
    for n in range(column.shape[0]):
        i, j = column[n] % nx, column[n] // nx
        for d in range(4):
            p = i + (d == 1) - (d == 0)
            q = j + (d == 3) - (d == 2)
            out_link[n, d] = -1
            if p < 0 or q < 0 or p >= nx or q >= ny:
                continue
            best = step + 1e-6
            c = q * nx + p
            for m in range(first[c], first[c + 1]):
                rise = abs(floor[m] - floor[n])
                room = min(ceiling[m], ceiling[n]) - max(floor[m], floor[n])
                if rise <= best and room >= head:
                    best = rise
                    out_link[n, d] = m


@kernel
def mend_links(out_link: A) -> int:
    """Drop the links that lead one way only; how many."""
    dropped = 0
    for n in range(out_link.shape[0]):
        for d in range(4):
            m = out_link[n, d]
            if m >= 0 and out_link[m, d ^ 1] != n:
                out_link[n, d] = -1
                dropped += 1
    return dropped


@kernel
def _corner(link: A, n: int, d: int, e: int) -> int:
    """The diagonal neighbour, when both ways round lead there."""
    a, b = link[n, d], link[n, e]
    if a < 0 or b < 0 or link[a, e] < 0 or link[a, e] != link[b, d]:
        return -1
    return link[a, e]


@kernel
def nearest_blocks(column: A, link: A, nx: int, spacing: float, out_block: A, out_far: A) -> None:
    """Distance from each floor's centre to the edge of the nearest column that blocks the way.

    Vectors are handed on from neighbour to neighbour, forth and back, until none gets shorter
    (Danielsson 1980, on layers instead of an image).
    """
    total = column.shape[0]
    for n in range(total):
        out_far[n] = math.inf
        i, j = column[n] % nx, column[n] // nx
        for d in range(8):
            if d < 4:
                open_way = link[n, d] >= 0
                p, q = i + (d == 1) - (d == 0), j + (d == 3) - (d == 2)
            else:
                e, f = (d - 4) & 1, 2 + ((d - 4) >> 1)
                open_way = _corner(link, n, e, f) >= 0
                p, q = i + (e == 1) - (e == 0), j + (f == 3) - (f == 2)
            if not open_way:
                far = math.sqrt((p - i) ** 2 + (q - j) ** 2)
                if far < out_far[n]:
                    out_far[n], out_block[n, 0], out_block[n, 1] = far, p, q
    changed = True
    while changed:
        changed = False
        for way in range(2):
            for k in range(total):
                n = k if way == 0 else total - 1 - k
                i, j = column[n] % nx, column[n] // nx
                for d in range(8):
                    m = link[n, d] if d < 4 else _corner(link, n, (d - 4) & 1, 2 + ((d - 4) >> 1))
                    if m < 0 or out_far[m] == math.inf:
                        continue
                    p, q = out_block[m, 0], out_block[m, 1]
                    far = math.sqrt((p - i) ** 2 + (q - j) ** 2)
                    if far < out_far[n] - 1e-9:
                        out_far[n], out_block[n, 0], out_block[n, 1] = far, p, q
                        changed = True
    for n in range(total):
        out_far[n] = (out_far[n] - 0.5) * spacing


@kernel
def label_floors(link: A, cut: A, out_label: A, out_queue: A) -> int:
    """Number the connected sets of floors, largest index last; links in ``cut`` are closed."""
    label = 0
    for seed in range(link.shape[0]):
        if out_label[seed] != -1:
            continue
        out_label[seed] = label
        out_queue[0] = seed
        head, tail = 0, 1
        while head < tail:
            n = out_queue[head]
            head += 1
            for d in range(4):
                m = link[n, d]
                if m >= 0 and out_label[m] == -1 and not cut[n, d]:
                    out_label[m] = label
                    out_queue[tail] = m
                    tail += 1
        label += 1
    return label


@kernel
def smooth_floor(link: A, floor: A, rounds: int, out_one: A, out_two: A) -> None:
    """Floor heights averaged over linked neighbours, ``rounds`` times; the result is in one."""
    out_one[:] = floor
    for _ in range(rounds):
        for n in range(link.shape[0]):
            total, count = out_one[n], 1
            for d in range(4):
                m = link[n, d]
                if m >= 0:
                    total += out_one[m]
                    count += 1
            out_two[n] = total / count
        out_one[:] = out_two


@kernel
def cross_furniture(
    nx: int, ny: int, span_first: A, span_low: A, span_high: A, eye: float, head: float,
    step: float, size: int, out_column: A, out_floor: A, out_ceiling: A, out_grown: A,
    out_next: A, out_top: A,
) -> int:  # fmt: skip
    """Continue floors under what stands on them, as far as the air at head height is free.

    A column joins a floor at height h when nothing fills it between h + eye and h + head, and
    something stands on the floor there: furniture, not a void.

    Args:
        nx: columns along x.
        ny: columns along y.
        span_first: (nx * ny + 1,) where each column's spans begin.
        span_low: lower ends of the spans.
        span_high: upper ends.
        eye: lower end of the band above a floor that must be free, metres.
        head: its upper end.
        step: heights that differ by less are one floor.
        size: how many floors there are to begin with.
        out_column: column of each floor, room for more at the end.
        out_floor: height of each.
        out_ceiling: height of the next solid above.
        out_grown: True where a floor was added.
        out_next: next floor of the same column, or -1.
        out_top: (nx * ny,) first floor of each column, or -1.

    Returns:
        How many floors there are now; the length of ``out_column`` if there was no more room.
    """
    n = 0
    while n < size:
        h, c = out_floor[n], out_column[n]
        sky = out_ceiling[n] == math.inf
        i, j = c % nx, c // nx
        n += 1
        if sky:
            continue
        for d in range(4):
            p, q = i + (d == 1) - (d == 0), j + (d == 3) - (d == 2)
            if p < 0 or q < 0 or p >= nx or q >= ny:
                continue
            to = q * nx + p
            m, taken = out_top[to], False
            while m >= 0:  # a floor goes on here, or somebody can stand on what is here: a stair
                low = out_floor[m] - h
                taken = taken or abs(low) <= step or (not out_grown[m] and 0.0 < low < head)
                m = out_next[m]
            if taken:
                continue
            ceiling, stands, free = math.inf, False, True
            for k in range(span_first[to], span_first[to + 1]):
                if span_low[k] < h + head and span_high[k] > h + eye:
                    free = False
                    break
                if span_low[k] >= h + head:
                    ceiling = span_low[k]
                    break
                stands = stands or span_high[k] >= h - 0.1
            if not free or not stands or ceiling == math.inf:
                continue
            if size == out_column.shape[0]:
                return size
            out_column[size], out_floor[size], out_ceiling[size] = to, h, ceiling
            out_grown[size] = True
            out_next[size], out_top[to] = out_top[to], size
            size += 1
    return size


@kernel
def flood_down(order: A, link: A, out_basin: A) -> int:
    """The watershed: floors taken from the widest place to the narrowest join a neighbour's basin.

    Args:
        order: (N,) floors by falling distance from the walls.
        link: (N, 4) neighbours.
        out_basin: (N,) preset to -1.

    Returns:
        The number of basins. A floor without a labelled neighbour begins one; between basins no
        line is left out, they touch.
    """
    basins = 0
    for k in range(order.shape[0]):
        n = order[k]
        best = -1
        for d in range(8):
            m = link[n, d] if d < 4 else _corner(link, n, (d - 4) & 1, 2 + ((d - 4) >> 1))
            if m >= 0 and out_basin[m] >= 0 and (best < 0 or out_basin[m] < best):
                best = out_basin[m]
        if best < 0:
            best = basins
            basins += 1
        out_basin[n] = best
    return basins


@kernel
def spread(link: A, value: A, rounds: int, sign: float, out_one: A, out_two: A) -> None:
    """The largest (sign 1) or least (sign -1) value within so many links; the result is in one."""
    out_one[:] = value
    for _ in range(rounds):
        for n in range(link.shape[0]):
            best = out_one[n]
            for d in range(8):
                m = link[n, d] if d < 4 else _corner(link, n, (d - 4) & 1, 2 + ((d - 4) >> 1))
                if m >= 0 and sign * out_one[m] > sign * best:
                    best = out_one[m]
            out_two[n] = best
        out_one[:] = out_two
