"""Kernels that un-mix the samples at a silhouette: where its edge runs, and the pure colours.

A sample's colour is a mean over its pixel, so at a silhouette it mixes both surfaces, in the
proportion of their areas; its depth is one or the other. Between the last sample of one surface and
the first of the other, the mixture tells how far the nearer one really reaches.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import DOWN, EIGHT, MIXED, RIGHT, joined, list_lacking, list_set
from belvedere.warp._strand import NOISE, apart, is_strand, strand_color, strand_reach

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
STEPS = np.float32(254.0)
"""Places of an edge between two samples; 127 is half way, and what is not known."""
MIDDLE = 127
ODDER = np.float32(4.0)
"""How fast trust in a mixture falls, and returns, with the shares in it that no edge explains."""


@inner
def share(color: F4, v: int, u: int, vf: int, uf: int, vb: int, ub: int) -> Real:
    """How much of colour (vf, uf) is in (v, u), the rest being (vb, ub); 0 to 1."""
    along, length = ZERO, ZERO
    for k in range(3):
        axis = color[vf, uf, k] - color[vb, ub, k]
        along += (color[v, u, k] - color[vb, ub, k]) * axis
        length += axis * axis
    return min(max(along / length, ZERO), ONE)


@inner
def edge_between(color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> Real:
    """How far the surface of (v, u) reaches toward its unlinked neighbour, 0 to 1; 1/2 if unknown.

    The pure colours are those of the next samples on each side. Where they hardly differ, or differ
    less than the surfaces' own textures do, the mixture tells nothing. Nor does it where a sample
    has somewhat less than half of the surface that its centre is on, or the one beyond more than
    half: no straight edge leaves that, but shading does. A sample that is all of the other surface
    tells again: its depth is a sample off, as that of cameras often is.
    """
    v2, u2 = v + dv, u + du
    if is_strand(disparity, links, v, u, dv, du):
        return strand_reach(color, links, v, u, dv, du)[1]
    if is_strand(disparity, links, v2, u2, dv, du):
        return ONE - strand_reach(color, links, v2, u2, dv, du)[0]
    if not joined(links, v, u, -dv, -du) or not joined(links, v2, u2, dv, du):
        return HALF  # no pure colour
    va, ua, vb, ub = v - dv, u - du, v2 + dv, u2 + du
    texture = NOISE
    # two samples wide: the other edge mixes one of them, and the purer one is farther from beyond
    if joined(links, va, ua, -dv, -du):
        texture += apart(color, va, ua, va - dv, ua - du)
    elif apart(color, v, u, vb, ub) > apart(color, va, ua, vb, ub):
        va, ua = v, u
    if joined(links, vb, ub, dv, du):
        texture += apart(color, vb, ub, vb + dv, ub + du)
    elif apart(color, va, ua, v2, u2) > apart(color, va, ua, vb, ub):
        vb, ub = v2, u2
    contrast = apart(color, va, ua, vb, ub)
    if not contrast > texture:
        return HALF
    own, other = share(color, v, u, va, ua, vb, ub), share(color, v2, u2, va, ua, vb, ub)
    odd = max(HALF - own, ZERO) + max(other - HALF, ZERO)
    trust = (ONE - texture / contrast) * min(abs(ONE - ODDER * odd), ONE)
    return min(max(HALF + trust * (own + other - ONE), ZERO), ONE)


@kernel
def find_edges(
    color: F4, disparity: F4, links: U1, row_low: int, row_high: int, out_right: U1, out_down: U1
) -> None:
    """Where the edge runs between each sample and its right and lower neighbour, 0 to 254."""
    height, width = disparity.shape
    lacks = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(lacks.size, np.int32)
    for v in range(row_low, row_high):
        out_right[v].fill(MIDDLE)
        out_down[v].fill(MIDDLE)
        for k in range(list_lacking(links, v, RIGHT | DOWN, lacks, places)):
            u = places[k]
            bits = links[v, u]
            if bits & MIXED or np.isnan(disparity[v, u]):
                continue
            if u + 1 < width and not bits & RIGHT and not np.isnan(disparity[v, u + 1]):
                out_right[v, u] = np.uint8(
                    edge_between(color, disparity, links, v, u, 0, 1) * STEPS + HALF
                )
            if v + 1 < height and not bits & DOWN and not np.isnan(disparity[v + 1, u]):
                out_down[v, u] = np.uint8(
                    edge_between(color, disparity, links, v, u, 1, 0) * STEPS + HALF
                )


@inner
def reach_toward(right: U1, down: U1, v: int, u: int, dv: int, du: int) -> Real:
    """How far the surface of (v, u) reaches toward a neighbour, one of dv and du being +-1."""
    if du > 0:
        return np.float32(right[v, u]) / STEPS
    if dv > 0:
        return np.float32(down[v, u]) / STEPS
    if du < 0:
        return ONE - np.float32(right[v, u - 1]) / STEPS if u > 0 else HALF
    return ONE - np.float32(down[v - 1, u]) / STEPS if v > 0 else HALF


@inner
def mixed_in(
    color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int
) -> tuple[Real, Real, Real, Real]:
    """The pure colour of the surface that begins at (v, u), seen in direction (dv, du)."""
    if is_strand(disparity, links, v, u, abs(dv), abs(du)):
        return strand_color(color, links, v, u, abs(dv), abs(du))
    v2, u2 = v + dv, u + du
    return color[v2, u2, 0], color[v2, u2, 1], color[v2, u2, 2], color[v2, u2, 3]


@kernel
def find_mixed(
    color: F4, disparity: F4, links: U1, right: U1, down: U1, row_low: int, row_high: int,
    out_sample: I4, out_pure: F4,
) -> int:  # fmt: skip
    """Samples that an edge runs through, and their colours without the other surface.

    An edge less than half way to the neighbour lies inside the sample's own pixel.

    Args:
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits.
        right: (H, W) from `find_edges`.
        down: (H, W).
        row_low: first row to do.
        row_high: row after the last.
        out_sample: (n,) their numbers ``v * W + u``, with room for every sample of the rows.
        out_pure: (n, 4).

    Returns:
        How many there are.
    """
    height, width = right.shape
    found = 0
    edged = np.zeros((width + EIGHT - 1) // EIGHT * EIGHT, np.uint8)
    places = np.zeros(edged.size, np.int32)
    for v in range(row_low, row_high):
        beside, below, above = right[v], down[v], down[max(v - 1, 0)]
        for u in range(width):
            edged[u] = np.uint8((beside[u] != MIDDLE) | (below[u] != MIDDLE) | (above[u] != MIDDLE))
        for u in range(width - 1):
            edged[u + 1] |= np.uint8(beside[u] != MIDDLE)
        for m in range(list_set(edged, places)):
            u = places[m]
            upright = is_strand(disparity, links, v, u, 0, 1)
            if upright or is_strand(disparity, links, v, u, 1, 0):
                dv, du = (0, 1) if upright else (1, 0)
                (
                    out_pure[found, 0], out_pure[found, 1], out_pure[found, 2], out_pure[found, 3],
                ) = strand_color(color, links, v, u, dv, du)  # fmt: skip
                out_sample[found] = v * width + u
                found += 1
                continue
            worst, dv, du = HALF, 0, 0
            for n in range(4):
                jv, ju = (0, 1) if n == 0 else (0, -1) if n == 1 else (1, 0) if n == 2 else (-1, 0)
                v2, u2, v3, u3 = v + 2 * jv, u + 2 * ju, v - jv, u - ju
                if min(v2, u2, v3, u3) < 0 or max(v2, v3) >= height or max(u2, u3) >= width:
                    continue
                reach = reach_toward(right, down, v, u, jv, ju)
                if reach < worst:
                    worst, dv, du = reach, jv, ju
            if worst >= HALF:
                continue
            own = HALF + worst
            others = mixed_in(color, disparity, links, v + dv, u + du, dv, du)
            for k in range(4):
                other, held = others[k], color[v, u, k]
                # a third colour is no mixture: never beyond the sample and the pure one beside it
                beside = color[v - dv, u - du, k]
                pure = (held - (ONE - own) * other) / own
                out_pure[found, k] = min(max(pure, min(held, beside)), max(held, beside))
            out_sample[found] = v * width + u
            found += 1
    return found


@kernel
def put(sample: I4, pure: F4, count: int, out_color: F4) -> None:
    """Write ``count`` colours (n, 4) into (H * W, 4)."""
    for n in range(count):
        for k in range(4):
            out_color[sample[n], k] = pure[n, k]
