"""Where a sample lands: between planes as fast as can be, between any two central cameras at all.

The geometry of a passage says by its type what it is. ``float32`` (12,) is a warp matrix between
planar cameras; ``float64`` (12 + 2 CHART,) comes from `manifold.geometry` and may have a cylinder
or a sphere at either end. Kernels are compiled for one or the other, so that planes pay nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from numba import types
from numba.extending import overload

from belvedere.ground.jit import Real, inner

Geometry = npt.NDArray[Any]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NAN = np.float32(np.nan)
SOURCE, TARGET = 12, 19
"""Where the two charts begin in a geometry; see `manifold.chart`."""
LIFT = 1e-30
"""Squared distance from a panorama's eye, relative to the rays, below which there is no image."""


@inner
def direction(g: Geometry, base: int, u: Real, v: Real) -> tuple[Real, Real, Real]:
    """Ray of a pixel in its camera's own frame; base is `SOURCE` or `TARGET`."""
    if g[base] == 0.0:
        return u, v, 1.0
    psi = g[base + 1] - u * g[base + 2]
    up = (g[base + 3] - v) * g[base + 4]
    if g[base] == 1.0:
        return np.cos(psi), np.sin(psi), up
    flat = np.cos(up)
    return flat * np.cos(psi), flat * np.sin(psi), np.sin(up)


@inner
def project(g: Geometry, base: int, a: Real, b: Real, c: Real) -> tuple[Real, Real, Real]:
    """Pixel of a direction in its camera's own frame, and one over its length there.

    The length is NaN where the camera has no image of it: behind a plane, at the eye, on the axis
    of a cylinder. Columns are those of the panorama's own turn.
    """
    if g[base] == 0.0:
        scale = 1.0 / c if c > 0.0 else np.nan
        return a * scale, b * scale, scale
    flat = a * a + b * b
    whole = flat if g[base] == 1.0 else flat + c * c
    scale = 1.0 / np.sqrt(whole) if whole > LIFT else np.nan
    x = (g[base + 1] - np.arctan2(b, a)) / g[base + 2]
    x -= g[base + 5] * np.floor((x - g[base + 6]) / g[base + 5])
    up = c * scale if g[base] == 1.0 else np.arctan2(c, np.sqrt(flat))
    return x, g[base + 3] - up / g[base + 4], scale


@inner
def reach(g: Geometry, u: Real, v: Real, delta: Real) -> tuple[Real, Real, Real]:
    """Y: what a sample is seen along from the desired eye, in that camera's frame.

    The sample stands at ``Y / delta``.
    """
    a, b, c = direction(g, SOURCE, u, v)
    return (
        g[0] * a + g[1] * b + g[2] * c + g[3] * delta,
        g[4] * a + g[5] * b + g[6] * c + g[7] * delta,
        g[8] * a + g[9] * b + g[10] * c + g[11] * delta,
    )


@inner
def land_flat(g: Geometry, u: Real, v: Real, delta: Real) -> tuple[Real, Real, Real]:
    """`land` between planar cameras."""
    t = g[8] * u + g[9] * v + g[10] + g[11] * delta
    scale = ONE / t if t > ZERO else NAN
    x = (g[0] * u + g[1] * v + g[2] + g[3] * delta) * scale
    return x, (g[4] * u + g[5] * v + g[6] + g[7] * delta) * scale, scale


@inner
def land_bent(g: Geometry, u: Real, v: Real, delta: Real) -> tuple[Real, Real, Real]:
    """`land` between any two central cameras."""
    a, b, c = reach(g, np.float64(u), np.float64(v), np.float64(delta))
    x, y, scale = project(g, TARGET, a, b, c)
    return np.float32(x), np.float32(y), np.float32(scale)


@inner
def bend_back(
    back: Geometry, y4: Real, x_low: int, front: Any, count: int, taps: Any, out_corner: Any,
    stride: int, height: int,
) -> None:  # fmt: skip
    """`_lookup.land_back` to or from a panorama; arguments as there."""
    last_u, last_v = np.float32(stride - 1), np.float32(height - 1)
    half, two, three = np.float32(0.5), np.float32(2.0), np.float32(3.0)
    four, five = np.float32(4.0), np.float32(5.0)
    for i in range(count):
        u, v, scale = land_bent(back, np.float32(x_low + i), y4, front[i])
        inside = (u >= ZERO) & (v >= ZERO) & (u < last_u) & (v < last_v)
        left, top = np.floor(u if inside else ZERO), np.floor(v if inside else ZERO)
        taps[0, i], taps[1, i], taps[2, i] = u, v, front[i] * scale
        out_corner[i] = int(top) * stride + int(left) if inside else -1
        for axis in range(2):
            f = u - left if axis == 0 else v - top
            taps[4 * axis + 3, i] = half * f * (f * (two - f) - ONE)
            taps[4 * axis + 4, i] = half * (f * f * (three * f - five) + two)
            taps[4 * axis + 5, i] = half * f * (f * (four - three * f) + ONE)
            taps[4 * axis + 6, i] = half * f * f * (f - ONE)


def land(g: Geometry, u: Real, v: Real, delta: Real) -> tuple[Real, Real, Real]:
    """Where a sample lands, and the factor of its disparity; NaN where it has no image.

    Args:
        g: geometry of the passage.
        u: column.
        v: row.
        delta: disparity.
    """
    return (land_flat if g.dtype == np.float32 else land_bent)(g, u, v, delta)


def is_flat(g: Any) -> bool:
    """Whether a geometry's Numba type is that of a passage between planes."""
    return g.dtype == types.float32


# Numba compiles what is returned: it must be a function with the names of the original.
# ruff: noqa: PLW0108
@overload(land, jit_options={"forceinline": True}, strict=False)
def _land(g: Any, u: Any, v: Any, delta: Any) -> Any:
    if is_flat(g):
        return lambda g, u, v, delta: land_flat(g, u, v, delta)
    return lambda g, u, v, delta: land_bent(g, u, v, delta)
