"""Small copies of an evaluation's pictures, as data URIs that fit a page of a few megabytes."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from belvedere.ground.color import SRGB8_TO_LINEAR, color_to_srgb8, encode_srgb8
from belvedere.ground.threads import run_parallel
from belvedere.scene.view import Color, Frame
from belvedere.studio.difference import coverage_picture, signed_difference
from belvedere.studio.evaluate import truth_mask
from belvedere.studio.scores import ViewScore

U1 = npt.NDArray[np.uint8]

PICTURE_BYTES = 4_000_000
"""Bytes of all pictures together before base64 makes 4/3 of them: a page of some 5.4 MB."""
MAX_VIEWS = 24
"""Views whose pictures are shown; of more, this many are taken evenly."""
QUALITIES = (86, 78, 68, 56, 44, 32)
"""WebP qualities, tried until a picture fits its share."""
SMALLEST = 160
"""Pixels across below which a picture is of no use."""
WIDTHS = ((40, 800), (100, 640), (200, 480), (10**9, 360))
"""Pictures on the page, at most: pixels across of each."""


@dataclass(eq=False)
class ViewPictures:
    """One held-out view's pictures, each a data URI."""

    width: int
    """Pixels across, as embedded."""
    height: int
    truth: str
    ways: dict[str, dict[str, str]] = field(default_factory=dict)
    """By reconstruction: ``prediction`` (holes filled), ``difference``, ``coverage``."""


class PictureCollector:
    """An observer of `evaluate` that keeps small pictures and lets the large ones go.

    Memory: the encoded pictures, `PICTURE_BYTES` in all.
    """

    def __init__(self, names: Sequence[str], ways: int, gain: float = 2.0) -> None:
        """Plan for the held-out views ``names``, each predicted in ``ways`` ways."""
        shown = list(names)
        if len(shown) > MAX_VIEWS:
            places = np.unique(np.linspace(0, len(shown) - 1, MAX_VIEWS).round().astype(int))
            shown = [shown[place] for place in places]
        self.shown = tuple(shown)
        """Names of the views whose pictures are kept."""
        self.gain = gain
        """How much the difference pictures enlarge differences."""
        self.views: dict[str, ViewPictures] = {}
        count = max(len(shown), 1) * (1 + 3 * ways)
        self._share = PICTURE_BYTES // count
        self._width = next(width for most, width in WIDTHS if count <= most)

    def __call__(self, score: ViewScore, truth: Color, frame: Frame) -> None:
        """Keep the pictures of one prediction (see `belvedere.studio.evaluate.Observer`)."""
        if score.view not in self.shown:
            return
        if score.view not in self.views:
            small = shrink(color_to_srgb8(truth)[..., :3], self._width)
            height, width = small.shape[:2]
            self.views[score.view] = ViewPictures(width, height, data_uri(small, self._share))
        known = (frame.coverage > 0) & truth_mask(truth)
        make = {
            "prediction": lambda: color_to_srgb8(frame.color)[..., :3],
            "difference": lambda: signed_difference(frame.color, truth, known, self.gain),
            "coverage": lambda: coverage_picture(frame.color, frame.coverage),
        }
        encoded = run_parallel(
            lambda kind: data_uri(shrink(make[kind](), self._width), self._share), list(make)
        )
        ways = self.views[score.view].ways
        ways[score.reconstruction] = dict(zip(make, encoded, strict=True))


def shrink(picture: U1, width: int) -> U1:
    """``picture`` at most ``width`` pixels across; averages are taken in linear light."""
    from PIL import Image

    if picture.shape[1] <= width:
        return picture
    height = max(round(picture.shape[0] * width / picture.shape[1]), 1)
    linear = SRGB8_TO_LINEAR[picture]
    planes = [
        np.asarray(
            Image.fromarray(np.ascontiguousarray(linear[..., channel])).resize(
                (width, height), Image.Resampling.BOX
            )
        )
        for channel in range(3)
    ]
    return encode_srgb8(np.stack(planes, axis=-1))


def data_uri(picture: U1, most_bytes: int) -> str:
    """A WebP data URI of at most ``most_bytes`` before base64, coarser and then smaller to fit.

    Pictures of `SMALLEST` pixels across are kept even if they do not fit.
    """
    from PIL import Image

    while True:
        image = Image.fromarray(np.ascontiguousarray(picture))
        data = b""
        for quality in QUALITIES:
            buffer = io.BytesIO()
            image.save(buffer, "WEBP", quality=quality, method=2)
            data = buffer.getvalue()
            if len(data) <= most_bytes:
                break
        if len(data) <= most_bytes or image.width <= SMALLEST:
            return "data:image/webp;base64," + base64.b64encode(data).decode("ascii")
        picture = shrink(picture, max(image.width * 2 // 3, SMALLEST))
