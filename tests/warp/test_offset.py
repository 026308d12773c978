"""The offset buffer: visibility in a finer grid, places kept within its cells, one filter."""

from __future__ import annotations

import sys
from typing import Any, Literal

import numpy as np
import pytest

from belvedere.scene import Camera, ReferenceView
from belvedere.warp import OffsetOptions, warp, warp_matrix, warp_points
from belvedere.warp._offset_lattice import covering_need, rows_of_run
from belvedere.warp._offset_word import (
    EMPTY,
    back_word,
    cell_in,
    disparity_in,
    front_word,
    mark,
    place_in,
    word_layout,
)
from belvedere.warp.reconstruct import filter_weights
from tests.oracles.warp import centroid, filter_weight, offset_warp
from tests.warp.worlds import (
    VISIBILITIES,
    boards,
    noise,
    plane_disparity,
    random_camera,
    random_rotation,
    straight_camera,
    view_of,
)

READINGS: tuple[Literal["radial", "separable"], ...] = ("radial", "separable")


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("radius", [0.5, 0.8, 1.0])
@pytest.mark.parametrize(("scale", "bits"), [(2, 2), (2, 0), (4, 1), (2, 4)])
def test_the_filter_table_holds_the_raised_cosine_at_every_place(
    reading: Literal["radial", "separable"], radius: float, scale: int, bits: int
) -> None:
    options = OffsetOptions(buffer_scale=scale, offset_bits=bits, filter=reading, radius=radius)
    table = filter_weights(options)
    count = 2 * scale * 2**bits
    assert table.shape == (count, count)
    place = (np.arange(count) + 0.5) / (scale * 2**bits) - 1.0  # output pixels from the centre
    wanted = [[filter_weight(x, y, reading, radius) for x in place] for y in place]
    np.testing.assert_allclose(table, wanted, atol=1e-6)
    own = np.abs(place) < 0.5
    assert table[np.ix_(own, own)].min() > 0  # the denominator never vanishes
    np.testing.assert_array_equal(table, table.T)
    np.testing.assert_array_equal(table, table[::-1])


def test_the_papers_filter_has_sixteen_weights_a_row_and_ends_at_the_corners() -> None:
    assert filter_weights(OffsetOptions()).shape == (16, 16)
    assert filter_weight(1.0, 1.0, "radial") == 0.0
    assert filter_weight(1.0, 0.0, "radial") == pytest.approx(0.197, abs=1e-3)
    assert filter_weight(1.0, 0.0, "separable") == 0.0
    for reading in READINGS:
        table = filter_weights(OffsetOptions(offset_bits=4, radius=1.0, filter=reading))
        assert 0 < table[0, 0] < 0.002 * table.max()


@pytest.mark.parametrize("seed", range(6))
def test_a_plane_comes_out_as_the_slow_twin_makes_it(seed: int) -> None:
    reading, radius = READINGS[seed % 2], (1.0, 0.8, 0.6)[seed % 3]
    rng = np.random.default_rng(seed)
    reference = straight_camera(13, 10)
    normal = np.array([rng.normal(0, 0.2), 1.0, rng.normal(0, 0.2)])
    delta = plane_disparity(reference, normal, 4.0)
    color = noise(rng, 10, 13, "rgb32")
    desired = random_camera(rng, 15, 12, reach=0.2, turn=0.2)
    wanted, depth, coverage, sure = offset_warp(
        warp_matrix(reference, desired),
        color.astype(float),
        delta,
        (12, 15),
        reading,
        radius,
        density=2,
        bits=4,
    )
    frame = warp(
        ReferenceView(reference, color, delta.astype(np.float32)),
        desired,
        visibility="zbuffer",
        reconstruction="offset",
        offset=OffsetOptions(density=2, offset_bits=4, filter=reading, radius=radius),
    )
    assert (coverage > 0).sum() > 20
    # float32 moves sub-samples that lie on a cell's edge to the next one
    assert np.mean(np.abs(frame.coverage - coverage) < 1e-6) > 0.97
    alike = (frame.coverage > 0) & (coverage > 0)
    assert (sure & alike).sum() > 20
    error = np.abs(frame.color - wanted).max(axis=-1)[alike & sure]
    assert np.mean(error < 1e-3) > 0.9
    np.testing.assert_allclose(frame.disparity[alike], depth[alike], rtol=2e-2)


def covered_where_known(frame: Any, reference: Camera, normal: Any, offset: float) -> int:
    """Assert coverage 1 wherever a desired pixel looks at the reference's picture of a plane."""
    desired = frame.camera
    delta = plane_disparity(desired, normal, offset)
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    cells = np.ones(desired.size, bool)
    for du in (-0.5, 0.5):
        for dv in (-0.5, 0.5):
            slope_u, slope_v = np.gradient(delta, axis=1), np.gradient(delta, axis=0)
            x, y, _ = warp_points(
                warp_matrix(desired, reference),
                u + du,
                v + dv,
                delta + du * slope_u + dv * slope_v,
            )
            width, height = reference.width, reference.height
            cells &= (x > -0.3) & (y > -0.3) & (x < width - 0.7) & (y < height - 0.7)
    assert np.all(frame.coverage[cells] == 1), frame.coverage[cells].min()
    return int(cells.sum())


@pytest.mark.parametrize("visibility", VISIBILITIES)
@pytest.mark.parametrize("growth", [0.7, 1.0, 1.6, 2.5, 3.7, 5.0])
def test_adaptive_density_leaves_no_cell_empty_at_any_turn(growth: float, visibility: Any) -> None:
    rng = np.random.default_rng(int(growth * 10))
    reference = straight_camera(64, 48)
    roll = np.pi / 4
    for turn in (0.0, roll, 0.3, 1.1):
        cos, sin = np.cos(turn), np.sin(turn)
        rotation = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
        place = rng.uniform(-0.02, 0.02, 3) + np.array([0, 4 - 4 / growth, 0])
        desired = Camera(rotation @ reference.matrix, place, 64, 48)
        frame = warp(
            view_of(reference, np.full((48, 64), 0.25)),
            desired,
            reconstruction="offset",
            visibility=visibility,
        )
        assert covered_where_known(frame, reference, (0, 1, 0), 4.0) > 300


def test_adaptive_density_leaves_no_cell_empty_on_slanted_planes() -> None:
    rng = np.random.default_rng(5)
    total = 0
    for _ in range(30):
        reference = straight_camera(64, 48)
        normal = np.array([rng.normal(0, 0.4), 1.0, rng.normal(0, 0.4)])
        delta = plane_disparity(reference, normal, 4.0)
        if delta.min() < 0.02:
            continue
        desired = random_camera(rng, 64, 48, reach=0.7, turn=0.7)
        total += covered_where_known(
            warp(view_of(reference, delta), desired, reconstruction="offset"),
            reference,
            normal,
            4.0,
        )
    assert total > 10_000


@pytest.mark.parametrize("growth", [1.0, 1.3, 1.9, 2.0])
def test_the_papers_density_of_four_suffices_up_to_a_growth_of_two(growth: float) -> None:
    reference = straight_camera(64, 48)
    view = view_of(reference, np.full((48, 64), 0.25))
    four = OffsetOptions(density=4)
    desired = straight_camera(64, 48, (0.0131, 4 - 4 / growth, 0.0171))
    assert (
        covered_where_known(
            warp(view, desired, reconstruction="offset", offset=four), reference, (0, 1, 0), 4
        )
        > 1000
    )
    too_near = straight_camera(64, 48, (0.0131, 4 - 4 / 3.1, 0.0171))
    assert (warp(view, too_near, reconstruction="offset", offset=four).coverage < 1).any()


def dot_shift(shift: float, bits: int) -> float:
    """Columns that a soft dot moves by when the camera moves so that it should by ``shift``."""
    camera = straight_camera(25, 25, focal=25)
    color = np.full((25, 25, 3), 0.5, np.float32)  # nothing is cut off at 0
    color[12, 12] = 1.5
    view = ReferenceView(camera, color, np.full((25, 25), 0.5, np.float32))
    moved = camera.moved((-shift / 25 / 0.5, 0, 0))
    frame = warp(
        view, moved, reconstruction="offset", offset=OffsetOptions(density=4, offset_bits=bits)
    )
    light = np.where(frame.coverage > 0, frame.color[..., 0].astype(float) - 0.5, 0.0)
    return centroid(light)[0] - 12.0


def test_a_dot_follows_the_camera_by_a_sixteenth_of_a_pixel_and_in_steps_without_offsets() -> None:
    shifts = np.arange(17) / 16
    with_offsets = np.array([dot_shift(s, 2) for s in shifts])
    assert np.abs(with_offsets - shifts).max() <= 1 / 16 + 0.02
    without = np.array([dot_shift(s, 0) for s in shifts])
    assert np.abs(without - shifts).max() > 1 / 16 + 0.05
    assert np.abs(without - shifts).mean() > 2 * np.abs(with_offsets - shifts).mean()


def test_offsets_make_a_fine_texture_more_true() -> None:
    rng = np.random.default_rng(9)
    reference = straight_camera(80, 60)

    def wave(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        value = 0.5 + 0.4 * np.sin(1.1 * u + 0.3 * v) * np.cos(0.7 * v)
        return np.stack([value] * 3, -1).astype(np.float32)

    u, v = np.broadcast_arrays(*reference.pixel_grid())
    view = ReferenceView(reference, wave(u, v), np.full((60, 80), 0.25, np.float32))
    errors = {0: 0.0, 2: 0.0, 4: 0.0}
    for _ in range(6):
        place = rng.uniform(-0.1, 0.1, 3)
        desired = Camera(random_rotation(rng, 0.05) @ reference.matrix, place, 80, 60)
        delta = plane_disparity(desired, (0, 1, 0), 4.0)
        x, y, _ = warp_points(warp_matrix(desired, reference), u, v, delta)
        known = (x > 2) & (x < 77) & (y > 2) & (y < 57)
        for bits in errors:
            frame = warp(
                view,
                desired,
                reconstruction="offset",
                offset=OffsetOptions(density=4, offset_bits=bits),
            )
            errors[bits] += float(((frame.color - wave(x, y))[known] ** 2).mean())
    assert errors[2] < 0.97 * errors[0]
    assert errors[4] < 1.02 * errors[2]


def test_disparity_between_samples_is_that_of_the_plane_through_them() -> None:
    reference = straight_camera(64, 48)
    normal, offset = np.array([0.5, 1.0, -0.4]), 4.0
    delta = plane_disparity(reference, normal, offset)
    assert np.abs(np.diff(delta, n=2, axis=0)).max() < 1e-12
    assert np.abs(np.diff(delta, n=2, axis=1)).max() < 1e-12
    desired = straight_camera(64, 48, (0.1, 1.2, -0.1))
    frame = warp(view_of(reference, delta), desired, reconstruction="offset")
    truth = plane_disparity(desired, normal, offset)
    whole = frame.coverage == 1
    whole[:2], whole[-2:], whole[:, :2], whole[:, -2:] = False, False, False, False
    # the filter's mean over a lattice that is not centred, and float32
    np.testing.assert_allclose(frame.disparity[whole], truth[whole], rtol=3e-3)
    assert abs(float(np.mean(frame.disparity[whole] / truth[whole])) - 1) < 2e-4


@pytest.mark.parametrize("visibility", VISIBILITIES)
def test_no_wall_shows_through_a_board_and_no_board_is_printed_on_the_wall(visibility: Any) -> None:
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.2, np.float32)
    disparity[14:34, 20:44] = 0.5
    color = np.where(disparity[..., None] > 0.4, [250, 0, 0], [0, 0, 250]).astype(np.uint8)
    for step in ((0.2, 0, 0), (-0.2, 0.8, 0.1)):
        desired = camera.moved(step)
        frame = warp(
            ReferenceView(camera, color, disparity),
            desired,
            reconstruction="offset",
            visibility=visibility,
        )
        corners = camera.unproject(np.array([19.5, 43.5]), np.array([13.5, 33.5]), 0.5)
        (left, right), (top, bottom), _ = desired.project(corners)
        u, v = np.broadcast_arrays(*desired.pixel_grid())
        inside = (u > left + 1) & (u < right - 1) & (v > top + 1) & (v < bottom - 1)
        outside = (u < left - 1.1) | (u > right + 1.1) | (v < top - 1.1) | (v > bottom + 1.1)
        assert np.all(frame.color[inside] == [250, 0, 0])
        far = outside & (frame.coverage > 0)
        assert np.all(frame.color[far] == [0, 0, 250])
        assert inside.sum() > 200
        assert far.sum() > 200


def test_the_front_filter_takes_out_what_shines_through_a_torn_surface() -> None:
    """A lattice of two sub-samples a pixel tears a board that grows by a third."""
    camera = straight_camera(64, 48)
    disparity = np.full((48, 64), 0.1, np.float32)
    disparity[14:34, 20:44] = 0.5
    color = np.where(disparity[..., None] > 0.4, [250, 0, 0], [0, 0, 250]).astype(np.uint8)
    desired = camera.moved((0.3, 0.5, 0.02))
    torn, mended = (
        warp(
            ReferenceView(camera, color, disparity),
            desired,
            reconstruction="offset",
            offset=OffsetOptions(density=2, front_filter=front_filter),
        )
        for front_filter in (False, True)
    )
    corners = camera.unproject(np.array([19.5, 43.5]), np.array([13.5, 33.5]), 0.5)
    (left, right), (top, bottom), _ = desired.project(corners)
    u, v = np.broadcast_arrays(*desired.pixel_grid())
    inside = (u > left + 1.5) & (u < right - 1.5) & (v > top + 1.5) & (v < bottom - 1.5)
    far = (u > right + 2) | (v > bottom + 2)
    assert np.any(torn.color[inside] != [250, 0, 0])
    assert np.all(mended.color[inside] == [250, 0, 0])
    np.testing.assert_array_equal(torn.color[far], mended.color[far])


@pytest.mark.parametrize("front_filter", [False, True])
@pytest.mark.parametrize("density", ["adaptive", 2])
def test_no_row_shows_where_bands_meet(
    density: Any, front_filter: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(12)
    disparity, _ = boards(rng, 60, 80)
    camera = straight_camera(80, 60)
    view = ReferenceView(camera, noise(rng, 60, 80), disparity)
    desired = Camera(random_rotation(rng, 0.3) @ camera.matrix, np.array([0.3, 0.7, -0.2]), 80, 60)
    options = OffsetOptions(density=density, front_filter=front_filter)
    whole = warp(view, desired, reconstruction="offset", offset=options, threads=1)
    for count in (2, 7, 60):
        monkeypatch.setattr(
            sys.modules["belvedere.warp.warp"], "band_count", lambda *_, count=count: count
        )
        cut = warp(view, desired, reconstruction="offset", offset=options, threads=1)
        assert cut.color.tobytes() == whole.color.tobytes()
        assert cut.disparity.tobytes() == whole.disparity.tobytes()
        assert cut.coverage.tobytes() == whole.coverage.tobytes()


def test_words_keep_what_is_put_in() -> None:
    rng = np.random.default_rng(13)
    for bits, height, width, tolerance in (
        (2, 512, 512, 0.03), (0, 7, 9000, 0.5), (4, 4096, 4096, 0.03), (3, 100, 60, 0.0)
    ):  # fmt: skip
        layout = word_layout(bits, tolerance, height, width)
        for _ in range(50):
            delta = np.float32(rng.choice([0.0, rng.uniform(0, 2), 1e30 * rng.uniform()]))
            fine_u, fine_v = (np.uint32(n) for n in rng.integers(0, 1 << 16, 2))
            v, u = (int(rng.integers(-1, side)) for side in (height, width))
            step_v, step_u = (int(n) for n in rng.integers(0, 64, 2))
            front = front_word(delta, mark(fine_u, fine_v, layout), layout)
            word = np.uint64(
                int(front) << layout.low | int(back_word(v, u, step_v, step_u, layout))
            )
            assert word > EMPTY
            assert [int(n) for n in cell_in(word, layout)] == [v, u, step_v, step_u]
            precision = 2.0 ** -(layout.kept - 8)
            assert disparity_in(word, layout) == pytest.approx(delta, rel=precision, abs=0)
            place = (int(fine_v) % 2**bits << bits) | int(fine_u) % 2**bits
            odd = ((int(fine_u) >> bits) + (int(fine_v) >> bits)) % 2
            assert place_in(word, layout) == (4**bits - 1 - place if odd else place)


def test_a_cell_prefers_the_nearer_surface_then_the_place_nearer_its_middle() -> None:
    layout = word_layout(2, 0.03, 64, 64)

    def front(delta: float, qu: int, qv: int) -> int:
        return int(
            front_word(np.float32(delta), mark(np.uint32(qu), np.uint32(qv), layout), layout)
        )

    assert front(0.52, 0, 0) > front(0.5, 1, 1)  # over three per cent nearer
    assert front(0.5001, 0, 0) < front(0.5, 1, 1)  # one surface
    for near, far in (((1, 2), (1, 3)), ((2, 2), (0, 1)), ((0, 2), (3, 0))):
        assert front(0.5, *near) > front(0.5, *far)


def test_float_colours_stay_above_nothing() -> None:
    """Cubics undershoot beside bright specks; light is never negative."""
    camera = straight_camera(25, 25, focal=25)
    color = np.zeros((25, 25, 3), np.float32)
    color[5::6, 5::6] = 40.0
    view = ReferenceView(camera, color, np.full((25, 25), 0.5, np.float32))
    frame = warp(view, camera.moved((0.013, 0.02, 0.007)), reconstruction="offset")
    assert frame.color.min() == 0.0
    assert frame.color.max() > 10.0


def test_rows_of_sub_samples_are_never_more_than_a_step_apart() -> None:
    rng = np.random.default_rng(14)
    for _ in range(200):
        ahead, before, counted, area = np.float32(0.5), 0.5, 0, 0.0
        for run in range(32):
            asked = np.float32(rng.uniform(1, 5))
            need, after = rows_of_run(ahead, asked, run == 31)
            assert need >= asked
            rows = np.arange(float(ahead), float(need) - 1e-5)
            counted, area = counted + len(rows), area + float(asked)
            for row in rows:  # in steps, each run stretched to its own
                assert before + row <= 1 + 1e-4
                before = -row
            before += float(need)
            ahead = after
        assert before <= 0.5 + 1e-4  # the next tile begins half a step on
        assert counted <= area + 1.1  # and none is wasted


def test_a_cell_of_like_size_needs_what_the_buffer_is_finer_and_a_turned_one_more() -> None:
    two, zero, most = np.float32(2), np.float32(0), np.float32(32)
    assert covering_need(two, zero, zero, two, most) == (2, 2)
    half = np.float32(np.sqrt(2))  # turned by 45 degrees
    assert covering_need(half, half, half, half, most) == pytest.approx((2.828427, 2.828427))
    assert covering_need(zero, zero, zero, zero, most) == (1, 1)
    assert covering_need(two * 50, zero, zero, two, most)[0] == 32
