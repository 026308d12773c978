"""References that disagree, in place or exposure, are brought to their mean; others are left."""

from __future__ import annotations

import gc
import math
import pickle
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import belvedere as bv
from belvedere.ground.color import color_to_linear, color_to_srgb8
from belvedere.ground.errors import InputError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio.metrics import psnr
from belvedere.warp import PreparedView, Warper, prepare, warp, warp_matrix
from belvedere.warp.disagreement import _shifts_are_believed, measure
from belvedere.warp.reconcile import UNCHANGED, Correction, corrections
from tests.oracles.reconcile import blocks, differences
from tests.warp.worlds import FORWARD_Y, noise, plane_disparity, same, straight_camera, view_of

F8 = np.typing.NDArray[np.float64]

SIZE = 240, 180
NORMAL, OFFSET = (0.3, 1.0, 0.25), 3.0
"""A slanted wall: its disparity changes over the picture by a factor of two."""
HERE, ASIDE = (0.0, 0.0, 0.0), (0.25, 0.1, -0.05)


def at(
    center: Any, turn_px: Any = (0, 0), roll: float = 0.0, size: tuple[int, int] = SIZE
) -> Camera:
    """Looks along +y; turned by so many pixels to the right and down, and about its axis."""
    camera = straight_camera(size[0], size[1], center)
    focal = size[0]
    a, b = turn_px[0] / focal, turn_px[1] / focal
    yaw = [[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]]
    pitch = [[1, 0, 0], [0, math.cos(b), math.sin(b)], [0, -math.sin(b), math.cos(b)]]
    spin = [[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]]
    turn = FORWARD_Y @ np.array(yaw) @ np.array(pitch) @ np.array(spin) @ FORWARD_Y.T
    return Camera(turn @ camera.matrix, camera.center, *size)


def wall(camera: Camera) -> Any:
    """(H, W, 3) linear radiance of the wall: waves 10 to 40 pixels long, four samples a pixel."""
    total = np.zeros((camera.height, camera.width, 3))
    u, v = camera.pixel_grid()
    for du, dv in ((-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)):
        rays = camera.rays(u + du, v + dv)
        depth = (OFFSET - np.dot(NORMAL, camera.center)) / (rays @ NORMAL)
        x, _, z = np.moveaxis(camera.center + rays * depth[..., None], -1, 0)
        for k, (a, b) in enumerate(((9.0, 4.0), (-6.0, 11.0), (17.0, -8.0), (5.0, 23.0))):
            wave = np.sin(a * x + b * z + k)
            total += (wave * (1.0 + 0.2 * k))[..., None] * np.array([1.0, 0.8, 0.6])
    return (0.35 + 0.07 * total / 4).astype(np.float32)


def photograph(true: Camera, said: Camera | None = None, exposure: float = 1.0) -> ReferenceView:
    """The wall from the true camera, though another may be said to have taken it."""
    disparity = plane_disparity(true, NORMAL, OFFSET).astype(np.float32)
    return ReferenceView(said or true, color_to_srgb8(wall(true) * exposure), disparity)


def ready(view: ReferenceView) -> PreparedView:
    held = prepare(view)
    held.brightness()
    return held


def planar(view: ReferenceView) -> Camera:
    assert isinstance(view.camera, Camera)
    return view.camera


def astray(exposure: float = 1.0) -> tuple[ReferenceView, ReferenceView, Camera]:
    """A reference that is right, and one turned by 2 px and rolled by 1/100 without saying so."""
    true = at(ASIDE, (1.6, -1.2), 0.01)
    return photograph(at(HERE)), photograph(true, at(ASIDE), exposure), true


# ---- measuring -----------------------------------------------------------------------------------


def test_a_turn_that_the_pose_does_not_know_is_found_to_a_tenth_of_a_pixel() -> None:
    first, second, true = astray()
    found = measure([(ready(first), ready(second))])[0][0].shift
    u, v = second.camera.pixel_grid()
    disparity = plane_disparity(planar(second), NORMAL, OFFSET)
    points = second.camera.center + second.camera.rays(u, v) / disparity[..., None]
    x, y, _ = true.project(points)
    planted = np.stack([x - u, y - v])
    base = np.stack(np.broadcast_arrays(u, v, 1.0, disparity))
    r, s, t = np.tensordot(found + np.eye(3, 4), base, 1)
    apart = np.stack([r / t - u, s / t - v]) - planted
    assert np.hypot(*planted).mean() > 2
    assert np.hypot(*apart).max() < 0.15  # measured 0.09
    assert np.hypot(*apart).mean() < 0.05


@pytest.mark.parametrize("exposure", [0.6, 0.8, 1.5])
def test_how_much_brighter_the_other_is_is_found_to_two_hundredths(exposure: float) -> None:
    first, second, _ = astray(exposure)
    found, back = measure([(ready(first), ready(second))])[0]
    assert back.exposure == -found.exposure
    assert math.exp(found.exposure) == pytest.approx(exposure, rel=0.02)
    assert np.hypot(*found.shift[:2, 2]) > 1


def test_exact_pictures_agree() -> None:
    for size in (SIZE, (512, 360), (97, 64)):
        first, second = photograph(at(HERE, size=size)), photograph(at(ASIDE, size=size))
        assert all(found.is_none for found in measure([(ready(first), ready(second))])[0])


def test_pictures_of_different_things_are_said_to_agree() -> None:
    """Nothing is concluded from noise, one colour, no sample in common, or no sample at all."""
    rng = np.random.default_rng(4)
    exact = photograph(at(HERE))
    strange = [
        replace(exact, color=noise(rng, SIZE[1], SIZE[0])),
        replace(exact, color=np.full((SIZE[1], SIZE[0], 3), 30, np.uint8)),
        replace(exact, color=np.zeros((SIZE[1], SIZE[0], 3), np.uint8)),
        replace(exact, disparity=exact.disparity * 2),
        replace(exact, disparity=np.full_like(exact.disparity, np.nan)),
        replace(exact, disparity=np.zeros_like(exact.disparity)),
        replace(exact, camera=at((0, 100, 0))),
    ]
    for other in strange:
        for pair in ((exact, other), (other, exact), (other, other)):
            assert all(found.is_none for found in measure([(ready(pair[0]), ready(pair[1]))])[0])


@dataclass
class Measured:
    """What a comparison came to."""

    shift_px: float = 1.0
    saved: float = 0.1
    reach_px: float = 2.0


@pytest.mark.parametrize("doubt", [{"shift_px": 0.1}, {"saved": 0.01}, {"reach_px": 40.0}])
def test_a_shift_is_believed_if_it_is_large_useful_and_not_absurd(
    doubt: dict[str, Any],
) -> None:
    def believed(*both: Measured) -> bool:
        return _shifts_are_believed(both)  # type: ignore[arg-type]

    assert believed(Measured(), Measured())
    assert not believed(Measured(**doubt), Measured(**doubt))
    one_sided = believed(Measured(), Measured(**doubt))
    assert one_sided == (doubt.keys() <= {"shift_px", "saved"})  # those two are averaged


def test_the_kernel_adds_up_what_a_slow_twin_does() -> None:
    from belvedere.warp import _compare

    first, second, _ = astray(0.8)
    own, other = prepare(first), prepare(second)
    size = 4
    images = [
        blocks(np.sqrt(blocks(color_to_linear(one.color).mean(axis=-1), 2)), 2)
        for one in (first, second)
    ]
    matrix = warp_matrix(planar(first), planar(second))
    frame = np.array([119.5, 89.5, 1 / 120, 3.0])
    guess = np.array([0.7, -0.4, 0.3, 0.2, -0.5, 0.1, 0.6, -0.3, 0.2, -0.4, 0.9, 0.02])

    def twin(given: F8) -> tuple[F8, F8, F8]:
        return differences(matrix, images[0], first.disparity, images[1], size, frame, given)

    for ours, theirs in zip((own, other), images, strict=True):
        found_ours = ours.brightness()[size]
        whole = ~np.isnan(found_ours)  # no edges here, but the picture's own
        assert whole.mean() > 0.9
        np.testing.assert_allclose(found_ours[whole], theirs[whole], atol=2e-3)
    system, sums = np.zeros((12, 16)), np.zeros(_compare.SUMS)
    texture = np.zeros((_compare.PATCHES**2, 2))
    links = np.full(own.disparity.shape, 31, np.uint8)  # all bits: smooth everywhere
    _compare.compare(
        matrix.astype(np.float32).ravel(), images[0].astype(np.float32), own.disparity,
        images[1].astype(np.float32), other.disparity, links, size, 1, 0.5,
        frame.astype(np.float32), guess.astype(np.float32), np.float32(0.05), system, sums,
        texture,
    )  # fmt: skip
    apart, found, shift = twin(guess)
    damped = 1 / (1 + (apart / 0.05) ** 2)
    assert texture[:, 0].sum() == apart.size
    assert texture[:, 0].min() > 0
    assert sums[_compare.COUNT] == apart.size > 1000
    assert sums[_compare.APART] == pytest.approx(abs(apart).sum(), rel=1e-4)
    assert sums[_compare.COST] == pytest.approx((damped * apart**2).sum(), rel=1e-4)
    assert sums[_compare.SHIFTED] == pytest.approx((shift**2).sum() / 2, rel=1e-4)
    assert sums[_compare.FOUND] == pytest.approx((damped**2 * found).sum(), rel=1e-4)
    # each row of the linear system: how the difference falls when an unknown grows
    slopes = []
    for k, step in enumerate(np.eye(12) * 1e-6):
        ahead, behind = twin(guess + step)[0], twin(guess - step)[0]
        assert ahead.size == behind.size == apart.size, k
        slopes.append((behind - ahead) / 2e-6)
    rows = np.stack([*slopes, apart])
    expected = (rows[:12] * damped**2) @ rows.T
    assert abs(system[:, :13] - expected).max() < 2e-3 * abs(expected).max()
    assert not system[:, 13:].any()


def test_one_mark_on_a_plain_wall_does_not_move_the_wall() -> None:
    """A few edges hold a shift from one side only, and who blurs or samples them errs there."""
    views = []
    for shift in (0, 3):
        camera = at(HERE)
        color = np.full((*camera.size, 3), 120, np.uint8)
        color[80:100, 100 + shift : 130 + shift] = 220
        views.append(prepare(view_of(camera, plane_disparity(camera, NORMAL, OFFSET), color)))
    assert corrections(views, None, 1) == [UNCHANGED, UNCHANGED]


def test_who_sees_nothing_in_common_has_no_say() -> None:
    first, second, _ = astray(0.64)
    away = at((0.0, -5.0, 0.0))
    color = noise(np.random.default_rng(3), *away.size)
    alone = view_of(away, np.full(away.size, 0.3, np.float32), color)
    two = corrections([prepare(first), prepare(second)], None, 1)
    three = corrections([prepare(first), prepare(second), prepare(alone)], None, 1)
    for one, other in zip(two, three, strict=False):
        np.testing.assert_array_equal(one.place, other.place)
        assert one.gain == other.gain
    assert three[2] is UNCHANGED


def test_a_prepared_view_travels_without_what_it_was_compared_with() -> None:
    first, second, _ = astray(0.64)
    views = [prepare(first), prepare(second)]
    corrections(views, None, 1)
    copy = pickle.loads(pickle.dumps(views[0]))
    assert not copy.compared
    assert copy.links(1).tobytes() == views[0].links(1).tobytes()


# ---- the mean ------------------------------------------------------------------------------------


def test_two_references_meet_half_way() -> None:
    first, second, _ = astray(0.64)
    one, two = corrections([prepare(first), prepare(second)], None, 1)
    here = np.array([100.0, 80.0, 1.0, 0.35])
    placed = [each.place @ here for each in (one, two)]
    moved = [there[:2] / there[2] - here[:2] for there in placed]
    assert np.hypot(*moved[0]) == pytest.approx(np.hypot(*moved[1]), abs=0.1)
    assert np.hypot(*(moved[0] + moved[1])) < 0.1
    assert np.hypot(*moved[0]) > 0.7
    assert one.gain == pytest.approx(0.8, rel=0.02)
    assert two.gain == pytest.approx(1.25, rel=0.02)


def test_a_share_is_how_much_a_reference_says_in_the_mean() -> None:
    first, second, _ = astray(0.64)
    views = [prepare(first), prepare(second)]
    nearly_first = corrections(views, [1.0, 1e-9], 1)
    np.testing.assert_allclose(nearly_first[0].place, np.eye(4), atol=1e-6)
    assert nearly_first[0].gain == pytest.approx(1.0)
    assert nearly_first[1].gain == pytest.approx(1 / 0.64, rel=0.02)


def test_a_correction_moves_forth_and_back_alike() -> None:
    here, there = at(HERE), at(ASIDE)
    place = np.eye(4)
    place[:3] += [[0.01, -0.02, 1.5, 0.7], [0.005, 0.01, -0.8, 0.4], [1e-4, -2e-4, 0.01, 0.0]]
    correction = Correction(place, 1.0)
    forth = correction.forward(warp_matrix(here, there))
    back = correction.backward(warp_matrix(there, here))
    u, v, delta = 70.0, 50.0, 0.4
    r, s, t = forth @ [u, v, 1.0, delta]
    a, b, c = back @ [r / t, s / t, 1.0, delta / t]
    np.testing.assert_allclose([a / c, b / c, delta / t / c], [u, v, delta], atol=1e-9)


# ---- pictures ------------------------------------------------------------------------------------


def test_a_picture_from_references_astray_is_sharper_and_evenly_exposed() -> None:
    first, second, true = astray(0.7)
    views = [prepare(first), prepare(second)]
    desired = at((0.1, 0.05, 0.0))
    raw = warp(views, desired, reconcile=False)
    mean = warp(views, desired)
    # the truth that is in their middle: half of the turn, and the mean exposure
    middle = at((0.1, 0.05, 0.0), (0.8, -0.6), 0.005)
    truth = color_to_srgb8(wall(middle) * math.sqrt(0.7))
    known = (mean.coverage == 1) & (raw.coverage == 1)
    assert known.mean() > 0.8
    better, worse = psnr(mean.color, truth, known), psnr(raw.color, truth, known)
    assert better > 38  # measured 42.2
    assert better > worse + 15  # measured 22.3
    assert true.center == pytest.approx(second.camera.center)


def test_exact_references_keep_every_byte() -> None:
    views = [photograph(at(center)) for center in (HERE, ASIDE, (-0.2, 0.0, 0.1))]
    desired = at((0.1, 0.05, 0.0))
    assert same(warp(views, desired, reconcile=True), warp(views, desired, reconcile=False))


def test_one_reference_is_left_as_it_is() -> None:
    _, second, _ = astray(0.7)
    assert corrections([prepare(second)], None, 1) == [UNCHANGED]


def test_only_inverse_reconciles() -> None:
    first, second, _ = astray(0.7)
    desired = at((0.1, 0.05, 0.0))
    for reconstruction in ("point", "splat", "gaussian", "mesh", "offset"):
        frames = [
            warp([first, second], desired, reconstruction=reconstruction, reconcile=on)
            for on in (True, False)
        ]
        assert same(*frames), reconstruction


def test_the_picture_does_not_depend_on_threads_order_or_who_warped_before() -> None:
    first, second, _ = astray(0.7)
    third = photograph(at((-0.2, 0.1, 0.0), (-1, 1)), at((-0.2, 0.1, 0.0)))
    desired = at((0.1, 0.05, 0.0), size=(301, 203))
    frame = warp([first, second, third], desired, threads=1)
    for threads in (2, 3, 4):
        assert same(frame, warp([first, second, third], desired, threads=threads))
    assert same(frame, warp([third, first, second], desired))
    held = [prepare(one) for one in (second, third, first)]
    warp(held[:2], desired)
    assert same(frame, warp(held, desired))
    assert same(frame, Warper(301, 203).warp([first, second, third], desired))
    assert not same(frame, warp(held, desired, reconcile=False))


def test_a_reference_that_fades_in_moves_the_others_little_by_little() -> None:
    first, second, _ = astray()
    views = [prepare(first), prepare(second)]
    desired = at((0.1, 0.05, 0.0))
    alone = warp(views[0], desired)
    warper = Warper(*SIZE, cross_fade=16)
    warper.warp(views[0], desired)
    entering = warper.warp(views, desired)
    inside = (alone.coverage == 1) & (entering.coverage == 1)
    near = psnr(entering.color, alone.color, inside)
    assert near > psnr(warp(views, desired).color, alone.color, inside) + 12  # measured 17.5
    assert near > 45  # measured 51.3


def test_alpha_is_not_exposed() -> None:
    first, second, _ = astray(0.7)
    views = []
    for view in (first, second):
        linear = np.concatenate(
            [color_to_linear(view.color) * 0.5, np.full((*view.disparity.shape, 1), 0.5)], axis=-1
        )
        views.append(replace(view, color=linear.astype(np.float32)))
    frame = warp(views, at((0.1, 0.05, 0.0)))
    inside = frame.coverage == 1
    np.testing.assert_allclose(frame.color[..., 3][inside], 0.5, atol=1e-5)


def test_features_move_as_colours_do() -> None:
    first, second, _ = astray()
    views = [
        replace(one, features=color_to_linear(one.color).astype(np.float32))
        for one in (first, second)
    ]
    frame = warp(views, at((0.1, 0.05, 0.0)))
    inside = frame.coverage == 1
    inside[:4] = inside[-4:] = inside[:, :4] = inside[:, -4:] = False
    features = frame.features
    assert features is not None
    apart = abs(features - color_to_linear(frame.color))[inside]
    assert apart.max() < 0.02


def test_a_comparison_is_forgotten_with_the_view_it_was_made_with() -> None:
    first, second, _ = astray()
    kept, lost = prepare(first), prepare(second)
    warp([kept, lost], at((0.1, 0.05, 0.0)))
    assert list(kept.compared) == [lost]
    del lost
    gc.collect()
    assert not kept.compared


def test_reconcile_takes_true_or_false() -> None:
    with pytest.raises(InputError, match=r"WarpOptions\.reconcile is 1, expected True or False"):
        bv.WarpOptions(reconcile=1)  # type: ignore[arg-type]
