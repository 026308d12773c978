"""When a portal shows pictures."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.ground.errors import InputError
from belvedere.walkthrough import Switches, SwitchOptions
from belvedere.walkthrough.switching import closeness
from tests.walkthrough.graphs import three_rooms

DOOR = three_rooms().portals[1]  # one metre wide, in the plane y = 4.47


def eye_before(distance: float) -> np.ndarray:
    return np.array([1.65, 4.47 - distance, 1.6])


def test_geometry_begins_where_the_width_or_the_angle_says() -> None:
    options = SwitchOptions(angle_deg=60.0, widths=0.75)
    angle_at = 0.5 / np.tan(np.radians(30.0))  # here a metre subtends 60 degrees
    assert closeness(DOOR, eye_before(angle_at * 1.01), options) < 1.0
    assert closeness(DOOR, eye_before(angle_at * 0.99), options) > 1.0
    only_widths = SwitchOptions(angle_deg=179.0, widths=2.0)
    assert closeness(DOOR, eye_before(2.01), only_widths) < 1.0
    assert closeness(DOOR, eye_before(1.99), only_widths) > 1.0


def test_the_distance_is_to_the_nearest_point_of_the_portal() -> None:
    options = SwitchOptions(angle_deg=179.0, widths=1.0, slant_deg=90.0)
    aside = np.array([2.15 + 0.6, 4.47 - 0.8, 1.6])  # a 3-4-5 triangle away from the jamb
    assert closeness(DOOR, aside, options) == pytest.approx(1.0)


def test_pictures_come_back_only_farther_off() -> None:
    switches = Switches((DOOR,), SwitchOptions(angle_deg=179.0, widths=1.0, hysteresis=1.5, fade=0))
    shown = []
    for distance in (1.1, 0.9, 1.1, 1.4, 1.6, 1.4, 1.1):
        switches.update(eye_before(distance))
        shown.append(bool(switches.geometry[0]))
    assert shown == [False, True, True, True, False, False, False]


def test_the_change_takes_the_stated_frames() -> None:
    switches = Switches((DOOR,), SwitchOptions(fade=3))
    switches.update(eye_before(3.0))
    shares = []
    for _ in range(6):
        switches.update(eye_before(0.3))
        shares.append(float(switches.share[0]))
    np.testing.assert_allclose(shares, [0.25, 0.5, 0.75, 1.0, 1.0, 1.0])
    switches.reset()
    switches.update(eye_before(0.3))
    assert switches.share[0] == 1.0  # a jump does not fade


@pytest.mark.parametrize(
    ("name", "value"), [("angle_deg", 0.0), ("hysteresis", 0.9), ("fade", -1), ("widths", -1.0)]
)
def test_switches_of_no_use_are_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        SwitchOptions(**{name: value})  # type: ignore[arg-type]
