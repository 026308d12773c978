"""Light for a model that comes without: sun, sky, its own glowing surfaces, a lamp in each room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.progress import Progress, silent
from belvedere.model.building import Building
from belvedere.model.chart_mesh import charts_of
from belvedere.model.light import Lamp, LightSettings, bake
from belvedere.model.photograph import LitModel
from belvedere.model.raycast import RayCaster
from belvedere.scene.mesh import Mesh

SOFT_POINTS, SUN_POINTS = 3e6, 1.2e7
"""Points of light of a model at most: a larger one has them farther apart."""
LAMP_M2 = 14.0
"""Square metres of a room for which one lamp is enough."""
LAMP_DROP_M = 0.55
"""How far below the ceiling a room's lamp hangs."""
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
    """Lamps below the ceilings of all rooms, one for every `LAMP_M2` square metres or less."""
    lamps = []
    for room in building.rooms:
        ring = max(room.rings, key=_area)
        count = max(1, round(_area(ring) / LAMP_M2))
        low, high = ring.min(axis=0), ring.max(axis=0)
        along = int(np.argmax(high - low))
        height = room.ceiling - min(LAMP_DROP_M, 0.2 * (room.ceiling - room.floor))
        for k in range(count):
            at = (low + high) / 2.0
            at[along] = low[along] + (k + 0.5) / count * (high[along] - low[along])
            lamps.append(Lamp((float(at[0]), float(at[1]), float(height)), LAMP_POWER))
    return tuple(lamps)


def _area(ring: npt.NDArray[np.float64]) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


def _doubled_areas(mesh: Mesh) -> npt.NDArray[np.float64]:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)
