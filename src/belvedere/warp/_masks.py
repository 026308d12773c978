"""Steps of kernels that find which sixteenths of a pixel a cell at an edge covers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import bits16, bits_of, load16
from belvedere.warp._quads import SLACK, SURE, UNSURE, is_cut, marked

F4 = npt.NDArray[np.float32]
U2 = npt.NDArray[np.uint16]

ZERO = np.float32(0.0)
HALF = np.float32(0.5)
ONE = np.float32(1.0)


@inner
def up(x: Real) -> int:
    """The whole number next above, of x >= 0; `np.ceil` of one number is a function call."""
    whole = int(x)
    return whole + 1 if np.float32(whole) < x else whole


@inner
def note_part(
    x: int, row: int, bits: Real, z: Real, z_high: Real, keep: Real, mark: Real, out_edge: F4,
    out_mask: U2,
) -> None:  # fmt: skip
    """Add what a cell covers of one pixel to what is known of its nearest surface there."""
    held = out_edge[row, x]
    if bits == 0:  # too thin for a place, but an edge does run through the pixel
        if mark == UNSURE and z_high >= held * keep:
            if held < ZERO:
                out_mask[row, x] = 0
                held = z
            out_edge[row, x] = marked(held, mark)
    elif z * keep > held:
        out_edge[row, x] = marked(z, mark)
        out_mask[row, x] = bits
    elif z >= held * keep:
        out_edge[row, x] = marked(max(z, held), mark | (bits_of(held) & UNSURE))
        out_mask[row, x] |= bits


@inner
def mask_quad(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    xd: Real, yd: Real, width: int, row_low: int, first: int, end: int, keep: Real, mark: Real,
    steps: F4, out_edge: F4, out_mask: U2,
) -> None:  # fmt: skip
    """Which of sixteen places in each pixel a cell covers, of the nearest surface there.

    A surface that is clearly nearer than what the pixel holds starts its mask anew; one clearly
    behind leaves no trace. Corners are a, b above and c, d below; disparity is that of the plane
    through a, b and c, at the pixel's centre or the nearest corner. It is marked `UNSURE` as soon
    as a part of a broken cell is among what the pixel holds: else no edge runs through it, and an
    intact cell leaves it alone. steps is (4, 16) to work in.
    """
    bx, by, cx, cy = xb - xa, yb - ya, xc - xa, yc - ya
    area = bx * cy - cx * by
    if not area > ZERO or not (xd - xc) * (yd - yb) - (xd - xb) * (yd - yc) > ZERO:
        return
    x_high, y_high = max(xa, xb, xc, xd) + HALF, max(ya, yb, yc, yd) + HALF
    if x_high < ZERO or y_high < ZERO:
        return
    left = up(max(min(xa, xb, xc, xd) - HALF, ZERO))
    right = int(min(x_high, np.float32(width - 1)))
    top = up(max(min(ya, yb, yc, yd) - HALF, np.float32(first)))
    bottom = int(min(y_high, np.float32(end - 1)))
    if mark == SURE:
        cut = False
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                cut |= is_cut(out_edge[y - row_low, x])
        if not cut:
            return
    scale = ONE / area
    zb, zc = zb - za, zc - za
    z_low, z_high = min(za, za + zb, za + zc, za + zb + zc), max(za, za + zb, za + zc, za + zb + zc)
    # edges a to b, b to d, d to c, c to a: inside is to the right of each
    dx, dy, ex, ey = xd - xb, yd - yb, xc - xd, yc - yd
    slack = SLACK * area
    for k in range(16):  # from the pixel's centre to its places, along the normals of the edges
        mirrored = (k & 1) * 8 + (k & 2) * 2 + (k & 4) // 2 + (k & 8) // 8
        ox = (np.float32(k) - np.float32(7.5)) * np.float32(0.0625)
        oy = (np.float32(mirrored) - np.float32(7.5)) * np.float32(0.0625)
        steps[0, k], steps[1, k] = bx * oy - by * ox, dx * oy - dy * ox
        steps[2, k], steps[3, k] = ex * oy - ey * ox, cy * ox - cx * oy
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            if mark == SURE and not is_cut(out_edge[y - row_low, x]):
                continue
            px, py = np.float32(x) - xa, np.float32(y) - ya
            qx, qy = np.float32(x) - xd, np.float32(y) - yd
            above, beside = bx * py - by * px - slack, dx * qy - dy * qx - slack
            below, before = ex * qy - ey * qx - slack, cy * px - cx * py - slack
            bits = np.uint32(bits16(load16(steps, 0), -above) & bits16(load16(steps, 4), -beside))
            bits = np.uint32(bits & bits16(load16(steps, 8), -below))
            bits = np.uint32(bits & bits16(load16(steps, 12), -before))
            wb, wc = (px * cy - cx * py) * scale, (bx * py - px * by) * scale
            z = max(min(max(za + wb * zb + wc * zc, z_low), z_high), ZERO)
            note_part(x, y - row_low, bits, z, z_high, keep, mark, out_edge, out_mask)
