"""Kernels that find where neighbouring samples belong to different surfaces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel

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
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(row_low, row_high):
        below = min(v + 1, height - 1)
        for u in range(width - 1):  # the usual case, in a loop that vectorises
            p, q, r = disparity[v, u], disparity[v, u + 1], disparity[below, u]
            right = abs(q - p) <= share * (p if p > q else q)
            down = abs(r - p) <= share * (p if p > r else r)
            out[v, u] = np.uint8(right) * np.uint8(RIGHT) | np.uint8(down) * np.uint8(DOWN)
        out[v, width - 1] = 0
        if v + 1 == height:
            out[v].fill(0)
        for k in range(list_lacking(out, v, RIGHT | DOWN, lacks, places)):
            u = places[k]
            bits = out[v, u]
            if u + 1 < width and linked(disparity, v, u, 0, 1, tolerance):
                bits |= np.uint8(RIGHT)
            if v + 1 < height and linked(disparity, v, u, 1, 0, tolerance):
                bits |= np.uint8(DOWN)
            out[v, u] = bits


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
