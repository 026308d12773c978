"""Where references stand, and what their pictures show."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import CameraError, InputError
from belvedere.walkthrough import (
    OUTSIDE,
    PlacementOptions,
    Portal,
    Side,
    reference_camera,
    semicircle_eyes,
    sides_of,
)
from tests.walkthrough.graphs import three_rooms, upright


def sides() -> list[Side]:
    return [Side(p, c, 0.0) for p in three_rooms().portals for c in p.cells]


@pytest.mark.parametrize("side", sides())
def test_eyes_stand_on_an_arc_before_the_portal(side: Side) -> None:
    options = PlacementOptions(count=7, span_deg=120, radius=2.0)
    eyes = semicircle_eyes(side, options)
    level = (eyes - side.portal.center)[:, :2]
    np.testing.assert_allclose(np.linalg.norm(level, axis=1), 2.0, rtol=1e-12)
    assert (level @ side.normal[:2] > 0.99).all()  # 60 degrees off: half of two metres
    np.testing.assert_allclose(eyes[:, 2], 1.6)
    angles = np.degrees(np.arccos(np.clip(level @ side.normal[:2] / 2.0, -1, 1)))
    np.testing.assert_allclose(angles, [60, 40, 20, 0, 20, 40, 60], atol=1e-5)


@pytest.mark.parametrize("side", sides())
def test_a_references_picture_is_exactly_the_portal(side: Side) -> None:
    options = PlacementOptions()
    for eye in semicircle_eyes(side, options):
        camera, near = reference_camera(side, eye, options)
        u, v, delta = camera.project(side.portal.corners)
        edges = {(round(a + 0.5), round(b + 0.5)) for a, b in zip(u, v, strict=True)}
        w, h = camera.width, camera.height
        assert edges == {(0, 0), (w, 0), (0, h), (w, h)}
        np.testing.assert_allclose(delta * near, 1.0, rtol=1e-9)  # n / Z is 1 on the portal
        assert abs(camera.forward @ side.normal + 1.0) < 1e-12
        top = camera.project(side.corner + 0.5 * side.right)
        assert top[1] == pytest.approx(-0.5, abs=1e-6)  # and it stands upright
        assert side.corner[2] == pytest.approx(side.portal.corners[:, 2].max())


def test_texels_are_square_and_as_many_as_asked() -> None:
    for side in sides():
        camera, _ = reference_camera(side, semicircle_eyes(side, PlacementOptions())[0],
                                     PlacementOptions(texels=256))  # fmt: skip
        area = np.linalg.norm(side.right) * np.linalg.norm(side.down)
        wanted = 256**2 * max(1.0, area / 2.0)
        assert camera.width * camera.height == pytest.approx(wanted, rel=0.02)
        a, b = camera.matrix[:, 0], camera.matrix[:, 1]
        assert np.linalg.norm(a) == pytest.approx(np.linalg.norm(b), rel=0.01)


def test_a_well_in_the_floor_has_references_too() -> None:
    well = np.array([[1, 1, 2.65], [3, 1, 2.65], [3, 2, 2.65], [1, 2, 2.65]], dtype=float)
    side = Side(Portal("well", "opening", well, (1, 0)), 0, 0.0)  # seen from below
    assert side.normal[2] == pytest.approx(-1.0)
    for eye in semicircle_eyes(side, PlacementOptions()):
        camera, near = reference_camera(side, eye, PlacementOptions())
        assert near > 0.0
        assert camera.forward[2] == pytest.approx(1.0)


def test_a_window_to_the_outside_has_no_references() -> None:
    graph = three_rooms()
    assert [side.cell for side in sides_of(graph.portals[0], graph.cells)] == [0, 1]
    window = upright("window", "x", 9.3, (1, 3), (0.8, 2.0), (1, OUTSIDE), "window")
    assert sides_of(window, graph.cells) == ()


def test_an_eye_behind_the_portal_is_refused() -> None:
    side = sides()[0]
    with pytest.raises(CameraError):
        reference_camera(side, side.portal.center - side.normal, PlacementOptions())


@pytest.mark.parametrize(
    ("name", "value"),
    [("count", 0), ("span_deg", 175.0), ("radius", 0.0), ("texels", 4), ("eye", float("nan"))],
)
def test_placement_of_no_use_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        PlacementOptions(**{name: value})  # type: ignore[arg-type]
