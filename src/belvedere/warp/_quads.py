"""Steps of kernels that scan-convert quads of disparity, many at once.

The lowest bit of a disparity says how sure it is: 1 where it was drawn from a part of a broken
cell, between two surfaces, where the true edge may run on either side; 0 inside a surface.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import bits_of, float_of
from belvedere.warp._edges import list_set
from belvedere.warp._tiles import TILE

F4 = npt.NDArray[np.float32]
I4 = npt.NDArray[np.int32]
U1 = npt.NDArray[np.uint8]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
TWO = np.float32(2.0)
SLACK = np.float32(-1e-4)
"""Barycentric slack of the inside test: neighbouring triangles may both paint a shared edge, but
never leave a pixel between them. A hundred float32 roundings."""
REACH = np.float32(1e-3)
"""Pixels by which a cell's bounds are widened, for the same reason."""
LARGEST_CELL = np.float32(64.0)
"""Pixels a single cell may grow to. More is not a reconstruction but a guess from one sample, and
would let a sample near the eye paint the whole view."""
HOLE = np.float32(-1.0)
RUN = TILE
"""Cells of a run, at most."""
SURE, UNSURE = np.uint32(0), np.uint32(1)


@inner
def marked(delta: Real, mark: Real) -> Real:
    """The disparity with its lowest bit set to ``mark``: `SURE` or `UNSURE`."""
    return float_of(np.uint32((bits_of(delta) & ~UNSURE) | mark))


@inner
def is_unsure(delta: Real) -> bool:
    """Whether a disparity was drawn at an edge."""
    return np.uint32(bits_of(delta) & UNSURE) != 0


@inner
def is_cut(edge: Real) -> bool:
    """Whether an edge is known to run through a pixel, from what it holds of `out_edge`."""
    return is_unsure(edge) & (edge >= ZERO)


@inner
def test_quads(
    xa: F4, ya: F4, za: F4, xb: F4, yb: F4, zb: F4, xc: F4, yc: F4, zc: F4, xd: F4, yd: F4, zd: F4,
    drawn: U1, mark: Real, width: int, row_low: int, first: int, end: int,
    out_corner: F4, out_z: F4, out_place: I4, out_hits: I4, out_span: I4,
) -> None:  # fmt: skip
    """Which of the first 2 x 2 pixel centres in its bounds each of RUN quads covers.

    A quad mostly holds one centre or none, so many are tested at once. Straight-line arithmetic on
    purpose: it vectorises. The areas that a centre spans with the four edges and the disparity are
    affine: they are computed at the upper left centre and stepped to the other three. A quad is two
    triangles of disparity, folded along the diagonal from b to c.

    Args:
        xa: (RUN,) where the upper left corners land.
        ya: ...
        za: their warped disparities.
        xb: the upper right corners ...
        yb: ...
        zb: ...
        xc: the lower left ...
        yc: ...
        zc: ...
        xd: the lower right ...
        yd: ...
        zd: ...
        drawn: (RUN,) 0 where there is nothing to draw.
        mark: lowest bit of the disparities, `SURE` or `UNSURE`.
        width: of the desired view.
        row_low: first row of the band.
        first: first row to paint.
        end: row after the last.
        out_corner: (2, RUN) column and row of the upper left centre.
        out_z: (5, RUN) disparity at the four centres, -1 where the quad does not cover one or has
            more of them; then that of the first it covers.
        out_place: (2, RUN) flat index in the band of the upper left centre, which may lie outside;
            and of the first that is covered, if any is.
        out_hits: (RUN,) how many are covered.
        out_span: (RUN,) centres across and down, the larger, at least 3 for a quad that is bent; 0
            for none; -1 for a quad that is not drawn, behind the eye, or too large.
    """
    right, top_most = np.float32(width - 1), np.float32(first)
    bottom = np.float32(end - 1)
    columns, rows = np.uint32(width), np.uint32(end - first)
    for i in range(RUN):
        x00, x01, x10, x11 = xa[i], xb[i], xc[i], xd[i]
        y00, y01, y10, y11 = ya[i], yb[i], yc[i], yd[i]
        x_low, x_high = min(x00, x01, x10, x11), max(x00, x01, x10, x11)
        y_low, y_high = min(y00, y01, y10, y11), max(y00, y01, y10, y11)
        left, top = np.ceil(x_low - REACH), np.ceil(y_low - REACH)
        across, down = np.floor(x_high + REACH) - left, np.floor(y_high + REACH) - top
        total = x00 + x01 + x10 + x11
        whole = total - total == ZERO  # no corner is behind the eye
        outside = (left + across < ZERO) | (left > right)
        outside |= (top + down < top_most) | (top > bottom)
        span = max(across, down) + ONE
        small = whole & (span <= LARGEST_CELL) & (drawn[i] != 0)
        fits = small & (across >= ZERO) & (down >= ZERO) & (not outside)
        # edges a to b, a to c, d to b, d to c: two triangles, a b c and d c b
        bx, by, cx, cy = x01 - x00, y01 - y00, x10 - x00, y10 - y00
        ex, ey, fx, fy = x01 - x11, y01 - y11, x10 - x11, y10 - y11
        area, other = bx * cy - cx * by, fx * ey - ex * fy
        convex = (area > ZERO) & (other > ZERO)
        convex &= (by * ex - bx * ey > ZERO) & (cx * fy - cy * fx > ZERO)
        facing = (area > ZERO) | (other > ZERO)
        few = fits & convex & (span <= TWO)
        # one of its triangles turns away, or it has a dent: each triangle by itself
        span = span if convex or not facing else max(span, np.float32(3.0))
        out_span[i] = np.int32(span) if fits else (np.int32(0) if small else np.int32(-1))
        left, top = left if fits else ZERO, top if fits else ZERO
        out_corner[0, i], out_corner[1, i] = left, top
        px, py, qx, qy = left - x00, top - y00, left - x11, top - y11
        # twice the areas that a centre spans with each edge: inside, all are positive
        ab, ac = bx * py - by * px, cy * px - cx * py
        dc, db = fx * qy - fy * qx, ey * qx - ex * qy
        scale = ONE / area
        zb4, zc4 = (zb[i] - za[i]) * scale, (zc[i] - za[i]) * scale
        plane = za[i] + ac * zb4 + ab * zc4
        plane_x, plane_y = cy * zb4 - by * zc4, bx * zc4 - cx * zb4
        # beyond the diagonal the other triangle's plane bends away from it
        beyond, beyond_x, beyond_y = area - ab - ac, by - cy, cx - bx
        bend = (plane_x * (x11 - x00) + plane_y * (y11 - y00) + za[i] - zd[i]) / other
        slack = SLACK * area
        slack2 = SLACK * other
        ab, ac, dc, db = ab - slack, ac - slack, dc - slack2, db - slack2
        column, row = np.int32(left), np.int32(top) - np.int32(first)
        in_left, in_right = np.uint32(column) < columns, np.uint32(column + np.int32(1)) < columns
        in_top, in_bottom = np.uint32(row) < rows, np.uint32(row + np.int32(1)) < rows
        in_top, in_bottom = in_top & few, in_bottom & few
        hit0 = (min(ab, ac, dc, db) >= ZERO) & in_left & in_top
        z0 = max(plane + bend * min(beyond, ZERO), ZERO)
        ab1, ac1, dc1, db1 = ab - by, ac + cy, dc - fy, db + ey
        hit1 = (min(ab1, ac1, dc1, db1) >= ZERO) & in_right & in_top
        z1 = max(plane + plane_x + bend * min(beyond + beyond_x, ZERO), ZERO)
        hit2 = (min(ab + bx, ac - cx, dc + fx, db - ex) >= ZERO) & in_left & in_bottom
        plane, beyond = plane + plane_y, beyond + beyond_y
        z2 = max(plane + bend * min(beyond, ZERO), ZERO)
        hit3 = (min(ab1 + bx, ac1 - cx, dc1 + fx, db1 - ex) >= ZERO) & in_right & in_bottom
        z3 = max(plane + plane_x + bend * min(beyond + beyond_x, ZERO), ZERO)
        z0, z1 = marked(z0, mark) if hit0 else HOLE, marked(z1, mark) if hit1 else HOLE
        z2, z3 = marked(z2, mark) if hit2 else HOLE, marked(z3, mark) if hit3 else HOLE
        out_z[0, i], out_z[1, i], out_z[2, i], out_z[3, i] = z0, z1, z2, z3
        out_z[4, i] = z0 if hit0 else z1 if hit1 else z2 if hit2 else z3
        wide = np.int32(width)
        base = np.int32((np.int32(top) - np.int32(row_low)) * wide + column)
        step = (
            np.int32(0) if hit0 else np.int32(1) if hit1 else wide if hit2 else wide + np.int32(1)
        )
        out_place[0, i] = base
        out_place[1, i] = base + np.int32(step) if hit0 | hit1 | hit2 | hit3 else np.int32(0)
        out_hits[i] = np.int32(hit0) + np.int32(hit1) + np.int32(hit2) + np.int32(hit3)


@inner
def paint_quads(z: F4, place: I4, hits: I4, width: int, more: U1, listed: I4, flat: F4) -> None:
    """The nearer of what is there and what `test_quads` found; -1 changes nothing.

    more and listed are (RUN,) to work in.
    """
    for i in range(RUN):
        more[i] = np.uint8(hits[i] > 1)
    for i in range(RUN):
        at = np.uint32(place[1, i])
        flat[at] = max(flat[at], z[4, i])
    for k in range(list_set(more, listed)):
        i = listed[k]
        for n in range(1, 4):
            if z[n, i] >= ZERO:
                at = np.uint32(place[0, i] + (n & 1) + (n >> 1) * width)
                flat[at] = max(flat[at], z[n, i])


@inner
def draw_triangle(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    left: int, right: int, top: int, bottom: int, row_low: int, mark: Real, out: F4,
) -> None:  # fmt: skip
    """Disparity at the pixel centres of a triangle that turns from a to b to c as the picture does.

    Disparity is affine on the desired view too, so the triangle's plane is kept exactly.
    """
    bx, by, cx, cy = xb - xa, yb - ya, xc - xa, yc - ya
    area = bx * cy - cx * by
    if not area > ZERO:  # seen from behind, or edge on
        return
    scale = ONE / area
    zb, zc = zb - za, zc - za
    for y in range(top, bottom + 1):
        py = np.float32(y) - ya
        for x in range(left, right + 1):
            px = np.float32(x) - xa
            wb, wc = (px * cy - cx * py) * scale, (bx * py - px * by) * scale
            if min(wb, wc, ONE - wb - wc) < SLACK:
                continue
            z = max(za + wb * zb + wc * zc, ZERO)
            if z > out[y - row_low, x]:
                out[y - row_low, x] = marked(z, mark)


@inner
def draw_large(
    xa: Real, ya: Real, za: Real, xb: Real, yb: Real, zb: Real, xc: Real, yc: Real, zc: Real,
    xd: Real, yd: Real, zd: Real, left: Real, top: Real, span: int, width: int, row_low: int,
    first: int, end: int, mark: Real, out: F4,
) -> None:  # fmt: skip
    """A quad that holds more than 2 x 2 pixel centres."""
    right = int(min(left + np.float32(span), np.float32(width))) - 1
    bottom = int(min(top + np.float32(span), np.float32(end))) - 1
    x_low, y_low = int(max(left, ZERO)), int(max(top, np.float32(first)))
    draw_triangle(
        xa, ya, za, xb, yb, zb, xc, yc, zc, x_low, right, y_low, bottom, row_low, mark, out
    )
    draw_triangle(
        xd, yd, zd, xc, yc, zc, xb, yb, zb, x_low, right, y_low, bottom, row_low, mark, out
    )
