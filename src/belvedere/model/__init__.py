"""Polygon models: ray casting with Embree, baked light, photographs with exact depth.

The built-in house (`build_interior`) needs no files and gives the demo, the tests and the
benchmarks references with ground truth. Embree: Wald et al. 2014; light gathered over the
hemisphere after Goral et al. 1984.
"""

from belvedere.model.building import Building, Opening, Room
from belvedere.model.chart_mesh import charts_of
from belvedere.model.house import HOUSES, House, HouseKind, build_house
from belvedere.model.interior import Interior, build_interior
from belvedere.model.light import Lamp, LightMap, LightSettings, bake
from belvedere.model.light_mesh import light_model
from belvedere.model.lit_file import load_lit_model, save_lit_model
from belvedere.model.model_scene import ModelScene
from belvedere.model.photograph import LitModel, photograph
from belvedere.model.rasterize import DrawList, Rasterizer
from belvedere.model.raycast import Hits, RayCaster

__all__ = [
    "HOUSES",
    "Building",
    "DrawList",
    "Hits",
    "House",
    "HouseKind",
    "Interior",
    "Lamp",
    "LightMap",
    "LightSettings",
    "LitModel",
    "ModelScene",
    "Opening",
    "Rasterizer",
    "RayCaster",
    "Room",
    "bake",
    "build_house",
    "build_interior",
    "charts_of",
    "light_model",
    "load_lit_model",
    "photograph",
    "save_lit_model",
]
