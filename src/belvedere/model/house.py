"""The built-in houses: furnished, lit, of any number of polygons, from a seed.

The plans are fixed (`belvedere.model.house_plans`); the seed chooses textures, furniture, where it
stands and how it is turned. Light is baked on the cage of the furniture (`SmoothBuilder`), so that
a house in ten times as many polygons has the same light.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from belvedere.ground.checks import check_choice, check_integer
from belvedere.ground.progress import Progress, silent
from belvedere.model.building import Building
from belvedere.model.charts import Charts
from belvedere.model.furnishing import furnish
from belvedere.model.house_plans import HOUSES, HouseKind
from belvedere.model.house_walk import recorded_walk
from belvedere.model.light import Lamp, LightSettings, bake
from belvedere.model.palette import add_house_materials, make_palette
from belvedere.model.photograph import LitModel
from belvedere.model.plan import HousePlan, build_shell
from belvedere.model.raycast import RayCaster
from belvedere.model.smooth import SmoothBuilder
from belvedere.scene import CameraPath
from belvedere.scene.mesh import Mesh

MOST_DETAIL = 20
MOST_RAYS = 4096

__all__ = ["HOUSES", "House", "HouseKind", "UnlitHouse", "build_house", "build_unlit_house"]


@dataclass(frozen=True, eq=False)
class House(LitModel):
    """A built-in house, lit and ready to be photographed and walked through."""

    building: Building = field(default_factory=lambda: Building(()))
    """Its rooms, whose outlines are the inner faces of the walls, and the openings between them,
    rectangles in the middle of the wall."""
    path: CameraPath = field(kw_only=True)
    """The recorded walk: through most rooms at an even pace, eyes 1.6 m above the floor."""
    name: str = "flat"
    """Which of `HOUSES`."""
    seed: int = 0
    """What textures and furniture were drawn from."""


@dataclass(frozen=True, eq=False)
class UnlitHouse:
    """A built-in house before the light is baked."""

    mesh: Mesh
    """Its polygons, as many as the detail asks for."""
    charts: Charts
    """Where light is stored on them."""
    cage: Mesh
    """The coarse polygons on whose charts, in the same order, light is baked."""
    cage_charts: Charts
    """Charts of the cage: those of `charts`."""
    lamps: tuple[Lamp, ...]
    """The lamps of its rooms."""
    plan: HousePlan
    """Its rooms, doors, windows and stair."""


def build_unlit_house(
    name: str = "flat", seed: int = 0, *, detail: int = 1, threads: int | None = None
) -> UnlitHouse:
    """Build and furnish a house without baking its light; see `build_house`."""
    check_choice("build_house", "name", name, tuple(HOUSES))
    seed = check_integer("build_house", "seed", seed, 0, 2**31 - 1)
    detail = check_integer("build_house", "detail", detail, 1, MOST_DETAIL)
    plan = HOUSES[name].plan()
    b = SmoothBuilder()
    m = make_palette(b, seed, threads)
    add_house_materials(b, m, seed, threads)
    build_shell(b, m, plan)
    lamps = []
    for k, room in enumerate(plan.rooms):
        lamps += furnish(b, m, plan, room, np.random.default_rng([seed, 2000 + k]))
    return UnlitHouse(*b.refined(HOUSES[name].polygons * detail), *b.finish(), tuple(lamps), plan)


def build_house(
    name: str = "flat",
    seed: int = 0,
    *,
    detail: int = 1,
    rays: int = 128,
    threads: int | None = None,
    progress: Progress = silent,
) -> House:
    """Build, furnish and light a house; the same bytes for any number of threads.

    Args:
        name: ``"flat"`` (2 rooms, 80,000 polygons), ``"bungalow"`` (19 rooms, 52 openings,
            528,000) or ``"villa"`` (7 rooms on two storeys, 12 openings, 214,000).
        seed: changes textures and furniture, not the plan.
        detail: times that many polygons: the same shapes and light, cut finer.
        rays: gathered per light map point; fewer is quicker and blotchier.
        threads: how many to use; None for as many as there are processors.
        progress: told in hundredths while the light is baked.

    Raises:
        InputError: an unknown name; a seed that is not a whole number from 0 to 2**31 - 1; detail
            not 1 to 20; rays not 4 to 4096.
        MissingDependencyError: embreex is not installed.
    """
    rays = check_integer("build_house", "rays", rays, 4, MOST_RAYS)
    unlit = build_unlit_house(name, seed, detail=detail, threads=threads)
    caster = RayCaster(unlit.cage)
    settings = LightSettings(lamps=unlit.lamps, rays=rays)
    light = bake(unlit.cage, unlit.cage_charts, caster, settings, threads, progress)
    path = recorded_walk(unlit.plan, HOUSES[name].tour, caster)
    return House(
        unlit.mesh, unlit.charts, light, unlit.plan.building(), path=path, name=name, seed=seed
    )
