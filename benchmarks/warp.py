"""Warping one reference view, and two, to one desired view of the benchmark's room (asv)."""

from __future__ import annotations

from typing import Any, ClassVar

from belvedere.studio._bench_scene import make_room
from belvedere.studio.bench import warp_choices
from belvedere.warp import PreparedView, prepare, warp

SIZES = [256, 512, 1024]
THREADS = [1, 2]
NAMES = ["point", "splat3", "splat-jacobian", "mesh", "offset", "offset-full"]


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
