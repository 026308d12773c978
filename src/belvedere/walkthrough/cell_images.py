"""The pictures that stand for a cell's own polygons where these are too many to draw.

At each of some places in the cell six pictures look all round, the sides of a box that is taller
than wide, so that an eye that looks ahead needs two of them::

        .-------.
        |  up   |        55 degrees up and down at the sides,
    .---+---+---+---.    so most windows meet neither up nor down
    | l | a | r | b |
    '---+---+---+---'
        | down  |
        '-------'

Source: spec portal-walkthrough 1 and 3.1; the box and where it stands are our choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.ground.errors import InputError
from belvedere.model import LitModel, RayCaster, photograph
from belvedere.scene import Camera, ReferenceView, ViewSet

F8 = npt.NDArray[np.float64]

SIDES = 6
"""Pictures at each place."""
SAMPLES = 2
"""Samples per side of a texel."""
RISE_DEG = 55.0
"""How far up and down the four upright ones see."""
OVERLAP = 1.5
"""Texels that neighbouring pictures share beyond their common edge, so that no seam opens."""
NEAR_M = 0.3
"""A picture that shows nothing farther than this from the eye within the window is not warped."""

__all__ = ["CellImageOptions", "CellImages", "box_cameras", "photograph_place", "places_in"]


@dataclass(frozen=True, slots=True)
class CellImageOptions:
    """Which cells are shown by pictures of their own, and how fine these are."""

    polygons: int = 2_000_000
    """Cells with at least so many polygons are; 0 for all cells. Below that drawing them is
    quicker than warping pictures of them."""
    spacing: float = 1.5
    """Every place where a visitor can stand sees one that is at most this many metres away."""
    texels: int = 512
    """Across a right angle, in the pictures that look ahead and aside."""

    def __post_init__(self) -> None:
        owner = "CellImageOptions"
        check_integer(owner, "polygons", self.polygons, 0, 1_000_000_000)
        check_number(owner, "spacing", self.spacing, 0.3, 100.0)
        check_integer(owner, "texels", self.texels, 16, 4096)


def box_cameras(eye: F8, texels: int) -> tuple[Camera, ...]:
    """Six cameras at ``eye`` that see everything: ahead (+x), left, back, right, up, down.

    Args:
        eye: (3,) metres.
        texels: across a right angle, in the middle of a picture.
    """
    focal = texels / 2.0
    rise = np.tan(np.radians(RISE_DEG))
    ways = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])
    across = np.roll(ways, 1, axis=0)  # the direction to the right of each
    down = np.array([0.0, 0.0, -1.0])
    cameras = [
        _facing(eye, way, right, down, focal, 1.0, rise)
        for way, right in zip(ways, across, strict=True)
    ]
    for way in (-down, down):
        right = across[0]
        cameras.append(
            _facing(eye, way, right, np.cross(way, right), focal, 1.0 / rise, 1.0 / rise)
        )
    return tuple(cameras)


def _facing(
    eye: F8, way: F8, right: F8, down: F8, focal: float, half_width: float, half_height: float
) -> Camera:
    width, height = (
        int(np.ceil(2.0 * (focal * half + OVERLAP))) for half in (half_width, half_height)
    )
    corner = way - ((width - 1) / 2.0 * right + (height - 1) / 2.0 * down) / focal
    return Camera(np.stack([right / focal, down / focal, corner], axis=1), eye, width, height)


def places_in(caster: RayCaster, standing: F8, spacing: float, threads: int | None = None) -> F8:
    """(N, 3) eyes out of those where a visitor can stand, such that each of them sees a near one.

    The eye that sees most of those not yet seen within ``spacing`` is taken, again and again.

    Args:
        caster: of the building.
        standing: (M, 3) eyes.
        spacing: metres.
        threads: how many to use.

    Memory: some 100 bytes for each pair of eyes within ``spacing``.
    """
    from scipy.sparse import csr_matrix
    from scipy.spatial import KDTree

    count = len(standing)
    pairs = KDTree(standing).query_pairs(spacing, output_type="ndarray")
    if len(pairs):
        way = standing[pairs[:, 1]] - standing[pairs[:, 0]]
        length = np.linalg.norm(way, axis=1)
        hidden = caster.blocked(standing[pairs[:, 0]], way, 1.0, threads)
        pairs = pairs[~hidden & (length > 0.0)]
    one, other = pairs[:, 0], pairs[:, 1]
    own = np.arange(count)
    rows, columns = np.concatenate([one, other, own]), np.concatenate([other, one, own])
    sees = csr_matrix((np.ones(len(rows), dtype=np.int32), (rows, columns)), (count, count))
    waiting, chosen = np.ones(count, dtype=np.int32), []
    while waiting.any():
        best = int(np.argmax(sees @ waiting))
        chosen.append(best)
        waiting[sees.indices[sees.indptr[best] : sees.indptr[best + 1]]] = 0
    return standing[chosen]


def photograph_place(
    model: LitModel, eye: F8, options: CellImageOptions, threads: int | None = None
) -> tuple[ReferenceView, ...]:
    """Pictures all round from one place, as `box_cameras` orders them.

    Args:
        model: the whole building: what lies beyond doors and windows is in the pictures too.
        eye: (3,) metres.
        options: how fine.
        threads: how many to use.
    """
    cameras = box_cameras(eye, options.texels)
    return tuple(photograph(model, camera, SAMPLES, threads=threads) for camera in cameras)


@dataclass(frozen=True, eq=False)
class CellImages:
    """All pictures of one cell from inside."""

    views: ViewSet
    """`SIDES` for each place, as `box_cameras` orders them; pixels are read when asked for."""

    def __post_init__(self) -> None:
        if len(self.views) == 0 or len(self.views) % SIDES:
            raise InputError(
                f"CellImages.views has {len(self.views)} pictures, expected {SIDES} for each place"
            )

    @cached_property
    def places(self) -> F8:
        """(N, 3) the eyes they were taken from."""
        return np.array([one.camera.center for one in self.views.entries[::SIDES]])

    @cached_property
    def _planes(self) -> F8:
        """(SIDES, 4, 3) the sides of each picture's pyramid, inwards: the same at every place."""
        planes = []
        for entry in self.views.entries[:SIDES]:
            assert isinstance(entry.camera, Camera)
            planes.append(entry.camera.edge_planes)
        return np.array(planes)

    def nearest(self, eye: F8, count: int) -> list[int]:
        """Indices of the places nearest to an eye, nearest first."""
        away = np.linalg.norm(self.places - eye, axis=1)
        return [int(k) for k in np.argsort(away, kind="stable")[:count]]

    def in_sight(self, place: int, camera: Camera) -> list[int]:
        """Indices of a place's views that may show what a camera sees beyond `NEAR_M`.

        A view is left out where all that the camera sees lies on the outer side of one of its four
        sides.
        """
        right, bottom = camera.width - 0.5, camera.height - 0.5
        columns, rows = np.array([-0.5, right, right, -0.5]), np.array([-0.5, -0.5, bottom, bottom])
        rays = camera.rays(columns, rows)
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        near = camera.center + NEAR_M * rays - self.places[place]
        reach = np.maximum(self._planes @ near.T, self._planes @ rays.T).max(axis=2)
        return [place * SIDES + int(k) for k in np.flatnonzero((reach >= 0.0).all(axis=1))]
