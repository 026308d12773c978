"""What a frame draws: the clusters in sight, the nearest first, whoever culls them."""

from __future__ import annotations

import numpy as np
import pytest

from belvedere.model import Interior, Rasterizer, _draw_plan
from belvedere.model._draw_plan import DrawPlan
from belvedere.scene import Camera

CAMERA = Camera.look_at((1.2, 1.5, 1.6), (5.0, 2.3, 1.5), fov_deg=60, width=320, height=240)


def test_clusters_come_the_nearest_first_to_a_hundredth(house: Interior) -> None:
    rasterizer = Rasterizer(house)
    plan = DrawPlan(CAMERA, rasterizer.origin, [(rasterizer.prepare(), None)])
    near = plan.near[np.isfinite(plan.near)]
    assert len(near) > 50
    assert (near[1:] <= 1.01 * near[:-1]).all()
    assert not np.isfinite(plan.near[: len(plan.near) - len(near)]).any()  # round the eye


def test_clusters_culled_in_pieces_are_those_culled_at_once(
    house: Interior, monkeypatch: pytest.MonkeyPatch
) -> None:
    rasterizer = Rasterizer(house)
    faces = np.arange(len(house.mesh.faces))
    lists = [(rasterizer.prepare(part), None) for part in np.array_split(faces, 3)]
    whole = DrawPlan(CAMERA, rasterizer.origin, lists)
    monkeypatch.setattr(_draw_plan, "CULLED", 7)
    pieces = DrawPlan(CAMERA, rasterizer.origin, lists, threads=3)
    for name in ("rects", "near", "cluster", "count"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(pieces, name))
    assert whole.parts(0, len(whole.cluster), 1)[0][0] == 0
    assert {part[0] for part in pieces.parts(0, len(pieces.cluster), 1)} == {0, 1, 2}
