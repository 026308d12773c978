"""Rendered frames as picture files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from belvedere import Camera, Frame
from belvedere.ground.errors import InputError, OutputError
from belvedere.scene.io import read_color, save_frame
from belvedere.scene.io.depth import read_depth_values
from belvedere.scene.io.exr import read_exr_channels


@pytest.fixture
def frame(rng: np.random.Generator) -> Frame:
    camera = Camera.look_at((0, -2, 1), (0, 0, 1), width=6, height=4)
    color = rng.integers(1, 256, (4, 6, 3), dtype=np.uint8)
    disparity = rng.uniform(0.1, 2, (4, 6)).astype(np.float32)
    coverage = np.ones((4, 6), np.float32)
    color[0, 0], disparity[0, 0], coverage[0, 0] = 0, np.nan, 0
    disparity[1, 1] = 0
    coverage[2, 2] = 0.5
    return Frame(camera, color, disparity, coverage)


@pytest.mark.parametrize("suffix", [".png", ".webp"])
def test_colour_is_saved_as_it_is(tmp_path: Path, frame: Frame, suffix: str) -> None:
    file = save_frame(frame, tmp_path / "new" / f"out{suffix}")
    np.testing.assert_array_equal(read_color(file), frame.color)


@pytest.mark.parametrize("suffix", [".png", ".webp"])
def test_holes_become_transparent_on_request(tmp_path: Path, frame: Frame, suffix: str) -> None:
    with Image.open(save_frame(frame, tmp_path / f"out{suffix}", alpha=True)) as image:
        pixels = np.array(image)
    assert pixels[0, 0].tolist() == [0, 0, 0, 0]
    assert pixels[2, 2, 3] == 128
    assert pixels[3, 3].tolist() == [*frame.color[3, 3], 255]
    assert np.abs(pixels[2, 2, :3].astype(int) - frame.color[2, 2]).max() <= 1


def test_exr_holds_linear_colour_depth_and_coverage(tmp_path: Path, frame: Frame) -> None:
    channels = read_exr_channels(save_frame(frame, tmp_path / "out.exr"))
    assert sorted(channels) == ["B", "G", "R", "Z", "coverage"]
    np.testing.assert_array_equal(channels["coverage"], frame.coverage)
    assert channels["Z"][0, 0] == 0
    assert channels["Z"][1, 1] == np.inf
    np.testing.assert_allclose(channels["Z"][3], 1 / frame.disparity[3], rtol=1e-6)
    np.testing.assert_array_equal(read_depth_values(tmp_path / "out.exr"), channels["Z"])
    assert read_color(tmp_path / "out.exr").dtype == np.float32


def test_a_frame_with_alpha_is_saved_over_black_as_jpeg(tmp_path: Path, frame: Frame) -> None:
    color = np.full((4, 6, 4), 200, np.uint8)
    save_frame(Frame(frame.camera, color, frame.disparity, frame.coverage), tmp_path / "out.jpg")
    back = read_color(tmp_path / "out.jpg")
    assert back.shape == (4, 6, 3)
    assert np.abs(back.astype(int) - 200).max() <= 2


def test_linear_frames_are_encoded_for_the_eye(tmp_path: Path, frame: Frame) -> None:
    linear = np.full((4, 6, 3), 0.5, np.float32)
    save_frame(Frame(frame.camera, linear, frame.disparity, frame.coverage), tmp_path / "out.png")
    assert np.unique(read_color(tmp_path / "out.png")).tolist() == [188]


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("out.tga", {}, "ends in '.tga', expected one of .png"),
        ("out.jpg", {"alpha": True}, "alpha is for .png and .webp"),
        ("out.exr", {"alpha": True}, "holds the coverage as a channel anyway"),
    ],
)
def test_what_cannot_be_saved_is_refused(
    tmp_path: Path, frame: Frame, name: str, options: Any, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        save_frame(frame, tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_picture_is_replaced_only_by_force(tmp_path: Path, frame: Frame) -> None:
    for suffix in (".png", ".exr"):
        file = save_frame(frame, tmp_path / f"out{suffix}")
        before = file.read_bytes()
        with pytest.raises(OutputError, match="--force"):
            save_frame(frame, file)
        save_frame(frame, file, force=True)
        assert file.read_bytes() == before


def test_what_is_no_frame_or_no_path_is_refused() -> None:
    wrong: Any = 3
    with pytest.raises(InputError, match=r"save_frame\.frame is a int, expected a Frame: what a s"):
        save_frame(wrong, "z.png")
    color = np.zeros((1, 1, 3), np.uint8)
    ones = np.ones((1, 1), np.float32)
    made = Frame(Camera.look_at((0, 0, 0), (0, 1, 0), width=1, height=1), color, ones, ones)
    for nothing in (None, 3):
        path: Any = nothing
        with pytest.raises(InputError, match=rf"save_frame\.path is {nothing}, expected the name"):
            save_frame(made, path)
