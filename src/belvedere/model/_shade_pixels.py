"""Loops that colour pixels whose face is known: exact disparity, texture, light. Private.

Everything on a face is affine in the position, so a pixel needs no corners: its ray meets the
face's plane, and texture and chart coordinates are four dot products away.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel
from belvedere.model._kernels import expose
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


@kernel
def shade_pixels(
    face: A, row0: int, row1: int, matrix: A, eye: A, spread: float, plane: A, maps: A, of_face: A,
    density: A, material: A, base: A, emission: A, texture_of: A, texels: A, levels: A, decode: A,
    encode: A, soft_first: A, soft_shape: A, soft: A, sun_first: A, sun_shape: A, sun: A,
    sun_color: A, wanted: A, out_disparity: A, out_color: A,
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
        of_face, density, material, base, emission, texture_of, texels, levels: see
            `photograph.Shading`.
        decode: (256,) linear light of each byte.
        encode: (N,) byte of linear light.
        soft_first, soft_shape, soft, sun_first, sun_shape, sun, sun_color: see `LightMap`.
        wanted: (H, W) bool, or (0, 0) for all: the others are left as they are.
        out_disparity: (H, W) float32, made exact.
        out_color: (H, W, 3) uint8.
    """
    steps = F(encode.shape[0] - 1)
    one, zero, some = F(1.0), F(0.0), wanted.shape[0] > 0
    sun_r, sun_g, sun_b = F(sun_color[0]), F(sun_color[1]), F(sun_color[2])
    wide = F(spread)
    finest = F(levels.shape[1] - 1.001)
    for y in range(row0, row1):
        for x in range(face.shape[1]):
            if some and not wanted[y, x]:
                continue
            rx = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]
            ry = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]
            rz = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
            length = math.sqrt(rx * rx + ry * ry + rz * rz)
            f = face[y, x]
            if f < 0:
                out_disparity[y, x] = zero
                r, g, b = sky_radiance(rx / length, ry / length, rz / length)
                out_color[y, x, 0] = encode[int(F(math.sqrt(expose(r))) * steps + F(0.5))]
                out_color[y, x, 1] = encode[int(F(math.sqrt(expose(g))) * steps + F(0.5))]
                out_color[y, x, 2] = encode[int(F(math.sqrt(expose(b))) * steps + F(0.5))]
                continue
            nx, ny, nz = plane[f, 0], plane[f, 1], plane[f, 2]
            above = plane[f, 3] - (nx * eye[0] + ny * eye[1] + nz * eye[2])
            along = nx * rx + ny * ry + nz * rz
            depth = above / along
            if depth > 0.0 and depth < 1e9:
                out_disparity[y, x] = F(along / above)
            else:  # seen edge on: the corners' disparity is what there is
                depth = 1.0 / out_disparity[y, x]
            px = F(eye[0] + depth * rx)
            py = F(eye[1] + depth * ry)
            pz = F(eye[2] + depth * rz)
            k = of_face[f]
            s = maps[f, 0, 0] * px + maps[f, 0, 1] * py + maps[f, 0, 2] * pz + maps[f, 0, 3]
            t = maps[f, 1, 0] * px + maps[f, 1, 1] * py + maps[f, 1, 2] * pz + maps[f, 1, 3]
            s, t = min(max(s, zero), one), min(max(t, zero), one)
            # soft light, bilinear
            ns = soft_shape[k, 0]
            a, c = s * F(ns - 1), t * F(soft_shape[k, 1] - 1)
            i, j = int(a), int(c)
            fa, fc = a - F(i), c - F(j)
            i1 = 1 if i + 1 < ns else 0
            j1 = ns if j + 1 < soft_shape[k, 1] else 0
            at = soft_first[k] + j * ns + i
            w00, w10 = (one - fa) * (one - fc), fa * (one - fc)
            w01, w11 = (one - fa) * fc, fa * fc
            red = w00 * soft[at, 0] + w10 * soft[at + i1, 0]
            red += w01 * soft[at + j1, 0] + w11 * soft[at + i1 + j1, 0]
            green = w00 * soft[at, 1] + w10 * soft[at + i1, 1]
            green += w01 * soft[at + j1, 1] + w11 * soft[at + i1 + j1, 1]
            blue = w00 * soft[at, 2] + w10 * soft[at + i1, 2]
            blue += w01 * soft[at + j1, 2] + w11 * soft[at + i1 + j1, 2]
            # the sun, bilinear
            ns = sun_shape[k, 0]
            a, c = s * F(ns - 1), t * F(sun_shape[k, 1] - 1)
            i, j = int(a), int(c)
            fa, fc = a - F(i), c - F(j)
            i1 = 1 if i + 1 < ns else 0
            j1 = ns if j + 1 < sun_shape[k, 1] else 0
            at = sun_first[k] + j * ns + i
            lit = (one - fc) * ((one - fa) * sun[at] + fa * sun[at + i1])
            lit += fc * ((one - fa) * sun[at + j1] + fa * sun[at + i1 + j1])
            m = material[f]
            red = (red + lit * sun_r) * base[m, 0]
            green = (green + lit * sun_g) * base[m, 1]
            blue = (blue + lit * sun_b) * base[m, 2]
            q = texture_of[m]
            if q >= 0:
                facing = F(abs(along) / length)
                foot = F(depth * length) * wide * density[f] / math.sqrt(max(facing, F(0.04)))
                level = F(math.log2(max(foot, F(1e-6)))) + F(0.15)
                level = min(max(level, zero), finest)
                l0 = int(level)
                fl = level - F(l0)
                u = maps[f, 2, 0] * px + maps[f, 2, 1] * py + maps[f, 2, 2] * pz + maps[f, 2, 3]
                v = maps[f, 3, 0] * px + maps[f, 3, 1] * py + maps[f, 3, 2] * pz + maps[f, 3, 3]
                u, v = u - F(math.floor(u)), v - F(math.floor(v))
                tr, tg, tb = zero, zero, zero
                for d in range(2):
                    weight = one - fl if d == 0 else fl
                    if weight < F(0.02):
                        continue
                    first = levels[q, l0 + d, 0]
                    th, tw = levels[q, l0 + d, 1], levels[q, l0 + d, 2]
                    a, c = u * F(tw) - F(0.5), v * F(th) - F(0.5)
                    i, j = int(a + one) - 1, int(c + one) - 1
                    fa, fc = a - F(i), c - F(j)
                    i = i + tw if i < 0 else i
                    j = j + th if j < 0 else j
                    i1 = i + 1 if i + 1 < tw else 0
                    j1 = j + 1 if j + 1 < th else 0
                    p0, p1 = first + j * tw, first + j1 * tw
                    w00, w10 = weight * (one - fa) * (one - fc), weight * fa * (one - fc)
                    w01, w11 = weight * (one - fa) * fc, weight * fa * fc
                    tr += w00 * decode[texels[p0 + i, 0]] + w10 * decode[texels[p0 + i1, 0]]
                    tr += w01 * decode[texels[p1 + i, 0]] + w11 * decode[texels[p1 + i1, 0]]
                    tg += w00 * decode[texels[p0 + i, 1]] + w10 * decode[texels[p0 + i1, 1]]
                    tg += w01 * decode[texels[p1 + i, 1]] + w11 * decode[texels[p1 + i1, 1]]
                    tb += w00 * decode[texels[p0 + i, 2]] + w10 * decode[texels[p0 + i1, 2]]
                    tb += w01 * decode[texels[p1 + i, 2]] + w11 * decode[texels[p1 + i1, 2]]
                red, green, blue = red * tr, green * tg, blue * tb
            red, green, blue = red + emission[m, 0], green + emission[m, 1], blue + emission[m, 2]
            red, green, blue = F(expose(red)), F(expose(green)), F(expose(blue))
            out_color[y, x, 0] = encode[int(math.sqrt(max(red, zero)) * steps + F(0.5))]
            out_color[y, x, 1] = encode[int(math.sqrt(max(green, zero)) * steps + F(0.5))]
            out_color[y, x, 2] = encode[int(math.sqrt(max(blue, zero)) * steps + F(0.5))]
