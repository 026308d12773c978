"""Polygon models: ray casting with Embree, baked light, photographs with exact depth.

The built-in house (`build_interior`) needs no files and gives the demo, the tests and the
benchmarks references with ground truth. Embree: Wald et al. 2014; light gathered over the
hemisphere after Goral et al. 1984.
"""

from belvedere.model.building import Building, Opening, Room
from belvedere.model.house import (
    HOUSES,
    House,
    HouseKind,
    UnlitHouse,
    build_house,
    build_unlit_house,
)
from belvedere.model.imported import ImportedModel, ModelSource
from belvedere.model.interior import Interior, build_interior
from belvedere.model.light import Lamp, LightMap, LightSettings, bake
from belvedere.model.lighting import light_model, room_lamps
from belvedere.model.lit_file import load_lit_model, save_lit_model
from belvedere.model.model_scene import ModelScene
from belvedere.model.opengl_rasterize import OpenGLDrawList, OpenGLRasterizer
from belvedere.model.photograph import LitModel, photograph, photograph_pixels
from belvedere.model.rasterize import DrawList, Rasterizer
from belvedere.model.raycast import Hits, RayCaster
from belvedere.model.read import MODEL_SUFFIXES, read_model
from belvedere.model.write import write_glb

__all__ = [
    "HOUSES",
    "MODEL_SUFFIXES",
    "Building",
    "DrawList",
    "Hits",
    "House",
    "HouseKind",
    "ImportedModel",
    "Interior",
    "Lamp",
    "LightMap",
    "LightSettings",
    "LitModel",
    "ModelScene",
    "ModelSource",
    "OpenGLDrawList",
    "OpenGLRasterizer",
    "Opening",
    "Rasterizer",
    "RayCaster",
    "Room",
    "UnlitHouse",
    "bake",
    "build_house",
    "build_interior",
    "build_unlit_house",
    "light_model",
    "load_lit_model",
    "photograph",
    "photograph_pixels",
    "read_model",
    "room_lamps",
    "save_lit_model",
    "write_glb",
]
