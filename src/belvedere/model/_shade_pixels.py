"""Loops that colour pixels whose face is known: exact disparity, texture, light. Private.

Everything on a face is affine in the position, so a pixel needs no corners: its ray meets the
face's plane, and texture and chart coordinates are a product and a sum away. A run of pixels that
show one face is worked on in passes: eight pixels at once find out where they read, then each
pixel reads colours of four floats.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.eight import (
    eight,
    floor8,
    fold8,
    load8,
    log2_8,
    max8,
    min8,
    mix8,
    ramp8,
    sqrt8,
    store8,
    store_whole8,
    where8,
    whole8,
)
from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import (
    add4,
    float_of,
    four,
    lane4,
    load4,
    max4,
    mul4,
    prefetch,
    scale4,
    store4,
    zero4,
)
from belvedere.model._raster_fill import LAST_FACE, SKY
from belvedere.model._sky_run import sky_run

A = npt.NDArray[Any]
F = np.float32

ZERO, HALF, ONE = F(0.0), F(0.5), F(1.0)
TINY, HUGE = F(1e-9), F(1e9)
"""Disparities outside these are not believed."""
FULL = F(65535.0)
"""A texel that reflects everything."""
PAD = 16
"""Elements more that rows of working memory need: eight pixels are written at once."""
ROWS, WHOLE_ROWS = 14, 6
"""Rows of working memory, float32 and int32."""
CHART, SUN, MATERIAL, DENSITY = 0, 3, 6, 7
"""Columns of a face's record: first point and shape of both lattices, material, texels a metre."""


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
        out_map: (M, 4, 4) float32: slope of s, t, u, v along x, along y, along z, and their
            values at the origin.
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
                out_map[f, k, row] = slope
                at -= slope * (vertices[a, k] - origin[k])
            out_map[f, 3, row] = at


@inner
def locate_run(
    f: int, x0: int, y: int, count: int, matrix: A, eye: A, spread: Any, plane: A, maps: A,
    record: A, density: Any, finest: Any, raster: A, disparity: A, work: A, whole: A,
) -> None:  # fmt: skip
    """Where ``count`` pixels of row y, from x0 on, meet face f, and where they read its light.

    ``work`` gets, a row each: place in the cell of the soft lattice (2), of the sun's lattice (2),
    texture coordinates (2), mip level, depth; ``whole`` the cells of both lattices.
    """
    stride = work.shape[1]
    ax, ay, az = matrix[0, 0], matrix[1, 0], matrix[2, 0]
    bx = ax * x0 + matrix[0, 1] * y + matrix[0, 2]
    by = ay * x0 + matrix[1, 1] * y + matrix[1, 2]
    bz = az * x0 + matrix[2, 1] * y + matrix[2, 2]
    nx, ny, nz = plane[f, 0], plane[f, 1], plane[f, 2]
    above = plane[f, 3] - (nx * eye[0] + ny * eye[1] + nz * eye[2])
    over = 1.0 / above if above != 0.0 else 0.0
    start, slope = (nx * bx + ny * by + nz * bz) * over, (nx * ax + ny * ay + nz * az) * over
    gx, gy, gz = load4(maps, 4 * f), load4(maps, 4 * f + 1), load4(maps, 4 * f + 2)
    at_eye = add4(scale4(gx, F(eye[0])), scale4(gy, F(eye[1])))
    at_eye = add4(add4(at_eye, scale4(gz, F(eye[2]))), load4(maps, 4 * f + 3))
    first = add4(add4(scale4(gx, F(bx)), scale4(gy, F(by))), scale4(gz, F(bz)))
    step = add4(add4(scale4(gx, F(ax)), scale4(gy, F(ay))), scale4(gz, F(az)))
    wide, high = record[f, CHART + 1], record[f, CHART + 2]
    sun_wide, sun_high = record[f, SUN + 1], record[f, SUN + 2]
    last_i, last_j = F(max(wide - 2, 0)), F(max(high - 2, 0))
    sun_last_i, sun_last_j = F(max(sun_wide - 2, 0)), F(max(sun_high - 2, 0))
    px, py, pz, qx, qy, qz = F(bx), F(by), F(bz), F(ax), F(ay), F(az)
    size, normal = spread * density, F(abs(above))
    for i in range(0, count, 8):
        at = ramp8() + F(i)
        delta = ramp8() * F(slope) + F(start + slope * i)
        # seen edge on, the corners' disparity is what there is
        known = load8(raster, x0 + i)
        delta = where8(delta, eight(TINY), delta, known)
        delta = where8(eight(HUGE), delta, delta, known)
        store8(disparity, x0 + i, delta)
        depth = ONE / delta
        store8(work, 7 * stride + i, depth)
        s = depth * (at * lane4(step, 0) + lane4(first, 0)) + lane4(at_eye, 0)
        t = depth * (at * lane4(step, 1) + lane4(first, 1)) + lane4(at_eye, 1)
        s, t = min8(max8(s, ZERO), ONE), min8(max8(t, ZERO), ONE)
        a, c = s * F(wide - 1), t * F(high - 1)
        cell_a, cell_c = min8(floor8(a), last_i), min8(floor8(c), last_j)
        store_whole8(whole, i, cell_c * F(wide) + cell_a)
        store8(work, i, a - cell_a)
        store8(work, stride + i, c - cell_c)
        a, c = s * F(sun_wide - 1), t * F(sun_high - 1)
        cell_a, cell_c = min8(floor8(a), sun_last_i), min8(floor8(c), sun_last_j)
        store_whole8(whole, stride + i, cell_c * F(sun_wide) + cell_a)
        store8(work, 2 * stride + i, a - cell_a)
        store8(work, 3 * stride + i, c - cell_c)
        u = depth * (at * lane4(step, 2) + lane4(first, 2)) + lane4(at_eye, 2)
        v = depth * (at * lane4(step, 3) + lane4(first, 3)) + lane4(at_eye, 3)
        store8(work, 4 * stride + i, min8(max8(u - floor8(u), ZERO), ONE))
        store8(work, 5 * stride + i, min8(max8(v - floor8(v), ZERO), ONE))
        rx, ry, rz = at * qx + px, at * qy + py, at * qz + pz
        length = rx * rx + ry * ry + rz * rz
        facing = max8(delta * normal / sqrt8(length), F(0.04))
        foot = depth * size
        level = log2_8(max8(foot * foot * length / facing, F(1e-12))) * HALF + F(0.15)
        store8(work, 6 * stride + i, min8(max8(level, ZERO), finest))


@inner
def light_run(
    count: int, work: A, whole: A, record: A, f: int, soft: A, sun: A, sun_color: A, gain: Any,
    out_light: A, x0: int,
) -> None:  # fmt: skip
    """Light that arrives at a run of pixels, times their gain: lattices read bilinearly."""
    first, down = record[f, CHART], record[f, CHART + 1]
    color = mul4(four(F(sun_color[0]), F(sun_color[1]), F(sun_color[2]), ZERO), gain)
    sun_first, sun_down = record[f, SUN], record[f, SUN + 1]
    if sun_down == 1 and record[f, SUN + 2] == 1:
        given = scale4(color, sun[sun_first])
        for i in range(count):
            at = first + whole[0, i]
            pair = mix8(load8(soft, 4 * at), load8(soft, 4 * (at + down)), work[1, i])
            store4(out_light, x0 + i, add4(mul4(fold8(pair, work[0, i]), gain), given))
        return
    for i in range(count):
        at = first + whole[0, i]
        pair = mix8(load8(soft, 4 * at), load8(soft, 4 * (at + down)), work[1, i])
        at = np.uint64(sun_first + whole[1, i])
        under = np.uint64(at + np.uint64(sun_down))
        fa, fc = work[2, i], work[3, i]
        upper = sun[at] + fa * (sun[at + np.uint64(1)] - sun[at])
        lower = sun[under] + fa * (sun[under + np.uint64(1)] - sun[under])
        given = scale4(color, upper + fc * (lower - upper))
        store4(out_light, x0 + i, add4(mul4(fold8(pair, work[0, i]), gain), given))


@inner
def place_level(
    first: int, last: int, work: A, whole: A, row: int, wide: Real, high: Real, texels: A,
    start: Real, down: Real,
) -> None:  # fmt: skip
    """Where some pixels of a run read a level of their texture, which begins at ``start``.

    ``whole`` gets the upper and the lower left texel, in the row that is given and the next, and
    ``work`` the place between the four.
    """
    stride = work.shape[1]
    for i in range(first, last, 8):
        a = load8(work, 4 * stride + i) * wide + HALF
        c = load8(work, 5 * stride + i) * high + HALF
        column, line = floor8(a), floor8(c)
        store_whole8(whole, row * stride + i, column)
        store_whole8(whole, (row + 1) * stride + i, line)
        store8(work, (row + 8) * stride + i, a - column)
        store8(work, (row + 9) * stride + i, c - line)
    for n in range(first, last):
        i = np.uint64(n)
        upper = start + whole[row + 1, i] * down + whole[row, i]
        lower = upper + down
        whole[row, i], whole[row + 1, i] = upper, lower
        prefetch(texels, 4 * upper)
        prefetch(texels, 4 * lower)


@inner
def place_run(count: int, work: A, whole: A, q: Real, sizes: A, places: A, texels: A) -> None:
    """Where a run of pixels reads two levels of its texture; the processor begins to fetch them.

    Pixels between the same two levels are worked on together.
    """
    first = 0
    while first < count:
        level = np.int32(work[6, first])
        last = first + 1
        while last < count and np.int32(work[6, last]) == level:
            last += 1
        at = np.uint64(q + level)
        place_level(
            first, last, work, whole, 2, sizes[at, 0], sizes[at, 1], texels, places[at, 0],
            places[at, 1],
        )  # fmt: skip
        at = np.uint64(at + np.uint64(1))
        place_level(
            first, last, work, whole, 4, sizes[at, 0], sizes[at, 1], texels, places[at, 0],
            places[at, 1],
        )  # fmt: skip
        first = last


@inner
def read_level(texels: A, i: Real, work: A, whole: A, row: int) -> Any:
    """A pixel's colour in a level, bilinearly; see `place_level`."""
    upper, lower = np.uint64(4 * whole[row, i]), np.uint64(4 * whole[row + 1, i])
    pair = mix8(whole8(texels, upper), whole8(texels, lower), work[row + 9, i])
    return fold8(pair, work[row + 8, i])


@inner
def texture_run(count: int, work: A, whole: A, texels: A, out_light: A, x0: int) -> None:
    """Multiply the light of a run of pixels by their texture, two levels of it mixed."""
    for n in range(count):
        i = np.uint64(n)
        color = read_level(texels, i, work, whole, 2)
        share = work[6, i] - np.floor(work[6, i])
        if share > F(0.01):
            coarse = read_level(texels, i, work, whole, 4)
            color = add4(scale4(color, ONE - share), scale4(coarse, share))
        store4(out_light, x0 + n, mul4(load4(out_light, x0 + n), color))


@inner
def tint_run(
    f: int, x0: int, y: int, count: int, matrix: A, eye: A, tints: A, work: A, out_light: A
) -> None:
    """Multiply the light of a run of pixels by the color between the face's corners."""
    gx, gy, gz = load4(tints, 4 * f), load4(tints, 4 * f + 1), load4(tints, 4 * f + 2)
    at_eye = add4(scale4(gx, F(eye[0])), scale4(gy, F(eye[1])))
    at_eye = add4(add4(at_eye, scale4(gz, F(eye[2]))), load4(tints, 4 * f + 3))
    for i in range(count):
        x = x0 + i
        rx = F(matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2])
        ry = F(matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2])
        rz = F(matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2])
        along = add4(add4(scale4(gx, rx), scale4(gy, ry)), scale4(gz, rz))
        tint = max4(add4(at_eye, scale4(along, work[7, i])), zero4())
        store4(out_light, x, mul4(load4(out_light, x), tint))


@inner
def encode_row(y: int, light: A, whole: A, encode: A, out_color: A) -> None:
    """Expose (as `_kernels.expose`, but negative radiance is black) and encode a row of pixels."""
    steps, knee, rest = F(encode.shape[0] - 1), F(0.55), F(0.45)
    width = out_color.shape[1]
    for i in range(0, 4 * width, 8):
        radiance = min8(max8(load8(light, i), ZERO), HUGE)  # infinity would become no number
        over = max8(radiance - knee, ZERO)
        shown = min8(radiance, knee) + over * rest / (over + rest)
        store_whole8(whole, i, sqrt8(shown) * steps + HALF)
    for x in range(width):
        out_color[y, x, 0] = encode[np.uint32(whole[4 * x])]
        out_color[y, x, 1] = encode[np.uint32(whole[4 * x + 1])]
        out_color[y, x, 2] = encode[np.uint32(whole[4 * x + 2])]


@kernel
def shade_pixels(
    keys: A, row0: int, row1: int, matrix: A, eye: A, spread: float, plane: A, maps: A, record: A,
    density: A, tints: A, base: A, emission: A, texture_of: A, texels: A, sizes: A, places: A,
    depth: int, encode: A, soft: A, sun: A, sun_color: A, work: A, whole: A, light: A, codes: A,
    out_face: A, out_disparity: A, out_color: A,
) -> None:  # fmt: skip
    """Colour the pixels of some rows; agrees with `_kernels.shade` to rounding.

    Args:
        keys: (H, W and more) see `_raster_fill`.
        row0: first row.
        row1: the row after the last.
        matrix: (3, 3) of the camera.
        eye: (3,) in the frame of the tables.
        spread: angle between neighbouring pixels, radians.
        plane: (M, 4) from `face_tables`.
        maps: (M, 4, 4) from `face_tables`.
        record: (M, 8) int32, see `CHART` and what follows.
        density: (M, 8) float32, the same memory.
        tints: (M, 4, 4) slopes of the colors that multiply the base color; (0, 4, 4): of none.
        base: (T, 4) of each material.
        emission: (T, 4).
        texture_of: (T,) first row of ``sizes``, or -1.
        texels: (X, 4) uint16 linear, each level framed by a texel from its other side.
        sizes: (Q, 2) float32 width and height of each level.
        places: (Q, 2) int64 first texel and texels a row, frame included.
        depth: levels of each texture.
        encode: (N,) byte of linear light.
        soft: (P, 4) see `LightMap`; with a row of zeros for each column of the widest chart.
        sun: (S,) with as many zeros at the end.
        sun_color: (3,).
        work: (ROWS, W + PAD) float32, overwritten.
        whole: (WHOLE_ROWS, W + PAD) int32, overwritten.
        light: (W + PAD, 4) float32, overwritten.
        codes: (4 * (W + PAD),) int32, overwritten.
        out_face: (H, W) int32; -1 is the sky.
        out_disparity: (H, W) float32; 0 in the sky.
        out_color: (H, W, 3) uint8.
    """
    width = out_face.shape[1]
    raster, disparity = work[8], work[9]
    wide = F(spread)
    finest = F(depth - 1.001)
    for y in range(row0, row1):
        for x in range(width):
            key = keys[y, x]
            raster[x] = float_of(np.uint32(key >> 32))
            out_face[y, x] = np.int32(LAST_FACE - (key & SKY)) if key != SKY else np.int32(-1)
        x = 0
        while x < width:
            f, x0 = out_face[y, x], x
            while x < width and out_face[y, x] == f:
                x += 1
            count = x - x0
            if f < 0:
                sky_run(x0, y, count, matrix, work[0], work[1], work[2])
                for i in range(count):
                    store4(light, x0 + i, four(work[0, i], work[1, i], work[2, i], ZERO))
                    disparity[x0 + i] = ZERO
                continue
            m = record[f, MATERIAL]
            q = texture_of[m]
            locate_run(
                f, x0, y, count, matrix, eye, wide, plane, maps, record, density[f, DENSITY],
                finest, raster, disparity, work, whole,
            )  # fmt: skip
            gain = load4(base, m)
            if q >= 0:
                place_run(count, work, whole, q, sizes, places, texels)
                gain = scale4(gain, ONE / FULL)
            light_run(count, work, whole, record, f, soft, sun, sun_color, gain, light, x0)
            if q >= 0:
                texture_run(count, work, whole, texels, light, x0)
            if tints.shape[0] > 0:
                tint_run(f, x0, y, count, matrix, eye, tints, work, light)
            if emission[m, 0] + emission[m, 1] + emission[m, 2] > ZERO:
                for i in range(x0, x):
                    store4(light, i, add4(load4(light, i), load4(emission, m)))
        encode_row(y, light, codes, encode, out_color)
        for x in range(width):
            out_disparity[y, x] = disparity[x]
