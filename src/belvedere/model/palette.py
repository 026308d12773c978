"""The materials of the built-in house: colors and textures, all from one seed."""

from __future__ import annotations

import numpy as np

from belvedere.ground.threads import run_parallel
from belvedere.model import art, textures
from belvedere.model.architecture import Palette
from belvedere.model.charts import Builder

_PLAIN: dict[str, tuple[float, float, float]] = {
    "brass": (0.56, 0.38, 0.15), "iron": (0.035, 0.036, 0.04), "earth": (0.045, 0.03, 0.02),
    "terracotta": (0.50, 0.20, 0.10), "glaze": (0.075, 0.16, 0.22), "celadon": (0.33, 0.46, 0.38),
    "porcelain": (0.80, 0.79, 0.76), "orange": (0.80, 0.27, 0.03), "apple": (0.48, 0.05, 0.03),
    "stem": (0.12, 0.20, 0.06), "leaf0": (0.09, 0.22, 0.07), "leaf1": (0.15, 0.30, 0.08),
    "leaf2": (0.06, 0.17, 0.07), "petal_a": (0.85, 0.42, 0.30), "petal_b": (0.90, 0.72, 0.35),
    "petal_c": (0.78, 0.20, 0.24), "paper": (0.74, 0.70, 0.60), "frame": (0.80, 0.78, 0.73),
    "rug_edge": (0.30, 0.22, 0.15),
}  # fmt: skip

_TINTED: dict[str, tuple[str, tuple[float, float, float]]] = {
    "cream_wall": ("plaster", (0.92, 0.83, 0.68)), "sage_wall": ("plaster", (0.60, 0.66, 0.53)),
    "white_wall": ("plaster", (0.92, 0.89, 0.83)), "ceiling": ("plaster", (0.95, 0.94, 0.91)),
    "trim": ("plaster", (0.93, 0.91, 0.87)), "sofa": ("weave", (0.12, 0.24, 0.27)),
    "armchair": ("weave", (0.66, 0.29, 0.12)), "pillow_a": ("weave", (0.85, 0.53, 0.16)),
    "pillow_b": ("weave", (0.85, 0.76, 0.62)), "curtain": ("weave", (0.93, 0.86, 0.74)),
    "cupboard": ("plaster", (0.23, 0.33, 0.34)), "linen": ("weave", (0.80, 0.76, 0.68)),
}  # fmt: skip

_BOOKS = (
    (0.30, 0.06, 0.05), (0.05, 0.10, 0.18), (0.07, 0.17, 0.10), (0.45, 0.36, 0.22),
    (0.11, 0.07, 0.06), (0.55, 0.49, 0.40), (0.36, 0.18, 0.07), (0.16, 0.20, 0.24),
)  # fmt: skip


def paint_textures(seed: int, threads: int | None = None) -> dict[str, textures.U1]:
    """Every texture of the house by name; each has a random stream of its own."""
    recipes = {
        "planks": textures.planks,
        "oak": lambda r: textures.wood(r, (0.46, 0.29, 0.15)),
        "walnut": lambda r: textures.wood(r, (0.21, 0.11, 0.058)),
        "dark": lambda r: textures.wood(r, (0.085, 0.045, 0.027), 256),
        "plaster": textures.plaster,
        "tiles": textures.cement_tiles,
        "brick": lambda r: textures.bricks(r, (0.42, 0.17, 0.10), (0.46, 0.42, 0.37), 14, 4, 768),
        "subway": lambda r: textures.bricks(
            r, (0.70, 0.74, 0.72), (0.36, 0.35, 0.33), 8, 4, 512, 0.05, 0.025
        ),
        "weave": textures.weave,
        "marble": textures.marble,
        "rug": art.persian_rug,
        "kilim": art.kilim,
        "spines": art.book_spines,
        "seascape": art.seascape,
        "orchard": art.orchard,
        "composition": art.composition,
        "fern": art.botanical,
        "rings": art.rings,
    }
    names = list(recipes)
    painted = run_parallel(
        lambda k: recipes[names[k]](np.random.default_rng([seed, k])), range(len(names)), threads
    )
    return dict(zip(names, painted, strict=True))


def make_palette(b: Builder, seed: int, threads: int | None = None) -> Palette:
    """Add every material of the house to a builder; gives their indices by name."""
    painted = paint_textures(seed, threads)
    white = (1.0, 1.0, 1.0)
    m = {name: b.material(name, white, image) for name, image in painted.items()}
    m |= {name: b.material(name, color) for name, color in _PLAIN.items()}
    for name, (texture, color) in _TINTED.items():
        m[name] = b.material(name, color, painted[texture])
    for k, color in enumerate(_BOOKS):
        m[f"book{k}"] = b.material(f"book{k}", color)
    m["shade"] = b.material("shade", (0.85, 0.74, 0.55), painted["weave"], (0.80, 0.55, 0.29))
    m["shade_inside"] = b.material("shade_inside", (0.9, 0.85, 0.75), None, (1.0, 0.82, 0.55))
    return m


_HOUSE_PLAIN: dict[str, tuple[float, float, float]] = {
    "white_paint": (0.78, 0.77, 0.73), "lacquer": (0.016, 0.015, 0.016),
    "enamel": (0.80, 0.80, 0.78), "copper": (0.55, 0.25, 0.14), "chrome": (0.52, 0.53, 0.54),
    "crystal": (0.62, 0.66, 0.68), "silver": (0.55, 0.58, 0.58), "dark_glass": (0.05, 0.09, 0.05),
    "block0": (0.55, 0.10, 0.07), "block1": (0.10, 0.20, 0.42), "block2": (0.70, 0.48, 0.08),
    "roof": (0.16, 0.13, 0.12),
}  # fmt: skip

_HOUSE_TINTED: dict[str, tuple[str, tuple[float, float, float]]] = {
    "green_wall": ("plaster", (0.34, 0.42, 0.33)), "rose_wall": ("plaster", (0.72, 0.50, 0.44)),
    "blue_wall": ("plaster", (0.52, 0.60, 0.68)), "ochre_wall": ("plaster", (0.78, 0.60, 0.34)),
    "yellow_wall": ("plaster", (0.90, 0.80, 0.50)), "bath_wall": ("bath_tiles", (1.0, 1.0, 1.0)),
    "door": ("plaster", (0.10, 0.17, 0.14)), "white_cloth": ("weave", (0.90, 0.89, 0.86)),
    "towel": ("weave", (0.72, 0.80, 0.78)), "facade": ("brick", (1.0, 1.0, 1.0)),
}  # fmt: skip


def add_house_materials(b: Builder, m: Palette, seed: int, threads: int | None = None) -> None:
    """What the larger houses have besides `make_palette`; adds to ``m``."""
    recipes = {
        "checker": lambda r: textures.checker(r, (0.66, 0.64, 0.60), (0.07, 0.075, 0.08)),
        "bath_tiles": lambda r: textures.bricks(
            r, (0.76, 0.80, 0.80), (0.42, 0.42, 0.40), 14, 7, 1024, 0.04, 0.03
        ),
        "quilt_a": lambda r: textures.patchwork(r, ((0.5, 0.12, 0.1), (0.7, 0.6, 0.42))),
        "quilt_b": lambda r: textures.patchwork(r, ((0.10, 0.2, 0.36), (0.62, 0.66, 0.66))),
        "globe": textures.globe,
    }
    names = list(recipes)
    painted = run_parallel(
        lambda k: recipes[names[k]](np.random.default_rng([seed, 100 + k])),
        range(len(names)),
        threads,
    )
    images = dict(zip(names, painted, strict=True))
    for name in ("checker", "quilt_a", "quilt_b", "globe"):
        m[name] = b.material(name, (1.0, 1.0, 1.0), images[name])
    m |= {name: b.material(name, color) for name, color in _HOUSE_PLAIN.items()}
    for name, (texture, color) in _HOUSE_TINTED.items():
        image = images.get(texture)
        if image is None:
            image = b.materials[m[texture]].texture
        assert image is None or image.dtype == np.uint8
        m[name] = b.material(name, color, image)  # type: ignore[arg-type]
    m["milk_glass"] = b.material("milk_glass", (0.8, 0.78, 0.72), None, (0.85, 0.68, 0.46))
    m["flame"] = b.material("flame", (0.9, 0.8, 0.6), None, (2.6, 1.6, 0.7))
