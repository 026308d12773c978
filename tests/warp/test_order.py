"""Occlusion-compatible order: the picture a z-buffer makes, without looking at depths."""

from __future__ import annotations

import importlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from belvedere.scene import Camera
from belvedere.warp import Sheet, epipole, occlusion_compatible_sheets, order_key, warp
from belvedere.warp.order import occlusion_compatible_cell_sheets
from tests.oracles.warp import nearest_samples, paint_in_order
from tests.warp.worlds import boards, random_camera, random_rotation, straight_camera, view_of

WIDTH, HEIGHT = 45, 33
RATIOS = (-0.6, 0.45, 1.5)
"""Epipole left of, in and right of a picture of size 1: three by three regions."""
PLACES = [
    pytest.param((x * WIDTH, y * HEIGHT, 1.0), sign, id=f"{name}{'+' if sign > 0 else '-'}")
    for (x, y), name in zip([(x, y) for y in RATIOS for x in RATIOS], "ABCDEFGHI", strict=True)
    for sign in (1.0, -1.0)
] + [
    pytest.param((x * WIDTH, y * HEIGHT, 0.0), 1.0, id=f"level{x:+d}{y:+d}")
    for x in (-1, 1)
    for y in (-1, 1)
]


def desired_camera(reference: Camera, e: tuple[float, float, float], sign: float) -> Camera:
    """A camera near the reference whose eye is seen at the epipole e, 0.5 m away."""
    step = reference.matrix @ np.array(e) * sign
    return reference.moved(reference.center + 0.5 * step / np.linalg.norm(step))


def wrong_share(e: tuple[float, float, float], sign: float, scenes: int = 6) -> float:
    """Share of covered pixels where order shows another surface than the z-buffer."""
    rng = np.random.default_rng(5)
    wrong = covered = 0
    for _ in range(scenes):
        reference = straight_camera(WIDTH, HEIGHT)
        disparity, label = boards(rng, HEIGHT, WIDTH)
        color = np.repeat(label[..., None].astype(np.uint8) * 20 + 9, 3, axis=-1)
        view = view_of(reference, disparity, color)
        desired = desired_camera(reference, e, sign)
        by_order, by_depth = (
            warp(view, desired, reconstruction="point", visibility=v, threads=1)
            for v in ("order", "zbuffer")
        )
        wrong += int((by_order.color != by_depth.color).any(axis=-1).sum())
        covered += int((by_depth.coverage > 0).sum())
    assert covered > scenes * 200
    return wrong / covered


@pytest.mark.parametrize(("e", "sign"), PLACES)
def test_the_painter_shows_what_the_z_buffer_shows(
    e: tuple[float, float, float], sign: float
) -> None:
    assert wrong_share(e, sign) == 0.0


@pytest.mark.parametrize(("e", "sign"), PLACES)
def test_the_reversed_order_shows_wrong_surfaces(
    e: tuple[float, float, float], sign: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def backwards(e: np.ndarray, width: int, height: int) -> tuple[Sheet, ...]:
        sheets = occlusion_compatible_sheets(e, width, height)
        return tuple(replace(s, u_step=-s.u_step, v_step=-s.v_step) for s in sheets)

    module = importlib.import_module("belvedere.warp.warp")
    monkeypatch.setattr(module, "occlusion_compatible_sheets", backwards)
    assert wrong_share(e, sign) > 0.005


def test_the_scenes_land_in_all_nine_regions_on_both_sides_and_level() -> None:
    reference = straight_camera(WIDTH, HEIGHT)
    counts: dict[int, int] = {}
    for place in PLACES:
        e, sign = place.values
        seen = epipole(reference, desired_camera(reference, e, sign))  # type: ignore[arg-type]
        count = len(occlusion_compatible_sheets(seen, WIDTH, HEIGHT))
        counts[count] = counts.get(count, 0) + 1
    assert counts == {4: 2, 2: 8, 1: 8 + 4}


@pytest.mark.parametrize("reconstruction", ["mesh", "offset"])
def test_surfaces_drawn_in_order_hide_one_another_as_the_z_buffer_says(
    reconstruction: Any,
) -> None:
    """Cells reach to both sides of the epipole; drawn with one quadrant they showed what is behind.

    At silhouettes a warp-buffer cell that both surfaces reach may go to either, so `offset` is
    asked a pixel away from them.
    """
    rng = np.random.default_rng(0)
    wrong = known = 0
    for _ in range(100):
        camera = straight_camera(90, 70)
        disparity, _ = boards(rng, 70, 90, 6)
        at = np.array([rng.uniform(-0.2, 1.2) * 90, rng.uniform(-0.2, 1.2) * 70, 1])
        step = camera.matrix @ at * rng.choice([-1, 1])
        desired = camera.moved(rng.uniform(0.3, 0.95) * step / np.linalg.norm(step))
        by_order, by_depth = (
            np.nan_to_num(
                warp(view_of(camera, disparity), desired, reconstruction=reconstruction,
                     visibility=v).disparity, nan=-1.0,
            )
            for v in ("order", "zbuffer")
        )  # fmt: skip
        around = np.stack(
            [np.roll(by_depth, (j, i), (0, 1)) for j in (-1, 0, 1) for i in (-1, 0, 1)]
        )
        inside = np.ptp(around, axis=0) < 1e-3 if reconstruction == "offset" else by_depth > -2
        inside = inside[2:-2, 2:-2]
        wrong += int((np.abs(by_order - by_depth)[2:-2, 2:-2] > 1e-3)[inside].sum())
        known += int(inside.sum())
    assert wrong == 0
    assert known > 300_000


def test_cell_sheets_hold_every_cell_once_and_the_epipole_s_row_and_column_by_themselves() -> None:
    for sign in (1.0, -1.0):
        sheets = occlusion_compatible_cell_sheets((30.4 * sign, 10.7 * sign, sign), 60, 40)
        count = np.zeros((40, 60), int)
        for sheet in sheets:
            count[sheet.v_low : sheet.v_high, sheet.u_low : sheet.u_high] += 1
        assert np.all(count == 1)
        assert len(sheets) == 9
        middle = sheets[-1 if sign > 0 else 0]
        assert (middle.u_low, middle.u_high, middle.v_low, middle.v_high) == (30, 31, 10, 11)
        corners = sheets[:4] if sign > 0 else sheets[5:]
        assert all(30 not in range(s.u_low, s.u_high) for s in corners)
        assert all(10 not in range(s.v_low, s.v_high) for s in corners)
    for e in ((-9.0, 10.7, 1.0), (1.0, -2.0, 0.0), (0.0, 0.0, 0.0), (59.9, 39.2, 1.0)):
        cells = occlusion_compatible_cell_sheets(e, 60, 40)
        assert sum((s.u_high - s.u_low) * (s.v_high - s.v_low) for s in cells) == 60 * 40
        assert len(cells) in {1, 3, 4}


epipoles = st.tuples(
    st.floats(-200, 200), st.floats(-200, 200), st.sampled_from([-2.0, -1.0, -1e-9, 0.0, 1e-9, 1.0])
)


@given(epipoles, st.integers(1, 40), st.integers(1, 40))
def test_sheets_hold_every_pixel_once_and_scan_by_the_sign_rule(
    e: tuple[float, float, float], width: int, height: int
) -> None:
    ex, ey, ez = e
    count = np.zeros((height, width), int)
    for sheet in occlusion_compatible_sheets(e, width, height):
        count[sheet.v_low : sheet.v_high, sheet.u_low : sheet.u_high] += 1
        u, v = np.arange(sheet.u_low, sheet.u_high), np.arange(sheet.v_low, sheet.v_high)
        # the division by ez that finds the split may round by one unit in the last place
        slack = 1e-12 * (abs(ez) * 40 + 1)
        assert np.all((ex - u * ez) * sheet.u_step >= -slack)
        assert np.all((ey - v * ez) * sheet.v_step >= -slack)
    assert np.all(count == 1)


def test_an_epipole_on_a_pixel_comes_last_when_the_eye_is_in_front_and_first_behind() -> None:
    front = occlusion_compatible_sheets((3.0, 2.0, 1.0), 8, 6)
    assert {(s.u_low, s.u_high, s.u_step) for s in front} == {(0, 3, 1), (3, 8, -1)}
    behind = occlusion_compatible_sheets((-3.0, -2.0, -1.0), 8, 6)
    assert {(s.v_low, s.v_high, s.v_step) for s in behind} == {(0, 2, -1), (2, 6, 1)}


@given(st.integers(0, 2**32 - 1))
def test_on_one_line_of_sight_the_nearer_point_comes_later_by_sheet_and_by_key(seed: int) -> None:
    rng = np.random.default_rng(seed)
    reference = random_camera(rng, WIDTH, HEIGHT, reach=0.3)
    desired = random_camera(rng, WIDTH, HEIGHT, reach=0.5)
    direction = desired.rays(rng.uniform(0, WIDTH), rng.uniform(0, HEIGHT))
    near, far = (desired.center + direction * z for z in (rng.uniform(1, 3), rng.uniform(4, 9)))
    un, vn, dn = reference.project(near)
    uf, vf, df = reference.project(far)
    if not (np.isfinite(dn) and np.isfinite(df)):
        return
    e = epipole(reference, desired)
    toward_u, toward_v = np.sign(e[0] - uf * e[2]), np.sign(e[1] - vf * e[2])
    assert (un - uf) * toward_u >= -1e-9
    assert (vn - vf) * toward_v >= -1e-9
    keys = order_key(desired.center - reference.center, reference.rays([un, uf], [vn, vf]))
    assert keys[0] >= keys[1] - 1e-12


def test_the_general_key_orders_as_the_z_buffer_does() -> None:
    rng = np.random.default_rng(8)
    reference = straight_camera(21, 17)
    for _ in range(8):
        disparity, _ = boards(rng, 17, 21, 3)
        desired = Camera(
            random_rotation(rng, 0.1) @ reference.matrix, rng.normal(0, 0.3, 3), 21, 17
        )
        by_key, _ = paint_in_order(reference, desired, disparity)
        by_depth, _ = nearest_samples(reference, desired, disparity)
        np.testing.assert_array_equal(np.isnan(by_key), np.isnan(by_depth))
        # the same surface: disparities of two samples of one frontal board differ by its tilt only
        np.testing.assert_allclose(by_key, by_depth, rtol=0.05)
