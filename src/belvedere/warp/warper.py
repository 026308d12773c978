"""`Warper`: one warp after another, for video and for walking about."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.errors import CameraError, InputError
from belvedere.ground.threads import thread_count
from belvedere.scene import CameraModel, Frame, ReferenceView
from belvedere.warp.fading import Fading
from belvedere.warp.features import feature_channels
from belvedere.warp.manifold import central
from belvedere.warp.prepare import PreparedView, prepare
from belvedere.warp.reconstruct import WarpOptions
from belvedere.warp.warp import frame_bytes, merge_options, prepare_all, warp_prepared

KEPT_VIEWS = 32
"""Prepared views that a warper remembers by default."""
LARGEST_SIDE = 1 << 16
LONGEST_FADE = 10_000
"""Frames; several minutes of video."""


class Warper:
    """Warps to views of one size, keeping what one frame can leave to the next.

    ::

        warper = Warper(640, 512)
        for camera in cameras:
            show(warper.warp([left, right], camera))

    The same pictures as `warp`, to the last bit. Views are prepared when they are first seen and
    remembered; working buffers and the frame's own memory are used again. **A frame therefore lasts
    until the next call only**: copy what is to be kept. What is changed in a view's arrays after it
    was first given is not seen: make a new view. One warper serves one thread at a time.

    Args:
        width: of the frames, pixels.
        height: of the frames.
        options: every choice in one `WarpOptions`.
        threads: how many to use, by default as many as there are processors.
        kept: prepared views to remember; the one not used for longest is forgotten first.
        cross_fade: frames over which references that enter or leave the set gain or lose their
            weight; 0 changes at once. Only colours fade: surfaces that a reference alone sees are
            there from its first frame, and gone after its last.
        choices: or single fields of `WarpOptions` by name.

    Raises:
        InputError: a size, a count, an option or a value it does not take.

    Memory: 11 to 24 bytes a pixel for the frame, 4 for each channel of features, and for each
    remembered view up to 56 bytes a sample beside its own pixels. With ``cross_fade`` up to
    `LEAVING_VIEWS` references more are remembered and warped while they leave.
    """

    def __init__(
        self,
        width: int,
        height: int,
        *,
        options: WarpOptions | None = None,
        threads: int | None = None,
        kept: int = KEPT_VIEWS,
        cross_fade: int = 0,
        **choices: Any,
    ) -> None:
        self.width = check_integer("Warper", "width", width, 1, LARGEST_SIDE)
        self.height = check_integer("Warper", "height", height, 1, LARGEST_SIDE)
        self.options = merge_options(options, choices, "Warper", ("threads", "kept", "cross_fade"))
        self.threads = thread_count(threads)
        self._kept = check_integer("Warper", "kept", kept, 1, 1 << 20)
        frames = check_integer("Warper", "cross_fade", cross_fade, 0, LONGEST_FADE)
        if frames and self.options.composite != "blend":
            raise InputError(
                f'Warper.cross_fade needs composite="blend": with "{self.options.composite}" '
                "references have no weights that could fade"
            )
        self._fading = Fading(frames) if frames else None
        self._views: OrderedDict[int, PreparedView] = OrderedDict()
        self._block = np.empty(0, np.uint8)
        self._features = np.empty(0, np.float32)

    def warp(
        self,
        views: ReferenceView | PreparedView | Iterable[ReferenceView | PreparedView],
        camera: CameraModel,
    ) -> Frame:
        """Show reference views from a desired camera; see `belvedere.warp`.

        Args:
            views: one or several.
            camera: planar, a cylinder or a sphere, of the warper's size.

        Returns:
            The frame; the next call writes over it.

        Raises:
            CameraError: an orthographic camera, or one of another size.
            ViewError: no view, or views whose colours or features differ in type or channels.

        With ``explain=True``, references that are fading out are numbered after those given.
        """
        desired = central(camera, "desired")
        if desired.size != (self.height, self.width):
            raise CameraError(
                f"Warper.warp.camera is {desired.width} x {desired.height}, expected "
                f"{self.width} x {self.height}: make one warper for each size"
            )
        if isinstance(views, ReferenceView):
            views = [views]
        if isinstance(views, Iterable):
            views = [self._remembered(view) for view in views]
        prepared, shares = prepare_all(views, "Warper.warp"), None
        if self._fading is not None:
            prepared, shares = self._fading.step(prepared)
        size = frame_bytes(prepared[0], desired)
        if self._block.size < size:
            self._block = np.empty(size, np.uint8)
        features = self._feature_memory(desired.size, feature_channels(prepared))
        return warp_prepared(
            prepared, desired, self.options, self.threads, self._block, shares, features
        )

    def cut(self) -> None:
        """Begin anew: the next frame's references fade neither in nor out, as after a jump."""
        if self._fading is not None:
            self._fading.forget()

    def _feature_memory(
        self, size: tuple[int, int], channels: int
    ) -> npt.NDArray[np.float32] | None:
        """(H, W, channels), the same memory for every frame; None without features."""
        if channels == 0:
            return None
        count = size[0] * size[1] * channels
        if self._features.size < count:
            self._features = np.empty(count, np.float32)
        return self._features[:count].reshape(*size, channels)

    def _remembered(self, view: Any) -> Any:
        """The view prepared, if it is one; `prepare_all` refuses the rest."""
        if not isinstance(view, ReferenceView):
            return view
        found = self._views.get(id(view))
        if found is None:  # it holds the view, so the number stays the view's own
            found = self._views[id(view)] = prepare(view)
            if len(self._views) > self._kept:
                self._views.popitem(last=False)
        self._views.move_to_end(id(view))
        return found
