"""`warp`: show one or several reference views from a desired camera."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import LINEAR_TO_SRGB8
from belvedere.ground.errors import InputError, ViewError
from belvedere.ground.scratch import lend, scratch
from belvedere.ground.threads import row_bands, run_parallel, thread_count
from belvedere.scene import Camera, CameraModel, Frame, ReferenceView
from belvedere.warp.equation import epipole, warp_matrix
from belvedere.warp.features import feature_channels, gather_features
from belvedere.warp.joint import join_parts
from belvedere.warp.manifold import central, check_planar, same_pixels
from belvedere.warp.order import (
    Sheet,
    occlusion_compatible_cell_sheets,
    occlusion_compatible_sheets,
)
from belvedere.warp.panoramas import (
    bent_passage,
    paint_beyond_seam,
    reconstructor_of,
    refuse_for_panoramas,
)
from belvedere.warp.prepare import Copy, PreparedView, prepare
from belvedere.warp.reconcile import UNCHANGED, Correction, corrections
from belvedere.warp.reconstruct import RECONSTRUCTORS, Passage, WarpOptions

F4 = npt.NDArray[np.float32]

BANDS_PER_THREAD = 3
"""Bands are handed to whichever thread is free; a few per thread even out their loads."""
SCATTERED_PER_THREAD = 2
"""The same where samples scatter: those that may land on either side of a border move twice."""

SMALLEST_BAND = 8192
"""Pixels of a band for which waking a thread is worth while."""
LARGEST_BAND = 1 << 18
"""Pixels of a band at most: bounds the working memory of large views."""
SMALLEST_SCATTERED = 1 << 14
"""The same where samples scatter, which is soon done."""
LARGEST_SCATTERED = 1 << 17
"""The same where samples scatter, of all layers together: their words then stay in the second-level
cache."""

DEFAULTS = WarpOptions()
OPTION_NAMES = {field.name for field in fields(WarpOptions)}

NEARNESS_FLOOR = 0.05
"""Share of the mean distance below which being nearer to the desired eye adds no more weight."""


def warp(
    views: ReferenceView | PreparedView | Iterable[ReferenceView | PreparedView],
    camera: CameraModel,
    *,
    threads: int | None = None,
    options: WarpOptions | None = None,
    **choices: Any,
) -> Frame:
    """Show reference views from a desired camera by 3D image warping.

    ::

        frame = warp(view, camera)
        frame = warp([left, right], camera, reconstruction="splat", fill="background")

    Args:
        views: one reference view or several; with several, each desired pixel shows the surface in
            front, blended from all that see it (``composite="blend"``), or is taken from the
            reference whose center is nearest, always (``composite="nearest"``) or unless another's
            surface is clearly nearer (``composite="fuzzy"``).
        camera: planar camera, cylinder or sphere to fill; any pose and size, same world.
        threads: how many to use, by default as many as there are processors. The result does not
            depend on it.
        options: every choice in one `WarpOptions`.
        choices: or single fields of `WarpOptions` by name: ``reconstruction`` ("point", "splat",
            "gaussian", "mesh", "offset", "inverse"), ``visibility`` ("order", "zbuffer"),
            ``composite``, ``fill``, ``surface_tolerance``, ``splat``, ``gaussian``, ``offset``,
            ``feature_filter``, ``reconcile``, ``explain``.

    Returns:
        A frame of the camera's size: colour of the references' type, disparity (so that warps
        chain), coverage (0 in holes), features if the references have some, with
        ``fill="background"`` the mask of invented pixels, with ``explain=True`` its explanation.

    Raises:
        InputError: an unknown option or value.
        CameraError: an orthographic camera.
        ViewError: no view, or views whose colours differ in type or channels, or whose features
            differ in channels.

    A view warped to its own camera comes back to the last bit, whatever the reconstruction.
    ``inverse``, the default, gives the best picture: surfaces instead of samples decide what a
    pixel sees, references check one another, colours are looked up backwards, and at silhouettes
    coverage is the share of the pixel that is known. Planar references of a capture whose poses or
    exposures are not exact it brings to their mean first (``reconcile``; compared once, which takes
    a millisecond or three for each pair, and remembered by prepared views). It, ``offset`` and
    ``gaussian`` compare disparities whatever ``visibility`` says.

    Seen from behind, ``gaussian``, ``mesh`` and ``inverse`` show nothing; the others show samples,
    which have no back. All but ``point`` and ``splat`` bridge gaps of up to `BRIDGE` missing
    samples whose two sides agree (`prepare` sets that, 0 for none), so they cover what those two
    leave as holes.

    Memory: beyond the frame itself, each thread keeps working buffers for one band of at most
    `LARGEST_BAND` pixels: for ``inverse`` 37 bytes a pixel and 10 for each reference; for ``mesh``
    24 for each reference, for ``gaussian`` 12 more, for ``offset`` 33 more (its warp buffer, four
    cells a pixel), so at most 21 MB a thread with two references. For ``point``, in bands of at
    most `LARGEST_SCATTERED` pixels shared among the references, 8 bytes for each reference, for
    ``splat`` 12 more, and with several references of ``float32`` colour 4 more for each: with the
    frame (11 bytes a pixel of ``uint8`` RGB) below 64 bytes a pixel up to four references. A large
    frame's memory is used again for the next one once nobody holds it any more (see
    `ground.scratch.lend`).

    Source: McMillan 1999 (eq. 10-18), Popescu and Lastra TR99-017; specs image-warping 3 and
    offset-buffer-warping 3.
    """
    chosen = merge_options(options, choices)
    desired = central(camera, "desired")
    return warp_prepared(prepare_all(views), desired, chosen, threads)


def warp_prepared(
    views: Sequence[PreparedView],
    desired: CameraModel,
    chosen: WarpOptions,
    threads: int | None,
    block: npt.NDArray[np.uint8] | None = None,
    shares: Sequence[float] | None = None,
    features: F4 | None = None,
) -> Frame:
    """`warp` once everything is checked.

    Args:
        views: at least one, their colours of one type.
        desired: the camera to fill.
        chosen: how.
        threads: how many to use.
        block: (`frame_bytes`,) memory for the frame; None for new one.
        shares: (n,) factors above 0 by which each view counts more or less; None for 1.
        features: (H, W, C) memory for the frame's features; None for new one.
    """
    order = nearest_order(views, desired)
    prepared = [views[n] for n in order]
    if len(prepared) == 1 and same_pixels(prepared[0].camera, desired):
        # nothing moves: every sample is its pixel already, and any filter would only blur it
        chosen = replace(chosen, reconstruction="point")
    cameras = [one.camera for one in prepared]
    refuse_for_panoramas(chosen, [desired, *cameras])
    if feature_channels(prepared) > 0:
        check_planar("features are warped", desired, cameras)
    if chosen.explain:
        check_planar("explain=True asks references", desired, cameras)
    shown = None if shares is None else [shares[n] for n in order]
    if RECONSTRUCTORS[chosen.reconstruction].joins:
        _prepare_together(prepared, chosen, threads)
    mended = [UNCHANGED] * len(prepared)
    if chosen.reconcile and chosen.reconstruction == "inverse" and isinstance(desired, Camera):
        mended = corrections(prepared, shown, threads)
    passages = [
        _passage(one, desired, chosen, threads, correction)
        for one, correction in zip(prepared, mended, strict=True)
    ]
    weights = nearness_weights(prepared, desired)
    if shown is not None:
        weights = weights * np.array(shown, np.float32)
        weights /= weights.sum()
    parts, kept = join_parts(passages)

    size = desired.size
    pixels = size[0] * size[1]
    if block is None:
        block = lend(frame_bytes(prepared[0], desired))
    disparity: F4 = np.ndarray(size, np.float32, block)
    coverage: F4 = np.ndarray(size, np.float32, block, 4 * pixels)
    held = prepared[0].color
    color = np.ndarray((*size, held.shape[2]), held.dtype, block, 8 * pixels)
    count = thread_count(threads)

    def work(rows: tuple[int, int]) -> None:
        band = slice(*rows)
        _paint_band(parts, weights[kept], rows, color[band], disparity[band], coverage[band])

    if RECONSTRUCTORS[chosen.reconstruction].scatters:
        layers = len(prepared) * (2 if chosen.reconstruction == "splat" else 1)
        limits = SMALLEST_SCATTERED, max(LARGEST_SCATTERED // layers, SMALLEST_SCATTERED)
        cut = band_count(pixels, count, SCATTERED_PER_THREAD, *limits)
    else:
        cut = band_count(pixels, count, BANDS_PER_THREAD, SMALLEST_BAND, LARGEST_BAND)
    run_parallel(work, row_bands(desired.height, cut), threads)
    frame = Frame(desired, color, disparity, coverage)
    if chosen.fill == "background":
        from belvedere.warp.holes import fill_background

        frame = fill_background(frame, chosen.surface_tolerance, threads)
    if feature_channels(prepared) > 0:
        moved = any(one is not UNCHANGED for one in mended)
        held = gather_features(
            prepared, weights, desired, frame.disparity, frame.coverage,
            feature_filter=chosen.feature_filter, nearest_only=chosen.composite != "blend",
            tolerance=chosen.surface_tolerance, threads=threads,
            backs=[one.back for one in passages] if moved else None, out=features,
        )  # fmt: skip
        frame = replace(frame, features=held)
    if chosen.explain:
        from belvedere.warp.explain import explain_prepared

        explanation = explain_prepared(
            frame, desired, prepared, order, weights, chosen.surface_tolerance, 0.0, threads
        )
        frame = replace(frame, explanation=explanation)
    return frame


def _prepare_together(
    views: Sequence[PreparedView], options: WarpOptions, threads: int | None
) -> None:
    """Prepare as many references at a time as there are threads, each of them in one.

    That wakes threads once, not for every step. Those that are left over are prepared when they are
    needed, by all threads.
    """
    count = thread_count(threads)
    ends = RECONSTRUCTORS[options.reconstruction].together
    waiting = [
        one
        for one in dict.fromkeys(views)
        if isinstance(one.camera, Camera) and not one.has_surface(ends)
    ]
    if 1 < count <= len(waiting):
        whole = len(waiting) - len(waiting) % count
        run_parallel(lambda one: one.find_surface(ends, 1), waiting[:whole], threads)


def frame_bytes(reference: PreparedView, desired: CameraModel) -> int:
    """Bytes of a frame's disparity, coverage and colour."""
    pixel = 8 + reference.color.shape[2] * reference.color.dtype.itemsize
    return desired.height * desired.width * pixel


def band_count(pixels: int, threads: int, each: int, smallest: int, largest: int) -> int:
    """Into how many bands a view is cut: ``each`` for a thread, of so many pixels.

    What is cut further because it is large is cut as often for every thread.
    """
    wanted = 1 if threads == 1 else threads * each
    needed = -(-pixels // (largest * threads)) * threads if pixels > largest else 1
    return max(min(wanted, pixels // smallest), needed)


def merge_options(
    options: WarpOptions | None,
    choices: dict[str, Any],
    owner: str = "warp",
    others: Sequence[str] = ("threads",),
) -> WarpOptions:
    """``options`` with single fields replaced.

    Args:
        options: all choices, or None.
        choices: single ones by name.
        owner: whom they were given to.
        others: what else it takes by name.

    Raises:
        InputError: a name that is no field, or a value it does not take.
    """
    if options is not None and not isinstance(options, WarpOptions):
        raise InputError(
            f"{owner}.options is a {type(options).__name__}, expected WarpOptions: single choices "
            'are named, such as reconstruction="point"'
        )
    unknown = sorted(choices.keys() - OPTION_NAMES)
    if unknown:
        raise InputError(
            f"{owner} has no option {unknown[0]!r}, expected one of "
            + ", ".join([*others, *sorted(OPTION_NAMES)])
        )
    try:
        return _merged(options or DEFAULTS, **choices)
    except TypeError:  # a value without a hash: no option takes one
        return replace(options or DEFAULTS, **choices)


@lru_cache(maxsize=64, typed=True)
def _merged(options: WarpOptions, **choices: Any) -> WarpOptions:
    """The same few choices are made for every frame: they are checked once."""
    return replace(options, **choices)


def prepare_all(
    views: ReferenceView | PreparedView | Iterable[ReferenceView | PreparedView],
    owner: str = "warp",
) -> list[PreparedView]:
    """Views as `warp` takes them, checked and prepared; ``owner`` is whom they were given to.

    Raises:
        ViewError: no view, something else, or colours that differ in type or channels.
    """
    if isinstance(views, ReferenceView | PreparedView):
        views = [views]
    if not isinstance(views, Iterable):
        hint = " (a Frame becomes one with as_view())" if isinstance(views, Frame) else ""
        raise ViewError(
            f"{owner}.views is a {type(views).__name__}, expected a ReferenceView or several{hint}"
        )
    held = list(views)
    if not held:
        raise ViewError(f"{owner}.views is empty, expected at least one reference view")
    for index, view in enumerate(held):
        if not isinstance(view, ReferenceView | PreparedView):
            raise ViewError(
                f"{owner}.views[{index}] is a {type(view).__name__}, expected a ReferenceView "
                "(a Frame becomes one with as_view())"
            )
    prepared = [prepare(view) for view in held]
    kinds = {(one.color.dtype, one.color.shape[2]) for one in prepared}
    if len(kinds) > 1:
        texts = " and ".join(sorted(f"{dtype} x {channels}" for dtype, channels in kinds))
        raise ViewError(
            f"{owner}.views mix colours of type {texts}: convert them to one (uint8 is "
            "sRGB-encoded, float32 is linear radiance; see belvedere.ground.color_to_linear)"
        )
    feature_channels(prepared)
    return prepared


def nearest_order(views: Sequence[PreparedView], desired: CameraModel) -> list[int]:
    """Indices by the distance of the view's center from the desired eye; ties keep the order."""
    if len(views) == 1:
        return [0]
    away = _distances(views, desired)
    return sorted(range(len(views)), key=lambda n: away[n])


def nearness_weights(views: Sequence[PreparedView], desired: CameraModel) -> F4:
    """(n,) blending weights, one over the squared distance to the desired eye, summing to 1."""
    if len(views) == 1:
        return np.ones(1, np.float32)
    away = _distances(views, desired)
    floor = NEARNESS_FLOOR * (sum(away) / len(away)) or 1.0
    weights = [1.0 / (distance * distance + floor * floor) for distance in away]
    total = sum(weights)
    return np.array([weight / total for weight in weights], np.float32)


def _distances(views: Sequence[PreparedView], desired: CameraModel) -> list[float]:
    """From each view's center to the desired eye, metres. Lists: arrays of three are slower."""
    eye = desired.center.tolist()
    return [math.dist(one.camera.center.tolist(), eye) for one in views]


def _passage(
    prepared: PreparedView,
    desired: CameraModel,
    options: WarpOptions,
    threads: int | None,
    correction: Correction = UNCHANGED,
) -> Passage:
    from belvedere.warp import _tiles
    from belvedere.warp.scatter import runs_of

    if not isinstance(desired, Camera) or not isinstance(prepared.camera, Camera):
        return bent_passage(prepared, desired, options, threads)
    reconstructor = RECONSTRUCTORS[options.reconstruction]
    matrix = correction.forward(warp_matrix(prepared.camera, desired))
    height, width = prepared.disparity.shape
    low, high = prepared.tile_low, prepared.tile_high
    cut = occlusion_compatible_sheets
    if reconstructor.joins:
        low, high = prepared.surface_range(threads)
        cut = occlusion_compatible_cell_sheets
    # now, and not in every band, whose threads must not start more
    if reconstructor.together:
        prepared.silhouettes(threads)
    if reconstructor.scatters:
        prepared.carried(threads)
    sheets = np.array(
        [
            (s.u_low, s.u_high, s.u_step, s.v_low, s.v_high, s.v_step)
            for s in (
                (Sheet(0, width, 1, 0, height, 1),)  # it compares disparities
                if reconstructor.together
                else cut(epipole(prepared.camera, desired), width, height)
            )
        ],
        np.int32,
    )
    across, down = low.shape[1] + 2, low.shape[0] + 2  # an axis is cut twice at most
    tiles = np.empty((across * down, _tiles.FIELDS), np.int32)
    count = _tiles.list_tiles(
        sheets,
        low,
        high,
        matrix,
        desired.width,
        desired.height,
        reconstructor.halo(options) + 1,
        tiles,
    )
    looks_back = reconstructor.together or options.reconstruction == "splat"
    back = np.empty((0, 4))
    if looks_back:
        back = correction.backward(warp_matrix(desired, prepared.camera))
    tiles = tiles[:count]
    columns = 0, desired.width
    if reconstructor.together:
        columns = _tiles.landing_columns(tiles, low, high, matrix, desired.width, 1)
    copies: tuple[Copy, ...] = ()
    links = prepared.links(threads) if reconstructor.joins else np.empty((0, 0), np.uint8)
    if reconstructor.together:
        from belvedere.warp import _shrink

        shrink = _shrink.largest_shrink(matrix, tiles, low, high, desired.width, desired.height)
        if shrink > _shrink.BEGIN:
            copies, links = prepared.copies(threads), prepared.wide_links(shrink, threads)
    return Passage(
        matrix,
        tiles,
        options,
        prepared.color if reconstructor.paint is None else prepared.linear(threads),
        prepared.surface(threads) if reconstructor.joins else prepared.disparity,
        links,
        desired.height,
        back.astype(np.float32).ravel(),
        prepared,
        runs_of(tiles) if reconstructor.scatters else tiles[:0],
        gain=correction.gain,
        copies=copies,
        columns=columns,
    )


def _paint_band(
    passages: list[Passage],
    weights: F4,
    rows: tuple[int, int],
    out_color: npt.NDArray[Any],
    out_disparity: F4,
    out_coverage: F4,
) -> None:
    """One band of the desired view: every reference to its layer, then the layers to one."""
    from belvedere.warp import _compose

    options = passages[0].options
    reconstructor = reconstructor_of(passages[0])
    if reconstructor.scatters:
        from belvedere.warp.scatter import paint_scattered

        paint_scattered(passages, weights, rows, out_color, out_disparity, out_coverage)
        return

    size = out_disparity.shape
    if reconstructor.together:
        paint_beyond_seam(passages, weights, rows, out_color, out_disparity, out_coverage)
        return
    colors = scratch("layer colors", (len(passages), *size, 4), np.float32)
    if len(passages) == 1:
        disparities, coverages = out_disparity[None], out_coverage[None]
    else:
        disparities = scratch("layer disparities", (len(passages), *size), np.float32)
        coverages = scratch("layer coverages", (len(passages), *size), np.float32)
    if not reconstructor.paints_all:
        colors.fill(0.0)
        disparities.fill(-1.0)
        coverages.fill(1.0)
    for n, passage in enumerate(passages):
        paint = reconstructor_of(passage).paint
        assert paint is not None
        paint(passage, rows, colors[n], disparities[n], coverages[n])
    if len(passages) == 1:
        linear = colors[0]
    else:
        linear = scratch("joint color", (*size, 4), np.float32)
        layers, joint = (colors, disparities, coverages), (linear, out_disparity, out_coverage)
        if options.merge_ratio is not None:
            _compose.overlay(*layers, options.merge_ratio, *joint)
        else:
            _compose.blend(*layers, weights, options.surface_tolerance, *joint)
    _finish(linear, out_color, out_disparity, out_coverage)


def _finish(linear: F4, out_color: npt.NDArray[Any], out_disparity: F4, out_coverage: F4) -> None:
    """Linear RGBA to the frame's own colours, and holes as frames have them."""
    from belvedere.warp import _compose

    if out_color.dtype == np.uint8:
        _compose.encode(linear, LINEAR_TO_SRGB8, out_color)
    else:
        out_color[:] = linear[..., : out_color.shape[2]]
    _compose.finish(out_disparity, out_coverage)
