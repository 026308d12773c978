"""belvedere: image-based scenes you can walk through.

Pictures that know their depth are warped to new views, so a frame costs what its pixels cost,
however many polygons stand behind them::

    import belvedere as bv

    scene = bv.open_scene("capture/")
    frame = scene.render(scene.home)
    bv.save_frame(frame, "view.png")

Names are loaded when they are first used: ``import belvedere`` reads NumPy and little else.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from belvedere.ground.errors import BelvedereError
from belvedere.ground.version import __version__
from belvedere.scene import (
    Affordances,
    Camera,
    CameraPath,
    CylinderCamera,
    Explanation,
    Frame,
    Hole,
    OrthographicCamera,
    ReferenceView,
    Scene,
    SphereCamera,
    ViewSet,
)
from belvedere.warp import (
    DepthViews,
    GaussianOptions,
    OffsetOptions,
    Photographs,
    SplatOptions,
    Warper,
    WarpOptions,
    explain,
    prepare,
    warp,  # before anything imports the room of that name, so that `belvedere.warp` is the verb
)

if TYPE_CHECKING:
    from belvedere.scene.io import VideoWriter, read_views, save_frame, save_views
    from belvedere.studio.evaluate import evaluate
    from belvedere.studio.scenes import ConventionWarning, open_scene, save_scene
    from belvedere.studio.walk import render_path

_LAZY: dict[str, str] = {
    "ConventionWarning": "belvedere.studio.scenes",
    "VideoWriter": "belvedere.scene.io",
    "evaluate": "belvedere.studio.evaluate",
    "open_scene": "belvedere.studio.scenes",
    "read_views": "belvedere.scene.io",
    "render_path": "belvedere.studio.walk",
    "save_frame": "belvedere.scene.io",
    "save_scene": "belvedere.studio.scenes",
    "save_views": "belvedere.scene.io",
}
"""Public name -> the module that defines it."""


def __getattr__(name: str) -> Any:
    module = _LAZY.get(name)
    if module is None:
        raise AttributeError(f"module 'belvedere' has no attribute {name!r}")
    value = getattr(import_module(module), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})


__all__ = [
    "Affordances",
    "BelvedereError",
    "Camera",
    "CameraPath",
    "ConventionWarning",
    "CylinderCamera",
    "DepthViews",
    "Explanation",
    "Frame",
    "GaussianOptions",
    "Hole",
    "OffsetOptions",
    "OrthographicCamera",
    "Photographs",
    "ReferenceView",
    "Scene",
    "SphereCamera",
    "SplatOptions",
    "VideoWriter",
    "ViewSet",
    "WarpOptions",
    "Warper",
    "__version__",
    "evaluate",
    "explain",
    "open_scene",
    "prepare",
    "read_views",
    "render_path",
    "save_frame",
    "save_scene",
    "save_views",
    "warp",
]
