"""Scenes made of posed pictures: with depth they are walked through, without they are hopped."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Collection, Iterable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import SceneError
from belvedere.scene import (
    Affordances,
    CameraModel,
    Frame,
    ReferenceView,
    ViewingRegion,
    ViewSet,
)
from belvedere.warp.choose import choose_references
from belvedere.warp.prepare import PreparedView, prepare
from belvedere.warp.reconstruct import WarpOptions
from belvedere.warp.warp import merge_options, warp

SAMPLED_VIEWS = 5
"""Views read to learn the scene's typical disparities."""
PREPARED_BYTES = 1 << 30
"""Bytes of prepared views a scene keeps (1 GiB: over a hundred of 512 x 512)."""


class DepthViews:
    """A set of reference views, walked through by warping the best of them.

    ::

        scene = DepthViews(views, references=2)
        frame = scene.render(camera)

    Memory: what the `ViewSet` keeps, plus at most `PREPARED_BYTES` of prepared views.
    """

    def __init__(
        self,
        views: ViewSet | Iterable[ReferenceView],
        *,
        references: int = 2,
        threads: int | None = None,
        options: WarpOptions | None = None,
        **choices: Any,
    ) -> None:
        """See `belvedere.warp.warp` for ``options`` and ``choices``.

        Args:
            views: the references; every one has depth.
            references: how many to warp for a frame, 1 to 16.
            threads: how many to use.
            options: every choice of the warp.
            choices: single choices of the warp by name.

        Raises:
            SceneError: a view without depth, or no view at all.
            InputError: an unknown choice.
        """
        self.views = views if isinstance(views, ViewSet) else ViewSet.of(views)
        for index in range(len(self.views)):
            if not self.views.entries[index].has_depth:
                _ = self.views[index]  # raises and says what is missing
        self.references = check_integer("DepthViews", "references", references, 1, 16)
        self.threads = threads
        self.options = merge_options(options, choices)
        self._prepared: OrderedDict[int, PreparedView] = OrderedDict()
        self._lock = threading.Lock()

    affords = Affordances(movement="continuous", geometry="local", lighting="fixed")

    @property
    def home(self) -> CameraModel:
        """The camera of the first reference."""
        return self.views.cameras[0]

    @cached_property
    def typical_disparities(self) -> npt.NDArray[np.float64]:
        """(3,) quartiles of disparity, 1/metre, from a few views spread over the set."""
        indices = np.unique(np.linspace(0, len(self.views) - 1, SAMPLED_VIEWS).astype(int))
        held = [self.views[int(i)].disparity[::8, ::8].ravel() for i in indices]
        values = np.concatenate(held)
        values = values[values > 0]
        if values.size == 0:
            return np.array([1.0])
        return np.quantile(values.astype(np.float64), [0.25, 0.5, 0.75])

    @property
    def viewing_region(self) -> ViewingRegion:
        """The box round the references' centers, wider by a tenth of the median depth."""
        centers = np.array([camera.center for camera in self.views.cameras])
        return ViewingRegion.around(centers, 0.1 / float(np.median(self.typical_disparities)))

    def choose(
        self, camera: CameraModel, count: int | None = None, exclude: Collection[int] = ()
    ) -> list[int]:
        """Indices of the references that show ``camera`` best, best first.

        Args:
            camera: the desired camera.
            count: how many; by default the scene's ``references``.
            exclude: indices that must not be used, such as a view held out for evaluation.
        """
        return choose_references(
            self.views.cameras, camera, self.typical_disparities, count or self.references, exclude
        )

    def render(
        self, camera: CameraModel, *, exclude: Collection[int] = (), **choices: Any
    ) -> Frame:
        """The picture from ``camera``, warped from the best references.

        Args:
            camera: planar camera, cylinder or sphere.
            exclude: indices of references that must not be used.
            choices: choices of the warp for this frame only.

        Raises:
            SceneError: no reference is left, or one cannot be read.
            CameraError: the camera is orthographic.
        """
        chosen = self.choose(camera, exclude=exclude)
        if not chosen:
            raise SceneError(
                f"DepthViews: all {len(self.views)} references are excluded, expected at least one "
                "to be left"
            )
        return self.warp(chosen, camera, **choices)

    def warp(self, indices: Iterable[int], camera: CameraModel, **choices: Any) -> Frame:
        """The picture from ``camera``, warped from given references."""
        prepared = [self.prepared(index) for index in indices]
        options = merge_options(self.options, choices)
        return warp(prepared, camera, threads=self.threads, options=options)

    def prepared(self, index: int) -> PreparedView:
        """Reference ``index`` with what every warp of it needs; the recent ones are kept."""
        with self._lock:
            held = self._prepared.get(index)
            if held is not None:
                self._prepared.move_to_end(index)
                return held
        made = prepare(self.views[index])
        with self._lock:
            self._prepared[index] = made
            each = made.disparity.size * 20 + made.view.nbytes
            while len(self._prepared) > max(2, PREPARED_BYTES // each):
                self._prepared.popitem(last=False)
        return made


class Photographs:
    """Posed pictures without depth: a visitor hops from one to the next and looks around.

    Each frame is the photograph that shows most of the desired picture, turned as if everything
    were infinitely far (the homography between the two cameras), so its disparity is 0.
    """

    def __init__(self, views: ViewSet, *, threads: int | None = None) -> None:
        self.views = views
        self.threads = threads

    affords = Affordances(movement="discrete", geometry="none", lighting="fixed")

    @property
    def home(self) -> CameraModel:
        """The camera of the first photograph."""
        return self.views.cameras[0]

    @property
    def viewing_region(self) -> ViewingRegion:
        """The box round the photographs' centers."""
        return ViewingRegion.around(np.array([camera.center for camera in self.views.cameras]))

    def choose(self, camera: CameraModel, exclude: Collection[int] = ()) -> int:
        """Index of the photograph to show: among the nearest places, the best direction."""
        centers = np.array([one.center for one in self.views.cameras])
        spread = float(np.linalg.norm(np.ptp(centers, axis=0))) or 1.0
        # as if the scene lay a spread away: nearness and direction weigh about the same
        chosen = choose_references(self.views.cameras, camera, [1.0 / spread], 1, exclude)
        if not chosen:
            raise SceneError(
                f"Photographs: all {len(self.views)} photographs are excluded, expected at least "
                "one to be left"
            )
        return chosen[0]

    def render(
        self, camera: CameraModel, *, exclude: Collection[int] = (), **choices: Any
    ) -> Frame:
        """The best photograph, turned to ``camera``. Arguments as `DepthViews.render`."""
        index = self.choose(camera, exclude)
        color = self.views.color(index)
        flat = np.zeros(color.shape[:2], np.float32)
        view = ReferenceView(self.views.cameras[index], color, flat)
        options = merge_options(WarpOptions(), choices)
        moved = _moved_to(camera, view.camera.center)
        frame = warp(view, moved, threads=self.threads, options=options)
        return Frame(camera, frame.color, frame.disparity, frame.coverage, frame.filled)


def _moved_to(camera: CameraModel, center: npt.NDArray[np.float64]) -> CameraModel:
    from belvedere.warp.manifold import central

    checked: Any = central(camera, "desired")  # each of them can be moved
    return checked.moved(center)
