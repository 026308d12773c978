"""The warp as a whole: what must hold whatever the reconstructor."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from types import FrameType
from typing import Any

import numpy as np
import pytest

from belvedere.ground.errors import CameraError, InputError, ViewError
from belvedere.scene import Camera, CylinderCamera, Frame, OrthographicCamera, ReferenceView
from belvedere.warp import (
    RECONSTRUCTIONS,
    GaussianOptions,
    OffsetOptions,
    PreparedView,
    SplatOptions,
    WarpOptions,
    prepare,
    warp,
)
from belvedere.warp.warp import BANDS_PER_THREAD, band_count, merge_options
from tests.warp.worlds import (
    VISIBILITIES,
    boards,
    noise,
    plane_disparity,
    random_camera,
    random_rotation,
    same,
    straight_camera,
    view_of,
)

KINDS = ("rgb8", "rgba8", "rgb32", "rgba32")


# ---- identity ----------------------------------------------------------------------------------


@pytest.mark.parametrize("visibility", VISIBILITIES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("reconstruction", ["point", "splat", "gaussian", "mesh", "offset"])
def test_a_view_warped_to_its_own_camera_is_the_identical_view(
    reconstruction: Any, kind: str, visibility: Any
) -> None:
    rng = np.random.default_rng(0)
    for n in range(4):
        disparity, _ = boards(rng, 61, 97)
        disparity[rng.random(disparity.shape) < 0.05] = np.nan
        camera = random_camera(rng, 97, 61, reach=3, turn=3)
        color = noise(rng, 61, 97, kind)
        color[rng.random((61, 97)) < 0.05] = 0  # what exact zeros blend with shows
        view = ReferenceView(camera, color, disparity)
        # bridged gaps are coloured too, so mesh is told to show samples alone
        frame = warp(prepare(view, bridge=0), camera, reconstruction=reconstruction,
                     visibility=visibility, threads=n + 1)  # fmt: skip
        known = ~np.isnan(disparity)
        np.testing.assert_array_equal(frame.coverage, known.astype(np.float32))
        np.testing.assert_array_equal(frame.color[known], color[known])
        assert not frame.color[~known].any()
        np.testing.assert_array_equal(frame.disparity, disparity)


def test_the_identity_of_mesh_holds_for_slanted_surfaces_with_bridged_gaps() -> None:
    rng = np.random.default_rng(1)
    camera = straight_camera(60, 50)
    disparity = plane_disparity(camera, (0.3, 1, 0.2), 3.0).astype(np.float32)
    disparity[20, 10:30] = np.nan
    view = ReferenceView(camera, noise(rng, 50, 60), disparity)
    part = camera.cropped(0, 0, 59, 50)  # the same pixels, but not the same picture
    frame = warp(view, part, reconstruction="mesh")
    known = ~np.isnan(disparity[:, :59])
    assert frame.coverage.all()
    np.testing.assert_array_equal(frame.color[known], view.color[:, :59][known])
    np.testing.assert_array_equal(frame.disparity[known], disparity[:, :59][known])


@pytest.mark.parametrize("filter_name", ["radial", "separable"])
@pytest.mark.parametrize("density", ["adaptive", 4, 6])
def test_offset_leaves_constants_and_ramps_as_they_are(density: Any, filter_name: Any) -> None:
    camera = straight_camera(60, 50)
    u, v = np.broadcast_arrays(*camera.pixel_grid())
    color = np.stack([0.01 * u, 0.02 * v, np.full(camera.size, 0.7)], -1).astype(np.float32)
    view = ReferenceView(camera, color, np.full((50, 60), 0.4, np.float32))
    options = OffsetOptions(density=density, filter=filter_name)
    part = camera.cropped(0, 0, 59, 50)  # the same pixels, but not the same picture
    frame = warp(view, part, offset=options)
    assert np.all(frame.coverage == 1)
    inside = np.s_[2:-2, 2:-2]
    np.testing.assert_allclose(frame.color[..., 2], 0.7, rtol=1e-5)
    # one sub-sample a cell is kept, so the lattice is not centred on the pixel: under a twentieth
    # of a pixel's step
    np.testing.assert_allclose(frame.color[..., 0][inside], color[:, :59, 0][inside], atol=0.01 / 8)
    np.testing.assert_allclose(frame.color[..., 1][inside], color[:, :59, 1][inside], atol=0.02 / 8)
    np.testing.assert_allclose(frame.disparity, 0.4, rtol=1e-5)


def test_offset_covers_wholly_what_has_samples_and_nothing_else() -> None:
    rng = np.random.default_rng(2)
    disparity, _ = boards(rng, 61, 97)
    disparity[20:30, 40:55] = np.nan
    disparity[5, 5] = np.nan
    camera = straight_camera(97, 61)
    part = camera.cropped(0, 0, 96, 61)  # the same pixels, but not the same picture
    frame = warp(prepare(view_of(camera, disparity), bridge=0), part, reconstruction="offset")
    known = ~np.isnan(disparity[:, :96])
    np.testing.assert_array_equal(frame.coverage, known.astype(np.float32))
    bridged = warp(view_of(camera, disparity), part, reconstruction="offset")
    assert bridged.coverage[5, 5] == 1
    assert np.all(bridged.coverage[22:28, 42:53] == 0)


# ---- threads -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("reconstruction", "visibility", "composite"), list(
    product(RECONSTRUCTIONS, VISIBILITIES, ("blend", "nearest", "fuzzy"))))  # fmt: skip
def test_the_number_of_threads_does_not_change_a_byte(
    reconstruction: Any, visibility: Any, composite: Any
) -> None:
    rng = np.random.default_rng(7)
    for n in range(5):
        views = []
        for _ in range((1, 2, 3, 2, 2)[n]):
            disparity, _ = boards(rng, 61, 97)
            disparity *= np.linspace(1, 2, 97, dtype=np.float32)
            disparity[rng.random(disparity.shape) < 0.03] = np.nan
            camera = random_camera(rng, 97, 61, reach=0.2)
            views.append(ReferenceView(camera, noise(rng, 61, 97, KINDS[n % 4]), disparity))
        size = ((97, 61), (61, 97), (33, 131), (130, 7), (5, 3))[n]
        desired = random_camera(rng, *size, reach=0.5, turn=0.4)
        options = WarpOptions(
            reconstruction=reconstruction,
            visibility=visibility,
            composite=composite,
            fill="background" if n == 4 else "none",
        )
        one = warp(views, desired, threads=1, options=options)
        for threads in (2, 3, 4):
            many = warp(views, desired, threads=threads, options=options)
            assert same(one, many), (n, threads)
    assert BANDS_PER_THREAD * 4 > 7  # some of those pictures have fewer rows than bands


@pytest.mark.slow
@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_large_pictures_do_not_depend_on_the_threads_either(reconstruction: Any) -> None:
    """Places are rounded where a power of two is crossed: only tall pictures show that."""
    rng = np.random.default_rng(8)
    for n in range(6):
        camera = straight_camera(300, 530)
        disparity, _ = boards(rng, 530, 300, 8)
        view = ReferenceView(camera, noise(rng, 530, 300), disparity)
        place = rng.normal(0, 0.1, 3)
        desired = Camera(random_rotation(rng, 0.05) @ camera.matrix, place, 300, 530)
        choices: dict[str, Any] = {
            "reconstruction": reconstruction,
            "visibility": VISIBILITIES[n % 2],
        }
        one = warp(view, desired, threads=1, **choices)
        for threads in (2, 4):
            assert same(one, warp(view, desired, threads=threads, **choices))


# ---- saying no ---------------------------------------------------------------------------------

VIEW = view_of(straight_camera(8, 6), np.ones((6, 8)))
HOME = straight_camera(8, 6)


@pytest.mark.parametrize(
    ("views", "camera", "choices", "error", "text"),
    [
        ([], HOME, {}, ViewError, "warp.views is empty, expected at least one reference view"),
        (None, HOME, {}, ViewError, "warp.views is a NoneType, expected a ReferenceView or"),
        (7, HOME, {}, ViewError, "warp.views is a int, expected a ReferenceView or several"),
        ([VIEW, "x"], HOME, {}, ViewError, "warp.views[1] is a str, expected a ReferenceView"),
        (
            VIEW,
            None,
            {},
            CameraError,
            "the desired camera is a NoneType, expected a camera",
        ),
        (
            VIEW,
            OrthographicCamera(np.eye(4), [0.1, 0.1], 8, 6),
            {},
            CameraError,
            "the desired view has a OrthographicCamera, but warping goes between cameras whose",
        ),
        (
            VIEW,
            CylinderCamera([0, 0, 0], 8, 6),
            {"reconstruction": "mesh"},
            InputError,
            'warp.reconstruction "mesh" goes between planar cameras only: with a cylinder or a '
            'sphere among the cameras choose "point" or "splat" or "inverse"',
        ),
        (VIEW, HOME, {"threads": 0}, InputError, "threads is 0, expected a whole number from 1 to"),
        (VIEW, HOME, {"threads": 1.5}, InputError, "threads is 1.5, expected a whole number"),
        (VIEW, HOME, {"quality": 3}, InputError, "warp has no option 'quality', expected one of"),
        (VIEW, HOME, {"options": "point"}, InputError, "warp.options is a str, expected WarpOpt"),
        (VIEW, HOME, {"reconstruction": "spline"}, InputError, "reconstruction is 'spline', exp"),
        (VIEW, HOME, {"visibility": "depth"}, InputError, "visibility is 'depth', expected one"),
        (VIEW, HOME, {"composite": None}, InputError, "composite is None, expected one of 'blend"),
        (VIEW, HOME, {"fill": True}, InputError, "fill is True, expected one of 'none', 'back"),
        (VIEW, HOME, {"surface_tolerance": -1}, InputError, "surface_tolerance is -1, expected"),
        (VIEW, HOME, {"splat": 3}, InputError, "splat is a int, expected SplatOptions(...)"),
        (VIEW, HOME, {"gaussian": 1}, InputError, "gaussian is a int, expected GaussianOptions("),
        (VIEW, HOME, {"offset": {}}, InputError, "offset is a dict, expected OffsetOptions(...)"),
    ],
)
def test_a_bad_call_is_refused_before_the_work(
    views: Any, camera: Any, choices: dict[str, Any], error: type[Exception], text: str
) -> None:
    with pytest.raises(error) as refusal:
        warp(views, camera, **choices)
    assert text in str(refusal.value)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: SplatOptions(size=2), "SplatOptions.size is 2, expected an odd number"),
        (lambda: SplatOptions(size=17), "SplatOptions.size is 17, expected a whole number from 1"),
        (lambda: SplatOptions(largest=4), "SplatOptions.largest is 4, expected an odd number"),
        (lambda: GaussianOptions(sigma=0.3), "GaussianOptions.sigma is 0.3, expected a finite num"),
        (lambda: GaussianOptions(cut=1), "GaussianOptions.cut is 1, expected a finite number from"),
        (lambda: GaussianOptions(low_pass=0), "GaussianOptions.low_pass is 0, expected a finite"),
        (lambda: OffsetOptions(density=3), "OffsetOptions.density is 3, expected an even number"),
        (lambda: OffsetOptions(density=18), "density is 18, expected a whole number from 2 to 16"),
        (lambda: OffsetOptions(buffer_scale=1), "buffer_scale is 1, expected a whole number from"),
        (lambda: OffsetOptions(offset_bits=5), "offset_bits is 5, expected a whole number from 0"),
        (lambda: OffsetOptions(radius=0.4), "radius is 0.4, expected a finite number from 0.5 up"),
        (lambda: OffsetOptions(largest=1), "largest is 1, expected a whole number from 2 to 128"),
        (lambda: OffsetOptions(front_filter=1), "front_filter is 1, expected True or False"),  # type: ignore[arg-type]
        (lambda: OffsetOptions(filter="box"), "filter is 'box', expected one of 'radial', 'sepa"),  # type: ignore[arg-type]
        (lambda: prepare(None), "prepare.view is a NoneType, expected a ReferenceView"),  # type: ignore[arg-type]
        (lambda: prepare(VIEW, edge_tolerance=2), "prepare.edge_tolerance is 2, expected a fin"),
        (lambda: prepare(VIEW, bridge=-1), "prepare.bridge is -1, expected a whole number from 0"),
    ],
)
def test_bad_options_are_refused_by_name(make: Any, text: str) -> None:
    with pytest.raises(InputError) as refusal:
        make()
    assert text in str(refusal.value)


@pytest.mark.parametrize("choices", [
    {"reconstruction": "point"}, {"reconstruction": "splat", "splat": SplatOptions(size=3)},
    {"reconstruction": "splat"}])  # fmt: skip
def test_points_and_splats_take_less_than_64_bytes_a_pixel(choices: dict[str, Any]) -> None:
    from belvedere.studio._bench_memory import peak_megabytes

    rng = np.random.default_rng(9)
    camera = straight_camera(512, 512)
    views = [
        prepare(view_of(camera.moved((0.1 * n, 0, 0)), boards(rng, 512, 512)[0],
                        noise(rng, 512, 512)))
        for n in range(4)
    ]  # fmt: skip

    def run() -> Frame:
        return warp(views, camera, threads=2, **choices)

    run()
    assert peak_megabytes(run) * 1e6 < 64 * 512 * 512


def test_a_frame_is_not_a_view_until_it_is_made_one() -> None:
    frame = warp(VIEW, HOME)
    for views in (frame, [frame]):
        with pytest.raises(ViewError, match=r"a Frame becomes one with as_view\(\)"):
            warp(views, HOME)  # type: ignore[arg-type]
    with pytest.raises(ViewError, match=r"prepare.view is a Frame.*as_view\(\)"):
        prepare(frame)  # type: ignore[arg-type]
    assert warp(frame.as_view(), HOME, reconstruction="point").coverage.all()


def test_single_choices_override_options() -> None:
    options = WarpOptions(reconstruction="point", fill="background")
    frame = warp(VIEW, HOME, options=options, fill="none")
    assert frame.filled is None
    np.testing.assert_array_equal(frame.color, VIEW.color)


def test_an_option_is_refused_even_if_its_like_was_taken_before() -> None:
    """1 equals True, and what was checked is remembered."""
    for good, bad in ((True, 1), (False, 0)):
        assert merge_options(None, {"explain": good}).explain is good
        with pytest.raises(InputError, match=rf"WarpOptions.explain is {bad}, expected"):
            merge_options(None, {"explain": bad})
    with pytest.raises(InputError, match=r"WarpOptions.splat is a dict"):
        merge_options(None, {"splat": {"size": 3}})


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("width", [1, 2, 3, 4, 5, 7, 8, 33])
def test_pictures_of_any_width_keep_every_byte(width: int, channels: int) -> None:
    """Bytes are packed several pixels at a time."""
    rng = np.random.default_rng(width)
    camera = straight_camera(width + 3, 6)
    color = rng.integers(0, 256, (6, width + 3, channels), dtype=np.uint8)
    view = ReferenceView(camera, color, np.full((6, width + 3), 0.5, np.float32))
    part = camera.cropped(2, 1, width, 4)
    for given in (view, [view, view]):
        frame = warp(given, part, reconstruction="point", threads=1)
        np.testing.assert_array_equal(frame.color, color[1:5, 2 : 2 + width])


@pytest.mark.parametrize("threads", [1, 2, 3, 4])
@pytest.mark.parametrize("pixels", [1, 900, 65_536, 262_144, 327_680, 1 << 24])
def test_bands_are_neither_too_large_nor_shared_out_unevenly(pixels: int, threads: int) -> None:
    count = band_count(pixels, threads, 2, 1 << 14, 1 << 16)
    assert count >= 1
    assert pixels / count <= 1 << 16
    assert count == 1 or pixels / count >= 1 << 13 or count <= 2 * threads
    if pixels >= threads << 16:
        assert count % threads == 0


# ---- warps beside and inside one another ---------------------------------------------------------


def random_job(seed: int) -> tuple[list[ReferenceView], Camera]:
    """Two noisy views of boards, and a camera of always the same size."""
    rng = np.random.default_rng(seed)
    views = [
        ReferenceView(random_camera(rng, 80, 60), noise(rng, 60, 80), boards(rng, 60, 80)[0])
        for _ in range(2)
    ]
    return views, random_camera(rng, 72, 64)


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_a_warp_that_interrupts_another_in_its_thread_changes_nothing(reconstruction: Any) -> None:
    """As a signal handler's, a finaliser's or a profiler's would, wherever a step of it ends."""
    (views, camera), other = random_job(7), random_job(8)
    options = WarpOptions(reconstruction=reconstruction, explain=True)
    alone = warp(views, camera, threads=1, options=options)
    interrupted: set[str] = set()

    def interrupt(frame: FrameType, event: str, value: Any) -> None:
        del value
        if event == "return" and "/belvedere/warp/" in frame.f_code.co_filename:
            interrupted.add(frame.f_code.co_name)
            warp(*other, threads=1, options=options)  # the profiler does not call itself

    sys.setprofile(interrupt)
    try:
        disturbed = warp([prepare(view) for view in views], camera, threads=1, options=options)
    finally:
        sys.setprofile(None)
    assert {"_paint_band", "work"} < interrupted
    assert same(alone, disturbed)
    assert alone.explanation is not None
    assert disturbed.explanation is not None
    for name in ("source", "seen_by", "hole", "error"):
        np.testing.assert_array_equal(
            getattr(alone.explanation, name), getattr(disturbed.explanation, name)
        )


@pytest.mark.parametrize("reconstruction", RECONSTRUCTIONS)
def test_warps_in_several_threads_at_once_do_not_disturb_one_another(reconstruction: Any) -> None:
    jobs = [random_job(n) for n in range(6)]
    alone = [warp(*job, threads=1, reconstruction=reconstruction) for job in jobs]
    with ThreadPoolExecutor(3) as pool:
        together = pool.map(
            lambda job: warp(*job, threads=2, reconstruction=reconstruction), 4 * jobs
        )
        assert all(same(a, b) for a, b in zip(4 * alone, together, strict=True))


@pytest.mark.parametrize(("threads", "together"), [(1, 0), (2, 4), (3, 3), (4, 4), (6, 0)])
def test_as_many_references_are_prepared_at_once_as_there_are_threads(
    threads: int, together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    (first, camera), (second, _), (third, _) = random_job(1), random_job(2), random_job(3)
    views = [*first, *second, third[0]]
    ready = [prepare(view) for view in views]
    for one in ready:
        one.find_surface(True, 2)
    asked: list[int] = []
    find = PreparedView.find_surface

    def counted(self: PreparedView, silhouettes: bool, threads: int) -> None:
        asked.append(id(self))
        assert threads == 1  # which starts none of its own
        find(self, silhouettes, threads)

    monkeypatch.setattr(PreparedView, "find_surface", counted)
    assert same(warp(views, camera, threads=threads), warp(ready, camera, threads=threads))
    assert len(set(asked)) == len(asked) == together
