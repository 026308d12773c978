from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from belvedere.ground.errors import CameraError
from belvedere.scene import Camera
from belvedere.scene.opengl import (
    ClipDepth,
    camera_from_frustum,
    camera_from_gltf,
    camera_from_projection,
    camera_to_world_from_view_matrix,
    frustum_from_camera,
    gltf_from_camera,
    opengl_pose,
    planes_from_projection,
    projection_matrix,
)
from belvedere.scene.zbuffer import disparity_from_zbuffer
from tests.strategies import F8, numbers, planar_cameras, poses

WIDTH, HEIGHT = 64, 48
DEPTHS: list[ClipDepth] = ["ndc", "zero_to_one", "reversed"]


def gl_frustum(left: float, right: float, bottom: float, top: float, n: float, f: float) -> F8:
    """The matrix of the OpenGL 2.1 reference page of glFrustum, entry by entry."""
    return np.array(
        [
            [2 * n / (right - left), 0, (right + left) / (right - left), 0],
            [0, 2 * n / (top - bottom), (top + bottom) / (top - bottom), 0],
            [0, 0, -(f + n) / (f - n), -2 * f * n / (f - n)],
            [0, 0, -1, 0],
        ]
    )


def gl_pixels(projection: F8, pose: F8, points: F8) -> F8:
    """(N, 3): column and row (centres at integers, rows downwards) and NDC depth, as OpenGL does
    it: clip coordinates, division by w, viewport."""
    eye = np.linalg.inv(pose) @ np.column_stack([points, np.ones(len(points))]).T
    clip = projection @ eye
    ndc = clip[:3] / clip[3]
    return np.stack(
        [
            (ndc[0] + 1) / 2 * WIDTH - 0.5,
            (1 - ndc[1]) / 2 * HEIGHT - 0.5,
            ndc[2],
        ],
        axis=1,
    )


def points_before(pose: F8, near: float, far: float) -> F8:
    """(40, 3) points in front of an OpenGL camera, between its planes."""
    rng = np.random.default_rng(7)
    depth = 1.0 / rng.uniform(1.0 / far, 1.0 / near, 40)
    eye = np.column_stack([rng.uniform(-1, 1, (40, 2)) * depth[:, None], -depth])
    return eye @ pose[:3, :3].T + pose[:3, 3]


@given(poses(), numbers(-2, 0), numbers(0.1, 2), numbers(-2, 0), numbers(0.1, 2), numbers(0.05, 2))
def test_a_frustum_camera_sees_what_opengl_draws(
    pose: F8, left: float, width: float, bottom: float, height: float, near: float
) -> None:
    right, top, far = left + width, bottom + height, near * 50
    camera = camera_from_frustum(left, right, bottom, top, near, pose, width=WIDTH, height=HEIGHT)
    points = points_before(pose, near, far)
    drawn = gl_pixels(gl_frustum(left, right, bottom, top, near, far), pose, points)
    u, v, delta = camera.project(points)
    np.testing.assert_allclose(u, drawn[:, 0], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(v, drawn[:, 1], rtol=1e-9, atol=1e-6)
    # the classic mistake would be off by the factor `near` here
    window = np.clip((drawn[:, 2] + 1) / 2, 0, 1)
    np.testing.assert_allclose(disparity_from_zbuffer(window, near, far), delta, rtol=1e-6)


@given(poses(), numbers(-2, 0), numbers(0.1, 2), numbers(-2, 0), numbers(0.1, 2), numbers(0.05, 2))
def test_a_frustum_comes_back_as_it_was_given(
    pose: F8, left: float, width: float, bottom: float, height: float, near: float
) -> None:
    sides = (left, left + width, bottom, bottom + height)
    camera = camera_from_frustum(*sides, near, pose, width=WIDTH, height=HEIGHT)
    assert frustum_from_camera(camera, near) == pytest.approx(sides, abs=1e-9)
    np.testing.assert_allclose(
        projection_matrix(camera, near, 9 * near),
        gl_frustum(*sides, near, 9 * near),
        rtol=1e-9,
        atol=1e-9,
    )
    np.testing.assert_allclose(opengl_pose(camera), pose, atol=1e-12)


@pytest.mark.parametrize("far", [30.0, math.inf])
@pytest.mark.parametrize("depth", DEPTHS)
@given(camera=planar_cameras(), near=numbers(0.01, 2.0))
def test_a_camera_survives_the_round_trip_through_its_projection_matrix(
    depth: ClipDepth, far: float, camera: Camera, near: float
) -> None:
    matrix = projection_matrix(camera, near, far, depth)
    again = camera_from_projection(
        matrix, opengl_pose(camera), width=camera.width, height=camera.height
    )
    np.testing.assert_allclose(again.matrix, camera.matrix, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(again.center, camera.center)
    found = planes_from_projection(matrix, depth)
    assert found[0] == pytest.approx(near)
    assert found[1] == pytest.approx(far, rel=1e-9)


@pytest.mark.parametrize(
    ("depth", "at_near", "at_far"),
    [("ndc", -1.0, 1.0), ("zero_to_one", 0.0, 1.0), ("reversed", 1.0, 0.0)],
)
@pytest.mark.parametrize("far", [30.0, math.inf])
def test_clip_depth_runs_from_the_near_plane_to_the_far_plane(
    depth: ClipDepth, at_near: float, at_far: float, far: float
) -> None:
    matrix = projection_matrix(Camera.look_at((0, 0, 0), (1, 0, 0)), 0.5, far, depth)

    def depth_at(z: float) -> float:
        clip = matrix @ [0.0, 0.0, -z, 1.0]
        return float(clip[2] / clip[3])

    assert depth_at(0.5) == pytest.approx(at_near)
    assert depth_at(min(far, 1e12)) == pytest.approx(at_far, abs=1e-9)


def test_an_infinite_projection_has_the_textbooks_entries() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0), fov_deg=90, width=100, height=100)
    np.testing.assert_allclose(
        projection_matrix(camera, 0.1),
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]],
        atol=1e-15,
    )
    np.testing.assert_allclose(projection_matrix(camera, 0.1, depth="reversed")[2], [0, 0, 0, 0.1])


def test_float32_matrices_are_understood() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0))
    for far in (100.0, math.inf):
        matrix = projection_matrix(camera, 0.1, far).astype(np.float32)
        near, found = planes_from_projection(matrix)
        assert near == pytest.approx(0.1, rel=1e-5)
        assert found == pytest.approx(far, rel=1e-2)


def test_a_view_matrix_gives_the_pose_it_inverts() -> None:
    camera = Camera.look_at((1, 2, 3), (4, 4, 4))
    pose = opengl_pose(camera)
    view = np.linalg.inv(pose)
    np.testing.assert_allclose(camera_to_world_from_view_matrix(view), pose, atol=1e-14)
    np.testing.assert_allclose(view[:3, :3] @ camera.forward, [0, 0, -1], atol=1e-14)


@given(poses(), numbers(0.1, 3.0), numbers(0.3, 3.0))
def test_a_gltf_camera_sees_what_the_gltf_matrix_draws(pose: F8, yfov: float, ratio: float) -> None:
    camera = camera_from_gltf(yfov, pose, aspect_ratio=ratio, width=WIDTH, height=HEIGHT)
    t = math.tan(yfov / 2)
    n, f = 0.1, 10.0
    matrix = np.array(  # glTF 2.0, 5.12.3, finite perspective
        [
            [1 / (ratio * t), 0, 0, 0],
            [0, 1 / t, 0, 0],
            [0, 0, (f + n) / (n - f), 2 * f * n / (n - f)],
            [0, 0, -1, 0],
        ]
    )
    points = points_before(pose, n, f)
    drawn = gl_pixels(matrix, pose, points)
    u, v, _ = camera.project(points)
    np.testing.assert_allclose(u, drawn[:, 0], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(v, drawn[:, 1], rtol=1e-9, atol=1e-6)

    told = gltf_from_camera(camera, n, f)["perspective"]
    expected = {"yfov": yfov, "aspectRatio": ratio, "znear": n, "zfar": f}
    assert told == pytest.approx(expected)
    assert "zfar" not in gltf_from_camera(camera, n)["perspective"]


def test_gltf_pixels_are_square_unless_an_aspect_ratio_says_otherwise() -> None:
    k = camera_from_gltf(1.0, np.eye(4), width=WIDTH, height=HEIGHT).intrinsics
    assert k[0, 0] == pytest.approx(k[1, 1])


# ---- refusals ------------------------------------------------------------------------------------


def test_frusta_that_enclose_nothing_are_refused() -> None:
    for sides, message in (
        ((1, -1, -1, 1, 0.1), r"expected left < right and bottom < top"),
        ((-1, 1, 1, 1, 0.1), r"enclose nothing"),
        ((-1, 1, -1, 1, 0.0), r"frustum.near is 0"),
        ((-1, math.nan, -1, 1, 0.1), r"frustum.sides\[1\] is nan"),
    ):
        with pytest.raises(CameraError, match=message):
            camera_from_frustum(*sides, np.eye(4), width=4, height=4)


def test_planes_in_the_wrong_order_are_refused() -> None:
    camera = Camera.look_at((0, 0, 0), (1, 0, 0))
    for near, far, message in (
        (1.0, 0.5, r"OpenGL.far is 0.5, expected more than near \(1\) or infinity"),
        (0.0, 1.0, r"OpenGL.near is 0"),
        (0.1, math.nan, r"OpenGL.far is nan"),
    ):
        with pytest.raises(CameraError, match=message):
            projection_matrix(camera, near, far)


def _changed(*entries: tuple[int, int, float]) -> F8:
    matrix = gl_frustum(-1, 1, -1, 1, 1, 10)
    for row, column, value in entries:
        matrix[row, column] = value
    return matrix


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (gl_frustum(-1, 1, -1, 1, 1, 10).T, r"it is transposed \(row vectors\), pass its .T"),
        (np.diag([1.0, 1.0, -0.1, 1.0]), r"it is orthographic, use OrthographicCamera"),
        (_changed((3, 2, 1.0)), r"its eye space looks along \+z, negate column 2"),
        (_changed((1, 1, -1.0)), r"negate row 1 of a matrix with y downwards \(Vulkan\)"),
        (_changed((0, 3, 2.0)), r"split the view matrix off it"),
        (_changed((2, 2, math.nan)), r"opengl.projection\[2, 2\] is nan"),
        (np.eye(3), r"opengl.projection has shape \(3, 3\), expected \(4, 4\)"),
        (np.zeros((4, 4)), r"expected \[0, 0, -1, 0\]"),
        (3.0 * gl_frustum(-1, 1, -1, 1, 1, 10), r"has the last row \[0.0, 0.0, -3.0, 0.0\]"),
        (gl_frustum(-1, 2, -1, 1, 1, 10).T, r"it is transposed"),
    ],
)
def test_matrices_that_are_no_perspective_are_refused_with_the_remedy(
    matrix: F8, message: str
) -> None:
    with pytest.raises(CameraError, match=message):
        camera_from_projection(matrix, np.eye(4), width=4, height=4)


def test_a_depth_convention_that_cannot_be_is_refused() -> None:
    matrix = projection_matrix(Camera.look_at((0, 0, 0), (1, 0, 0)), 0.1, depth="reversed")
    with pytest.raises(CameraError, match=r"is depth another convention\?"):
        planes_from_projection(matrix, "zero_to_one")


def test_gltf_cannot_say_off_axis_and_frusta_cannot_say_skew() -> None:
    k = np.array([[50.0, 0, 40.0], [0, 50, 23.5], [0, 0, 1]])
    off_axis = Camera.from_intrinsics(k, np.eye(4), WIDTH, HEIGHT)
    with pytest.raises(CameraError, match=r"meets the picture 8.5 pixels off its middle"):
        gltf_from_camera(off_axis, 0.1)
    k[0, 1] = 3.0
    skewed = Camera.from_intrinsics(k, np.eye(4), WIDTH, HEIGHT)
    with pytest.raises(CameraError, match=r"has skew 3, which a frustum cannot say"):
        frustum_from_camera(skewed, 0.1)
    with pytest.raises(CameraError, match=r"has skew 3, which a glTF camera cannot say"):
        gltf_from_camera(skewed, 0.1)
