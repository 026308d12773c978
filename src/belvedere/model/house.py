"""The built-in houses: furnished, lit, of any number of polygons, from a seed.

The plans are fixed (`belvedere.model.house_plans`); the seed chooses textures, furniture, where it
stands and how it is turned. Light is baked on the cage of the furniture (`SmoothBuilder`), so that
a house in ten times as many polygons has the same light.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from belvedere.ground.checks import check_choice, check_integer
from belvedere.model.building import Building
from belvedere.model.furnishing import furnish
from belvedere.model.house_plans import PLANS, POLYGONS
from belvedere.model.light import LightMap, LightSettings, bake
from belvedere.model.palette import add_house_materials, make_palette
from belvedere.model.photograph import LitModel
from belvedere.model.plan import build_shell
from belvedere.model.raycast import RayCaster
from belvedere.model.smooth import SmoothBuilder

HouseKind = Literal["flat", "brooks", "haunted"]
"""A flat of two rooms; 19 rooms on one floor; seven rooms on two."""
EYE_M = 1.6
"""Height of the eye above the floor."""
MOST_DETAIL = 20


@dataclass(frozen=True, eq=False)
class House(LitModel):
    """A built-in house, lit and ready to be photographed and walked through."""

    building: Building
    """Its rooms and openings."""
    kind: HouseKind = "flat"
    """Which plan."""
    seed: int = 0
    """What textures and furniture were drawn from."""


def build_house(
    kind: HouseKind = "flat",
    seed: int = 0,
    detail: int = 1,
    *,
    rays: int = 128,
    threads: int | None = None,
) -> House:
    """Build, furnish and light a house; the same bytes for any number of threads.

    Args:
        kind: ``"flat"`` (2 rooms, 80,000 polygons), ``"brooks"`` (19 rooms, 52 openings, 528,000)
            or ``"haunted"`` (7 rooms on two floors, 12 openings, 214,000).
        seed: changes textures and furniture, not the plan.
        detail: times that many polygons: the same shapes and light, cut finer.
        rays: gathered per light map point; fewer is quicker and blotchier.
        threads: how many to use; None for as many as there are processors.

    Raises:
        InputError: an unknown kind; a seed that is not a whole number from 0 to 2**31 - 1; detail
            not 1 to 20; rays not 4 to 4096.
        MissingDependencyError: embreex is not installed.
    """
    check_choice("build_house", "kind", kind, tuple(PLANS))
    seed = check_integer("build_house", "seed", seed, 0, 2**31 - 1)
    detail = check_integer("build_house", "detail", detail, 1, MOST_DETAIL)
    rays = check_integer("build_house", "rays", rays, 4, 4096)
    plan = PLANS[kind]()
    b = SmoothBuilder()
    m = make_palette(b, seed, threads)
    add_house_materials(b, m, seed, threads)
    build_shell(b, m, plan)
    lamps = []
    for k, room in enumerate(plan.rooms):
        lamps += furnish(b, m, plan, room, np.random.default_rng([seed, 2000 + k]))
    settings = LightSettings(lamps=tuple(lamps), rays=rays)
    light = _light(b, settings, threads)
    mesh, charts = b.refined(POLYGONS[kind] * detail)
    return House(mesh, charts, light, plan.building(), kind, seed)


def _light(b: SmoothBuilder, settings: LightSettings, threads: int | None) -> LightMap:
    """The light, baked on the cage."""
    cage, charts = b.finish()
    return bake(cage, charts, RayCaster(cage), settings, threads)
