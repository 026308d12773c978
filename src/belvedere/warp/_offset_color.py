"""The reference's colour at the place that a sub-sample's word holds."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import (
    Four,
    add4,
    add16,
    fold16,
    load4,
    load16,
    mul16,
    scale4,
    scale16,
)
from belvedere.warp._edges import INTACT, joined
from belvedere.warp._offset_word import STEPS

F4 = npt.NDArray[np.float32]
U1 = npt.NDArray[np.uint8]

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)


@inner
def smooth_color(
    color: F4, stride: int, spread: F4, cubics: F4, sample: int, step_v: Real, step_u: Real
) -> Four:
    """Bicubic colour between sixteen samples; ``sample`` is the flat index of the first."""
    first, second = load16(color, sample), load16(color, sample + stride)
    third, last = load16(color, sample + 2 * stride), load16(color, sample + 3 * stride)
    at = step_v << np.uint64(2)
    upper = add16(scale16(first, cubics[at]), scale16(second, cubics[at + np.uint64(1)]))
    lower = add16(
        scale16(third, cubics[at + np.uint64(2)]), scale16(last, cubics[at + np.uint64(3)])
    )
    return fold16(mul16(add16(upper, lower), load16(spread, step_u << np.uint64(2))))


@inner
def edge_color(color: F4, links: U1, v: int, u: int, step_v: Real, step_u: Real) -> Four:
    """Colour in a cell beside an edge or the border: bilinear, with what is of one surface."""
    stride = color.shape[1]
    fu, fv = np.float32(step_u) / STEPS, np.float32(step_v) / STEPS
    whole = v >= 0 and u >= 0 and (links[v, u] & INTACT) != 0
    dv, du = 1, 1
    if not whole and fu >= HALF:  # a broken cell: from the sample whose quarter it is
        u, fu, du = u + 1, ONE - fu, -1
    if not whole and fv >= HALF:
        v, fv, dv = v + 1, ONE - fv, -1
    across = whole or joined(links, v, u, 0, du)
    along = whole or joined(links, v, u, dv, 0)
    sample, product = v * stride + u, fu * fv if whole else ZERO
    share_u, share_v = fu - product if across else ZERO, fv - product if along else ZERO
    value = scale4(load4(color, sample), ONE - product - share_u - share_v)
    # what has no share may lie outside the picture, or be no number: the sample itself instead
    beside = sample + du if across else sample
    below = sample + dv * stride if along else sample
    value = add4(value, scale4(load4(color, beside), share_u))
    value = add4(value, scale4(load4(color, below), share_v))
    return add4(value, scale4(load4(color, sample + stride + 1 if whole else sample), product))
