"""Kernels that find where neighbouring samples belong to different surfaces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

RIGHT = 1
"""Bit: the sample and its right neighbour lie on one surface."""
DOWN = 2
"""Bit: the sample and the one below lie on one surface."""
MIXED = 4
"""Bit: a false sample between two surfaces, as scanners and resampling leave at silhouettes."""
INTACT = 8
"""Bit: the cell between the sample and the one below to the right is one piece of surface."""
SMOOTH = 16
"""Bit: so are the eight cells round that one: sixteen samples may be mixed."""
RIM = 32
"""Bit: the cell is intact and on the near side of an edge, within two samples of it."""

PLAIN = 0.6
"""Share of the tolerance below which a step is no edge, whatever is beside it: noise and relief."""
STEEPER = 3.0
"""How much steeper than the steps beside it a larger one may be and still be slope: a step between
two level surfaces is an edge, though within the tolerance."""

EIGHT = 8
"""Samples that are passed over at once where the same bits are set in all."""


@inner
def slope_explains(jump: Real, first: Real, second: Real) -> bool:
    """Whether a steep jump continues two equal steps beside it: a slanted surface, not an edge."""
    near = 0.25 * abs(jump)
    return abs(jump - first) <= near and abs(first - second) <= near


@inner
def plain_step(tolerance: Real) -> Real:
    """Relative step that is no edge, whatever is beside it; a tolerance of 1 links everything."""
    return tolerance if tolerance >= 1.0 else PLAIN * tolerance


@inner
def linked(d: F4, v: int, u: int, dv: int, du: int, tolerance: Real) -> bool:
    """Whether sample (v, u) and its neighbour at (v + dv, u + du) lie on one surface.

    Disparity is affine along any image line that crosses one plane, so a jump is no edge if it is
    small or if two more steps on either side continue it.
    """
    height, width = d.shape
    p, q = d[v, u], d[v + dv, u + du]
    if np.isnan(p) or np.isnan(q):
        return False
    jump = q - p
    if abs(jump) <= plain_step(tolerance) * max(p, q):
        return True
    if abs(jump) <= tolerance * max(p, q):
        # a step of its own between two level surfaces is an edge
        beside = np.float32(0.0)
        if v >= dv and u >= du and not np.isnan(d[v - dv, u - du]):
            beside = abs(p - d[v - dv, u - du])
        if v + 2 * dv < height and u + 2 * du < width and not np.isnan(d[v + 2 * dv, u + 2 * du]):
            beside = max(beside, abs(d[v + 2 * dv, u + 2 * du] - q))
        return abs(jump) <= STEEPER * beside
    v2, u2 = v - 2 * dv, u - 2 * du
    if v2 >= 0 and u2 >= 0:
        a = d[v - dv, u - du]
        if slope_explains(jump, p - a, a - d[v2, u2]):
            return True
    v3, u3 = v + 3 * dv, u + 3 * du
    if v3 < height and u3 < width:
        b = d[v + 2 * dv, u + 2 * du]
        if slope_explains(jump, b - q, d[v3, u3] - b):
            return True
    return False


@inner
def all_set(flags: U1, start: int, count: int, bits: int) -> bool:
    """Whether each of the ``count`` flags from ``start`` on has all these bits."""
    held = np.uint8(255)
    for i in range(count):
        held = np.uint8(held & flags[np.uint64(start + i)])
    return held & bits == bits


@inner
def list_set(flags: U1, out_places: I4) -> int:
    """Places of the flags that are not 0, whose number is a multiple of EIGHT; returns how many.

    A loop over the flags themselves would carry every address its body needs along.
    """
    eights, found = flags.view(np.uint64), 0
    for e in range(eights.size):
        if eights[e] != 0:
            for i in range(EIGHT * e, EIGHT * e + EIGHT):
                out_places[found] = i
                found += int(flags[i] != 0)
    return found


@inner
def list_lacking(links: U1, v: int, bits: int, lacks: U1, out_places: I4) -> int:
    """Columns of row v whose flags lack one of the bits, as `list_set`.

    lacks is to work in, its number a multiple of EIGHT, 0 beyond the row.
    """
    for u in range(links.shape[1]):
        lacks[u] = np.uint8(links[v, u] & bits != bits)
    return list_set(lacks, out_places)


@kernel
def link_samples(disparity: F4, tolerance: Real, row_low: int, row_high: int, out: U1) -> None:
    """RIGHT and DOWN bits of rows [row_low, row_high).

    disparity is (H, W), out is (H, W).
    """
    height, width = disparity.shape
    share = np.float32(plain_step(tolerance))
    for v in range(row_low, row_high):
        below = min(v + 1, height - 1)
        for u in range(width - 1):  # the usual case, in a loop that vectorises
            p, q, r = disparity[v, u], disparity[v, u + 1], disparity[below, u]
            right = abs(q - p) <= share * (p if p > q else q)
            down = abs(r - p) <= share * (p if p > r else r)
            out[v, u] = np.uint8(right) * np.uint8(RIGHT) | np.uint8(down) * np.uint8(DOWN)
        out[v, width - 1] = 0
        for u in range(width):
            bits = out[v, u]
            if u + 1 == width or v + 1 == height:
                bits = np.uint8(0)
            if bits != RIGHT | DOWN:
                if u + 1 < width and linked(disparity, v, u, 0, 1, tolerance):
                    bits |= np.uint8(RIGHT)
                if v + 1 < height and linked(disparity, v, u, 1, 0, tolerance):
                    bits |= np.uint8(DOWN)
                out[v, u] = bits


@kernel
def step_to_sample(d: F4, v: int, u: int, dv: int, du: int, most: int) -> int:
    """Steps from (v, u) to the next sample in a direction, or 0 if ``most`` do not reach one."""
    for step in range(1, most + 1):
        v2, u2 = v + step * dv, u + step * du
        if v2 < 0 or u2 < 0 or v2 >= d.shape[0] or u2 >= d.shape[1]:
            return 0
        if not np.isnan(d[v2, u2]):
            return step
    return 0


@kernel
def bridge_gaps(
    disparity: F4, widest: int, tolerance: Real, row_low: int, row_high: int, out: F4
) -> None:
    """Give missing samples the disparity of the surface that goes on at both sides of the gap.

    Sensors leave seams and specks without depth in the middle of a surface. Where the samples on
    two opposite sides of a gap agree, the surface is taken to run through; where they do not, there
    is an edge, and nothing is made up.

    Args:
        disparity: (H, W), NaN where missing.
        widest: missing samples in a row or column that are bridged at most.
        tolerance: relative difference in disparity of samples that agree.
        row_low: first row to do.
        row_high: row after the last.
        out: (H, W), written in those rows.
    """
    width = disparity.shape[1]
    for v in range(row_low, row_high):
        for u in range(width):
            out[v, u] = disparity[v, u]
            if not np.isnan(disparity[v, u]):
                continue
            total, weights = np.float32(0.0), np.float32(0.0)
            for axis in range(2):
                dv, du = axis, 1 - axis
                back = step_to_sample(disparity, v, u, -dv, -du, widest)
                ahead = step_to_sample(disparity, v, u, dv, du, widest)
                if back == 0 or ahead == 0 or back + ahead - 1 > widest:
                    continue
                a = disparity[v - back * dv, u - back * du]
                b = disparity[v + ahead * dv, u + ahead * du]
                if abs(a - b) <= tolerance * max(a, b):
                    span = np.float32(back + ahead)
                    value = (a * np.float32(ahead) + b * np.float32(back)) / span
                    total += value / span
                    weights += np.float32(1.0) / span
            if weights > 0:
                out[v, u] = total / weights


@inner
def between(low: Real, middle: Real, high: Real) -> bool:
    """Whether the middle value lies strictly between its neighbours, in either direction."""
    return (low < middle < high) or (low > middle > high)


@kernel
def mark_mixed(disparity: F4, row_low: int, row_high: int, out: U1) -> None:
    """MIXED bits: unlinked on two opposite sides, with a disparity between theirs.

    A thin object also stands unlinked on both sides, but nearer than both, and is kept.
    """
    height, width = disparity.shape
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(row_low, row_high):
        for k in range(list_lacking(out, v, RIGHT | DOWN, lacks, places)):
            u = places[k]
            d = disparity[v, u]
            if np.isnan(d):
                continue
            across = (
                0 < u < width - 1
                and not out[v, u] & RIGHT
                and not out[v, u - 1] & RIGHT
                and between(disparity[v, u - 1], d, disparity[v, u + 1])
            )
            along = (
                0 < v < height - 1
                and not out[v, u] & DOWN
                and not out[v - 1, u] & DOWN
                and between(disparity[v - 1, u], d, disparity[v + 1, u])
            )
            if across or along:
                out[v, u] |= MIXED


@inner
def usable(disparity: F4, links: U1, v: int, u: int) -> bool:
    """Whether (v, u) is inside the image and holds a true sample."""
    if v < 0 or u < 0 or v >= disparity.shape[0] or u >= disparity.shape[1]:
        return False
    return not np.isnan(disparity[v, u]) and not links[v, u] & MIXED


@inner
def intact(links: U1, v: int, u: int) -> bool:
    """Whether the cell between (v, u) and (v + 1, u + 1) is one piece of surface."""
    return v >= 0 and u >= 0 and bool(links[v, u] & INTACT)


@kernel
def mark_intact(row_low: int, row_high: int, out: U1) -> None:
    """INTACT bits of rows [row_low, row_high), after MIXED is known everywhere."""
    height, width = out.shape
    for v in range(row_low, min(row_high, height - 1)):
        for u in range(width - 1):
            top, right, bottom, last = out[v, u], out[v, u + 1], out[v + 1, u], out[v + 1, u + 1]
            sides = top & (right | RIGHT) & (bottom | DOWN) & (RIGHT | DOWN)
            mixed = (top | right | bottom | last) & MIXED
            whole = (sides == RIGHT | DOWN) & (mixed == 0)
            out[v, u] = top | np.uint8(INTACT if whole else 0)


@kernel
def mark_smooth(row_low: int, row_high: int, out: U1) -> None:
    """SMOOTH bits of rows [row_low, row_high), after INTACT is known everywhere."""
    height, width = out.shape
    column = np.empty(width, np.uint8)
    for v in range(max(row_low, 1), min(row_high, height - 2)):
        for u in range(width):
            column[u] = out[v - 1, u] & out[v, u] & out[v + 1, u] & INTACT
        for u in range(1, width - 2):
            out[v, u] |= np.uint8((column[u - 1] & column[u] & column[u + 1]) << 1)


@inner
def undivided(links: U1, v: int, u: int) -> bool:
    """Whether a sample is linked to all four neighbours, none of them a false one."""
    height, width = links.shape
    if v < 1 or u < 1 or v + 1 >= height or u + 1 >= width:
        return False
    here, left, above = links[v, u], links[v, u - 1], links[v - 1, u]
    mixed = (here | left | above | links[v, u + 1] | links[v + 1, u]) & MIXED
    sides = here & (left | DOWN) & (above | RIGHT) & (RIGHT | DOWN)
    return mixed == 0 and sides == RIGHT | DOWN


@kernel
def mark_rims(disparity: F4, tolerance: Real, row_low: int, row_high: int, out: U1) -> None:
    """RIM bits of rows [row_low, row_high), after SMOOTH is known everywhere.

    A rim is the near side of an edge. Its cells reach two samples inward: further in, no pixel of a
    view of like scale meets the silhouette.
    """
    height, width = disparity.shape
    keep = np.float32(1.0) - np.float32(tolerance)
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(max(row_low - 2, 0), min(row_high + 3, height)):
        for k in range(list_lacking(out, v, SMOOTH, lacks, places)):
            u = places[k]
            if undivided(out, v, u):
                continue
            own = disparity[v, u]
            near = (
                beyond(disparity, out, v, u, 0, 1) or beyond(disparity, out, v, u, 0, -1)
                or beyond(disparity, out, v, u, 1, 0) or beyond(disparity, out, v, u, -1, 0)
            )  # fmt: skip
            if not near:
                continue
            for j in range(max(v - 2, row_low, 0), min(v + 2, row_high, height - 1)):
                for i in range(max(u - 2, 0), min(u + 2, width - 1)):
                    if out[j, i] & INTACT and disparity[j, i] >= own * keep:
                        out[j, i] |= np.uint8(RIM)


@inner
def beyond(disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> bool:
    """Whether the neighbour of (v, u) in a direction lies behind an edge, or is missing."""
    v2, u2 = v + dv, u + du
    if v2 < 0 or u2 < 0 or v2 >= disparity.shape[0] or u2 >= disparity.shape[1]:
        return False
    if joined(links, v, u, dv, du):
        return False
    return not disparity[v2, u2] >= disparity[v, u]


@inner
def joined(links: U1, v: int, u: int, dv: int, du: int) -> bool:
    """Whether (v, u) is linked to its neighbour in direction (dv, du), one of them +-1."""
    v2, u2 = v + dv, u + du
    if v2 < 0 or u2 < 0 or v2 >= links.shape[0] or u2 >= links.shape[1]:
        return False
    bit = RIGHT if du != 0 else DOWN
    owner = links[min(v, v2), min(u, u2)]
    return bool(owner & bit) and not links[v2, u2] & MIXED


@inner
def slope_toward(disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> Real:
    """Change of disparity per pixel from (v, u) toward (dv, du), on its own surface.

    The linked neighbour on that side, else the linked one on the other side continued, else flat.
    """
    if joined(links, v, u, dv, du):
        return disparity[v + dv, u + du] - disparity[v, u]
    if joined(links, v, u, -dv, -du):
        return disparity[v, u] - disparity[v - dv, u - du]
    return np.float32(0.0)


@inner
def undisturbed(links: U1, v: int, u: int) -> bool:
    """Whether every cell round a sample is intact."""
    if v < 1 or u < 1:
        return False
    upper, lower = links[v - 1, u - 1] & links[v - 1, u], links[v, u - 1] & links[v, u]
    return bool(upper & lower & INTACT)


@inner
def step_along(disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> Real:
    """Size of the step in disparity to a linked neighbour; 0 to one that is not."""
    if joined(links, v, u, dv, du):
        return abs(disparity[v + dv, u + du] - disparity[v, u])
    return np.float32(0.0)


@kernel
def surface_range(
    disparity: F4, links: U1, sample_low: F4, sample_high: F4, tile_row_low: int,
    tile_row_high: int, out_low: F4, out_high: F4,
) -> None:  # fmt: skip
    """Smallest and largest disparity of the surface that is drawn of each tile.

    A sample is drawn up to a pixel around it, with the slope of its surface: on a steep one that
    reaches beyond the disparities of the samples themselves.

    Args:
        disparity: (H, W), small gaps bridged.
        links: (H, W) bits.
        sample_low: (ceil(H / TILE), ceil(W / TILE)) smallest disparity of the samples of each tile
            and round it.
        sample_high: the largest.
        tile_row_low: first row of tiles to do.
        tile_row_high: row of tiles after the last.
        out_low: (ceil(H / TILE), ceil(W / TILE)).
        out_high: same; high < low where a tile has no sample.
    """
    height, width = disparity.shape
    flat = links.reshape(-1)
    for tv in range(tile_row_low, tile_row_high):
        for tu in range(out_low.shape[1]):
            unbroken = (tv + 1) * TILE < height and (tu + 1) * TILE < width
            for v in range(tv * TILE, min((tv + 1) * TILE + 1, height)):
                if unbroken:
                    unbroken = all_set(flat, v * width + tu * TILE, TILE + 1, INTACT)
            if unbroken and tv > 0 and tu > 0:  # drawn between samples, never beyond them
                out_low[tv, tu], out_high[tv, tu] = sample_low[tv, tu], sample_high[tv, tu]
                continue
            low, high = np.float32(np.inf), np.float32(-np.inf)
            # the cells of a tile end at the first samples of the next
            for v in range(tv * TILE, min((tv + 1) * TILE + 1, height)):
                for u in range(tu * TILE, min((tu + 1) * TILE + 1, width)):
                    if undisturbed(links, v, u):  # drawn between samples, never beyond them
                        low = min(low, disparity[v, u])
                        high = max(high, disparity[v, u])
                        continue
                    if not usable(disparity, links, v, u):
                        continue
                    # a side that is not linked continues the slope of the other
                    reach = max(
                        step_along(disparity, links, v, u, 0, 1),
                        step_along(disparity, links, v, u, 0, -1),
                    ) + max(
                        step_along(disparity, links, v, u, 1, 0),
                        step_along(disparity, links, v, u, -1, 0),
                    )
                    low = min(low, max(disparity[v, u] - reach, np.float32(0.0)))
                    high = max(high, disparity[v, u] + reach)
            out_low[tv, tu] = low
            out_high[tv, tu] = high
