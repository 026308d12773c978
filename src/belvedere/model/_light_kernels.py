"""Loops that bake light: lattice points, gathered rays, bounces, smoothing. Private."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import kernel
from belvedere.model._sky import sky_radiance

A = npt.NDArray[Any]

SKY = -1
DARK = -2
"""Links of gathered rays that met no chart's front."""


@kernel
def lattice_points(
    corners: A, normals: A, curved: A, first: A, shape: A, lift: float, out_p: A, out_n: A,
    out_chart: A,
) -> None:  # fmt: skip
    """World points just above each chart's lattice, drawn in a little from the chart's edges."""
    for k in range(corners.shape[0]):
        for j in range(shape[k, 1]):
            for i in range(shape[k, 0]):
                s = 0.5 if shape[k, 0] == 1 else i / (shape[k, 0] - 1.0)
                t = 0.5 if shape[k, 1] == 1 else j / (shape[k, 1] - 1.0)
                at = first[k] + j * shape[k, 0] + i
                out_chart[at] = k
                length_s, length_t = 0.0, 0.0
                for c in range(3):
                    length_s += (corners[k, 1, c] - corners[k, 0, c]) ** 2
                    length_t += (corners[k, 3, c] - corners[k, 0, c]) ** 2
                # curved charts keep their corners, which their neighbours share
                keep = 0.0 if curved[k] else 1.0
                inset_s = keep * min(0.012 / max(math.sqrt(length_s), 1e-6), 0.2)
                inset_t = keep * min(0.012 / max(math.sqrt(length_t), 1e-6), 0.2)
                s = min(max(s, inset_s), 1.0 - inset_s)
                t = min(max(t, inset_t), 1.0 - inset_t)
                w0, w1, w2, w3 = (1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t
                norm = 0.0
                for c in range(3):
                    n = w0 * normals[k, 0, c] + w1 * normals[k, 1, c]
                    n += w2 * normals[k, 2, c] + w3 * normals[k, 3, c]
                    out_n[at, c] = n
                    norm += n * n
                norm = 1.0 / math.sqrt(max(norm, 1e-12))
                for c in range(3):
                    out_n[at, c] *= norm
                    p = w0 * corners[k, 0, c] + w1 * corners[k, 1, c]
                    p += w2 * corners[k, 2, c] + w3 * corners[k, 3, c]
                    out_p[at, c] = p + lift * out_n[at, c]


@kernel
def mark_bands(first: A, shape: A, value: A, reach: int, out_mark: A) -> None:
    """Mark lattice points within ``reach`` of a change of ``value`` inside their chart."""
    for k in range(first.shape[0]):
        ns, nt, base = shape[k, 0], shape[k, 1], first[k]
        for j in range(nt):
            for i in range(ns):
                here = value[base + j * ns + i]
                changes = (i + 1 < ns and value[base + j * ns + i + 1] != here) or (
                    j + 1 < nt and value[base + (j + 1) * ns + i] != here
                )
                if not changes:
                    continue
                for b in range(max(j - reach, 0), min(j + reach + 2, nt)):
                    for a in range(max(i - reach, 0), min(i + reach + 2, ns)):
                        out_mark[base + b * ns + a] = True


@kernel
def hemisphere_rays(p: A, n: A, pattern: A, samples: A, out_origins: A, out_directions: A) -> None:
    """Cosine-weighted rays: ``samples[pattern]`` (S, 2) turned into each point's hemisphere."""
    count = samples.shape[1]
    for i in range(p.shape[0]):
        nx, ny, nz = n[i, 0], n[i, 1], n[i, 2]
        sign = 1.0 if nz >= 0.0 else -1.0  # a frame without branches: Duff et al. 2017
        a = -1.0 / (sign + nz)
        b = nx * ny * a
        for j in range(count):
            radius = math.sqrt(samples[pattern[i], j, 0])
            angle = 2.0 * math.pi * samples[pattern[i], j, 1]
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            z = math.sqrt(max(1.0 - radius * radius, 1e-5))
            at = i * count + j
            out_directions[at, 0] = x * (1.0 + sign * nx * nx * a) + y * b + z * nx
            out_directions[at, 1] = x * sign * b + y * (sign + ny * ny * a) + z * ny
            out_directions[at, 2] = -x * sign * nx + -y * ny + z * nz
            out_origins[at, 0] = p[i, 0]
            out_origins[at, 1] = p[i, 1]
            out_origins[at, 2] = p[i, 2]


@kernel
def gather_hits(
    face: A, u: A, v: A, directions: A, of_face: A, st: A, front: A, albedo: A, emission: A,
    two_sided: A, soft_first: A, soft_shape: A, sun_first: A, sun_shape: A, sun: A, sun_color: A,
    sky_gain: float, count: int, out_link: A, out_light: A, out_back: A,
) -> None:  # fmt: skip
    """Light that comes at once (sky, sunlit surfaces); links to charts for what bounces later."""
    for i in range(out_light.shape[0]):
        r, g, b, back = 0.0, 0.0, 0.0, 0
        for j in range(count):
            at = i * count + j
            f = face[at]
            if f < 0:
                sr, sg, sb = sky_radiance(directions[at, 0], directions[at, 1], directions[at, 2])
                r += sr * sky_gain
                g += sg * sky_gain
                b += sb * sky_gain
                out_link[at] = SKY
                continue
            k = of_face[f]
            facing = 0.0
            for c in range(3):
                facing += directions[at, c] * front[k, c]
            if facing >= 0.0 and not two_sided[k]:
                out_link[at] = DARK
                back += 1
                continue
            w = 1.0 - u[at] - v[at]
            s = w * st[f, 0, 0] + u[at] * st[f, 1, 0] + v[at] * st[f, 2, 0]
            t = w * st[f, 0, 1] + u[at] * st[f, 1, 1] + v[at] * st[f, 2, 1]
            s, t = min(max(s, 0.0), 1.0), min(max(t, 0.0), 1.0)
            a = int(s * (soft_shape[k, 0] - 1) + 0.5)
            c0 = int(t * (soft_shape[k, 1] - 1) + 0.5)
            out_link[at] = soft_first[k] + c0 * soft_shape[k, 0] + a
            a = int(s * (sun_shape[k, 0] - 1) + 0.5)
            c0 = int(t * (sun_shape[k, 1] - 1) + 0.5)
            lit = sun[sun_first[k] + c0 * sun_shape[k, 0] + a]
            r += albedo[k, 0] * lit * sun_color[0] + emission[k, 0]
            g += albedo[k, 1] * lit * sun_color[1] + emission[k, 1]
            b += albedo[k, 2] * lit * sun_color[2] + emission[k, 2]
        out_light[i, 0], out_light[i, 1], out_light[i, 2] = r / count, g / count, b / count
        out_back[i] = back / count


@kernel
def bounce(link: A, count: int, chart: A, albedo: A, light: A, out_light: A) -> None:
    """One more bounce: the mean of what the linked points send back."""
    for i in range(out_light.shape[0]):
        r, g, b = 0.0, 0.0, 0.0
        for j in range(count):
            at = link[i * count + j]
            if at >= 0:
                k = chart[at]
                r += albedo[k, 0] * light[at, 0]
                g += albedo[k, 1] * light[at, 1]
                b += albedo[k, 2] * light[at, 2]
        out_light[i, 0], out_light[i, 1], out_light[i, 2] = r / count, g / count, b / count


@kernel
def smooth_lattice(first: A, shape: A, valid: A, light: A, out_light: A) -> None:
    """Mean over the 3x3 valid neighbours inside each chart; other points become NaN."""
    for k in range(first.shape[0]):
        ns, nt, base = shape[k, 0], shape[k, 1], first[k]
        for j in range(nt):
            for i in range(ns):
                r, g, b, weight = 0.0, 0.0, 0.0, 0.0
                for y in range(max(j - 1, 0), min(j + 2, nt)):
                    for x in range(max(i - 1, 0), min(i + 2, ns)):
                        at = base + y * ns + x
                        if valid[at]:
                            r += light[at, 0]
                            g += light[at, 1]
                            b += light[at, 2]
                            weight += 1.0
                at = base + j * ns + i
                if weight == 0.0 or not valid[at]:
                    out_light[at, 0] = out_light[at, 1] = out_light[at, 2] = np.nan
                else:
                    out_light[at, 0], out_light[at, 1] = r / weight, g / weight
                    out_light[at, 2] = b / weight


@kernel
def fill_lattice(first: A, shape: A, out_light: A) -> None:
    """Give points without light (inside solids, in openings) the nearest known light; in place."""
    for k in range(first.shape[0]):
        ns, nt, base = shape[k, 0], shape[k, 1], first[k]
        known = 0
        for at in range(base, base + ns * nt):
            if not math.isnan(out_light[at, 0]):
                known += 1
        if known == ns * nt:
            continue
        if known == 0:
            for at in range(base, base + ns * nt):
                out_light[at, 0] = out_light[at, 1] = out_light[at, 2] = 0.0
            continue
        for sweep in range(2 * (ns + nt)):
            left = 0
            forward = sweep % 2 == 0
            for q in range(ns * nt):
                at = q if forward else ns * nt - 1 - q
                if not math.isnan(out_light[base + at, 0]):
                    continue
                left += 1
                i, j = at % ns, at // ns
                for c in range(3):
                    total, weight = 0.0, 0.0
                    for y in range(max(j - 1, 0), min(j + 2, nt)):
                        for x in range(max(i - 1, 0), min(i + 2, ns)):
                            other = base + y * ns + x
                            # channel 2 is written last, so it tells whether all are known
                            if (x != i or y != j) and not math.isnan(out_light[other, 2]):
                                total += out_light[other, c]
                                weight += 1.0
                    if weight > 0.0:
                        out_light[base + at, c] = total / weight
            if left == 0:
                break
