"""Light for models that come without any: sun, sky, and a soft lamp in every room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from belvedere.ground.checks import check_integer
from belvedere.model.building import Building, Room
from belvedere.model.chart_mesh import charts_of
from belvedere.model.charts import F8, Charts
from belvedere.model.light import Lamp, LightSettings, Progress, bake
from belvedere.model.photograph import LitModel
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

ROOM_LAMP_M2 = 14.0
"""Floor for each lamp of a room."""
ROOM_LAMPS = 24
"""Lamps of one room at most."""
LAMP_POWER = (0.95, 0.80, 0.62)
LAMP_RADIUS = 0.15
LAMP_SHADE = 0.30
BELOW_CEILING_M = 0.5
LATTICE_M = 0.25
"""Between places that are tried for a lamp."""
SOFT_POINTS = 1_500_000
SUN_POINTS = 8_000_000
"""Points at most, about, of the two lattices: larger models get wider ones."""

__all__ = ["light_model", "room_lamps"]


def light_model(
    mesh: Mesh,
    building: Building | None = None,
    *,
    settings: LightSettings | None = None,
    rays: int = 64,
    threads: int | None = None,
    progress: Progress | None = None,
) -> LitModel:
    """Light any mesh; the same bytes for any number of threads.

    Faces turned the wrong way are lit on the side that people see; surfaces that glow light others.

    Args:
        mesh: what stands there, metres, +z up.
        building: its rooms, each of which gets lamps below its ceiling; None for daylight alone.
        settings: what shines; None for sun and sky, and the lamps of the rooms.
        rays: gathered per light map point where no settings are given.
        threads: how many to use; None for as many as there are processors.
        progress: called as ``progress(done, total, what)``.

    Raises:
        InputError: the mesh has no faces; rays not 1 to 4096.
        MissingDependencyError: embreex is not installed.
    """
    rays = check_integer("light_model", "rays", rays, 1, 4096)
    caster = RayCaster(mesh)
    charts = charts_of(mesh, caster, threads)
    if settings is None:
        lamps = () if building is None else room_lamps(building, caster)
        settings = replace(_for_size(charts), lamps=lamps, rays=rays)
    settings = replace(settings, two_sided=True, emissive=True)
    model = LitModel(mesh, charts, bake(mesh, charts, caster, settings, threads, progress))
    model.__dict__["caster"] = caster  # the cached property, made already
    return model


def _for_size(charts: Charts) -> LightSettings:
    """Spacings that keep the lattices of large models in bounds."""
    c = charts.corners
    area = np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 3] - c[:, 0]), axis=1)
    usual = LightSettings()
    total = float(area.sum())
    return replace(
        usual,
        soft_spacing=max(usual.soft_spacing, float(np.sqrt(total / SOFT_POINTS))),
        sun_spacing=max(usual.sun_spacing, float(np.sqrt(total / SUN_POINTS))),
    )


def room_lamps(building: Building, caster: RayCaster) -> tuple[Lamp, ...]:
    """Soft lamps below the ceilings of a building's rooms, spread over each.

    Args:
        building: the rooms.
        caster: of the mesh, which knows where the ceilings really are.
    """
    lamps = []
    for room in building.rooms:
        for x, y in _places(room):
            start = np.array([[x, y, room.floor + 0.6 * (room.ceiling - room.floor)]])
            reach = float(caster.cast(start, [[0.0, 0.0, 1.0]], threads=1).t[0])
            top = min(room.ceiling, start[0, 2] + reach)
            drop = min(BELOW_CEILING_M, 0.5 * (top - room.floor))
            lamps.append(
                Lamp((float(x), float(y), float(top - drop)), LAMP_POWER, LAMP_RADIUS, LAMP_SHADE)
            )
    return tuple(lamps)


def _places(room: Room) -> F8:
    """(N, 2) places spread over a room's floor, away from its walls."""
    corners = np.concatenate(room.rings)
    low, high = corners.min(axis=0), corners.max(axis=0)
    step = max(LATTICE_M, float((high - low).max()) / 200.0)
    axes = (np.arange(a + step / 2.0, c, step) for a, c in zip(low, high, strict=True))
    x, y = (g.ravel() for g in np.meshgrid(*axes, indexing="ij"))
    points = np.stack([x, y], axis=1)
    inside, wall = np.zeros(len(points), dtype=bool), np.full(len(points), np.inf)
    for ring in room.rings:
        for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            crosses = (p[1] > points[:, 1]) != (q[1] > points[:, 1])
            at = p[0] + (points[:, 1] - p[1]) * (q[0] - p[0]) / ((q[1] - p[1]) or 1.0)
            inside ^= crosses & (points[:, 0] < at)
            along = q - p
            t = np.clip((points - p) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
            wall = np.minimum(wall, np.linalg.norm(points - p - t[:, None] * along, axis=1))
    points, wall = points[inside], wall[inside]
    if not len(points):
        return np.zeros((0, 2))
    count = int(np.clip(round(len(points) * step**2 / ROOM_LAMP_M2), 1, ROOM_LAMPS))
    centers = points[[int(wall.argmax())]]
    for _ in range(count - 1):
        far = np.linalg.norm(points[:, None] - centers[None], axis=2).min(axis=1)
        centers = np.append(centers, points[[int(np.argmax(np.minimum(far, 2.0 * wall)))]], axis=0)
    for _ in range(8 if count > 1 else 0):  # each to the middle of the floor that is nearest to it
        owner = np.linalg.norm(points[:, None] - centers[None], axis=2).argmin(axis=1)
        for k in range(count):
            mine = points[owner == k]
            if len(mine):
                middle = mine.mean(axis=0)
                centers[k] = mine[np.linalg.norm(mine - middle, axis=1).argmin()]
    return centers
