"""Kernels that make pixels of layers of words (see `_scatter`).

Nothing but copies where one reference counts; means in linear light where several see one surface.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from belvedere.ground.jit import Real, inner, kernel
from belvedere.ground.simd import float_of, shl32, shr32
from belvedere.warp._scatter import CARRIED, EMPTY, HIGH

F4 = npt.NDArray[np.float32]
I8 = npt.NDArray[np.int64]
U1 = npt.NDArray[np.uint8]
U4 = npt.NDArray[np.uint32]

ZERO = np.float32(0.0)
ONE = np.float32(1.0)
NAN = np.float32(np.nan)
NOTHING = np.float32(-1.0)
BYTE = np.uint32(255)
BITS = np.uint32(8)
OPAQUE = np.uint32(0xFFFFFF)
"""The part of a colour in one number that three channels have."""


@inner
def disparity_of(word: Real) -> Real:
    """A word's disparity, or -1 of an empty one."""
    return float_of(np.uint32(word >> HIGH)) if word >= 0 else NOTHING


@inner
def carried_of(word: Real) -> Real:
    """What a word carries, or 0 of an empty one."""
    return np.uint32(word & CARRIED) if word >= 0 else np.uint32(0)


@inner
def alpha_of(value: Real) -> Real:
    """The fourth channel of a colour in one number, 0 to 255."""
    return np.float32(np.int32(value >> np.uint32(24)))


@inner
def put_colors(values: U4, y: int, width: int, channels: int, line: U4, out_bytes: U1) -> None:
    """A row of colours, one number each, as bytes.

    Three channels go four pixels at a time, as three numbers: byte by byte they would take four
    times as many stores.

    Args:
        values: (4 n,) at least the row's, the first channel lowest; overwritten.
        y: the row.
        width: of it.
        channels: 3 or 4.
        line: (3 n,) to work in.
        out_bytes: the whole picture's, (rows * width * channels,).
    """
    start = np.uint64(y * width * channels)
    if channels == 4:
        flat = values.view(np.uint8)
        for k in range(4 * width):
            out_bytes[start + np.uint64(k)] = flat[k]
        return
    for x in range(line.shape[0] // 3):
        a, b, c, d = values[4 * x], values[4 * x + 1], values[4 * x + 2], values[4 * x + 3]
        line[3 * x] = (a & OPAQUE) | shl32(b, np.uint32(24))
        line[3 * x + 1] = shr32(b & OPAQUE, np.uint32(8)) | shl32(c, np.uint32(16))
        line[3 * x + 2] = shr32(c & OPAQUE, np.uint32(16)) | shl32(d, np.uint32(8))
    flat = line.view(np.uint8)
    for k in range(3 * width):
        out_bytes[start + np.uint64(k)] = flat[k]


@kernel
def keep_first(words: I8, ratio: Real) -> None:
    """Leave one layer in each pixel: a later one replaces what is there if it is clearly nearer.

    Args:
        words: (n, rows, width) layers, the preferred first; those that lose become empty.
        ratio: how many times larger the newcomer's disparity must be; infinity: only holes are
            filled.

    Source: Popescu and Lastra's fuzzy z-buffer; spec offset-buffer-warping 3.4.
    """
    count, rows, width = words.shape
    factor = np.float32(ratio)
    bar = np.empty(width, np.float32)
    for y in range(rows):
        first = words[0, y]
        for x in range(width):
            bar[x] = disparity_of(first[x]) * factor if first[x] >= 0 else NOTHING
        for n in range(1, count):
            layer = words[n, y]
            for m in range(n):
                before = words[m, y]
                for x in range(width):
                    before[x] = EMPTY if disparity_of(layer[x]) > bar[x] else before[x]
            for x in range(width):
                delta = disparity_of(layer[x])
                nearer = delta > bar[x]
                bar[x] = delta * factor if nearer else bar[x]
                layer[x] = layer[x] if nearer else EMPTY


@kernel
def copy_bytes(words: I8, out_color: U1, out_disparity: F4, out_coverage: F4) -> None:
    """One layer's pixels as a frame has them.

    words is (rows, width) and carries colours; out_color (rows, width, 3|4); holes have colour
    and coverage 0 and disparity NaN.
    """
    rows, width, channels = out_color.shape
    fours, flat = -(-width // 4), out_color.reshape(-1)
    values, line = np.empty(4 * fours, np.uint32), np.empty(3 * fours, np.uint32)
    for y in range(rows):
        layer, depth, known = words[y], out_disparity[y], out_coverage[y]
        for x in range(width):
            word = layer[x]
            depth[x] = disparity_of(word) if word >= 0 else NAN
            known[x] = ONE if word >= 0 else ZERO
            values[x] = carried_of(word)
        put_colors(values, y, width, channels, line, flat)


@kernel
def copy_samples(words: I8, color: F4, out_color: F4, out_disparity: F4, out_coverage: F4) -> None:
    """`copy_bytes` of a layer that carries sample numbers; color is (H * W, C) ``float32``."""
    rows, width, channels = out_color.shape
    for y in range(rows):
        layer, target = words[y], out_color[y]
        depth, known = out_disparity[y], out_coverage[y]
        for x in range(width):
            word = layer[x]
            depth[x] = disparity_of(word) if word >= 0 else NAN
            known[x] = ONE if word >= 0 else ZERO
        for x in range(width):
            held, source = layer[x] >= 0, color[np.uint64(carried_of(layer[x]))]
            target[x, 0] = source[0] if held else ZERO
            target[x, 1] = source[1] if held else ZERO
            target[x, 2] = source[2] if held else ZERO
            if channels == 4:
                target[x, 3] = source[3] if held else ZERO


@kernel
def pair_table(first: Real, second: Real, linear: F4, encode: U1, out_table: U1) -> None:
    """What two bytes mix to: encoded mean of their radiances.

    Args:
        first: weight of the first byte.
        second: of the second; together 1.
        linear: (256,) radiance of each byte.
        encode: see `ground.color.LINEAR_TO_SRGB8`.
        out_table: (65536,) at ``256 a + b``.
    """
    top = np.float32(encode.shape[0] - 1)
    place = np.empty(256, np.int32)
    for a in range(256):
        one = first * linear[a]
        for b in range(256):
            place[b] = np.int32(np.sqrt(min(one + second * linear[b], ONE)) * top + np.float32(0.5))
        row = out_table[256 * a : 256 * a + 256]
        for b in range(256):
            row[b] = encode[np.uint32(place[b])]


@kernel
def blend_two(
    words: I8, weights: F4, tolerance: Real, table: U1,
    out_color: U1, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Two layers that carry bytes: the surface in front, averaged where both see it.

    Args:
        words: (2, rows, width).
        weights: (2,) one per reference, summing to 1.
        tolerance: relative difference in disparity up to which two layers show one surface.
        table: (65536,) from `pair_table` with these weights.
        out_color: (rows, width, 3|4).
        out_disparity: (rows, width), NaN in holes.
        out_coverage: (rows, width).
    """
    rows, width, channels = out_color.shape
    keep, wa, wb = np.float32(1.0 - tolerance), weights[0], weights[1]
    scale = ONE / (wa + wb)
    fours, flat = -(-width // 4), out_color.reshape(-1)
    values, line = np.empty(4 * fours, np.uint32), np.empty(3 * fours, np.uint32)
    pairs, alpha = np.empty((3, width), np.uint16), np.empty(width, np.uint32)
    red, green, blue = pairs[0], pairs[1], pairs[2]
    for y in range(rows):
        layer_a, layer_b = words[0, y], words[1, y]
        depth, known = out_disparity[y], out_coverage[y]
        for x in range(width):
            word_a, word_b = layer_a[x], layer_b[x]
            a, b = disparity_of(word_a), disparity_of(word_b)
            front = max(a, b)
            limit = max(front * keep, ZERO)
            sees_a, sees_b = a >= limit, b >= limit
            mean = front if sees_a != sees_b else (wa * a + wb * b) * scale
            depth[x] = mean if front >= ZERO else NAN
            known[x] = ONE if front >= ZERO else ZERO
            # where one is alone it stands for both: a byte mixed with itself is itself
            one = carried_of(word_a if sees_a else word_b)
            two = carried_of(word_b if sees_b else word_a)
            red[x] = np.uint16(((one & BYTE) << BITS) | (two & BYTE))
            green[x] = np.uint16((one & (BYTE << BITS)) | ((two >> BITS) & BYTE))
            blue[x] = np.uint16(((one >> BITS) & (BYTE << BITS)) | ((two >> (BITS + BITS)) & BYTE))
            if channels == 4:
                mixed = wa * alpha_of(one) + wb * alpha_of(two)
                alpha[x] = shl32(np.uint32(np.int32(mixed + np.float32(0.5))), np.uint32(24))
        for x in range(width):
            low, middle = np.uint32(table[red[x]]), np.uint32(table[green[x]])
            high = shl32(np.uint32(table[blue[x]]), np.uint32(16))
            values[x] = low | shl32(middle, np.uint32(8)) | high
        if channels == 4:
            for x in range(width):
                values[x] |= alpha[x]
        put_colors(values, y, width, channels, line, flat)


@kernel
def share(words: I8, weights: F4, tolerance: Real, y: int, out_share: F4, out_disparity: F4,
          out_coverage: F4) -> None:  # fmt: skip
    """How much each reference counts in each pixel of one row, and what is in front there.

    Args:
        words: (n, rows, width).
        weights: (n,) one per reference.
        tolerance: relative difference in disparity up to which layers show one surface.
        y: the row.
        out_share: (n, width), summing to 1, or all 0 in holes; exactly 1 for one alone.
        out_disparity: (width,), NaN in holes.
        out_coverage: (width,).
    """
    count, width = out_share.shape
    keep = np.float32(1.0 - tolerance)
    total, front = np.zeros(width, np.float32), np.full(width, NOTHING)
    out_disparity[:] = ZERO
    for n in range(count):
        layer = words[n, y]
        for x in range(width):
            front[x] = max(front[x], disparity_of(layer[x]))
    for n in range(count):
        layer, part, weight = words[n, y], out_share[n], weights[n]
        for x in range(width):
            delta = disparity_of(layer[x])
            mine = weight if delta >= max(front[x] * keep, ZERO) else ZERO
            part[x] = mine
            total[x] += mine
            out_disparity[x] += mine * delta
    for x in range(width):
        held = total[x] > ZERO
        out_disparity[x] = out_disparity[x] / total[x] if held else NAN
        out_coverage[x] = ONE if held else ZERO
    for n in range(count):
        part = out_share[n]
        for x in range(width):
            part[x] = part[x] / total[x] if total[x] > ZERO else ZERO


@kernel
def blend_bytes(
    words: I8, weights: F4, tolerance: Real, linear: F4, encode: U1,
    out_color: U1, out_disparity: F4, out_coverage: F4,
) -> None:  # fmt: skip
    """Any number of layers that carry bytes; see `blend_two`.

    Args:
        words: (n, rows, width).
        weights: (n,) one per reference.
        tolerance: as in `blend_two`.
        linear: (256,) radiance of each byte.
        encode: see `ground.color.LINEAR_TO_SRGB8`.
        out_color: (rows, width, 3|4).
        out_disparity: (rows, width), NaN in holes.
        out_coverage: (rows, width).
    """
    rows, width, channels = out_color.shape
    count, top = words.shape[0], np.float32(encode.shape[0] - 1)
    shares = np.empty((count, width), np.float32)
    light = np.empty(3 * width, np.float32)
    place = np.empty(3 * width, np.int32)
    alpha = np.empty(width, np.float32)
    for y in range(rows):
        share(words, weights, tolerance, y, shares, out_disparity[y], out_coverage[y])
        light[:] = ZERO
        alpha[:] = np.float32(0.5)
        for n in range(count):
            layer, part = words[n, y], shares[n]
            for x in range(width):
                value, mine = carried_of(layer[x]), part[x]
                light[3 * x] += mine * linear[value & BYTE]
                light[3 * x + 1] += mine * linear[(value >> BITS) & BYTE]
                light[3 * x + 2] += mine * linear[(value >> (BITS + BITS)) & BYTE]
                alpha[x] += mine * alpha_of(value)
        for k in range(3 * width):
            place[k] = np.int32(np.sqrt(min(light[k], ONE)) * top + np.float32(0.5))
        color = out_color[y]
        for x in range(width):
            color[x, 0] = encode[np.uint32(place[3 * x])]
            color[x, 1] = encode[np.uint32(place[3 * x + 1])]
            color[x, 2] = encode[np.uint32(place[3 * x + 2])]
        if channels == 4:
            for x in range(width):
                color[x, 3] = np.uint8(np.int32(alpha[x]))


@kernel
def settle(words: I8, weights: F4, tolerance: Real, out_share: F4, out_disparity: F4,
           out_coverage: F4) -> None:  # fmt: skip
    """`share` of every row of a band; out_share is (n, rows, width)."""
    for y in range(out_disparity.shape[0]):
        share(words, weights, tolerance, y, out_share[:, y], out_disparity[y], out_coverage[y])


@kernel
def add_samples(words: I8, share: F4, color: F4, out_color: F4) -> None:
    """Add one reference's part to a mean of ``float32`` colours.

    words (rows, width) carry sample numbers, share (rows, width) comes from `settle`, color is
    (H * W, C) and out_color (rows, width, C).
    """
    rows, width, channels = out_color.shape
    for y in range(rows):
        layer, part, target = words[y], share[y], out_color[y]
        for x in range(width):
            mine = part[x]
            if mine > ZERO:
                source = color[np.uint64(carried_of(layer[x]))]
                for k in range(channels):
                    target[x, k] += mine * source[k]
