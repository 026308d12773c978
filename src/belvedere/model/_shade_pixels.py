"""Loops that colour pixels whose face is known: exact disparity, texture, light. Private.

Everything on a face is affine in the position, so a pixel needs no corners: its ray meets the
face's plane, and texture and chart coordinates are four dot products away.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import inner, kernel
from belvedere.model._sky import sky_radiance

A = npt.NDArray[Any]
F = np.float32


@kernel
def face_tables(vertices: A, faces: A, origin: A, uv: A, st: A, out_plane: A, out_map: A) -> None:
    """What shading needs of each face.

    Args:
        vertices: (N, 3) float64.
        faces: (M, 3).
        origin: (3,) that positions are counted from, so that float32 holds them.
        uv: (M, 3, 2) texture coordinates of the corners.
        st: (M, 3, 2) chart coordinates.
        out_plane: (M, 4) float64 normal and height of each plane; zeros without area.
        out_map: (M, 4, 4) float32 rows for s, t, u, v: gradient, and value at the origin.
    """
    e, g, value = np.empty(3), np.empty(3), np.empty(3)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for k in range(3):
            e[k] = vertices[b, k] - vertices[a, k]
            g[k] = vertices[c, k] - vertices[a, k]
        nx, ny, nz = e[1] * g[2] - e[2] * g[1], e[2] * g[0] - e[0] * g[2], e[0] * g[1] - e[1] * g[0]
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        ee, eg, gg = 0.0, 0.0, 0.0
        for k in range(3):
            ee, eg, gg = ee + e[k] * e[k], eg + e[k] * g[k], gg + g[k] * g[k]
        det = ee * gg - eg * eg
        for k in range(4):
            out_plane[f, k] = 0.0
        if size > 0.0 and det > 0.0:
            out_plane[f, 0], out_plane[f, 1], out_plane[f, 2] = nx / size, ny / size, nz / size
            for k in range(3):
                out_plane[f, 3] += out_plane[f, k] * (vertices[a, k] - origin[k])
        for row in range(4):
            for i in range(3):
                value[i] = st[f, i, row] if row < 2 else uv[f, i, row - 2]
            p, q = value[1] - value[0], value[2] - value[0]
            along, up = 0.0, 0.0
            if det > 0.0:
                along, up = (p * gg - q * eg) / det, (q * ee - p * eg) / det
            at = value[0]
            for k in range(3):
                slope = along * e[k] + up * g[k]
                out_map[f, row, k] = slope
                at -= slope * (vertices[a, k] - origin[k])
            out_map[f, row, 3] = at


@inner
def film(radiance: Any) -> Any:
    """`_kernels.expose` in float32 and without a branch; negative radiance is black."""
    over = max(radiance - F(0.55), F(0.0))
    return max(min(radiance, F(0.55)), F(0.0)) + F(0.45) * over / (over + F(0.45))


@inner
def locate_run(
    f: int, x0: int, x1: int, y: int, matrix: A, eye: A, spread: Any, plane: A, maps: A,
    density: Any, out_disparity: A, out_s: A, out_t: A, out_u: A, out_v: A, out_foot: A,
) -> None:  # fmt: skip
    """Where the pixels x0..x1 of a row meet face f: disparity, coordinates, texels a pixel."""
    bx = matrix[0, 1] * y + matrix[0, 2]
    by = matrix[1, 1] * y + matrix[1, 2]
    bz = matrix[2, 1] * y + matrix[2, 2]
    ax, ay, az = matrix[0, 0], matrix[1, 0], matrix[2, 0]
    nx, ny, nz = plane[f, 0], plane[f, 1], plane[f, 2]
    ex, ey, ez = eye[0], eye[1], eye[2]
    above = plane[f, 3] - (nx * ex + ny * ey + nz * ez)
    start, slope = nx * bx + ny * by + nz * bz, nx * ax + ny * ay + nz * az
    over = 1.0 / above if above != 0.0 else 0.0
    sx, sy, sz, s1 = maps[f, 0, 0], maps[f, 0, 1], maps[f, 0, 2], maps[f, 0, 3]
    tx, ty, tz, t1 = maps[f, 1, 0], maps[f, 1, 1], maps[f, 1, 2], maps[f, 1, 3]
    ux, uy, uz, u1 = maps[f, 2, 0], maps[f, 2, 1], maps[f, 2, 2], maps[f, 2, 3]
    vx, vy, vz, v1 = maps[f, 3, 0], maps[f, 3, 1], maps[f, 3, 2], maps[f, 3, 3]
    for x in range(x0, x1):
        delta = (start + slope * x) * over
        # seen edge on, the corners' disparity is what there is
        delta = delta if 1e-9 < delta < 1e9 else np.float64(out_disparity[y, x])
        depth = 1.0 / delta
        rx, ry, rz = bx + ax * x, by + ay * x, bz + az * x
        out_disparity[y, x] = F(delta)
        px, py, pz = F(ex + depth * rx), F(ey + depth * ry), F(ez + depth * rz)
        s = sx * px + sy * py + sz * pz + s1
        t = tx * px + ty * py + tz * pz + t1
        out_s[x] = min(max(s, F(0.0)), F(1.0))
        out_t[x] = min(max(t, F(0.0)), F(1.0))
        out_u[x] = ux * px + uy * py + uz * pz + u1
        out_v[x] = vx * px + vy * py + vz * pz + v1
        length = F(rx * rx + ry * ry + rz * rz)
        facing = max(abs(F(start + slope * x)) / np.sqrt(length), F(0.04))
        out_foot[x] = F(depth) * spread * density * np.sqrt(length / facing)


@inner
def light_run(
    x0: int, x1: int, s: A, t: A, first: int, ns: int, nt: int, soft: A, sun_first: int,
    sun_ns: int, sun_nt: int, sun: A, sun_color: A, base: A, m: int, out_light: A,
) -> None:  # fmt: skip
    """Light that the pixels x0..x1 send back, the chart's lattices read bilinearly."""
    one = F(1.0)
    wide, high, sun_wide, sun_high = F(ns - 1), F(nt - 1), F(sun_ns - 1), F(sun_nt - 1)
    sr, sg, sb = F(sun_color[0]), F(sun_color[1]), F(sun_color[2])
    br, bg, bb = base[m, 0], base[m, 1], base[m, 2]
    for x in range(x0, x1):
        a, c = s[x] * wide, t[x] * high
        i, j = np.int32(a), np.int32(c)
        fa, fc = a - F(i), c - F(j)
        i1 = 1 if i + 1 < ns else 0
        j1 = ns if j + 1 < nt else 0
        at = first + j * ns + i
        w00, w10 = (one - fa) * (one - fc), fa * (one - fc)
        w01, w11 = (one - fa) * fc, fa * fc
        red = w00 * soft[at, 0] + w10 * soft[at + i1, 0]
        red += w01 * soft[at + j1, 0] + w11 * soft[at + i1 + j1, 0]
        green = w00 * soft[at, 1] + w10 * soft[at + i1, 1]
        green += w01 * soft[at + j1, 1] + w11 * soft[at + i1 + j1, 1]
        blue = w00 * soft[at, 2] + w10 * soft[at + i1, 2]
        blue += w01 * soft[at + j1, 2] + w11 * soft[at + i1 + j1, 2]
        a, c = s[x] * sun_wide, t[x] * sun_high
        i, j = np.int32(a), np.int32(c)
        fa, fc = a - F(i), c - F(j)
        i1 = 1 if i + 1 < sun_ns else 0
        j1 = sun_ns if j + 1 < sun_nt else 0
        at = sun_first + j * sun_ns + i
        lit = (one - fc) * ((one - fa) * sun[at] + fa * sun[at + i1])
        lit += fc * ((one - fa) * sun[at + j1] + fa * sun[at + i1 + j1])
        out_light[x, 0] = (red + lit * sr) * br
        out_light[x, 1] = (green + lit * sg) * bg
        out_light[x, 2] = (blue + lit * sb) * bb


@inner
def texture_run(
    x0: int, x1: int, u: A, v: A, foot: A, q: int, levels: A, texels: A, decode: A, out_light: A
) -> None:
    """Multiply the light of the pixels x0..x1 by their texture, two levels of it mixed."""
    one, half = F(1.0), F(0.5)
    finest = F(levels.shape[1] - 1.001)
    for x in range(x0, x1):
        level = np.log2(max(foot[x], F(1e-6))) + F(0.15)
        level = min(max(level, F(0.0)), finest)
        l0 = np.int32(level)
        fl = level - F(l0)
        if fl < F(0.02):
            fl = F(0.0)
        if fl > F(0.98):
            fl, l0 = F(0.0), l0 + 1
        uu, vv = u[x] - np.floor(u[x]), v[x] - np.floor(v[x])
        tr, tg, tb = F(0.0), F(0.0), F(0.0)
        for d in range(2):
            weight = one - fl if d == 0 else fl
            if weight == F(0.0):
                continue
            first = levels[q, l0 + d, 0]
            th, tw = levels[q, l0 + d, 1], levels[q, l0 + d, 2]
            a, c = uu * F(tw) + half, vv * F(th) + half
            i, j = np.int32(a), np.int32(c)
            fa, fc = a - F(i), c - F(j)
            i0 = i - 1 if i > 0 else tw - 1
            j0 = j - 1 if j > 0 else th - 1
            i1 = i if i < tw else 0
            j1 = j if j < th else 0
            p0, p1 = first + j0 * tw, first + j1 * tw
            w00, w10 = weight * (one - fa) * (one - fc), weight * fa * (one - fc)
            w01, w11 = weight * (one - fa) * fc, weight * fa * fc
            tr += w00 * decode[texels[p0 + i0, 0]] + w10 * decode[texels[p0 + i1, 0]]
            tr += w01 * decode[texels[p1 + i0, 0]] + w11 * decode[texels[p1 + i1, 0]]
            tg += w00 * decode[texels[p0 + i0, 1]] + w10 * decode[texels[p0 + i1, 1]]
            tg += w01 * decode[texels[p1 + i0, 1]] + w11 * decode[texels[p1 + i1, 1]]
            tb += w00 * decode[texels[p0 + i0, 2]] + w10 * decode[texels[p0 + i1, 2]]
            tb += w01 * decode[texels[p1 + i0, 2]] + w11 * decode[texels[p1 + i1, 2]]
        out_light[x, 0] *= tr
        out_light[x, 1] *= tg
        out_light[x, 2] *= tb


@inner
def sky_run(x0: int, x1: int, y: int, matrix: A, out_light: A) -> None:
    """What the pixels x0..x1 of a row see of the world outside."""
    for x in range(x0, x1):
        rx = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]
        ry = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]
        rz = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
        scale = 1.0 / math.sqrt(rx * rx + ry * ry + rz * rz)
        r, g, b = sky_radiance(rx * scale, ry * scale, rz * scale)
        out_light[x, 0], out_light[x, 1], out_light[x, 2] = F(r), F(g), F(b)


@inner
def encode_row(y: int, light: A, encode: A, out_color: A) -> None:
    """Expose and encode a row of pixels."""
    steps = F(encode.shape[0] - 1)
    for x in range(out_color.shape[1]):
        for c in range(3):
            root = np.sqrt(film(light[x, c])) * steps + F(0.5)
            out_color[y, x, c] = encode[np.int32(root)]


@kernel
def shade_pixels(
    face: A, row0: int, row1: int, matrix: A, eye: A, spread: float, plane: A, maps: A, of_face: A,
    density: A, material: A, base: A, emission: A, texture_of: A, texels: A, levels: A, decode: A,
    encode: A, soft_first: A, soft_shape: A, soft: A, sun_first: A, sun_shape: A, sun: A,
    sun_color: A, out_disparity: A, out_color: A,
) -> None:  # fmt: skip
    """Colour the pixels of some rows; agrees with `_kernels.shade` to rounding.

    Args:
        face: (H, W) int32; -1 is the sky.
        row0: first row.
        row1: the row after the last.
        matrix: (3, 3) of the camera.
        eye: (3,) in the frame of the tables.
        spread: angle between neighbouring pixels, radians.
        plane: (M, 4) from `face_tables`.
        maps: (M, 4, 4) from `face_tables`.
        of_face: (M,) chart of each face.
        density: (M,) see `photograph.Shading`, like all up to ``levels``.
        material: (M,) of each face.
        base: (T, 3) of each material.
        emission: (T, 3).
        texture_of: (T,) row of ``levels``, or -1.
        texels: (X, 3) uint8.
        levels: (Q, L, 3).
        decode: (256,) linear light of each byte.
        encode: (N,) byte of linear light.
        soft_first: (K,) see `LightMap`, like all up to ``sun_color``.
        soft_shape: (K, 2).
        soft: (P, 3).
        sun_first: (K,).
        sun_shape: (K, 2).
        sun: (S,).
        sun_color: (3,).
        out_disparity: (H, W) float32, made exact.
        out_color: (H, W, 3) uint8.
    """
    width = face.shape[1]
    s, t, u, v, foot = np.empty((5, width), np.float32)
    light = np.empty((width, 3), np.float32)
    wide = F(spread)
    for y in range(row0, row1):
        x = 0
        while x < width:
            f, x0 = face[y, x], x
            while x < width and face[y, x] == f:
                x += 1
            if f < 0:
                sky_run(x0, x, y, matrix, light)
                for i in range(x0, x):
                    out_disparity[y, i] = F(0.0)
                continue
            locate_run(
                f,
                x0,
                x,
                y,
                matrix,
                eye,
                wide,
                plane,
                maps,
                density[f],
                out_disparity,
                s,
                t,
                u,
                v,
                foot,
            )
            k, m = of_face[f], material[f]
            light_run(
                x0,
                x,
                s,
                t,
                soft_first[k],
                soft_shape[k, 0],
                soft_shape[k, 1],
                soft,
                sun_first[k],
                sun_shape[k, 0],
                sun_shape[k, 1],
                sun,
                sun_color,
                base,
                m,
                light,
            )
            if texture_of[m] >= 0:
                texture_run(x0, x, u, v, foot, texture_of[m], levels, texels, decode, light)
            if emission[m, 0] + emission[m, 1] + emission[m, 2] > F(0.0):
                for i in range(x0, x):
                    for c in range(3):
                        light[i, c] += emission[m, c]
        encode_row(y, light, encode, out_color)
