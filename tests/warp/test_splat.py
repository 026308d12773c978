"""The squares of splats, against a twin that asks every sample of every pixel."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.jit import Real
from belvedere.scene import ReferenceView
from belvedere.warp import SplatOptions, warp, warp_matrix
from tests.oracles.warp import splat_pixel
from tests.warp.worlds import noise, random_camera, straight_camera


def landed(rng: np.random.Generator, rows: int, width: int, share: float) -> tuple[Real, ...]:
    """Disparities (NaN: none), places right and down of the cells' middles: (rows, width) each."""
    delta = rng.choice([0.25, 0.252, 0.3, 0.9], (rows, width)).astype(np.float32)
    delta[rng.random(delta.shape) > share] = np.nan
    right, down = rng.integers(0, 65536, (2, rows, width))
    return delta, right, down


@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
@pytest.mark.parametrize(("size", "growth"), [(3, 1.0), (5, 1.0), (7, 1.0), (0, 1.6), (0, 4.3)])
def test_a_pixel_goes_to_the_nearest_center_of_the_front_surface_that_reaches_it(
    size: int, growth: float, share: float
) -> None:
    from belvedere.warp import _scatter, _splat

    rng = np.random.default_rng(size)
    halo, rows, width = 3 if size == 0 else size // 2, 9, 21
    delta, right, down = landed(rng, rows + 2 * halo, width + 2 * halo, share)
    number = np.arange(delta.size).reshape(delta.shape)
    word = np.where(
        np.isnan(delta), _scatter.EMPTY, (delta.view(np.int32).astype(np.int64) << 32) | number
    )
    # looking along the same axis from the same place, enlarged: 1 / t is 1, det H the square
    back = np.zeros(12, np.float32)
    back[10] = 1.0
    out = np.empty((rows, width), np.int64)
    _splat.spread(
        word, ((down << 16) | right).astype(np.uint32), back, growth**2, 0.0, size, halo, 0, 0.03,
        out,
    )  # fmt: skip
    half = 0.5 * size if size else max(0.7072 * growth, 0.5)
    for y, x in np.ndindex(rows, width):
        wanted = splat_pixel(
            delta, right / 65536 - 0.5, down / 65536 - 0.5, half, halo, y + halo, x + halo, 0.03
        )
        got = int(out[y, x])
        assert (got == -1) == (wanted is None)
        if wanted is not None:
            assert got & 0xFFFFFFFF == number[wanted]
            assert got >> 32 == int(delta.view(np.int32)[wanted])


def test_growth_needs_nothing_but_the_place_in_the_desired_view() -> None:
    """1 / t is linear in the place and the warped disparity, so det J is too simple to look up."""
    from belvedere.warp import _scatter, _splat

    rng = np.random.default_rng(2)
    for _ in range(50):
        a, b = random_camera(rng, 30, 22, 0.3), random_camera(rng, 25, 27, 0.3)
        matrix, back = warp_matrix(a, b), warp_matrix(b, a).astype(np.float32).ravel()
        u, v, delta = rng.uniform(0, 30), rng.uniform(0, 22), rng.uniform(0.05, 0.5)
        r, s, t = matrix @ (u, v, 1, delta)
        x, y = r / t, s / t
        if not (t > 0.1 and -50 < x < 50 and -50 < y < 50):
            continue
        dets = np.linalg.det(matrix[:, :3]), np.linalg.det(matrix[:, [0, 1, 3]])
        grown = 0.7072 * np.sqrt(abs(dets[0] + delta * dets[1]) / t**3)
        column, line = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
        place = [int((x + 0.5 - column) * 65536), int((y + 0.5 - line) * 65536)]
        bits = int(np.float32(delta / t).view(np.int32))
        rows = [np.empty(1, np.float32) for _ in range(4)]
        _splat.read_row(
            np.array([bits << 32], np.int64), np.array([(place[1] << 16) | place[0]], np.uint32),
            line, -column, back, *dets, 0, *rows,
        )  # fmt: skip
        np.testing.assert_allclose(rows[3][0], grown if grown > 0.7072 * 1.001 else 0.5, rtol=1e-3)
    assert _scatter.PLACES == 65536


@pytest.mark.parametrize("size", [1, 3, "jacobian"])
def test_what_is_infinitely_far_is_seen_even_if_its_zero_is_negative(size: int) -> None:
    rng = np.random.default_rng(4)
    camera = straight_camera(12, 9)
    view = ReferenceView(camera, noise(rng, 9, 12), np.full((9, 12), -0.0, np.float32))
    part = camera.cropped(0, 0, 11, 9)
    frame = warp(view, part, reconstruction="splat", splat=SplatOptions(size=size))
    assert frame.coverage.all()
    np.testing.assert_array_equal(frame.color, view.color[:, :11])
    assert not np.signbit(frame.disparity).any()
