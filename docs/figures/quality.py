"""Quality against time: ours and its rivals, as dots."""

from __future__ import annotations

import math
from typing import NamedTuple

from pen import FAINT, INK, ORANGE, SOFT, TEAL, Pen


class Dot(NamedTuple):
    """One way to make the picture, as ``belvedere bench warp`` measured it."""

    name: str
    ms: float
    psnr: float
    ours: bool = False
    side: str = "right"
    """Where its name stands."""


MEASURED = (
    Dot("inverse (default)", 12.8, 35.90, ours=True),
    Dot("offset", 27.4, 34.35, ours=True),
    Dot("mesh", 19.4, 33.02, ours=True),
    Dot("gaussian", 34.9, 32.31, ours=True, side="left"),
    Dot("splat", 2.7, 31.54, ours=True),
    Dot("point", 1.3, 30.88, ours=True),
    Dot("C point warp (one thread)", 1.6, 30.05),
    Dot("OpenCV registerDepth", 17.3, 31.83),
    Dot("Open3D point cloud", 14.7, 30.05),
    Dot("OpenCV mesh", 66, 30.86, side="left"),
    Dot("Embree mesh", 88, 30.86),
    Dot("softmax splatting", 47, 32.56),
    Dot("inverse-bilinear splatting", 56, 31.58),
)
"""Milliseconds, the median of 12 warm runs that took turns, on two cores of a shared AMD EPYC
server; and PSNR in dB: two references to one picture, 512 x 512, mean of three stations."""


def against_time() -> str:
    """Upwards is better, leftwards is faster."""
    pen = Pen(720, 440, "PSNR against milliseconds: our reconstructors and other ways.")
    left, right, top, bottom = 70.0, 690.0, 56.0, 372.0

    def at(ms: float, psnr: float) -> tuple[float, float]:
        along = math.log10(ms / 1.3) / math.log10(400 / 1.3)
        return left + along * (right - left), bottom - (psnr - 29.5) / 7.0 * (bottom - top)

    pen.text((20, 30), "Two references to one 512 x 512 picture", INK, 16, weight="bold")
    for ms in (2, 5, 10, 20, 50, 100, 200):
        x, _ = at(ms, 30)
        pen.line([(x, top), (x, bottom)], FAINT, 1)
        pen.text((x, bottom + 20), f"{ms:g}", SOFT, 13, "middle")
    pen.text(((left + right) / 2, bottom + 42), "milliseconds, two threads", SOFT, 13, "middle")
    for psnr in range(30, 37):
        _, y = at(10, psnr)
        pen.line([(left, y), (right, y)], FAINT, 1)
        pen.text((left - 10, y + 4), f"{psnr} dB", SOFT, 13, "end")
    for dot in MEASURED:
        x, y = at(dot.ms, dot.psnr)
        color = TEAL if dot.ours else ORANGE
        pen.dot((x, y), color, 7 if dot.ours else 5.5)
        place, anchor = {
            "right": ((x + 12, y + 5), "start"),
            "left": ((x - 12, y + 5), "end"),
            "below": ((x, y + 22), "middle"),
        }[dot.side]
        pen.text(place, dot.name, color, 13, anchor, "bold" if dot.ours else "normal")
    pen.dot((450, 26), TEAL, 6)
    pen.text((462, 31), "belvedere", TEAL, 13, weight="bold")
    pen.dot((560, 26), ORANGE, 5.5)
    pen.text((572, 31), "other libraries", ORANGE, 13)
    return pen.sheet()
