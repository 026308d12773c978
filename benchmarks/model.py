"""Drawing polygons (asv): ours beside what else draws or casts them on this machine.

One frame from each station of the built-in interior, of the bungalow and of the bungalow in ten
times as many polygons; a rival that is not installed is left out.
"""

from __future__ import annotations

from typing import Any, ClassVar

from belvedere.ground.errors import BelvedereError
from belvedere.model import Rasterizer
from belvedere.studio._bench_drawing import RENDERERS, Subject, make_subjects

SIZE = 512
SUBJECTS = ["interior", "bungalow", "bungalow x10"]


class Frames:
    """A frame of each station."""

    params: ClassVar = [SUBJECTS, list(RENDERERS), [1, 2]]
    param_names: ClassVar = ["model", "renderer", "threads"]
    timeout = 600

    def setup_cache(self) -> list[Subject]:
        """Build and light the houses once for all benchmarks."""
        return make_subjects(SIZE, (1, 10))

    def setup(self, subjects: list[Subject], name: str, renderer: str, threads: int) -> None:
        self.subject = subjects[SUBJECTS.index(name)]
        try:
            self.draw = RENDERERS[renderer][1](self.subject.model, threads)
        except BelvedereError as refusal:
            raise NotImplementedError(str(refusal)) from refusal  # asv leaves it out
        self.time_frames()  # kernels compile here, tables are made

    def time_frames(self, *_: object) -> None:
        for camera in self.subject.cameras:
            self.draw(camera)


class Preparing:
    """What is done once for a model."""

    params: ClassVar = [SUBJECTS]
    param_names: ClassVar = ["model"]
    timeout = 600

    def setup_cache(self) -> list[Subject]:
        """Build and light the houses once."""
        return make_subjects(SIZE, (1, 10))

    def setup(self, subjects: list[Subject], name: str) -> None:
        self.model: Any = subjects[SUBJECTS.index(name)].model
        Rasterizer(self.model).prepare()

    def time_tables_and_clusters(self, *_: object) -> None:
        Rasterizer(self.model).prepare()
