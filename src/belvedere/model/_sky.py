"""The world outside the windows, infinitely far: sky, hills, trees and fields. Private."""

from __future__ import annotations

import math

from belvedere.ground.jit import kernel


@kernel
def sky_radiance(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Linear radiance of the world outside along the unit direction (x, y, z)."""
    azimuth = math.atan2(y, x)
    rise = z / math.sqrt(max(x * x + y * y, 1e-12))
    far = 0.085 + 0.030 * math.sin(3.0 * azimuth + 1.0) + 0.020 * math.sin(7.0 * azimuth)
    far += 0.006 * math.sin(23.0 * azimuth + 2.0)
    near = 0.012 + 0.018 * math.sin(5.0 * azimuth + 0.6) + 0.009 * math.sin(17.0 * azimuth + 1.7)
    near += 0.0045 * math.sin(61.0 * azimuth) + 0.0035 * math.sin(143.0 * azimuth + 0.5)
    if rise > far:
        up = math.sqrt(min(max(z, 0.0), 1.0))
        haze = math.exp(-8.0 * max(z, 0.0))
        r = 0.30 * (1.0 - up) + 0.20 * up + 0.62 * haze
        g = 0.55 * (1.0 - up) + 0.40 * up + 0.42 * haze
        b = 0.95 - 0.14 * up + 0.08 * haze
        wisp = math.sin(4.0 * x / (z + 0.25) + 2.0 * y) * math.sin(3.0 * y / (z + 0.25) + x)
        wisp = max(wisp, 0.0) * 0.35
        return r + (0.98 - r) * wisp, g + (0.98 - g) * wisp, b + (0.99 - b) * wisp
    if rise > near:
        deep = min((far - rise) * 6.0, 1.0)
        return 0.40 - 0.14 * deep, 0.50 - 0.10 * deep, 0.58 - 0.26 * deep
    depth = 1.0 / (near - rise + 0.05)  # fields and hedges, foreshortened towards the horizon
    field = math.sin(2.3 * azimuth * depth + 1.3) * math.sin(1.1 * depth + 2.0 * azimuth)
    patch = 0.025 * field + 0.02 * math.sin(9.0 * azimuth + 0.6 * depth)
    trees = max(0.0, 1.0 - (near - rise) * (26.0 + 9.0 * math.sin(37.0 * azimuth)))
    r, g, b = 0.29 + 1.4 * patch, 0.36 + 0.8 * patch, 0.13 + 0.4 * patch
    leafy = 0.03 * math.sin(311.0 * azimuth) * math.sin(180.0 * rise + 7.0 * azimuth)
    return r + (0.12 + leafy - r) * trees, g + (0.20 + leafy - g) * trees, b + (0.09 - b) * trees
