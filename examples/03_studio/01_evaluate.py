"""How good is it? Hold views out and predict them.

Three views of a walk through the hall are held out, and each is predicted from the two best of the
others, by each reconstructor. The report folder has `report.html`, one page that needs no network,
and `report.json` for programs. `evaluate.png` shows one held-out view, from the left: the truth,
the prediction, the signed difference (grey is right) and the coverage.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import belvedere as bv
from belvedere.model import build_interior, photograph
from belvedere.scene.io import write_color
from belvedere.studio import coverage_picture, evaluate_to_report, signed_difference


def main(output: Path) -> None:
    house = build_interior(seed=0, rays=64)
    cameras = house.reference_cameras(36, width=260, height=208)[20:29]
    views = bv.ViewSet.of([photograph(house, camera) for camera in cameras])

    result = evaluate_to_report(
        views, output / "report", title="The built-in hall", hold_out=(2, 4, 6),
        references=2, reconstructions="all", repeats=1, force=True,
    )  # fmt: skip
    print(f"held out: {', '.join(result.held_out)} of {result.view_count} views")
    for line in result.summaries:
        print(
            f"{line.reconstruction:7} PSNR {line.psnr_common:.1f} dB on common pixels, "
            f"{line.psnr_whole:.1f} dB with holes filled, holes {line.hole_fraction:.1%}"
        )

    scene = bv.DepthViews(views, references=2)
    truth = views[4]
    frame = scene.render(truth.camera, exclude=[4])
    known = frame.coverage > 0
    pictures = [
        truth.color,
        frame.color,
        signed_difference(frame.color, truth.color, known),
        coverage_picture(frame.color, frame.coverage),
    ]
    write_color(output / "evaluate.png", np.hstack(pictures))


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "examples-output"))
