"""What a scene is, what it affords and how big it is: the facts behind ``belvedere info``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.scene import Affordances, ViewingRegion, ViewSet
from belvedere.studio._judgement import ConventionReport
from belvedere.studio.scenes import check_views, read_capture, scene_of
from belvedere.warp import DepthViews


@dataclass(frozen=True, slots=True, eq=False)
class SceneFacts:
    """What a scene folder holds."""

    path: Path
    views: ViewSet
    affords: Affordances
    region: ViewingRegion
    """Where it looks right from, metres."""
    disk_bytes: int
    """Bytes of every file in the folder."""
    disparities: tuple[float, ...]
    """Quartiles of disparity, 1/metre; empty without depth."""
    check: ConventionReport | None
    """What the check of the conventions found; None if not asked for or nothing to do."""

    @property
    def sizes(self) -> list[str]:
        """The distinct picture sizes, ``640x480``."""
        return sorted({f"{camera.width}x{camera.height}" for camera in self.views.cameras})

    @property
    def eye_span(self) -> tuple[float, float, float]:
        """Extent of the views' eye positions along x, y and z, metres."""
        x, y, z = np.ptp(np.array([camera.center for camera in self.views.cameras]), axis=0)
        return float(x), float(y), float(z)

    @property
    def stored_unit(self) -> float | None:
        """Metres per stored number of depth; None for disparity, plain metres and no depth."""
        held = self.views.facts
        scale = held.get("depth_scale")
        kind = (held.get("conventions") or {}).get("depth_kind")
        return None if scale is None or scale == 1 or kind == "disparity" else float(scale)

    def as_dict(self) -> dict[str, Any]:
        """Everything, as JSON values."""
        with_depth = sum(entry.has_depth for entry in self.views.entries)
        return {
            "path": str(self.path),
            "views": len(self.views),
            "views_with_depth": with_depth,
            "sizes": self.sizes,
            "disk_bytes": self.disk_bytes,
            "affords": self.affords.as_dict(),
            "eye_span": [round(x, 6) for x in self.eye_span],
            "viewing_region": {
                "low": [round(float(x), 6) for x in self.region.low],
                "high": [round(float(x), 6) for x in self.region.high],
            },
            "disparity_quartiles": [round(x, 6) for x in self.disparities],
            "facts": {
                key: value
                for key, value in self.views.facts.items()
                if key not in ("path", "extra", "frame_extra", "belvedere")
            },
            "check": None if self.check is None else self.check.as_dict(),
        }


def inspect_scene(
    path: str | Path,
    asked: dict[str, Any] | None = None,
    *,
    format: str | None = None,  # noqa: A002 - as in open_scene
    check: bool = True,
) -> SceneFacts:
    """Read a scene's facts, and check whether its views agree.

    Args:
        path: a scene folder.
        asked: conventions instead of the format's own (`studio.scenes.stated_conventions`).
        format: a layout's name, instead of looking.
        check: warp neighbouring views into each other.

    Raises:
        SceneError: as `open_scene`.
    """
    place = Path(path)
    views = read_capture(place, asked, format)
    scene = scene_of(views)
    quartiles: tuple[float, ...] = ()
    if isinstance(scene, DepthViews):
        quartiles = tuple(float(x) for x in scene.typical_disparities)
    folder = place if place.is_dir() else place.parent
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return SceneFacts(
        path=place,
        views=views,
        affords=scene.affords,
        region=scene.viewing_region,
        disk_bytes=size,
        disparities=quartiles,
        check=check_views(views) if check else None,
    )


def median_depth(facts: SceneFacts) -> float | None:
    """Metres to the middle of what the views see; None without depth."""
    return 1.0 / float(np.median(facts.disparities)) if facts.disparities else None
