"""What a frame knows about itself.

Which reference does a pixel come from? Is a hole a crack, where samples lie too far apart, or was
it seen by nobody? How far off may the colour be? `explain.png`, top row: a desired view between two
references, and which of them each pixel comes from. Bottom row: the holes of the quickest
reconstruction, of three kinds, and the error to expect of the best one, which is large where the
picture is fine, at silhouettes, and where no reference confirms what is shown.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import add_legend, explained_pictures, picture_with_holes


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    desired = bv.Camera.look_at(
        (5.75, 2.5, 1.6), (7.3, 0.9, 0.8), fov_deg=58, width=360, height=288
    )
    aside = 0.35 * desired.matrix[:, 0] / np.linalg.norm(desired.matrix[:, 0])  # to the right
    views = [photograph(house, desired.moved(desired.center + s * aside)) for s in (-1, 1.2)]

    best = bv.warp(views, desired, explain=True)
    quick = bv.warp(views, desired, reconstruction="point", explain=True)
    assert best.explanation is not None
    assert quick.explanation is not None
    shown = explained_pictures(best, best.explanation, ["from the left", "from the right"])
    holes = explained_pictures(quick, quick.explanation)["holes"]
    plain = add_legend(picture_with_holes(best.color, best.coverage), [("hole", (214, 71, 99))])
    write_color(
        output / "explain.png",
        np.vstack([np.hstack([plain, shown["source"]]), np.hstack([holes, shown["error"]])]),
    )

    for name, frame in (("inverse", best), ("point", quick)):
        why = frame.explanation
        assert why is not None
        kinds = ", ".join(
            f"{kind.name.lower()} {why.share(kind):.2%}" for kind in bv.Hole if kind > 0
        )
        print(f"holes of {name:7}: {kinds}")
    truth = photograph(house, desired).color
    known = best.coverage > 0
    off = np.sqrt(((best.color / 255.0 - truth / 255.0) ** 2).mean(axis=2))[known]
    expected = best.explanation.error[known]
    rank = spearmanr(expected, off)[0]
    mean, true = (np.sqrt((each**2).mean()) for each in (expected, off))
    print(f"expected error {mean:.4f}, true {true:.4f}")
    print(f"rank correlation of the two, pixel by pixel: {rank:.2f}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
