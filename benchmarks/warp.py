"""Warping to one desired view (asv): how long it takes, and how good the picture is.

Times are of the benchmark's room of boxes; pictures are judged at the built-in house's stations.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from belvedere.studio._bench_quality import Quality, mean_quality, quality
from belvedere.studio._bench_scene import make_room
from belvedere.studio._bench_speed import warp_choices
from belvedere.studio._bench_stations import make_stations
from belvedere.warp import RECONSTRUCTIONS, PreparedView, prepare, warp

SIZES = [256, 512, 1024]
THREADS = [1, 2]
PICTURE_SIZE = 256
NAMES = ["point", "splat3", "splat-jacobian", "gaussian", "mesh", "offset", "offset-full"]


class Warp:
    """References prepared once, as a scene does."""

    params: ClassVar = [NAMES, ["order", "zbuffer"], SIZES, THREADS]
    param_names: ClassVar = ["reconstruction", "visibility", "size", "threads"]
    timeout = 300

    def setup(self, name: str, visibility: str, size: int, threads: int) -> None:
        self.scene = make_room(size)
        self.prepared: list[PreparedView] = [prepare(view) for view in self.scene.views]
        self.choices: dict[str, Any] = {
            **warp_choices()[name], "visibility": visibility, "threads": threads
        }  # fmt: skip
        warp(self.prepared, self.scene.camera, **self.choices)  # kernels compile here

    def time_one_reference(self, *_: object) -> None:
        warp(self.prepared[0], self.scene.camera, **self.choices)

    def time_two_references(self, *_: object) -> None:
        warp(self.prepared, self.scene.camera, **self.choices)


class Complexity:
    """One view of as many samples whatever stands there: bare walls, furniture, a field of sticks.

    A polygon renderer's time grows with the surface; a warp's must not (Popescu and Lastra; spec
    offset-buffer-warping 6.7).
    """

    params: ClassVar = [["default", *RECONSTRUCTIONS], ["nothing", "furniture", "sticks"]]
    param_names: ClassVar = ["reconstruction", "contents"]
    timeout = 300

    def setup(self, name: str, contents: Any) -> None:
        self.scene = make_room(512, contents=contents)
        self.prepared = [prepare(view) for view in self.scene.views]
        self.choices: dict[str, Any] = {} if name == "default" else {"reconstruction": name}
        self.time_two_references()

    def time_two_references(self, *_: object) -> None:
        warp(self.prepared, self.scene.camera, threads=1, **self.choices)


class WarpUnprepared:
    """From the view itself: bounds, edges and linear colour are computed on the way."""

    params: ClassVar = [NAMES, SIZES]
    param_names: ClassVar = ["reconstruction", "size"]
    timeout = 300

    def setup(self, name: str, size: int) -> None:
        self.scene = make_room(size)
        self.choices = warp_choices()[name]
        warp(self.scene.views[0], self.scene.camera, **self.choices)

    def time_one_reference(self, *_: object) -> None:
        warp(self.scene.views[0], self.scene.camera, **self.choices)


class Prepare:
    """What a scene does once for each of its views."""

    params: ClassVar = [SIZES]
    param_names: ClassVar = ["size"]

    def setup(self, size: int) -> None:
        self.view = make_room(size).views[0]
        self.time_everything(size)

    def time_everything(self, size: int) -> None:
        del size
        prepared = prepare(self.view)
        prepared.surface()
        prepared.links()
        prepared.linear()


class Picture:
    """The numbers of `belvedere bench warp`, which tells what they mean, for a history of them."""

    params: ClassVar = [["default", *RECONSTRUCTIONS], [1, 2, 5], ["stations", "held out"]]
    param_names: ClassVar = ["reconstruction", "references", "scene"]
    timeout = 300

    def setup_cache(self) -> str:
        """Photograph both scenes once for all benchmarks; asv runs this in a folder of its own."""
        folder = Path.cwd()
        for held_out in (False, True):
            make_stations(PICTURE_SIZE, held_out, folder)
        return str(folder)

    def setup(self, folder: str, name: str, count: int, scene: str) -> None:
        choices: dict[str, Any] = {} if name == "default" else {"reconstruction": name}
        each: list[Quality] = []
        for station in make_stations(PICTURE_SIZE, scene == "held out", Path(folder)):
            frame = warp(station.views(count), station.camera, **choices)
            each.append(quality(frame.color, frame.disparity, frame.coverage, station, count))
        self.judged = mean_quality(each)

    def track_psnr(self, *_: object) -> float:
        return self.judged.psnr

    def track_ssim(self, *_: object) -> float:
        return self.judged.ssim

    def track_cracks(self, *_: object) -> float:
        return self.judged.cracks

    def track_ghosts(self, *_: object) -> float:
        return self.judged.ghosts

    def track_wrong_depth(self, *_: object) -> float:
        return self.judged.wrong_depth


Picture.track_psnr.unit = "dB"  # type: ignore[attr-defined]
for track in (Picture.track_cracks, Picture.track_ghosts, Picture.track_wrong_depth):
    track.unit = "%"  # type: ignore[attr-defined]
