"""From what a format says about a picture to a view of ours. Every reader ends here."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import BelvedereError, FileFormatError, SceneError
from belvedere.scene.camera import Camera
from belvedere.scene.conventions import Conventions
from belvedere.scene.io.depth import read_depth_values
from belvedere.scene.io.images import read_color
from belvedere.scene.io.json_files import JsonObject
from belvedere.scene.io.lens import Crop, Lens, shifted_lens, undistorted
from belvedere.scene.io.limits import sniff
from belvedere.scene.view import Color, ReferenceView
from belvedere.scene.views import ViewEntry, ViewSet

INFINITY_KEY = "belvedere_depth_infinity"
"""JSON key: the stored depth that means "infinitely far", a number or the text "inf"."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One picture as a format describes it: numbers in the format's own conventions."""

    where: str
    """Who says so, for messages: ``transforms.json: frames[3]``."""
    name: str
    color: Path
    depth: Path | None
    K: npt.NDArray[np.float64]
    """(3, 3) as stored."""
    pose: npt.NDArray[np.float64]
    """(4, 4) as stored."""
    width: int
    height: int
    lens: Lens | None = None
    """Its distortion, principal point as stored; None for a straight lens."""
    depth_offset: float = 0.0
    """Added to every stored number that is a sample (a stereo pair's ``doffs``)."""


def build_views(
    pictures: Iterable[Picture],
    conventions: Conventions,
    facts: dict[str, Any],
    infinity: float | None = None,
) -> ViewSet:
    """A lazily loaded set of views from a format's pictures.

    Args:
        pictures: what the format lists, in its order.
        conventions: how the stored numbers are to be read; ``depth_scale`` is stated.
        facts: what the reader found out; format, counts, conventions and crops are added.
        infinity: the stored depth that means "infinitely far", where the format has one.

    Raises:
        SceneError: no picture, a camera that cannot be, two pictures of one name.
    """
    entries: list[ViewEntry] = []
    crops: dict[str, Any] = {}
    first: dict[str, str] = {}
    for picture in pictures:
        if picture.name in first:
            raise SceneError(
                f"{picture.where}: the name {picture.name!r} is that of {first[picture.name]} "
                "already: two frames show one picture; remove or rename one"
            )
        first[picture.name] = picture.where
        crop = _crop(picture, conventions)
        if crop is not None:
            crops[picture.name] = crop.as_fact()
        entries.append(_entry(picture, crop, conventions, infinity))
    if not entries:
        raise SceneError(f"{facts.get('path', 'scene')}: lists no pictures, expected at least one")
    with_depth = sum(entry.has_depth for entry in entries)
    if not with_depth:
        facts = {key: value for key, value in facts.items() if not key.startswith("depth_scale")}
    found = {"frames": len(entries), "frames_with_depth": with_depth,
             "conventions": asdict(conventions)}  # fmt: skip
    if crops:
        found["undistorted"] = crops
    return ViewSet(tuple(entries), {**facts, **found})


def view_names(paths: list[str]) -> list[str]:
    """A name for each picture: its file's stem, or its whole path where stems repeat."""
    stems = [path.rsplit("/", 1)[-1].rsplit(".", 1)[0] or path for path in paths]
    return stems if len(set(stems)) == len(stems) else list(paths)


def default_scale(sample: Path | None) -> tuple[float, str]:
    """Metres per stored number where a scene does not say, by its first depth map; and why."""
    if sample is not None and sniff(sample) in ("exr", "pfm", "npy", "colmap"):
        return 1.0, "the default for float depth: metres"
    return 0.001, "the default for whole numbers: millimetres"


def stored_infinity(root: JsonObject) -> float | None:
    """The stored depth that means "infinitely far", where the scene says so."""
    if INFINITY_KEY not in root:
        return None
    if root.data[INFINITY_KEY] == "inf":
        return math.inf
    return root.number(INFINITY_KEY, above=0.0)


def _crop(picture: Picture, conventions: Conventions) -> Crop | None:
    lens = picture.lens
    if lens is None or lens.straight:
        return None
    if conventions.pixel_centers == "half":
        lens = shifted_lens(lens, -0.5)
    return undistorted(lens, picture.where)


def _entry(
    picture: Picture, crop: Crop | None, conventions: Conventions, infinity: float | None
) -> ViewEntry:
    try:
        if crop is None:
            camera = conventions.read_camera(picture.K, picture.pose, picture.width, picture.height)
        else:  # the crop's K is ours already
            ours = replace(conventions, pixel_centers="integer")
            camera = ours.read_camera(crop.intrinsics, picture.pose, crop.width, crop.height)
    except BelvedereError as error:
        raise SceneError(f"{picture.where}: {error}") from error

    def load_color() -> Color:
        return _load_color(picture, crop)

    def load() -> ReferenceView:
        return _load(picture, crop, camera, conventions, infinity)

    has_depth = picture.depth is not None
    return ViewEntry(picture.name, camera, has_depth, load_color, load if has_depth else None)


def _load_color(picture: Picture, crop: Crop | None) -> Color:
    color = read_color(picture.color)
    _check_size(picture.color, color.shape[:2], picture)
    return color if crop is None else crop.color(color)


def _load(
    picture: Picture,
    crop: Crop | None,
    camera: Camera,
    conventions: Conventions,
    infinity: float | None,
) -> ReferenceView:
    assert picture.depth is not None
    color = _load_color(picture, crop)
    stored = read_depth_values(picture.depth)
    _check_size(picture.depth, stored.shape, picture)
    if crop is not None:
        stored = crop.depth(stored)
    far = None if infinity is None else stored == np.float32(infinity)
    if picture.depth_offset:
        stored = np.where(stored > 0, stored + np.float32(picture.depth_offset), stored)
    disparity = conventions.read_disparity(stored, camera)
    if far is not None:
        disparity[far] = 0.0
    return ReferenceView(camera, color, disparity)


def _check_size(path: Path, shape: tuple[int, ...], picture: Picture) -> None:
    if tuple(shape) != (picture.height, picture.width):
        raise FileFormatError(
            f"{path}: is {shape[1]} x {shape[0]} pixels, but its camera ({picture.where}) has "
            f"{picture.width} x {picture.height}: resize it, or scale the camera with it"
        )
