"""Kernels that measure what is one sample wide: a bar, a cable, the edge of a board.

Such a strand may have no sample of its pure colour: lying between two rows of samples, it is mixed
with what is behind it in both. But the light it adds to the samples across it is its own colour
times its width, wherever it lies, and where that light lies tells where its two edges run.

::

    share of the strand     0    0.1    1    0.4    0
                         |    |   ##|####|##  |    |      width 1.5: both neighbours have some,
    samples                 B    L    C    R    B         so the sample between is pure
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.warp._edges import DOWN, MIXED, RIGHT, joined

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)
NOISE = np.float32(1e-4)
"""Squared difference of linear colours that is nothing: a hundredth of white."""
SOME = np.float32(0.05)
"""Share of a strand's light from which on a sample beside it surely has some of it."""


@inner
def apart(color: F4, v: int, u: int, v2: int, u2: int) -> Real:
    """Squared distance of two samples' colours."""
    total = ZERO
    for k in range(3):
        step = color[v, u, k] - color[v2, u2, k]
        total += step * step
    return total


@inner
def is_strand(disparity: F4, links: U1, v: int, u: int, dv: int, du: int) -> bool:
    """Whether the surface of (v, u) is one sample wide across (dv, du), before others that are not.

    It must go on at one end at least: a speck is no strand.
    """
    if links[v, u] & (MIXED | (RIGHT if du > 0 else DOWN)):
        return False
    height, width = links.shape
    if v < 2 * dv or u < 2 * du or v + 2 * dv >= height or u + 2 * du >= width:
        return False
    behind = max(disparity[v - dv, u - du], disparity[v + dv, u + du])
    return (
        disparity[v, u] > behind
        and not joined(links, v, u, -dv, -du)
        and (joined(links, v, u, du, dv) or joined(links, v, u, -du, -dv))
        and joined(links, v + dv, u + du, dv, du)
        and joined(links, v - dv, u - du, -dv, -du)
    )


@inner
def light_across(
    color: F4, links: U1, v: int, u: int, dv: int, du: int
) -> tuple[Real, Real, Real, Real]:
    """Width of a strand, how much of its light is in the samples before and after, and trust.

    The colours behind are those two samples away. Trust falls to 0 where their textures are as loud
    as the strand.
    """
    before, after, mass, texture = ZERO, ZERO, ZERO, NOISE
    for k in range(3):
        low, high = color[v - 2 * dv, u - 2 * du, k], color[v + 2 * dv, u + 2 * du, k]
        left, right = color[v - dv, u - du, k] - low, color[v + dv, u + du, k] - high
        whole = left + right + color[v, u, k] - HALF * (low + high)
        before += left * whole
        after += right * whole
        mass += whole * whole
        texture += HALF * (low - high) * (low - high)
    for side in (-3, 3):
        v2, u2 = v + side * dv, u + side * du
        inward = 1 if side < 0 else -1
        if joined(links, v2 + inward * dv, u2 + inward * du, -inward * dv, -inward * du):
            texture += apart(color, v2, u2, v2 + inward * dv, u2 + inward * du)
    if not mass > texture:
        return ONE, ZERO, ZERO, ZERO
    before, after = min(max(before / mass, ZERO), HALF), min(max(after / mass, ZERO), HALF)
    both = min(min(before, after) / SOME, ONE)
    center = max(ONE - before - after, HALF)
    return ONE + both * (ONE / center - ONE), before, after, ONE - texture / mass


@inner
def strand_reach(color: F4, links: U1, v: int, u: int, dv: int, du: int) -> tuple[Real, Real]:
    """How far a strand reaches toward the samples before and after it, 0 to 1."""
    width, before, after, trust = light_across(color, links, v, u, dv, du)
    if after >= before:
        ahead = HALF + after * width
        back = width - ahead
    else:
        back = HALF + before * width
        ahead = width - back
    back, ahead = HALF + trust * (back - HALF), HALF + trust * (ahead - HALF)
    return min(max(back, ZERO), ONE), min(max(ahead, ZERO), ONE)


@inner
def strand_color(
    color: F4, links: U1, v: int, u: int, dv: int, du: int
) -> tuple[Real, Real, Real, Real]:
    """The colour of a strand, without what is behind it; the fourth channel is alpha."""
    width, _, _, trust = light_across(color, links, v, u, dv, du)
    return (
        channel(color, v, u, dv, du, 0, width, trust),
        channel(color, v, u, dv, du, 1, width, trust),
        channel(color, v, u, dv, du, 2, width, trust),
        channel(color, v, u, dv, du, 3, width, trust),
    )


@inner
def channel(color: F4, v: int, u: int, dv: int, du: int, k: int, width: Real, trust: Real) -> Real:
    """One channel of `strand_color`."""
    low, high = color[v - 2 * dv, u - 2 * du, k], color[v + 2 * dv, u + 2 * du, k]
    held, behind = color[v, u, k], HALF * (low + high)
    light = held + color[v - dv, u - du, k] + color[v + dv, u + du, k] - low - high - behind
    return max(held + trust * (behind + light / width - held), ZERO)
