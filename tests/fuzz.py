"""Warps of anything, to anywhere, in any way: ``python -m tests.fuzz --cameras 100000``.

Every case has a number and comes from it alone: ``--first 4711 --cameras 1`` repeats one. Tiny
pictures, so that a case takes a millisecond; cameras behind, inside surfaces and a hair from them,
epipoles anywhere, scales from 1e-9 to 1e9, missing samples, skies. With NUMBA_BOUNDSCHECK=1 (and a
NUMBA_CACHE_DIR of its own) compiled kernels check their indices; with NUMBA_DISABLE_JIT=1 they run
as Python, and an index below zero is an error as well.
"""

from __future__ import annotations

import argparse
import functools
import os
import sys
import time
import traceback
import types
import warnings
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.scene import Camera, Frame, ReferenceView
from belvedere.warp import (
    RECONSTRUCTIONS,
    GaussianOptions,
    OffsetOptions,
    PreparedView,
    SplatOptions,
    prepare,
    warp,
)
from tests.warp.worlds import VISIBILITIES, noise, random_camera

KINDS = ("rgb8", "rgba8", "rgb32", "rgba32")
VIEW_SIZES = ((1, 1), (2, 1), (1, 5), (3, 3), (9, 7), (17, 34), (33, 12))
FRAME_SIZES = ((8, 6), (1, 1), (13, 2), (3, 21), (1, 9), (34, 5))
FARTHEST = 1e12
"""Coordinates beyond which a camera is put back where its reference is."""


def assert_frame_is_sound(frame: Frame) -> None:
    """What holds of every frame: finite colours, disparities where covered, nothing in holes."""
    assert frame.color.shape[:2] == frame.disparity.shape == frame.coverage.shape
    assert np.isfinite(frame.color.astype(np.float64)).all()
    assert frame.coverage.min() >= 0
    assert frame.coverage.max() <= 1
    hidden = frame.coverage == 0
    if frame.filled is not None:
        assert not (frame.filled & ~hidden).any()
        hidden &= ~frame.filled
    np.testing.assert_array_equal(np.isnan(frame.disparity), hidden)
    assert not frame.color[hidden].any()
    assert np.all(frame.disparity[~hidden] >= 0)


def strange_view(rng: np.random.Generator, n: int) -> ReferenceView:
    """A tiny reference view whose depths are all, or hardly, or nowhere what a scene's are."""
    width, height = VIEW_SIZES[n % len(VIEW_SIZES)]
    scale = 10.0 ** rng.uniform(-9, 9) if n % 3 == 0 else 1.0
    disparity = rng.uniform(0, 2, (height, width)) / scale
    match n % 10:
        case 0:
            disparity[:] = 0
        case 1:
            disparity[:] = np.nan
        case 2:
            disparity[rng.random((height, width)) < 0.5] = np.nan
        case 3:
            disparity[:] = 1.0 / scale
        case 4:
            disparity = rng.choice([0.0, 1e-30, 1e-3, 1.0, 1e3, 1e30], (height, width))
        case 5:
            disparity = np.outer(np.linspace(0, 3, height), np.ones(width)) / scale
        case 6:  # a ragged skyline
            disparity[rng.random((height, width)) < 0.5] = 0
            disparity[rng.random((height, width)) < 0.1] = np.nan
        case 7:  # one surface, a sample missing here and there
            disparity = rng.uniform(1.0, 1.02, (height, width)) / scale
            disparity[rng.random((height, width)) < 0.1] = np.nan
        case 8:  # two surfaces, half a sample of each at the edge
            disparity[:] = 0.2 / scale
            disparity[:, width // 2 :] = 0.7 / scale
            disparity[:, width // 2] = 0.4 / scale
        case _:
            pass
    camera = random_camera(rng, width, height, reach=scale, turn=3.1)
    color = noise(rng, height, width, KINDS[n % len(KINDS)])
    return ReferenceView(camera, color, disparity.astype(np.float32))


def strange_camera(rng: np.random.Generator, n: int, view: ReferenceView) -> Camera:
    """A camera where a view's geometry is at its worst."""
    width, height = FRAME_SIZES[n % len(FRAME_SIZES)]
    reference = view.camera
    assert isinstance(reference, Camera)
    camera = random_camera(rng, width, height, turn=3.1)
    match n % 8:
        case 0:
            center = reference.center
        case 1:  # on a surface, or a hair from it
            v, u = (int(rng.integers(0, side)) for side in reference.size)
            point = reference.unproject(u, v, np.float64(view.disparity[v, u]))
            center = point + rng.normal(0, 10.0 ** rng.uniform(-12, -1), 3)
        case 2:  # in the reference's own plane
            center = reference.center + reference.matrix[:, 0] * rng.normal(0, 10)
        case 3:
            center = reference.center + rng.normal(0, 10.0 ** rng.uniform(-9, 9), 3)
        case 4:  # ahead, near its own picture's axis
            u, v = rng.uniform(-1, reference.width), rng.uniform(-1, reference.height)
            center = reference.center + reference.rays(u, v) * rng.normal(0, 2)
            camera = Camera(reference.matrix, reference.center, width, height)
        case 5:  # the epipole on a pixel, or where four meet
            u, v = rng.integers(0, reference.width), rng.integers(0, reference.height)
            part = rng.choice([0.0, 0.5])
            ray = reference.rays(u + part, v + part)
            center = reference.center + ray * rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6, 2)
        case 6:  # through a telescope, or the eye of a fly
            center = reference.center + rng.normal(0, 1, 3)
            zoom = 10.0 ** rng.uniform(-4, 4)
            middle = camera.matrix @ [(width - 1) / 2, (height - 1) / 2, 1.0]
            matrix = np.column_stack([camera.matrix[:, :2] * zoom, middle])
            matrix[:, 2] -= matrix[:, :2] @ [(width - 1) / 2, (height - 1) / 2]
            camera = Camera(matrix, center, width, height)
        case _:
            center = camera.center
    if not np.isfinite(center).all() or np.abs(center).max() > FARTHEST:
        center = reference.center
    return camera.moved(center)


def aimed(rng: np.random.Generator, camera: Camera, view: ReferenceView) -> Camera:
    """The camera turned so that its middle shows one of the view's samples, if it has any."""
    known = np.argwhere(~np.isnan(view.disparity))
    if len(known) == 0:
        return camera
    v, u = known[rng.integers(len(known))]
    reference = view.camera
    assert isinstance(reference, Camera)
    # of a point far away only the direction counts
    toward = reference.rays(u, v) + (reference.center - camera.center) * float(view.disparity[v, u])
    middle = camera.rays((camera.width - 1) / 2, (camera.height - 1) / 2)
    lengths = np.linalg.norm(middle) * np.linalg.norm(toward)
    if not (np.isfinite(lengths) and lengths > 0):
        return camera
    cosine = float(middle @ toward / lengths)
    x, y, z = np.cross(middle, toward) / lengths
    if cosine < -0.99:
        return camera
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + cross + cross @ cross / (1 + cosine)
    return Camera(turn @ camera.matrix, camera.center, camera.width, camera.height)


def strange_choices(rng: np.random.Generator) -> dict[str, Any]:
    """Options of `warp` other than the reconstruction, each within what it takes."""
    pick = rng.integers
    return {
        "visibility": VISIBILITIES[pick(2)],
        "composite": ("blend", "nearest", "fuzzy")[pick(3)],
        "fill": ("none", "none", "none", "background")[pick(4)],
        "surface_tolerance": (0.03, 0.0, 1.0, 0.3)[pick(4)],
        "splat": SplatOptions(("jacobian", 1, 5, 15)[pick(4)], largest=(1, 7, 15)[pick(3)]),
        "gaussian": GaussianOptions(
            sigma=rng.uniform(0.4, 1), cut=rng.uniform(1.5, 3), low_pass=rng.uniform(0.25, 1)
        ),
        "offset": OffsetOptions(
            density=("adaptive", "adaptive", 2, 4)[pick(4)],
            largest=(2, 8, 32)[pick(3)],
            buffer_scale=(2, 4)[pick(2)],
            offset_bits=int(pick(5)),
            filter=("radial", "separable")[pick(2)],
            radius=rng.uniform(0.5, 1),
            front_filter=bool(pick(2)),
        ),
    }


def strange_warp(number: int, reconstruction: str | None = None) -> Frame:
    """Case ``number``, by one reconstruction; none takes them in turn."""
    rng = np.random.default_rng([7, number])
    n = int(rng.integers(0, 1 << 20))
    first = strange_view(rng, n)
    views: list[ReferenceView | PreparedView] = [first]
    for _n in range(int(rng.choice([0, 0, 1, 2]))):
        other = strange_view(rng, n + len(KINDS) * int(rng.integers(0, 1000)))  # colours alike
        views.append(other)
    camera = strange_camera(rng, int(rng.integers(0, 1 << 20)), first)
    if rng.random() < 0.8:  # most of the world is not in the picture otherwise
        camera = aimed(rng, camera, first)
    if rng.random() < 0.3:
        tolerance, bridge = rng.choice([0.0, 0.05, 1.0]), int(rng.choice([0, 1, 3, 64]))
        views = [prepare(view, tolerance, bridge) for view in views]
    choices = strange_choices(rng)
    name = reconstruction or RECONSTRUCTIONS[number % len(RECONSTRUCTIONS)]
    return warp(views, camera, threads=1, reconstruction=name, **choices)


def failures(numbers: Iterable[int], reconstruction: str | None = None) -> list[int]:
    """Cases that raise or give an unsound frame; each is told on the error stream."""
    failed = []
    for number in numbers:
        try:
            assert_frame_is_sound(strange_warp(number, reconstruction))
        except Exception:
            failed.append(number)
            name = reconstruction or RECONSTRUCTIONS[number % len(RECONSTRUCTIONS)]
            print(f"case {number}, {name}:\n{traceback.format_exc()}", file=sys.stderr)
    return failed


class Guarded(np.ndarray):
    """Refuses what would wrap round in Python and overrun in compiled code."""

    def __getitem__(self, key: Any) -> Any:
        """As an array, but for negative indices."""
        self._check(key)
        return super().__getitem__(key)

    def __setitem__(self, key: Any, value: Any) -> None:
        """As an array, but for negative indices."""
        self._check(key)
        super().__setitem__(key, value)

    def _check(self, key: Any) -> None:
        for one in key if isinstance(key, tuple) else (key,):
            ends = (one.start, one.stop) if isinstance(one, slice) else (one,)
            for end in ends:
                if isinstance(end, int | np.integer) and end < 0:
                    raise IndexError(f"negative index {key} into {self.shape}")


def guard_kernels() -> None:
    """Let every kernel of the room see guarded arrays; they must run as Python.

    Raises:
        RuntimeError: they are compiled.
    """
    from belvedere.ground import jit

    if not isinstance(jit.kernel(lambda: None), types.FunctionType):
        raise RuntimeError("kernels are compiled: set NUMBA_DISABLE_JIT=1 to guard them")

    def guarded(function: Any) -> Any:
        @functools.wraps(function)
        def call(*args: Any) -> Any:
            return function(*(a.view(Guarded) if type(a) is np.ndarray else a for a in args))

        return call

    room = Path(sys.modules["belvedere.warp.prepare"].__file__ or "").parent
    for path in sorted(room.glob("_[a-z]*.py")):
        module = import_module(f"belvedere.warp.{path.stem}")
        for name, held in list(vars(module).items()):
            if isinstance(held, types.FunctionType) and held.__module__ == module.__name__:
                setattr(module, name, guarded(held))


def main() -> int:
    """Run cases; gives 1 if any failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--cameras", type=int, default=3000, help="how many cases")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--reconstruction", choices=RECONSTRUCTIONS, help="only this one")
    told = parser.parse_args()
    if os.environ.get("NUMBA_DISABLE_JIT") == "1":
        warnings.simplefilter("ignore", RuntimeWarning)  # kernels divide as IEEE says
        guard_kernels()
    began = time.perf_counter()
    failed = failures(range(told.first, told.first + told.cameras), told.reconstruction)
    seconds = time.perf_counter() - began
    print(f"{told.cameras} cameras, {len(failed)} failed: {failed[:20]} ({seconds:.0f} s)")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
