"""Files: everything that reads and writes them, and the only place foreign conventions reach.

`read_views` opens posed pictures in any format we know. Everything is written atomically; paths
inside a scene cannot leave its folder; no pickle is ever loaded. Names load when first used.

Formats: our folder, nerfstudio and instant-ngp, COLMAP, TUM RGB-D, Open3D/Redwood, Middlebury.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from belvedere.scene.io.atomic import atomic_write, require_free, staged_folder
    from belvedere.scene.io.depth import quantise_depth, read_depth_values, write_depth
    from belvedere.scene.io.detect import (
        FORMATS,
        ViewFormat,
        detect_format,
        format_conventions,
        read_views,
    )
    from belvedere.scene.io.exporters import (
        WRITERS,
        to_cameras_json,
        to_colmap,
        to_tum,
        write_views,
    )
    from belvedere.scene.io.frames import save_frame
    from belvedere.scene.io.images import image_size, read_color, write_color
    from belvedere.scene.io.json_files import JsonObject, read_json, write_json
    from belvedere.scene.io.limits import MAX_PIXELS
    from belvedere.scene.io.paths import existing, inside
    from belvedere.scene.io.pixels_out import SavedViews
    from belvedere.scene.io.save import discard_partial, save_views
    from belvedere.scene.io.stereo import read_stereo
    from belvedere.scene.io.tum import read_tum
    from belvedere.scene.io.video import VideoWriter

_HOME = {
    "atomic_write": "atomic",
    "require_free": "atomic",
    "staged_folder": "atomic",
    "quantise_depth": "depth",
    "read_depth_values": "depth",
    "write_depth": "depth",
    "FORMATS": "detect",
    "ViewFormat": "detect",
    "detect_format": "detect",
    "format_conventions": "detect",
    "read_views": "detect",
    "WRITERS": "exporters",
    "to_cameras_json": "exporters",
    "to_colmap": "exporters",
    "to_tum": "exporters",
    "write_views": "exporters",
    "save_frame": "frames",
    "image_size": "images",
    "read_color": "images",
    "write_color": "images",
    "JsonObject": "json_files",
    "read_json": "json_files",
    "write_json": "json_files",
    "MAX_PIXELS": "limits",
    "existing": "paths",
    "inside": "paths",
    "SavedViews": "pixels_out",
    "discard_partial": "save",
    "save_views": "save",
    "read_stereo": "stereo",
    "read_tum": "tum",
    "VideoWriter": "video",
}
"""Public name -> its file."""


def __getattr__(name: str) -> Any:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})


__all__ = [
    "FORMATS",
    "MAX_PIXELS",
    "WRITERS",
    "JsonObject",
    "SavedViews",
    "VideoWriter",
    "ViewFormat",
    "atomic_write",
    "detect_format",
    "discard_partial",
    "existing",
    "format_conventions",
    "image_size",
    "inside",
    "quantise_depth",
    "read_color",
    "read_depth_values",
    "read_json",
    "read_stereo",
    "read_tum",
    "read_views",
    "require_free",
    "save_frame",
    "save_views",
    "staged_folder",
    "to_cameras_json",
    "to_colmap",
    "to_tum",
    "write_color",
    "write_depth",
    "write_json",
    "write_views",
]
