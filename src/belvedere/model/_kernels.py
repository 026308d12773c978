"""Loops that take photographs: exact disparity, hits on planes, shading. Private."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel
from belvedere.model._sky import sky_radiance

A = npt.NDArray[Any]


@kernel
def expose(radiance: float) -> float:
    """A film's shoulder: linear up to 0.55, then ever less, reaching 1 only at infinity."""
    if radiance <= 0.55:
        return radiance
    return 1.0 - 0.45 / (1.0 + (radiance - 0.55) / 0.45)


@kernel
def shade(
    face: A, u: A, v: A, directions: A, range_m: A, spread: float, per_pixel: int,
    pixel: A, of_face: A, st: A, uv: A, density: A, normal: A, material: A, base: A, emission: A,
    colors: A, texture_of: A, texels: A, levels: A, decode: A, soft_first: A, soft_shape: A,
    soft: A, sun_first: A, sun_shape: A, sun: A, sun_color: A, out_color: A,
) -> None:  # fmt: skip
    """Add the mean radiance of every ``per_pixel`` samples to ``out_color[pixel]``.

    Args are the arrays of `photograph.Shading`; ``range_m`` is the distance in metres, ``spread``
    the angle between samples.
    """
    light = np.zeros(3)
    share = 1.0 / per_pixel
    for i in range(face.shape[0]):
        at = pixel[i // per_pixel]
        f = face[i]
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        scale = 1.0 / math.sqrt(x * x + y * y + z * z)
        if f < 0:
            r, g, b = sky_radiance(x * scale, y * scale, z * scale)
            out_color[at, 0] += expose(r) * share
            out_color[at, 1] += expose(g) * share
            out_color[at, 2] += expose(b) * share
            continue
        k = of_face[f]
        w = 1.0 - u[i] - v[i]
        s = w * st[f, 0, 0] + u[i] * st[f, 1, 0] + v[i] * st[f, 2, 0]
        t = w * st[f, 0, 1] + u[i] * st[f, 1, 1] + v[i] * st[f, 2, 1]
        s, t = min(max(s, 0.0), 1.0), min(max(t, 0.0), 1.0)
        m = material[f]
        # light: soft lattice, bilinear
        a, b2 = s * (soft_shape[k, 0] - 1), t * (soft_shape[k, 1] - 1)
        i0, j0 = int(a), int(b2)
        fa, fb = a - i0, b2 - j0
        i1, j1 = min(i0 + 1, soft_shape[k, 0] - 1), min(j0 + 1, soft_shape[k, 1] - 1)
        row0, row1 = soft_first[k] + j0 * soft_shape[k, 0], soft_first[k] + j1 * soft_shape[k, 0]
        for c in range(3):
            low = soft[row0 + i0, c] * (1 - fa) + soft[row0 + i1, c] * fa
            high = soft[row1 + i0, c] * (1 - fa) + soft[row1 + i1, c] * fa
            light[c] = low * (1 - fb) + high * fb
        # sun lattice, bilinear
        a, b2 = s * (sun_shape[k, 0] - 1), t * (sun_shape[k, 1] - 1)
        i0, j0 = int(a), int(b2)
        fa, fb = a - i0, b2 - j0
        i1, j1 = min(i0 + 1, sun_shape[k, 0] - 1), min(j0 + 1, sun_shape[k, 1] - 1)
        row0, row1 = sun_first[k] + j0 * sun_shape[k, 0], sun_first[k] + j1 * sun_shape[k, 0]
        lit = (sun[row0 + i0] * (1 - fa) + sun[row0 + i1] * fa) * (1 - fb)
        lit += (sun[row1 + i0] * (1 - fa) + sun[row1 + i1] * fa) * fb
        for c in range(3):
            light[c] = (light[c] + lit * sun_color[c]) * base[m, c]
            if colors.shape[0] > 0:
                tint = w * colors[f, 0, c] + u[i] * colors[f, 1, c] + v[i] * colors[f, 2, c]
                light[c] *= max(tint, 0.0)
        q = texture_of[m]
        if q >= 0:
            facing = abs(x * normal[f, 0] + y * normal[f, 1] + z * normal[f, 2]) * scale
            foot = range_m[i] * spread * density[f] / math.sqrt(max(facing, 0.04))
            level = min(max(math.log2(max(foot, 1e-6)) + 0.15, 0.0), levels.shape[1] - 1.001)
            l0 = int(level)
            fl = level - l0
            tu = w * uv[f, 0, 0] + u[i] * uv[f, 1, 0] + v[i] * uv[f, 2, 0]
            tv = w * uv[f, 0, 1] + u[i] * uv[f, 1, 1] + v[i] * uv[f, 2, 1]
            tr, tg, tb = 0.0, 0.0, 0.0
            for d in range(2):
                weight = 1.0 - fl if d == 0 else fl
                if weight == 0.0:
                    continue
                first, th, tw = levels[q, l0 + d, 0], levels[q, l0 + d, 1], levels[q, l0 + d, 2]
                a = (tu - math.floor(tu)) * tw - 0.5
                b2 = (tv - math.floor(tv)) * th - 0.5
                fx, fy = math.floor(a), math.floor(b2)
                fa, fb = a - fx, b2 - fy
                x0, y0 = int(fx), int(fy)
                x0 = x0 + tw if x0 < 0 else x0
                y0 = y0 + th if y0 < 0 else y0
                x1 = x0 + 1 if x0 + 1 < tw else 0
                y1 = y0 + 1 if y0 + 1 < th else 0
                for corner in range(4):
                    cx, cy = x1 if corner & 1 else x0, y1 if corner & 2 else y0
                    wx, wy = fa if corner & 1 else 1 - fa, fb if corner & 2 else 1 - fb
                    texel = first + cy * tw + cx
                    wt = weight * wx * wy
                    tr += wt * decode[texels[texel, 0]]
                    tg += wt * decode[texels[texel, 1]]
                    tb += wt * decode[texels[texel, 2]]
            light[0] *= tr
            light[1] *= tg
            light[2] *= tb
        for c in range(3):
            out_color[at, c] += expose(light[c] + emission[m, c]) * share


@kernel
def exact_disparity(
    face: A, origins: A, directions: A, vertices: A, faces: A, out_delta: A
) -> None:
    """Disparity of centre rays from the plane of the face they meet, in float64; 0 for the sky."""
    for i in range(face.shape[0]):
        f = face[i]
        if f < 0:
            out_delta[i] = 0.0
            continue
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        e0 = vertices[b, 0] - vertices[a, 0]
        e1 = vertices[b, 1] - vertices[a, 1]
        e2 = vertices[b, 2] - vertices[a, 2]
        g0 = vertices[c, 0] - vertices[a, 0]
        g1 = vertices[c, 1] - vertices[a, 1]
        g2 = vertices[c, 2] - vertices[a, 2]
        nx, ny, nz = e1 * g2 - e2 * g1, e2 * g0 - e0 * g2, e0 * g1 - e1 * g0
        above = nx * (vertices[a, 0] - origins[i, 0]) + ny * (vertices[a, 1] - origins[i, 1])
        above += nz * (vertices[a, 2] - origins[i, 2])
        along = nx * directions[i, 0] + ny * directions[i, 1] + nz * directions[i, 2]
        out_delta[i] = along / above


@kernel
def plane_disparities(
    face: A, row0: int, row1: int, matrix: A, eye: A, plane: A, out_disparity: A
) -> int:
    """Disparity of pixels in some rows from the planes of the faces they show; 0 in the sky.

    Args:
        face: (H, W) int32; -1 is the sky.
        row0: first row.
        row1: the row after the last.
        matrix: (3, 3) of the camera.
        eye: (3,) in the planes' frame.
        plane: (M, 4) normal and height.
        out_disparity: (H, W) float32; NaN where a plane is seen edge on.

    Returns:
        How many are NaN.
    """
    unknown = 0
    for y in range(row0, row1):
        before, start, slope = -1, 0.0, 0.0
        for x in range(face.shape[1]):
            f = face[y, x]
            if f < 0:
                out_disparity[y, x] = 0.0
                continue
            if f != before:
                before = f
                nx, ny, nz = plane[f, 0], plane[f, 1], plane[f, 2]
                above = plane[f, 3] - (nx * eye[0] + ny * eye[1] + nz * eye[2])
                slope = (nx * matrix[0, 0] + ny * matrix[1, 0] + nz * matrix[2, 0]) / above
                start = nx * (matrix[0, 1] * y + matrix[0, 2])
                start += ny * (matrix[1, 1] * y + matrix[1, 2])
                start = (start + nz * (matrix[2, 1] * y + matrix[2, 2])) / above
            delta = start + slope * x
            if 1e-9 < delta < 1e9:
                out_disparity[y, x] = delta
            else:  # NaN too
                out_disparity[y, x] = math.nan
                unknown += 1
    return unknown


@kernel
def find_plain(chart: A, flat: A, out_plain: A) -> None:
    """Pixels whose 3x3 neighbours (H, W) all see one flat chart, or all the sky."""
    height, width = chart.shape
    for v in range(height):
        for u in range(width):
            here = chart[v, u]
            plain = here < 0 or flat[here]
            for y in range(max(v - 1, 0), min(v + 2, height)):
                for x in range(max(u - 1, 0), min(u + 2, width)):
                    plain = plain and chart[y, x] == here
            out_plain[v, u] = plain


@kernel
def plane_hits(
    face: A, origins: A, directions: A, vertices: A, faces: A, out_u: A, out_v: A, out_t: A
) -> None:
    """Where rays meet the planes of given faces: barycentrics and distance."""
    for i in range(face.shape[0]):
        f = face[i]
        if f < 0:
            continue
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        e0 = vertices[b, 0] - vertices[a, 0]
        e1 = vertices[b, 1] - vertices[a, 1]
        e2 = vertices[b, 2] - vertices[a, 2]
        g0 = vertices[c, 0] - vertices[a, 0]
        g1 = vertices[c, 1] - vertices[a, 1]
        g2 = vertices[c, 2] - vertices[a, 2]
        h0 = origins[i, 0] - vertices[a, 0]
        h1 = origins[i, 1] - vertices[a, 1]
        h2 = origins[i, 2] - vertices[a, 2]
        d0, d1, d2 = directions[i, 0], directions[i, 1], directions[i, 2]
        p0, p1, p2 = d1 * g2 - d2 * g1, d2 * g0 - d0 * g2, d0 * g1 - d1 * g0
        determinant = e0 * p0 + e1 * p1 + e2 * p2  # Moeller and Trumbore 1997
        q0, q1, q2 = h1 * e2 - h2 * e1, h2 * e0 - h0 * e2, h0 * e1 - h1 * e0
        t = (g0 * q0 + g1 * q1 + g2 * q2) / determinant
        if not 0.0 < t < 1e9:  # a sample past the horizon of a surface seen edge on; NaN too
            out_u[i], out_v[i], out_t[i] = 1.0 / 3.0, 1.0 / 3.0, 0.0
            continue
        out_u[i] = (h0 * p0 + h1 * p1 + h2 * p2) / determinant
        out_v[i] = (d0 * q0 + d1 * q1 + d2 * q2) / determinant
        out_t[i] = t
