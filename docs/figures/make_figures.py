"""Draw every figure of the documentation: ``python docs/figures/make_figures.py [FOLDER]``.

The drawings are committed; a test compares them with what this script draws.
"""

from __future__ import annotations

import sys
from pathlib import Path

import conventions
import house
import lattice
import quality
import sheets

FIGURES = {
    "frames.svg": conventions.frames,
    "pixels.svg": conventions.pixels,
    "disparity.svg": conventions.disparity,
    "floors.svg": house.floors,
    "flow.svg": house.flow,
    "sheets.svg": sheets.regions,
    "lattice.svg": lattice.lattice,
    "quality.svg": quality.against_time,
}


def main(folder: Path) -> None:
    """Draw them into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        (folder / name).write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
