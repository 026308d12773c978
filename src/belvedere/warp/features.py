"""Features: what reference views carry beside colour, warped along with it.

A frame's disparity says where each pixel lies in every reference. Features are looked up there, in
the references that see the surface, with taps that stay on it, and blended with the weights that
colours have: whatever the reconstruction, one path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import ViewError
from belvedere.ground.scratch import scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.ground.wording import counted
from belvedere.scene import CameraModel
from belvedere.warp.manifold import passage_matrix
from belvedere.warp.prepare import EDGE_TOLERANCE, PreparedView

F4 = npt.NDArray[np.float32]

Asked = tuple[F4, F4, npt.NDArray[np.uint8]]
"""See `ask`."""
FeatureFilter = Literal["cubic", "linear", "nearest"]
FEATURE_FILTERS: tuple[FeatureFilter, ...] = ("cubic", "linear", "nearest")

BAND_PIXELS = 1 << 14
"""Pixels of a band: its weights stay in the cache, and threads even out their loads."""


def feature_channels(views: Sequence[PreparedView]) -> int:
    """Channels of the views' features, 0 if none has any.

    Raises:
        ViewError: some have features and some have none, or of another number of channels.
    """
    counts = [0 if one.features is None else one.features.shape[2] for one in views]
    if len(set(counts)) > 1:
        texts = [
            "no features" if n == 0 else f"features of {counted(n, 'channel')}" for n in counts
        ]
        other = next(n for n, text in enumerate(texts) if text != texts[0])
        raise ViewError(
            f"warp.views[0] has {texts[0]} and warp.views[{other}] has {texts[other]}, expected "
            "the same of all: give every reference its features, or none"
        )
    return counts[0]


def gather_features(
    views: Sequence[PreparedView],
    weights: F4,
    desired: CameraModel,
    disparity: F4,
    coverage: F4,
    *,
    feature_filter: FeatureFilter,
    nearest_only: bool,
    tolerance: float,
    threads: int | None,
    backs: Sequence[F4] | None = None,
    out: F4 | None = None,
) -> F4:
    """The features of what a frame shows.

    Args:
        views: the references, nearest to the desired eye first, all with features.
        weights: (n,) how much each counts.
        desired: the frame's camera.
        disparity: (H, W) of the frame.
        coverage: (H, W) of the frame.
        feature_filter: "nearest" takes one sample and mixes nothing, neither samples nor
            references.
        nearest_only: whether the first reference that sees a pixel is taken alone.
        tolerance: relative difference in disparity that is one surface.
        threads: how many to use.
        backs: (12,) matrix from the frame to each reference; None for what their cameras say.
        out: (H, W, C) memory for the result; None for new one.

    Returns:
        (H, W, C), NaN where coverage is 0 or no reference has features near the surface.

    Memory: beyond the result, 4 bytes a reference and pixel of a band of `BAND_PIXELS`.
    """
    from belvedere.warp import _backward, _features

    channels = feature_channels(views)
    out = np.empty((*desired.size, channels), np.float32) if out is None else out
    kind = {"nearest": _features.NEAREST, "linear": _features.LINEAR, "cubic": _features.CUBIC}[
        feature_filter
    ]
    rule = _backward.LARGEST if feature_filter == "nearest" else _backward.ALL
    rule = _backward.FIRST if nearest_only else rule
    asked = [ask(one, desired, threads) for one in views]
    if backs is not None:
        asked = [(back, *one[1:]) for back, one in zip(backs, asked, strict=True)]
    flat, whole = [_flat(one) for one in views], [one.features_whole for one in views]

    def work(rows: tuple[int, int]) -> None:
        band = slice(*rows)
        front, covered = disparity[band], coverage[band]
        shares = scratch("feature shares", (len(views), *front.shape), np.float32)
        for n, (back, surface, links) in enumerate(asked):
            _backward.weigh(
                back, surface, links, front, covered, rows[0], weights[n], tolerance,
                EDGE_TOLERANCE, shares[n],
            )  # fmt: skip
            if not whole[n]:
                _features.drop_unknown(
                    kind, back, surface, links, flat[n], front, rows[0], EDGE_TOLERANCE, shares[n]
                )
        _backward.settle(rule, shares)
        out[band] = 0.0
        out[band][~(shares > 0).any(axis=0)] = np.nan
        for n, (back, surface, links) in enumerate(asked):
            _features.gather(
                kind, whole[n], back, surface, links, flat[n], front, rows[0], shares[n],
                EDGE_TOLERANCE, out[band],
            )  # fmt: skip

    run_parallel(work, bands_of(desired, threads), threads)
    return out


def ask(view: PreparedView, desired: CameraModel, threads: int | None) -> Asked:
    """What kernels need to ask a reference: (12,) matrix back, (H, W) surface, (H, W) links."""
    back = passage_matrix(desired, view.camera).astype(np.float32).ravel()
    return back, view.surface(threads), view.links(threads)


def _flat(view: PreparedView) -> F4:
    features = view.features
    assert features is not None  # checked by feature_channels
    return features.reshape(-1, features.shape[2])


def bands_of(desired: CameraModel, threads: int | None) -> list[tuple[int, int]]:
    """Rows of the desired view in bands; what is written does not depend on them."""
    count = max(desired.height * desired.width // BAND_PIXELS, thread_count(threads))
    return row_bands(desired.height, count)
