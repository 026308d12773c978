from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.errors import CameraError, InputError
from belvedere.scene import Camera
from belvedere.scene.opengl import ClipDepth, projection_matrix
from belvedere.scene.zbuffer import BufferDepth, disparity_from_zbuffer, zbuffer_from_disparity
from tests.strategies import numbers

DEPTHS: list[BufferDepth] = ["window", "ndc", "zero_to_one", "reversed"]
CLIP: dict[BufferDepth, ClipDepth] = {
    "window": "zero_to_one",
    "ndc": "ndc",
    "zero_to_one": "zero_to_one",
    "reversed": "reversed",
}


@pytest.mark.parametrize("far", [50.0, math.inf])
@pytest.mark.parametrize("depth", DEPTHS)
@given(near=numbers(0.01, 1.0), share=numbers(0.001, 1.0))
def test_the_buffer_of_an_actual_projection_gives_one_over_z(
    depth: BufferDepth, far: float, near: float, share: float
) -> None:
    z = 1.0 / (share / near + (0.0 if math.isinf(far) else (1.0 - share) / far))
    matrix = projection_matrix(Camera.look_at((0, 0, 0), (1, 0, 0)), near, far, CLIP[depth])
    clip = matrix @ [0.3 * z, -0.2 * z, -z, 1.0]
    value = np.array(clip[2] / clip[3])
    assert disparity_from_zbuffer(value, near, far, depth) == pytest.approx(1 / z, rel=1e-9)
    back = zbuffer_from_disparity(np.array(1 / z), near, far, depth)
    assert back == pytest.approx(float(value), abs=1e-12)


@pytest.mark.parametrize("depth", DEPTHS)
def test_nothing_drawn_is_infinitely_far_unless_asked_otherwise(depth: BufferDepth) -> None:
    far_value = zbuffer_from_disparity(np.zeros(2), 0.1, 20.0, depth)
    np.testing.assert_array_equal(far_value, 0.0 if depth == "reversed" else 1.0)
    np.testing.assert_array_equal(disparity_from_zbuffer(far_value, 0.1, 20.0, depth), 0.0)
    np.testing.assert_allclose(
        disparity_from_zbuffer(far_value, 0.1, 20.0, depth, sky="far"), 1 / 20.0
    )


@pytest.mark.parametrize("depth", DEPTHS)
def test_what_the_planes_cut_off_is_put_on_them(depth: BufferDepth) -> None:
    near, far = zbuffer_from_disparity(np.array([1e6, 1e-6]), 0.1, 20.0, depth)
    assert (near, far) == {"ndc": (-1, 1), "reversed": (1, 0)}.get(depth, (0, 1))


def test_missing_samples_stay_missing() -> None:
    value = np.array([np.nan, 0.5])
    assert np.isnan(disparity_from_zbuffer(value, 0.1, 10.0)).tolist() == [True, False]
    assert np.isnan(zbuffer_from_disparity(value, 0.1, 10.0)).tolist() == [True, False]


def test_float32_buffers_give_float32_disparity() -> None:
    buffer = np.linspace(0, 1, 5, dtype=np.float32)
    assert disparity_from_zbuffer(buffer, 0.1, 10.0).dtype == np.float32
    assert disparity_from_zbuffer(buffer.astype(np.float64), 0.1, 10.0).dtype == np.float64
    assert zbuffer_from_disparity(buffer, 0.1, 10.0).dtype == np.float32


def test_a_buffer_in_another_convention_is_refused() -> None:
    with pytest.raises(InputError, match=r"zbuffer holds -0.5, expected 0 to 1 for depth='window'"):
        disparity_from_zbuffer(np.array([0.5, -0.5]), 0.1, 10.0)
    with pytest.raises(InputError, match=r"or linear depth already\?"):
        disparity_from_zbuffer(np.array([2.5]), 0.1, 10.0, "ndc")
    with pytest.raises(InputError, match=r"zbuffer is uint16, .*\(65535 for 16 bits\)"):
        disparity_from_zbuffer(np.zeros(3, np.uint16), 0.1, 10.0)
    with pytest.raises(InputError, match=r"zbuffer.depth is 'linear', expected one of 'window'"):
        disparity_from_zbuffer(np.zeros(3), 0.1, 10.0, "linear")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"zbuffer.sky is 'blue', expected one of 'infinite'"):
        disparity_from_zbuffer(np.zeros(3), 0.1, 10.0, sky="blue")  # type: ignore[arg-type]


def test_planes_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(CameraError, match=r"OpenGL.far is 0.1, expected more than near"):
        disparity_from_zbuffer(np.zeros(3), 1.0, 0.1)
