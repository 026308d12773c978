"""Baked light: sun with soft edges, sky through the windows, lamps, and light between surfaces.

Light is stored on lattices over the charts: a fine one for the sun, whose shadows have edges, and
a coarse one for everything soft. Every point gathers the light of its hemisphere; what the rays
meet is kept, so that each further bounce is one pass over those links instead of new rays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import color_to_linear
from belvedere.ground.progress import Progress, silent
from belvedere.ground.threads import run_parallel
from belvedere.model.charts import Charts
from belvedere.model.lattice import (
    Lattice,
    blended,
    in_cutouts,
    lattice_points,
    make_lattice,
    settled,
    shared_points,
    smoothed,
)
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

TOTAL = 100
"""Steps of the progress that `bake` tells."""
PATTERNS = 9
"""Neighbouring lattice points use different parts of one sample set, smoothed over 3x3 points."""
POINTS = 256
"""Lattice points per piece of work."""
BROAD = 4
"""Charts with more lattice points than this along both sides are walls, floors, table tops."""
INSIDE = 0.25
"""A point that sees this share of back faces lies inside something solid."""


@dataclass(frozen=True, slots=True)
class Lamp:
    """A small sphere that gives light, usually behind a shade."""

    center: tuple[float, float, float]
    """World position, metres."""
    power: tuple[float, float, float]
    """Linear radiance of a white surface facing the lamp at one metre."""
    radius: float = 0.06
    """Of the glowing sphere, metres: the softness of shadows."""
    shade: float = 0.25
    """What stands closer to the center than this casts no shadow: the lamp's own shade."""


@dataclass(frozen=True, slots=True)
class LightSettings:
    """What shines and how finely it is stored."""

    sun_direction: tuple[float, float, float] = (-0.46, -0.70, 0.56)
    """Towards the sun; any length."""
    sun_color: tuple[float, float, float] = (4.1, 3.25, 2.25)
    """Linear radiance of a white surface that faces the sun."""
    sun_radius: float = 0.011
    """Angular radius of the sun, radians; twice the real one, for soft edges."""
    sky_gain: float = 5.0
    """How much more light the sky gives than it shows: a photographer would expose it so."""
    lamps: tuple[Lamp, ...] = ()
    """The lamps."""
    emissive: bool = False
    """Whether glowing materials light what is round them; the lamps of the built-in interior have
    glowing shades, and their light is counted already."""
    rays: int = 192
    """Rays gathered per lattice point of walls and floors; small things get a quarter."""
    bounces: int = 4
    """Times that light goes from surface to surface after the first."""
    soft_spacing: float = 0.13
    """Metres between points of the soft lattice."""
    sun_spacing: float = 0.022
    """Metres between points of the sun's lattice."""


@dataclass(frozen=True, slots=True, eq=False)
class LightMap:
    """Light that falls on every chart, as the radiance a white surface would send back."""

    soft_lattice: Lattice
    """Where `soft` is stored."""
    soft: F4
    """(P, 3) linear: sky, lamps and bounces."""
    sun_lattice: Lattice
    """Where `sun` is stored."""
    sun: F4
    """(Q,) share of the sun's light in [0, 1], cosine included."""
    sun_color: F4
    """(3,) linear."""


def bake(
    mesh: Mesh,
    charts: Charts,
    caster: RayCaster,
    settings: LightSettings,
    threads: int | None = None,
    progress: Progress = silent,
) -> LightMap:
    """Light the charts of a mesh; the same for any number of threads.

    Args:
        mesh: the surfaces; textures count with their mean color.
        charts: where the light is stored.
        caster: of that mesh.
        settings: what shines.
        threads: how many to use; None for as many as there are processors.
        progress: told in hundredths, never by two threads at once.
    """
    meter = _Meter(progress)
    meter.tell(0, "sun")
    sun_lattice = make_lattice(charts, settings.sun_spacing, 1 << 12, _faces_sun(charts, settings))
    sun = _bake_sun(charts, caster, sun_lattice, settings, threads)
    meter.tell(15, "lamps")
    lattice = make_lattice(charts, settings.soft_spacing, 64)
    every_point, every_normal, chart = lattice_points(charts, lattice)
    one, copies = shared_points(every_point, every_normal)
    points, normals = every_point[one], every_normal[one]
    ns = lattice.shape[chart, 0]
    place = np.arange(len(chart)) - lattice.first[chart]
    pattern = ((place % ns) % 3 + 3 * ((place // ns) % 3)).astype(np.int32)
    surface = _Surface(
        charts, chart_albedo(mesh, charts), lattice, sun_lattice, sun,
        np.asarray(settings.sun_color, dtype=np.float32), _emission(mesh, charts, settings),
        np.zeros(len(charts.material), bool) if charts.two_sided is None else charts.two_sided,
    )  # fmt: skip
    wanted = np.ones(len(chart), bool) if charts.covered else settled(charts, lattice)[2]
    broad = lattice.shape.min(axis=1)[chart[one]] > BROAD
    direct = _lamp_light(points, normals, pattern[one], caster, settings.lamps, threads)
    back = np.ones(len(points), dtype=np.float32)
    groups = []
    few = max(settings.rays // 4, 1)
    share = broad.sum() * settings.rays / max(broad.sum() * settings.rays + (~broad).sum() * few, 1)
    middle = 30 + round(55 * float(share))
    for member, rays, span in ((broad, settings.rays, (30, middle)), (~broad, few, (middle, 85))):
        which = np.flatnonzero(member & wanted[one])
        rays_of = _Rays(points[which], normals[which], pattern[one][which], rays)
        count = meter.over(-(-len(which) // POINTS), span, "light between surfaces")
        link, at_once, seen_back = _gather(
            surface, caster, rays_of, settings.sky_gain, threads, count
        )
        direct[which] += at_once
        back[which] = seen_back
        groups.append((which, link, rays))
    valid = (back < INSIDE)[copies] & ~in_cutouts(charts, lattice, chart, place)
    if not charts.covered:  # a chart that has no good point does with what it has
        good = np.bincount(chart[valid], minlength=len(charts.material)) > 0
        valid |= wanted & ~good[chart]
    joined = None if charts.joined is None else charts.joined[chart]

    def spread(seen: F4) -> F4:
        smooth = smoothed(lattice, valid, seen[copies])
        return smooth if joined is None else blended(smooth, copies, joined)

    light = spread(direct)
    for bounce in range(settings.bounces):
        meter.tell(85 + 15 * bounce // settings.bounces, "bounces")
        total = direct.copy()
        for which, link, rays in groups:
            total[which] += _bounced(surface, chart, link, rays, light, len(which), threads)
        light = spread(total)
    meter.tell(TOTAL, "done")
    return LightMap(lattice, light, sun_lattice, sun, surface.sun_color)


class _Meter:
    """Tells how far the light is, in hundredths."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._lock = progress, Lock()

    def tell(self, done: int, what: str) -> None:
        """So much is done."""
        with self._lock:
            self._progress(done, TOTAL, what)

    def over(self, pieces: int, span: tuple[int, int], what: str) -> Callable[[], None]:
        """What each of ``pieces`` calls when it is done; together they lead through ``span``."""
        told, done, lock = span[0], 0, Lock()
        self.tell(told, what)

        def count() -> None:
            nonlocal told, done
            with lock:
                done += 1
                now = span[0] + (span[1] - span[0]) * done // max(pieces, 1)
                if now > told:
                    told = now
                    self.tell(now, what)

        return count


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """What a gathering ray may find out about the place it meets."""

    charts: Charts
    albedo: F4
    lattice: Lattice
    sun_lattice: Lattice
    sun: F4
    sun_color: F4
    emission: F4
    two_sided: npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class _Rays:
    """Points that gather, and how many rays each."""

    points: F4
    normals: F4
    pattern: I4
    count: int


def _gather(
    surface: _Surface,
    caster: RayCaster,
    rays: _Rays,
    sky_gain: float,
    threads: int | None,
    count_piece: Callable[[], None],
) -> tuple[I4, F4, F4]:
    """Cast every point's rays.

    Returns:
        What each ray met: a lattice point, sky or dark; (P, 3) the light that came at once; (P,)
        the share of rays that met the back of something.
    """
    from belvedere.model import _light_kernels

    samples, count, total = _sample_set(rays.count), rays.count, len(rays.points)
    link = np.empty(total * count, dtype=np.int32)
    at_once = np.empty((total, 3), dtype=np.float32)
    back = np.empty(total, dtype=np.float32)
    charts, soft, fine = surface.charts, surface.lattice, surface.sun_lattice
    front = charts.normals.mean(axis=1)

    def piece(first: int) -> None:
        part = slice(first, min(first + POINTS, total))
        origins = np.empty(((part.stop - first) * count, 3), dtype=np.float32)
        directions = np.empty_like(origins)
        _light_kernels.hemisphere_rays(
            rays.points[part], rays.normals[part], rays.pattern[part], samples, origins, directions
        )
        hit = caster.cast_piece(origins, directions)
        _light_kernels.gather_hits(
            hit["primID"], hit["u"], hit["v"], directions, charts.of_face, charts.st, front,
            surface.albedo, surface.emission, surface.two_sided, soft.first, soft.shape,
            fine.first, fine.shape, surface.sun, surface.sun_color, sky_gain, count,
            link[first * count : part.stop * count], at_once[part], back[part],
        )  # fmt: skip
        count_piece()

    run_parallel(piece, range(0, total, POINTS), threads)
    return link, at_once, back


def _bounced(
    surface: _Surface, chart: I4, link: I4, count: int, light: F4, total: int, threads: int | None
) -> F4:
    """(P, 3) what the linked lattice points send back of ``light``."""
    from belvedere.model import _light_kernels

    gathered = np.empty((total, 3), dtype=np.float32)

    def piece(first: int) -> None:
        part = slice(first, min(first + POINTS, total))
        links = link[first * count : part.stop * count]
        _light_kernels.bounce(links, count, chart, surface.albedo, light, gathered[part])

    run_parallel(piece, range(0, total, POINTS), threads)
    return gathered


def chart_albedo(mesh: Mesh, charts: Charts) -> F4:
    """(K, 3) linear reflectance of each chart: base color times its texture's mean."""
    mean = [
        np.asarray(m.base_color)
        * (1.0 if m.texture is None else color_to_linear(m.texture).mean(axis=(0, 1)))
        for m in mesh.materials
    ]
    albedo = np.asarray(mean, dtype=np.float32)[charts.material]
    if mesh.colors is not None:
        count = np.maximum(np.bincount(charts.of_face, minlength=len(albedo)), 1)
        for c in range(3):
            total = np.bincount(charts.of_face, mesh.colors[..., c].mean(axis=1), len(albedo))
            albedo[:, c] *= total / count
    return albedo


def _emission(mesh: Mesh, charts: Charts, settings: LightSettings) -> F4:
    """(K, 3) what each chart gives off into the room."""
    glow = np.array([m.emission for m in mesh.materials], dtype=np.float32).reshape(-1, 3)
    return glow[charts.material] if settings.emissive else np.zeros_like(glow[charts.material])


def _to_sun(settings: LightSettings) -> F8:
    direction = np.asarray(settings.sun_direction, dtype=np.float64)
    return direction / np.linalg.norm(direction)


def _faces_sun(charts: Charts, settings: LightSettings) -> npt.NDArray[np.bool_]:
    return np.any(charts.normals @ _to_sun(settings) > 1e-3, axis=1)


def _bake_sun(
    charts: Charts,
    caster: RayCaster,
    lattice: Lattice,
    settings: LightSettings,
    threads: int | None,
) -> F4:
    """One ray a point, then sixteen over the sun's disk near the edges of shadows."""
    from belvedere.model import _light_kernels

    points, normals, _ = lattice_points(charts, lattice)
    to_sun = _to_sun(settings)
    cosine = np.maximum(normals @ to_sun.astype(np.float32), 0.0)
    seen = np.zeros(len(points), dtype=np.float32)
    facing = np.flatnonzero(cosine > 0.0)
    seen[facing] = ~_blocked_towards(caster, points[facing], to_sun, threads)
    edge = np.zeros(len(points), dtype=bool)
    _light_kernels.mark_bands(lattice.first, lattice.shape, seen, 3, edge)
    near = np.flatnonzero(edge & (cosine > 0.0))
    side = np.cross(to_sun, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    other = np.cross(to_sun, side)
    total = np.zeros(len(near), dtype=np.float32)
    for k in range(16):
        radius, angle = settings.sun_radius * np.sqrt((k + 0.5) / 16), 2.399963 * k
        towards = to_sun + radius * (np.cos(angle) * side + np.sin(angle) * other)
        total += ~_blocked_towards(caster, points[near], towards, threads)
    seen[near] = total / 16.0
    return seen * cosine


def _blocked_towards(
    caster: RayCaster, points: F4, direction: F8, threads: int | None
) -> npt.NDArray[np.bool_]:
    result = np.empty(len(points), dtype=bool)
    size = POINTS * 64

    def piece(first: int) -> None:
        start = points[first : first + size]
        along = np.ascontiguousarray(np.broadcast_to(direction.astype(np.float32), start.shape))
        reach = np.full(len(start), 1e30, dtype=np.float32)
        result[first : first + size] = caster.blocked_piece(start, along, reach)

    run_parallel(piece, range(0, len(points), size), threads)
    return result


def _lamp_light(
    points: F4,
    normals: F4,
    pattern: I4,
    caster: RayCaster,
    lamps: tuple[Lamp, ...],
    threads: int | None,
) -> F4:
    """(P, 3) light straight from the lamps; each point aims at one of nine places on the bulb."""
    total = np.zeros_like(points)
    k = np.arange(PATTERNS) + 0.5
    z, angle = 1.0 - 2.0 * k / PATTERNS, 2.399963 * k
    ring = np.sqrt(1.0 - z * z)
    bulb = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)
    size = POINTS * 16

    def piece(first: int) -> None:
        part = slice(first, first + size)
        for lamp in lamps:
            aim = (np.asarray(lamp.center) + lamp.radius * bulb)[pattern[part]]
            along = (aim - points[part]).astype(np.float32)
            distance = np.linalg.norm(along, axis=1)
            cosine = np.einsum("ij,ij->i", along, normals[part]) / distance
            tall = np.abs(along[:, 2]) / distance  # a shade lets more out above and below
            strength = np.maximum(cosine, 0.0) * (0.5 + 0.9 * tall**2)
            strength = strength / np.maximum(distance, lamp.shade) ** 2
            use = np.flatnonzero(strength > 1e-3)
            reach = np.maximum(1.0 - lamp.shade / distance[use], 1e-4).astype(np.float32)
            start = np.ascontiguousarray(points[part][use])
            free = ~caster.blocked_piece(start, along[use], reach)
            lit = (strength[use] * free)[:, None] * np.asarray(lamp.power)
            total[first + use] += lit.astype(np.float32)

    run_parallel(piece, range(0, len(points), size), threads)
    return total


def _sample_set(rays: int) -> F4:
    """(9, rays, 2) points of a golden-ratio lattice in the unit square, dealt out in turn."""
    index = np.arange(PATTERNS * rays)
    points = np.stack([(index + 0.5) / len(index), index * 0.6180339887498949 % 1.0], axis=1)
    return np.ascontiguousarray(
        points.reshape(rays, PATTERNS, 2).transpose(1, 0, 2), dtype=np.float32
    )
