"""Light for a model that comes without: sun, sky, its own glowing surfaces, a lamp in each room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.progress import Progress, silent
from belvedere.model._ifc_rooms import inside
from belvedere.model.building import Building
from belvedere.model.chart_mesh import charts_of
from belvedere.model.light import Lamp, LightSettings, bake
from belvedere.model.photograph import LitModel
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

F8 = npt.NDArray[np.float64]

SOFT_POINTS, SUN_POINTS = 3e6, 1.2e7
"""Points of light of a model at most: a larger one has them farther apart."""
LAMP_M2 = 14.0
"""Square metres of a room for which one lamp is enough."""
LAMP_DROP_M = 0.55
"""How far below the ceiling a room's lamp hangs."""
LAMP_WALL_M = 0.3
"""A lamp does not hang nearer to a wall, unless the room is narrow."""
LAMP_POWER = (1.3, 1.12, 0.88)
"""Linear radiance of a white surface facing a lamp at one metre: a warm sixty watts."""

__all__ = ["light_model", "room_lamps"]


def light_model(
    mesh: Mesh,
    building: Building | None = None,
    *,
    settings: LightSettings | None = None,
    rays: int = 64,
    threads: int | None = None,
    progress: Progress = silent,
) -> LitModel:
    """Bake light on any mesh.

    Args:
        mesh: the model; fronts and backs of its faces may be mixed up.
        building: its rooms, each of which gets lamps: inner rooms would be caves.
        settings: what shines and how finely it is stored; None for a sunny day, with lamps on.
        rays: gathered for each point of light, where ``settings`` is None.
        threads: how many to use; None for as many as there are processors. The light is the same.
        progress: told in hundredths.

    Raises:
        InputError: the mesh has no faces; rays not 4 to 4096.
        MissingDependencyError: embreex is not installed.

    Memory: some 700 bytes a face, and 300 for each point of light while it runs.
    """
    rays = check_integer("light_model", "rays", rays, 4, 4096)
    caster = RayCaster(mesh)
    charts = charts_of(mesh, caster, threads)
    if settings is None:
        lamps = () if building is None else room_lamps(building)
        settings = LightSettings(lamps=lamps, rays=rays, bounces=3, emissive=True)
        area = 0.5 * np.linalg.norm(_doubled_areas(mesh), axis=1).sum()
        settings = replace(
            settings,
            soft_spacing=max(settings.soft_spacing, float(np.sqrt(area / SOFT_POINTS))),
            sun_spacing=max(settings.sun_spacing, float(np.sqrt(area / SUN_POINTS))),
        )
    model = LitModel(mesh, charts, bake(mesh, charts, caster, settings, threads, progress))
    model.__dict__["caster"] = caster  # the cached property, made already
    return model


def room_lamps(building: Building) -> tuple[Lamp, ...]:
    """Lamps below the ceilings of all rooms, one for every `LAMP_M2` square metres or less.

    They hang along the middle of a room; where the room bends so that this is outside it or at a
    wall, where there is most room round them.
    """
    lamps = []
    for room in building.rooms:
        count = max(1, round(_area(max(room.rings, key=_area)) / LAMP_M2))
        height = room.ceiling - min(LAMP_DROP_M, 0.2 * (room.ceiling - room.floor))
        for x, y in _hung(room.rings, count):
            lamps.append(Lamp((float(x), float(y), float(height)), LAMP_POWER))
    return tuple(lamps)


def _hung(rings: tuple[F8, ...], count: int) -> F8:
    """(count, 2) places inside an outline, away from its edges and from one another."""
    ring = max(rings, key=_area)
    low, high = ring.min(axis=0), ring.max(axis=0)
    along = int(np.argmax(high - low))
    line = np.repeat([(low + high) / 2.0], count, axis=0)
    line[:, along] = low[along] + (np.arange(count) + 0.5) / count * (high - low)[along]
    if (_clearance(rings, line) >= min(LAMP_WALL_M, 0.45 * float((high - low).min()))).all():
        return line
    steps = np.maximum(np.ceil((high - low) / max(0.2, float((high - low).max()) / 100)), 1)
    u, v = (
        low[c] + (np.arange(int(steps[c])) + 0.5) / steps[c] * (high - low)[c] for c in range(2)
    )
    spots = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    clear = _clearance(rings, spots)
    spots, clear = spots[clear >= clear.max() / 2.0], clear[clear >= clear.max() / 2.0]
    chosen, apart = [int(np.argmax(clear))], np.full(len(spots), np.inf)
    while len(chosen) < count:
        apart = np.minimum(apart, np.linalg.norm(spots - spots[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(apart + clear)))
    return spots[chosen]


def _clearance(rings: tuple[F8, ...], points: F8) -> F8:
    """(N,) metres from points inside to the nearest edge, 0 for points outside."""
    nearest = np.full(len(points), np.inf)
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            way = b - a
            share = np.clip((points - a) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(points - a - share[:, None] * way, axis=1))
    return np.where(inside(rings, points), nearest, 0.0)


def _area(ring: F8) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


def _doubled_areas(mesh: Mesh) -> F8:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)
