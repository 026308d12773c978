"""The rasterizer's kernels as plain Python, where a read beyond an array's end raises."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("embreex", reason="ray casting needs embreex (pip install 'belvedere[model]')")

from belvedere.model import LitModel, Rasterizer
from belvedere.scene import Camera
from belvedere.scene.mesh import Material
from tests.model.test_rasterize import evenly_lit
from tests.oracles.raster import nearest_faces

FOLDER = Path(__file__).resolve().parents[2]
GUARDED = """
import numpy as np
from belvedere.model import _raster_setup
assert not hasattr(_raster_setup.set_up, "py_func"), "these kernels are compiled"
from tests.model.test_drawing_guarded import draw_anything
for seed in range(24):
    draw_anything(seed)
print("sound")
"""


def draw_anything(seed: int) -> None:
    """A few quads near the eye, round it or far away, textured by few texels or many."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-2, 1.5)
    quads = rng.uniform((1, -3, -3), (7, 3, 3), (5, 1, 3)) + rng.uniform(-size, size, (5, 4, 3))
    quads[:, 3] = quads[:, 0] + quads[:, 2] - quads[:, 1]
    model = evenly_lit(quads)
    if seed % 2:
        height, width = rng.integers(1, 20, 2)
        texture = rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
        mesh = replace(
            model.mesh,
            materials=(Material("spots", texture=texture),),
            uv=rng.normal(0, 2, (10, 3, 2)).astype(np.float32),
            colors=rng.random((10, 3, 3)).astype(np.float32) if seed % 4 == 1 else None,
        )
        model = LitModel(mesh, model.charts, model.light)
    width, height = rng.integers(1, 24, 2)
    camera = Camera.look_at(rng.normal(0, 1, 3), rng.normal((4, 0, 0), 0.5),
                            fov_deg=float(rng.uniform(20, 120)),
                            width=int(width), height=int(height))  # fmt: skip
    with np.errstate(all="ignore"):  # kernels divide as IEEE says
        face, _ = nearest_faces(model.mesh, camera)
        color, disparity, drawn = Rasterizer(model, 1).draw(camera)
    assert np.count_nonzero(face != drawn) <= 1 + 0.03 * face.size
    assert ((drawn >= 0) == (disparity > 0)).all()
    assert np.isfinite(disparity).all()
    assert color.shape == (*camera.size, 3)


@pytest.mark.parametrize("seed", range(24))
def test_whatever_stands_there_is_what_rays_meet(seed: int) -> None:
    draw_anything(seed)


def test_interpreted_kernels_stay_inside_their_arrays() -> None:
    done = subprocess.run(
        [sys.executable, "-c", GUARDED], cwd=FOLDER,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip() == "sound"
