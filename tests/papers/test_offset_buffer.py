"""Numbers that spec offset-buffer-warping promises, section 6. The laws themselves: tests/warp."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.warp import OffsetOptions, SplatOptions, prepare, warp
from tests.oracles.city import City
from tests.oracles.warp import psnr

pytestmark = pytest.mark.slow


def above_the_city(angle: float, width: int = 160, height: int = 120) -> Camera:
    eye = (14 * np.sin(angle), -14 * np.cos(angle), 7.0)
    return Camera.look_at(eye, (0, 0, 0.5), fov_deg=45, width=width, height=height)


def test_6_1_the_detector_finds_the_edges_between_blocks_and_no_others() -> None:
    """Recall and precision of cut links, against finer rays; measured 1.000 and 0.98."""
    found = missed = false = 0
    for seed in range(4):
        city = City(seed)
        camera = above_the_city(0.4 * seed)
        view = city.photograph(camera, rays=1)
        u, v = np.broadcast_arrays(*camera.pixel_grid())
        # truth: along 32 steps from pixel to pixel, does disparity jump somewhere?
        steps = np.stack([city.look(camera, u[:, :-1] + k / 32, v[:, :-1])[1] for k in range(33)])
        jump = np.abs(np.diff(steps, axis=0)).max(axis=0) / steps.max(axis=0)
        edge, smooth = jump > 0.06, jump < 0.02
        # sampled well enough to be known for one surface: two more steps on either side are smooth
        whole = smooth[:, 2:-2] & smooth[:, :-4] & smooth[:, 1:-3] & smooth[:, 3:-1] & smooth[:, 4:]
        cut = (prepare(view).links()[:, :-1] & 1) == 0
        # a jump there and back within one pixel cannot be known from its ends
        same_again = np.abs(steps[0] - steps[-1]) < 0.05 * steps[0]
        found += int((cut & edge).sum())
        missed += int((~cut & edge & ~same_again).sum())
        false += int((cut[:, 2:-2] & whole).sum())
    assert found > 500
    assert found / (found + missed) >= 0.99
    assert found / (found + false) >= 0.95


CHOICES: dict[str, dict[str, Any]] = {
    "offset": {"reconstruction": "offset"},
    "no offsets": {"reconstruction": "offset", "offset": OffsetOptions(offset_bits=0)},
    "splat 3x3": {"reconstruction": "splat", "splat": SplatOptions(size=3)},
    "mesh": {"reconstruction": "mesh"},
}


@pytest.fixture(scope="module")
def city_scores() -> dict[str, float]:
    """PSNR of each choice against 64 rays a pixel, where both of two references see the point."""
    totals = dict.fromkeys(CHOICES, 0.0)
    for seed in range(2):
        city = City(seed)
        truth = city.photograph(above_the_city(0.03))
        views = [city.photograph(above_the_city(a)) for a in (-0.12, 0.12)]
        frames = {name: warp(views, truth.camera, **one) for name, one in CHOICES.items()}
        doubly = np.logical_and.reduce(
            [warp(v, truth.camera, **one).coverage > 0 for v in views for one in CHOICES.values()]
        )
        assert doubly.mean() > 0.5
        for name, frame in frames.items():
            totals[name] += psnr(frame.color, truth.color, doubly) / 2
    return totals


def test_6_3_offsets_beat_no_offsets_and_those_beat_splats(city_scores: dict[str, float]) -> None:
    assert city_scores["offset"] > city_scores["no offsets"] > city_scores["splat 3x3"]


def test_6_3_offset_is_as_good_as_the_mesh(city_scores: dict[str, float]) -> None:
    """The spec asks for half a decibel; bicubic sub-samples put it 0.6 dB above (30.00, 29.38)."""
    assert city_scores["offset"] >= city_scores["mesh"] - 0.5
    assert city_scores["offset"] >= 29.9


def cones(shared_data: Path, source: str) -> tuple[ReferenceView, Camera, np.ndarray]:
    """One picture of the rectified pair with its true disparity, the other's camera and pixels."""
    folder = shared_data / "stereo-middlebury-cones"
    if not folder.is_dir():
        pytest.skip("no stereo-middlebury-cones in the test data")
    other = {"left": "right", "right": "left"}[source]
    color, truth = (
        np.asarray(Image.open(folder / f"{side}.png").convert("RGB")) for side in (source, other)
    )
    pixels = np.abs(np.asarray(Image.open(folder / f"disp_{source}.tif"), np.float32))
    height, width = pixels.shape
    focal, baseline = 900.0, 0.16  # any: the picture is the same
    k = [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]
    camera = Camera.from_intrinsics(k, np.eye(4), width, height)
    disparity = np.where(pixels > 0, pixels / (focal * baseline), np.nan)
    step = baseline if source == "left" else -baseline
    return (
        ReferenceView(camera, np.ascontiguousarray(color), disparity.astype(np.float32)),
        camera.moved((step, 0, 0)),
        truth,
    )


@pytest.mark.parametrize(
    ("source", "point", "offset", "mesh"),
    [("left", 27.62, 29.04, 28.55), ("right", 27.53, 28.85, 28.14)],
)
def test_on_a_real_pair_with_true_disparity_offset_beats_point(
    shared_data: Path, source: str, point: float, offset: float, mesh: float
) -> None:
    """PSNR of one picture from the other on pixels that both cover, as measured (450 x 375)."""
    view, camera, truth = cones(shared_data, source)
    frames: dict[str, Frame] = {
        r: warp(view, camera, reconstruction=r) for r in ("point", "offset", "mesh")
    }
    both = (frames["point"].coverage > 0) & (frames["offset"].coverage > 0)
    scores = {r: psnr(frame.color, truth, both) for r, frame in frames.items()}
    assert scores["point"] == pytest.approx(point, abs=0.1)
    assert scores["offset"] >= offset - 0.1
    assert scores["mesh"] >= mesh - 0.1
    assert scores["offset"] - scores["point"] >= 1.0


def flicker(reconstruction: Any, tolerance: float) -> float:
    """Mean square change of a pixel from frame to frame while the eye creeps along a noisy wall.

    The nearest reference stays the same one, so that only the z-buffer can swap them.
    """
    rng = np.random.default_rng(5)
    width, height, focal = 96, 72, 96.0
    k = [[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]]
    home = Camera.from_intrinsics(k, np.eye(4), width, height)
    grain = rng.uniform(0.0, 1.0, (600, 600)).astype(np.float32)
    views = []
    for center in ((-0.31, 0.02, 0.0), (0.5, -0.03, 0.1)):  # the wall is at 4 metres
        camera = home.moved(center)
        disparity = np.full((height, width), 1.0 / (4.0 - center[2]))
        points = camera.unproject(*camera.pixel_grid(), disparity)
        cells = np.floor((points[..., :2] + 6.0) / 0.03).astype(int)
        color = np.repeat(grain[cells[..., 1], cells[..., 0]][..., None], 3, axis=-1)
        disparity *= 1.0 + 0.004 * rng.normal(size=disparity.shape)
        views.append(ReferenceView(camera, color, disparity.astype(np.float32)))
    frames = []
    for step in range(12):  # a twentieth of a pixel each
        camera = home.moved((-0.25 + step * 0.05 * 4.0 / focal, 0.01, 0.003 * step))
        frames.append(warp(views, camera, reconstruction=reconstruction, composite="fuzzy",
                           surface_tolerance=tolerance))  # fmt: skip
    inside = np.s_[8:-8, 20:-20, 0]
    changes = [b.color[inside] - a.color[inside] for a, b in itertools.pairwise(frames)]
    return float(np.mean(np.square(changes)))


@pytest.mark.parametrize(
    ("reconstruction", "share"), [("mesh", 0.3), ("offset", 0.4), ("splat", 0.8)]
)
def test_6_5_a_fuzzy_z_buffer_flickers_less_than_a_hard_one(
    reconstruction: Any, share: float
) -> None:
    """Two references with depths jittered by 0.4 %. Measured: 0.21, 0.32 and 0.73 of the hard
    z-buffer's flicker."""
    assert flicker(reconstruction, 0.03) < share * flicker(reconstruction, 0.0)


def test_6_6_nine_references_leave_under_one_per_cent_of_holes_within_twenty_degrees() -> None:
    city = City(3)
    angles = np.linspace(-1.2, 1.2, 9)  # 17 degrees apart
    views = [prepare(city.photograph(above_the_city(a, 120, 90), rays=1)) for a in angles]
    for angle in np.linspace(-1.1, 1.1, 12):
        frame = warp(views, above_the_city(angle, 120, 90), reconstruction="offset")
        assert frame.hole_fraction < 0.01
