"""Kernels of the mesh reconstructor: one small quad per cell of four samples, cut at edges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.warp._edges import intact, joined, slope_toward, usable

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
HALF = np.float32(0.5)
SLACK = np.float32(-1e-5)
"""Barycentric slack of the inside test: neighbouring triangles may both paint a shared edge, but
never leave a pixel between them. Ten float32 roundings."""

LARGEST_QUAD = 64.0
"""Pixels a single cell may grow to. More is not a reconstruction but a guess from one sample, and
would let a sample near the eye paint the whole view."""


@inner
def warp_vertex(w: F4, u: Real, v: Real, delta: Real, n: int, out_quad: F4) -> bool:
    """Write x, y and warped disparity of corner ``n``; False behind the desired camera."""
    u4, v4, d4 = np.float32(u), np.float32(v), np.float32(delta)
    t = w[8] * u4 + w[9] * v4 + w[10] + w[11] * d4
    if not t > np.float32(1e-9):
        return False
    scale = ONE / t
    out_quad[n, 0] = (w[0] * u4 + w[1] * v4 + w[2] + w[3] * d4) * scale
    out_quad[n, 1] = (w[4] * u4 + w[5] * v4 + w[6] + w[7] * d4) * scale
    out_quad[n, 2] = d4 * scale
    return True


@inner
def draw_quad(
    quad: F4, paint: F4, largest: Real, row_low: int, first: int, end: int, by_order: bool,
    out_color: F4, out_disparity: F4,
) -> None:  # fmt: skip
    """Draw two triangles, (0, 1, 2) and (3, 2, 1), at the pixel centres they hold.

    Args:
        quad: (4, 3) x, y, disparity of the corners: upper left, upper right, lower left, lower
            right in the reference.
        paint: (4, 4) their linear colours.
        largest: pixels along each axis beyond which it is not drawn.
        row_low: first row of the band.
        first: first row to paint.
        end: row after the last to paint, within the band.
        by_order: later quads win; otherwise the larger disparity.
        out_color: (rows, width, 4).
        out_disparity: (rows, width), preset to -1.
    """
    width = out_disparity.shape[1]
    x_low = min(quad[0, 0], quad[1, 0], quad[2, 0], quad[3, 0])
    x_high = max(quad[0, 0], quad[1, 0], quad[2, 0], quad[3, 0])
    y_low = min(quad[0, 1], quad[1, 1], quad[2, 1], quad[3, 1])
    y_high = max(quad[0, 1], quad[1, 1], quad[2, 1], quad[3, 1])
    if not (x_high - x_low <= largest and y_high - y_low <= largest):
        return
    if x_high < -ONE or x_low > np.float32(width) or y_high < np.float32(first - 1):
        return
    if y_low > np.float32(end):
        return
    left, right = max(int(np.ceil(x_low - 1e-3)), 0), min(int(np.floor(x_high + 1e-3)), width - 1)
    top = max(int(np.ceil(y_low - 1e-3)), first)
    bottom = min(int(np.floor(y_high + 1e-3)), end - 1)
    if left > right or top > bottom:
        return
    for half in range(2):
        a, b, c = (0, 1, 2) if half == 0 else (3, 2, 1)
        xa, ya, za = quad[a, 0], quad[a, 1], quad[a, 2]
        bx, by = quad[b, 0] - xa, quad[b, 1] - ya
        cx, cy = quad[c, 0] - xa, quad[c, 1] - ya
        area = bx * cy - cx * by
        if not area > ZERO:  # folded over, or edge on
            continue
        scale = ONE / area
        for y in range(top, bottom + 1):
            py = np.float32(y) - ya
            for x in range(left, right + 1):
                px = np.float32(x) - xa
                wb = (px * cy - cx * py) * scale
                wc = (bx * py - px * by) * scale
                if wb < SLACK or wc < SLACK or ONE - wb - wc < SLACK:
                    continue
                wb, wc = max(wb, ZERO), max(wc, ZERO)  # or bright samples would leave dark ones < 0
                wa = max(ONE - wb - wc, ZERO)
                z = wa * za + wb * quad[b, 2] + wc * quad[c, 2]
                if by_order or z > out_disparity[y - row_low, x]:
                    out_disparity[y - row_low, x] = max(z, ZERO)
                    for k in range(4):
                        out_color[y - row_low, x, k] = (
                            wa * paint[a, k] + wb * paint[b, k] + wc * paint[c, k]
                        )


@inner
def whole_cell(
    w: F4, color: F4, disparity: F4, v: int, u: int, out_quad: F4, out_paint: F4
) -> bool:
    """Corners and colours of an intact cell; False if a corner is behind the desired camera."""
    for n in range(4):
        dv, du = n >> 1, n & 1
        if not warp_vertex(w, u + du, v + dv, disparity[v + dv, u + du], n, out_quad):
            return False
        for k in range(4):
            out_paint[n, k] = color[v + dv, u + du, k]
    return True


@inner
def quarter_cell(
    w: F4, color: F4, disparity: F4, links: U1, v: int, u: int, dv: int, du: int,
    out_quad: F4, out_paint: F4,
) -> bool:  # fmt: skip
    """The quarter that sample (v, u) owns of the broken cell toward (dv, du), each +-1."""
    across = np.float32(0.5) * slope_toward(disparity, links, v, u, 0, du)
    along = np.float32(0.5) * slope_toward(disparity, links, v, u, dv, 0)
    tied_u, tied_v = joined(links, v, u, 0, du), joined(links, v, u, dv, 0)
    for n in range(4):
        # corner n of the quad seen from the sample: is it away from it along u, along v?
        away_u = (n & 1) == (1 if du > 0 else 0)
        away_v = (n >> 1) == (1 if dv > 0 else 0)
        delta = disparity[v, u]
        delta += across if away_u else ZERO
        delta += along if away_v else ZERO
        x = u + (0.5 * du if away_u else 0.0)
        y = v + (0.5 * dv if away_v else 0.0)
        if not warp_vertex(w, x, y, max(delta, ZERO), n, out_quad):
            return False
        for k in range(4):
            own = color[v, u, k]
            value = own
            if away_u and tied_u:
                value += HALF * (color[v, u + du, k] - own)
            if away_v and tied_v:
                value += HALF * (color[v + dv, u, k] - own)
            out_paint[n, k] = value
    return True


@kernel
def draw_mesh(
    w: F4, color: F4, disparity: F4, links: U1, tiles: I4, row_low: int, row_high: int,
    by_order: bool, out_color: F4, out_disparity: F4,
) -> None:  # fmt: skip
    """Draw every cell of every tile that can reach the band.

    Args:
        w: (12,) warp matrix.
        color: (H, W, 4) linear.
        disparity: (H, W).
        links: (H, W) bits of `_edges`.
        tiles: (n, FIELDS).
        row_low: first row of the band.
        row_high: row after its last.
        by_order: later cells win; otherwise the larger disparity.
        out_color: (rows, width, 4).
        out_disparity: (rows, width), preset to -1.
    """
    whole, quarter = np.float32(LARGEST_QUAD), np.float32(0.5 * LARGEST_QUAD)
    quad = np.empty((4, 3), np.float32)
    paint = np.empty((4, 4), np.float32)
    for n in range(tiles.shape[0]):
        if tiles[n, 7] <= row_low or tiles[n, 6] >= row_high:
            continue
        first, end = max(tiles[n, 6], row_low), min(tiles[n, 7], row_high)
        u_first = tiles[n, 0] - 1 if tiles[n, 0] == 0 else tiles[n, 0]
        v_first = tiles[n, 3] - 1 if tiles[n, 3] == 0 else tiles[n, 3]
        for j in range(tiles[n, 4] - v_first):
            v = v_first + j if tiles[n, 5] > 0 else tiles[n, 4] - 1 - j
            for i in range(tiles[n, 1] - u_first):
                u = u_first + i if tiles[n, 2] > 0 else tiles[n, 1] - 1 - i
                if intact(links, v, u):
                    if whole_cell(w, color, disparity, v, u, quad, paint):
                        draw_quad(
                            quad,
                            paint,
                            whole,
                            row_low,
                            first,
                            end,
                            by_order,
                            out_color,
                            out_disparity,
                        )
                    continue
                for corner in range(4):
                    dv = corner >> 1 if tiles[n, 5] > 0 else 1 - (corner >> 1)
                    du = corner & 1 if tiles[n, 2] > 0 else 1 - (corner & 1)
                    if usable(disparity, links, v + dv, u + du) and quarter_cell(
                        w, color, disparity, links, v + dv, u + du, 1 - 2 * dv, 1 - 2 * du,
                        quad, paint,
                    ):  # fmt: skip
                        draw_quad(
                            quad,
                            paint,
                            quarter,
                            row_low,
                            first,
                            end,
                            by_order,
                            out_color,
                            out_disparity,
                        )
