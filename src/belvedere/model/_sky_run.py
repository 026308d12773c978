"""`_sky.sky_radiance` for eight pixels at once, in float32. Private.

Angles are counted in turns, so that a sine needs no division to find its period.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.eight import (
    Eight,
    abs8,
    eight,
    floor8,
    max8,
    min8,
    ramp8,
    sqrt8,
    store8,
    where8,
)
from belvedere.ground.jit import inner

A = npt.NDArray[Any]
F = np.float32

ZERO, HALF, ONE = F(0.0), F(0.5), F(1.0)
TURN = F(1.0 / (2.0 * math.pi))
S1, S3, S5, S7, S9 = F(6.2831852), F(-41.341665), F(81.601632), F(-76.564668), F(39.652800)
"""Least squares fit of sin(2 pi t) for t in [0, 1/4], good to 1e-8."""
T1, T3, T5, T7, T9 = F(0.99999999), F(-0.33332674), F(0.19987153), F(-0.14170064), F(0.10531653)
T11, T13, T15, T17 = F(-0.073027104), F(0.040575162), F(-0.014890372), F(0.0025799283)
"""Least squares fit of the arc tangent on [0, 1], good to 2e-8."""


@inner
def sine(turns: Eight) -> Eight:
    """Sine of an angle in turns."""
    t = turns - floor8(turns + HALF)
    a = abs8(t)
    a = min8(a, HALF - a)
    q = a * a
    value = a * ((((S9 * q + S7) * q + S5) * q + S3) * q + S1)
    return where8(t, eight(ZERO), value, ZERO - value)


@inner
def angle(y: Eight, x: Eight) -> Eight:
    """Direction of (x, y) in turns, in [-1/2, 1/2]."""
    a, b = abs8(x), abs8(y)
    q = min8(a, b) / max8(max8(a, b), F(1e-30))
    p = q * q
    t = (((((((T17 * p + T15) * p + T13) * p + T11) * p + T9) * p + T7) * p + T5) * p + T3) * p + T1
    t = t * q * TURN
    t = where8(b, a, F(0.25) - t, t)
    t = where8(eight(ZERO), x, HALF - t, t)
    return where8(eight(ZERO), y, ZERO - t, t)


@inner
def sky_run(x0: int, y: int, count: int, matrix: A, out_red: A, out_green: A, out_blue: A) -> None:
    """What ``count`` pixels of row y, from x0 on, see of the world outside."""
    zero = eight(ZERO)
    ax, ay, az = F(matrix[0, 0]), F(matrix[1, 0]), F(matrix[2, 0])
    bx = F(matrix[0, 0] * x0 + matrix[0, 1] * y + matrix[0, 2])
    by = F(matrix[1, 0] * x0 + matrix[1, 1] * y + matrix[1, 2])
    bz = F(matrix[2, 0] * x0 + matrix[2, 1] * y + matrix[2, 2])
    for i in range(0, count, 8):
        at = ramp8() + F(i)
        rx, ry, rz = at * ax + bx, at * ay + by, at * az + bz
        scale = ONE / sqrt8(rx * rx + ry * ry + rz * rz)
        dx, dy, dz = rx * scale, ry * scale, rz * scale
        azimuth = angle(dy, dx)
        rise = dz / sqrt8(max8(dx * dx + dy * dy, F(1e-12)))
        far = F(0.030) * sine(F(3.0) * azimuth + TURN) + F(0.020) * sine(F(7.0) * azimuth)
        far = far + F(0.085) + F(0.006) * sine(F(23.0) * azimuth + F(2.0) * TURN)
        near = F(0.018) * sine(F(5.0) * azimuth + F(0.6) * TURN) + F(0.012)
        near = near + F(0.009) * sine(F(17.0) * azimuth + F(1.7) * TURN)
        near = near + F(0.0045) * sine(F(61.0) * azimuth)
        near = near + F(0.0035) * sine(F(143.0) * azimuth + F(0.5) * TURN)
        # the sky
        high = min8(max8(dz, ZERO), ONE)
        up = sqrt8(high)
        haze = high * F(0.125)  # exp(-8 z): a series for z / 8 and its 64th power
        haze = ONE - haze * (ONE - haze * (HALF - haze * (F(1 / 6) - haze * F(1 / 24))))
        haze = haze * haze * haze * haze
        haze = haze * haze * haze * haze
        haze = haze * haze * haze * haze
        over = TURN / (dz + F(0.25))
        wisp = sine(F(4.0) * dx * over + (F(2.0) * TURN) * dy)
        wisp = max8(wisp * sine(F(3.0) * dy * over + TURN * dx), ZERO) * F(0.35)
        r = F(0.30) - F(0.10) * up + F(0.62) * haze
        g = F(0.55) - F(0.15) * up + F(0.42) * haze
        b = F(0.95) - F(0.14) * up + F(0.08) * haze
        r, g, b = (
            r + (F(0.98) - r) * wisp, g + (F(0.98) - g) * wisp, b + (F(0.99) - b) * wisp,
        )  # fmt: skip
        # hills
        deep = min8((far - rise) * F(6.0), ONE)
        hill_r, hill_g = F(0.40) - F(0.14) * deep, F(0.50) - F(0.10) * deep
        hill_b = F(0.58) - F(0.26) * deep
        # fields and hedges
        below = max8(near - rise, ZERO)
        depth = ONE / (below + F(0.05))
        field = sine(F(2.3) * azimuth * depth + F(1.3) * TURN)
        field = field * sine((F(1.1) * TURN) * depth + F(2.0) * azimuth)
        patch = F(0.025) * field
        patch = patch + F(0.02) * sine(F(9.0) * azimuth + (F(0.6) * TURN) * depth)
        trees = ONE - below * (F(9.0) * sine(F(37.0) * azimuth) + F(26.0))
        trees = max8(trees, ZERO)
        leafy = sine(F(311.0) * azimuth) * sine((F(180.0) * TURN) * rise + F(7.0) * azimuth)
        leafy = F(0.03) * leafy
        low_r, low_g = F(1.4) * patch + F(0.29), F(0.8) * patch + F(0.36)
        low_b = F(0.4) * patch + F(0.13)
        low_r = low_r + (leafy + F(0.12) - low_r) * trees
        low_g = low_g + (leafy + F(0.20) - low_g) * trees
        low_b = low_b + (F(0.09) - low_b) * trees
        above, hills = rise - far, rise - near
        r = where8(above, zero, r, where8(hills, zero, hill_r, low_r))
        g = where8(above, zero, g, where8(hills, zero, hill_g, low_g))
        b = where8(above, zero, b, where8(hills, zero, hill_b, low_b))
        store8(out_red, i, r)
        store8(out_green, i, g)
        store8(out_blue, i, b)
