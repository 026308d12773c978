"""What a cell of the warp buffer holds, in one word, so that claiming a cell is taking a maximum.

::

    bit 63                                                                                   0
        | surface | nearness, place | rest of the disparity | row, column | place in it | wide |

A word compares first by its *surface*: the leading bits of the warped disparity, as many as
the tolerance leaves. Of two surfaces the nearer wins. Of several sub-samples on one surface a cell
keeps the one nearest its middle: the first or the last would lie toward one side of every cell,
and the whole picture with them. What is left of the disparity makes it complete; row, column and
place say where in the reference its colour is to be found. The largest of some words is the same
in any order: neither tiles nor bands nor threads can change the picture.

A *wide* sub-sample stands for the whole output pixel that it lands in: its surface goes on all
round, and the reference is not much finer there than the picture.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from belvedere.ground.jit import Real, inner
from belvedere.ground.simd import bits_of, float_of, mul32, shl32, shr32

EMPTY = np.uint64(0)
"""The word of a cell that sees nothing: rows and columns count from 1, so no other is 0."""
IN_CELL = 6
"""Bits of a place between two samples of the reference, per axis: colours are looked up to within
1/128 of a sample. Landing is exact."""
WIDE = np.uint64(1)
"""Bit of a wide sub-sample."""
STEPS = np.float32(1 << IN_CELL)
LAST_STEP = np.float32((1 << IN_CELL) - 1)
MOST_NEARNESS = 3
"""Bits that tell how near the middle of its cell a place is, at most."""
FRONT = 32
"""Bits of surface, place and disparity, at most."""


class Layout(NamedTuple):
    """How the bits of a word are shared out."""

    bits: int
    """Of a place within a cell of the warp buffer, per axis (the paper's o)."""
    place: int
    """Of nearness and place together."""
    surface: int
    """Leading bits of a disparity that tell one surface from another."""
    kept: int
    """Bits of a disparity that are kept in all, of 31 (its sign is none)."""
    low: int
    """Bits below the disparity."""
    across: int
    """Bits of a column of the reference."""
    nearer: int
    """Nearness for each square of half a place that is left to the corner of a cell, times 2^16."""


def word_layout(bits: int, tolerance: float, height: int, width: int) -> Layout:
    """Share out the bits of a word.

    Args:
        bits: of a place within a cell of the warp buffer, per axis, 0 to 4.
        tolerance: relative difference in disparity up to which sub-samples are on one surface.
        height: of the reference, up to 16,000 or so.
        width: likewise.
    """
    across = (width + 1).bit_length()
    low = (height + 1).bit_length() + across + 2 * IN_CELL + 1
    near = min(max(2 * bits - 2, 0), MOST_NEARNESS)
    place = 2 * bits + near
    kept = min(min(FRONT, 64 - low) - place, 31)
    # a float32 has 8 bits of exponent; so many of its fraction tell apart what differs by more
    fraction = 23 if tolerance <= 0 else int(np.ceil(-np.log2(tolerance)))
    corner = 2 * (2**bits - 1) ** 2
    nearer = -(-((1 << near) - 1 << 16) // (corner - 2)) if near else 0
    return Layout(bits, place, min(8 + fraction, kept), kept, low, across, nearer)


@inner
def mark(fine_u: Real, fine_v: Real, layout: Any) -> Real:
    """A place within its cell, preceded by how near the middle it is: larger is better.

    In every second cell, as on a chessboard, places are numbered from the other end. Whole numbers,
    which vectorise. With no bits a cell knows no places: that is the paper's warp buffer without
    offsets.

    Args:
        fine_u: column in steps of 2^-bits of a cell; the cell itself is ``fine_u >> bits``.
        fine_v: row likewise.
        layout: of the word.
    """
    bits, places = np.uint32(layout.bits), np.uint32(1 << layout.bits)
    qu, qv = np.uint32(fine_u & np.uint32(places - 1)), np.uint32(fine_v & np.uint32(places - 1))
    # how far from the middle, in half places: odd, and the sign does not matter for its square
    off_u, off_v = np.uint32(qu + qu + 1 - places), np.uint32(qv + qv + 1 - places)
    corner = np.uint32(2 * (places - 1) * (places - 1))
    left = np.uint32(corner - mul32(off_u, off_u) - mul32(off_v, off_v))
    near = shr32(mul32(left, np.uint32(layout.nearer)), np.uint32(16))
    place = np.uint32(shl32(qv, bits) | qu)
    # of places as near, one cell prefers the last, the next one the first: none leans to a side
    odd = np.uint32(np.uint32(shr32(fine_u, bits) + shr32(fine_v, bits)) & np.uint32(1))
    flip = np.uint32(np.uint32(-odd) & np.uint32(places * places - 1))
    return np.uint32(shl32(near, np.uint32(2 * layout.bits)) | np.uint32(place ^ flip))


@inner
def front_word(warped: Real, marked: Real, layout: Any) -> Real:
    """A word's bits above row and column; warped is a disparity of 0 or more."""
    # rounded, not cut, to what is kept
    bits = np.uint32(bits_of(warped) + np.uint32((1 << (31 - layout.kept)) >> 1))
    rest = np.uint32(layout.kept - layout.surface)
    mask = np.uint32((1 << (layout.kept - layout.surface)) - 1)
    surface = shr32(bits, np.uint32(31 - layout.surface))
    fine = np.uint32(shr32(bits, np.uint32(31 - layout.kept)) & mask)
    upper = np.uint32(shl32(surface, np.uint32(layout.place)) | marked)
    return np.uint32(shl32(upper, rest) | fine)


@inner
def back_word(v: int, u: int, step_v: int, step_u: int, layout: Any) -> Real:
    """A word's bits below the disparity; not a wide one's.

    Args:
        v: row of the cell of the reference, from -1.
        u: its column.
        step_v: place in it, 0 to 2^IN_CELL - 1.
        step_u: ...
        layout: of the word.
    """
    cell = (np.uint64(v + 1) << np.uint64(layout.across)) | np.uint64(u + 1)
    inside = (np.uint64(step_v) << np.uint64(IN_CELL)) | np.uint64(step_u)
    return ((cell << np.uint64(2 * IN_CELL)) | inside) << np.uint64(1)


@inner
def disparity_in(word: Real, layout: Any) -> Real:
    """The disparity that a word holds; 0 comes back as 0."""
    front = np.uint32(word >> np.uint64(layout.low))
    rest = np.uint32(layout.kept - layout.surface)
    mask = np.uint32((1 << (layout.kept - layout.surface)) - 1)
    surface = shr32(front, np.uint32(rest + np.uint32(layout.place)))
    fine = shl32(np.uint32(front & mask), np.uint32(31 - layout.kept))
    return float_of(np.uint32(shl32(surface, np.uint32(31 - layout.surface)) | fine))


@inner
def place_in(word: Real, layout: Any) -> Real:
    """The place that a word holds, as it is numbered in its cell: see `mark`."""
    front = np.uint32(word >> np.uint64(layout.low))
    place = shr32(front, np.uint32(layout.kept - layout.surface))
    return np.uint32(place & np.uint32((1 << (2 * layout.bits)) - 1))


@inner
def cell_in(word: Real, layout: Any) -> tuple[Real, Real, Real, Real]:
    """Row and column of the reference's cell and the place in it: v, u, step_v, step_u."""
    inside = np.uint64((1 << IN_CELL) - 1)
    step_u = (word >> np.uint64(1)) & inside
    step_v = (word >> np.uint64(IN_CELL + 1)) & inside
    cell = word >> np.uint64(2 * IN_CELL + 1)
    u = cell & np.uint64((1 << layout.across) - 1)
    v = (cell >> np.uint64(layout.across)) & np.uint64(
        (1 << (layout.low - layout.across - 2 * IN_CELL - 1)) - 1
    )
    return np.int64(v) - 1, np.int64(u) - 1, step_v, step_u
