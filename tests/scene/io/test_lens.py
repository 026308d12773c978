"""Undistorting: every pixel shows what the straight camera would see there."""

from __future__ import annotations

import sys

import numpy as np
import numpy.typing as npt
import pytest

from belvedere.ground.errors import MissingDependencyError, SceneError
from belvedere.scene.io.lens import Crop, Lens, undistorted

F8 = npt.NDArray[np.float64]
WIDTH, HEIGHT = 97, 71
BASE = {"width": WIDTH, "height": HEIGHT, "fx": 80.0, "fy": 82.0, "cx": 47.3, "cy": 36.1}
LENSES = {
    "barrel": Lens(**BASE, coefficients=(-0.2, 0.05, 0.0, 0.0)),
    "pincushion": Lens(**BASE, coefficients=(0.15, 0.02, 0.0, 0.0)),
    "tangential": Lens(**BASE, coefficients=(-0.1, 0.02, 0.003, -0.004, 0.01)),
    "rational": Lens(**BASE, coefficients=(0.1, 0.02, 0.001, 0.001, 0.01, 0.2, 0.03, 0.01)),
    "fisheye": Lens(**BASE, coefficients=(0.02, -0.01, 0.003, 0.0), fisheye=True),
}


def distorted_position(lens: Lens, u: F8, v: F8) -> tuple[F8, F8]:
    """Where the lens shows what a straight camera shows at (u, v): OpenCV's formulae, by hand."""
    x, y = (u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy
    r2 = x * x + y * y
    c = [*lens.coefficients, *[0.0] * 8]
    if lens.fisheye:
        r = np.sqrt(np.maximum(r2, 1e-30))
        theta = np.arctan(r)
        bent = theta * (1 + c[0] * theta**2 + c[1] * theta**4 + c[2] * theta**6 + c[3] * theta**8)
        x, y = x * bent / r, y * bent / r
    else:
        radial = (1 + c[0] * r2 + c[1] * r2**2 + c[4] * r2**3) / (
            1 + c[5] * r2 + c[6] * r2**2 + c[7] * r2**3
        )
        x, y = (
            x * radial + 2 * c[2] * x * y + c[3] * (r2 + 2 * x * x),
            y * radial + c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y,
        )
    return x * lens.fx + lens.cx, y * lens.fy + lens.cy


def positions(crop: Crop) -> tuple[F8, F8]:
    v, u = np.mgrid[0 : crop.height, 0 : crop.width].astype(np.float64)
    return distorted_position(crop.lens, u + crop.left, v + crop.top)


@pytest.mark.parametrize("name", LENSES)
def test_a_picture_of_its_own_coordinates_is_moved_where_the_formula_says(name: str) -> None:
    crop = undistorted(LENSES[name])
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    straight = crop.color(np.stack([columns, rows, np.zeros_like(rows)], axis=-1))
    x, y = positions(crop)
    np.testing.assert_allclose(straight[..., 0], x, atol=0.05)  # cv2 interpolates in 1/32 pixel
    np.testing.assert_allclose(straight[..., 1], y, atol=0.05)


@pytest.mark.parametrize("name", LENSES)
def test_depth_is_taken_from_the_nearest_sample_and_never_blended(name: str) -> None:
    crop = undistorted(LENSES[name])
    index = np.arange(HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    x, y = positions(crop)
    taken = crop.depth(index).astype(int)
    assert np.abs(taken % WIDTH - x).max() <= 0.501
    assert np.abs(taken // WIDTH - y).max() <= 0.501


@pytest.mark.parametrize("name", LENSES)
def test_every_pixel_of_the_crop_is_known_and_no_side_can_grow(name: str) -> None:
    crop = undistorted(LENSES[name])

    def known(left: int, top: int, width: int, height: int) -> bool:
        v, u = np.mgrid[0:height, 0:width].astype(np.float64)
        x, y = distorted_position(crop.lens, u + left, v + top)
        inside = (x > -1e-3) & (x < WIDTH - 1 + 1e-3) & (y > -1e-3) & (y < HEIGHT - 1 + 1e-3)
        return bool(inside.all())

    left, top, width, height = crop.left, crop.top, crop.width, crop.height
    assert known(left, top, width, height)
    assert not known(left - 1, top, width + 1, height)
    assert not known(left, top - 1, width, height + 1)
    assert not known(left, top, width + 1, height)
    assert not known(left, top, width, height + 1)
    assert crop.as_fact() == {"from": [WIDTH, HEIGHT], "to": [width, height], "left": left,
                              "top": top}  # fmt: skip


def test_the_crop_is_nearly_the_largest_there_is() -> None:
    """Against every rectangle round the principal point, on a coarse grid."""
    lens = LENSES["barrel"]
    crop = undistorted(lens)
    lefts, tops = np.arange(-40, 40, 4.0), np.arange(-30, 30, 4.0)
    left, top, right, bottom = np.meshgrid(
        lefts, tops, lefts + WIDTH - 1, tops + HEIGHT - 1, indexing="ij"
    )
    u = np.stack([left, right, left, right, left * 0 + lens.cx, left * 0 + lens.cx, left, right])
    v = np.stack([top, top, bottom, bottom, top, bottom, top * 0 + lens.cy, top * 0 + lens.cy])
    x, y = distorted_position(lens, u, v)
    fits = (x >= 0).all(0) & (y >= 0).all(0) & (x <= WIDTH - 1).all(0) & (y <= HEIGHT - 1).all(0)
    best = ((right - left + 1) * (bottom - top + 1))[fits].max()
    assert crop.width * crop.height >= 0.97 * best


def test_a_constant_picture_stays_constant_in_bytes() -> None:
    crop = undistorted(LENSES["barrel"])
    flat = np.full((HEIGHT, WIDTH, 3), 137, np.uint8)
    out = crop.color(flat)
    assert out.dtype == np.uint8
    assert np.unique(out).tolist() == [137]


def test_a_lens_without_coefficients_is_straight_but_a_fisheye_never_is() -> None:
    assert Lens(**BASE, coefficients=(0.0, 0.0, 0.0, 0.0)).straight
    assert not Lens(**BASE, coefficients=(0.0,) * 4, fisheye=True).straight


def test_coefficients_that_fold_the_picture_are_refused() -> None:
    with pytest.raises(SceneError, match=r"camera 1: the distortion \[-30.0, .* check the coeff"):
        undistorted(Lens(**BASE, coefficients=(-30.0, 0.0, 0.0, 0.0)), "camera 1")


def test_a_missing_opencv_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'belvedere\[undistort\]'"):
        undistorted(Lens(**BASE, coefficients=(-0.123, 0.0, 0.0, 0.0)))
