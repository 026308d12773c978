"""Asking references backwards: sound for any camera, and never outside an array."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import belvedere as bv
from belvedere.warp import FEATURE_FILTERS
from tests.warp.test_inverse import run_apart, warp_of_anything


def explain_anything(rng: np.random.Generator, n: int) -> int:
    """Explain a warp of anything, with features; gives how many pixels are covered."""
    views, frame = warp_of_anything(rng, n)
    given = []
    for k, view in enumerate(views):
        features = np.full((*view.disparity.shape, 2), k, np.float32)
        if n % 4 == 3:
            features[::2] = np.nan
        given.append(bv.ReferenceView(view.camera, view.color, view.disparity, features))
    frame = bv.warp(given, frame.camera, threads=1, explain=True,
                    feature_filter=FEATURE_FILTERS[n % 3])  # fmt: skip
    why, covered = frame.explanation, frame.coverage > 0
    assert why is not None
    assert frame.features is not None
    np.testing.assert_array_equal(why.hole == bv.Hole.COVERED, covered)
    np.testing.assert_array_equal(np.isnan(why.error), ~covered)
    assert (why.source[covered] >= 0).all(), n
    assert (why.source[covered] < len(views)).all()
    assert (why.source[~covered] == -1).all()
    assert (why.seen_by < 1 << len(views)).all()
    assert np.isnan(frame.features[~covered]).all()
    if n % 4 != 3:
        known = frame.features[covered]
        assert ((known > -1e-3) & (known < len(views) - 1 + 1e-3)).all(), n
    return int(covered.sum())


def test_a_thousand_warps_of_anything_are_explained_soundly() -> None:
    rng = np.random.default_rng(50)
    assert sum(explain_anything(rng, n) for n in range(1000)) > 2_500


GUARDED = """
import functools, types, warnings
import numpy as np
warnings.simplefilter("ignore", RuntimeWarning)  # kernels divide as IEEE says
from belvedere.warp import _backward, _explain, _features, _gaps
assert not hasattr(_backward.weigh, "py_func"), "these kernels are compiled"

class Guarded(np.ndarray):
    '''Refuses what wraps round in Python and overruns in compiled code.'''
    def __getitem__(self, key):
        self.check(key)
        return super().__getitem__(key)
    def __setitem__(self, key, value):
        self.check(key)
        super().__setitem__(key, value)
    def check(self, key):
        for one in key if isinstance(key, tuple) else (key,):
            ends = (one.start, one.stop) if isinstance(one, slice) else (one,)
            for end in ends:
                if isinstance(end, (int, np.integer)) and end < 0:
                    raise IndexError(f"negative index {key} into {self.shape}")

def guarded(function):
    @functools.wraps(function)
    def call(*args):
        return function(*(a.view(Guarded) if type(a) is np.ndarray else a for a in args))
    return call

for module in (_backward, _explain, _features, _gaps):
    for name, held in list(vars(module).items()):
        if isinstance(held, types.FunctionType) and held.__module__ == module.__name__:
            setattr(module, name, guarded(held))
from tests.warp.test_backward import explain_anything
rng = np.random.default_rng(51)
for n in range(30):
    if n % 6 != 5:  # two tiles across take long without the compiler
        explain_anything(rng, n)
print("sound")
"""
BOUNDED = """
import numpy as np
from tests.warp.test_backward import explain_anything
rng = np.random.default_rng(52)
for n in range(300):
    explain_anything(rng, n)
print("sound")
"""


def test_interpreted_kernels_stay_inside_their_arrays_at_either_end() -> None:
    done = run_apart(GUARDED, NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip() == "sound"


@pytest.mark.slow  # compiles every kernel anew
def test_compiled_kernels_with_checked_indices_stay_inside_their_arrays(tmp_path: Path) -> None:
    done = run_apart(BOUNDED, NUMBA_BOUNDSCHECK="1", NUMBA_CACHE_DIR=str(tmp_path))
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip() == "sound"
