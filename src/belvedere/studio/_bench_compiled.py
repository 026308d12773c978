"""A point warp with a z-buffer in C, compiled here and now: how fast moving samples can be.

It does what McMillan's warp must and nothing else: no bounds, no edges, no filter, one thread.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.errors import MissingDependencyError
from belvedere.scene import Camera, ReferenceView
from belvedere.studio._bench_rival import Layer, planar_of

COMPILERS = ("cc", "gcc", "clang")
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")
SOURCE = r"""
#include <stdint.h>

/* w: 12 numbers, row by row; out_disparity comes preset to -1. The first loop of each row has no
   branch, so that it runs on vectors; the second only moves. */
void warp_points(const float *w, int width, int height, const uint8_t *color,
                 const float *disparity, int out_width, int out_height,
                 int32_t *cell, float *moved, uint8_t *out_color, float *out_disparity)
{
    const float right = out_width - 0.5f, low = out_height - 0.5f;
    for (int v = 0; v < height; v++) {
        const float *delta = disparity + (long)v * width;
        const uint8_t *from = color + 3L * v * width;
        const float r0 = w[1] * v + w[2], s0 = w[5] * v + w[6], t0 = w[9] * v + w[10];
        for (int u = 0; u < width; u++) {
            const float d = delta[u];
            const float t = w[8] * u + t0 + w[11] * d, scale = 1.0f / t;
            const float x = (w[0] * u + r0 + w[3] * d) * scale;
            const float y = (w[4] * u + s0 + w[7] * d) * scale;
            const int in = (t > 0) & (x >= -0.5f) & (x < right) & (y >= -0.5f) & (y < low);
            const float xs = in ? x : 0.0f, ys = in ? y : 0.0f;
            cell[u] = in ? (int)(ys + 0.5f) * out_width + (int)(xs + 0.5f) : -1;
            moved[u] = d * scale;
        }
        for (int u = 0; u < width; u++) {
            const int at = cell[u];
            if (at < 0 || !(moved[u] > out_disparity[at])) continue;
            out_disparity[at] = moved[u];
            uint8_t *to = out_color + 3L * at;
            to[0] = from[3 * u]; to[1] = from[3 * u + 1]; to[2] = from[3 * u + 2];
        }
    }
}
"""


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """References, and the function that moves them."""

    function: Any
    views: tuple[ReferenceView, ...]


@lru_cache(maxsize=1)
def compiled_warp() -> Any:
    """`warp_points` of the source above, from a compiler on the path.

    Raises:
        MissingDependencyError: there is none, or it fails.
    """
    compiler = next((found for name in COMPILERS if (found := shutil.which(name))), None)
    if compiler is None:
        raise MissingDependencyError("a C compiler")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        source, library = Path(folder) / "warp.c", Path(folder) / "warp.so"
        source.write_text(SOURCE)
        done = subprocess.run(
            [compiler, *FLAGS, str(source), "-o", str(library)],
            check=False, capture_output=True, text=True,
        )  # fmt: skip
        if done.returncode:
            raise MissingDependencyError(f"a C compiler that takes {' '.join(FLAGS)}")
        return ctypes.CDLL(str(library)).warp_points  # stays loaded when its file is gone


def prepare_c(views: Sequence[ReferenceView], threads: int) -> Loaded:
    """Nothing but the function: disparity is what the warp equation takes."""
    del threads
    return Loaded(compiled_warp(), tuple(views))


def warp_c(loaded: Loaded, camera: Camera, threads: int) -> Layer:
    """All references into one z-buffer, in disparity: the larger one wins."""
    from belvedere.warp import warp_matrix

    del threads
    color = np.zeros((*camera.size, 3), np.uint8)
    disparity = np.full(camera.size, np.float32(-1.0))
    for view in loaded.views:
        matrix = warp_matrix(planar_of(view), camera).astype(np.float32)
        height, width = view.disparity.shape
        cell, moved = np.empty(width, np.int32), np.empty(width, np.float32)
        arrays = [one.ctypes.data_as(ctypes.c_void_p)
                  for one in (matrix, view.color, view.disparity, cell, moved, color, disparity)
                  ]  # fmt: skip
        loaded.function(
            arrays[0], width, height, *arrays[1:3], camera.width, camera.height, *arrays[3:]
        )
    return Layer(color, disparity)
