"""Where the warp's picture is judged: stations in the built-in house, photographed with the truth.

A station is a desired camera and five references round it, as somebody leaves them who walks
through a room taking pictures: the first two on either side at arm's length, the others further
off, higher and lower. Embree says for each desired pixel which of them truly saw its surface, so
that what a warp leaves out, invents or misplaces can be counted.

::

            3                      desired eye at +, references numbered from the nearest;
       1  +    2   5               each looks the same way give or take some degrees
          4
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer
from belvedere.ground.progress import Progress, silent
from belvedere.scene import Camera, ReferenceView

if TYPE_CHECKING:
    from belvedere.model import Interior

F4 = npt.NDArray[np.float32]
F8 = npt.NDArray[np.float64]
U1 = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

FOV_DEG = 60.0
SAMPLES = 4
"""Colour is the mean of so many samples squared in a pixel; disparity is its centre's."""
LIGHT_RAYS = 96
"""Rays of baked light; the pictures differ from the house's best by no more than shades."""
OCCLUSION_TOLERANCE = 1e-3
"""Share of the way to a surface that a ray may fall short of it and still reach it: Embree's
``float32`` and the width of an edge, below any two surfaces of the house that matter."""


class Stand(NamedTuple):
    """A reference beside a desired camera: metres in its level frame, degrees of turn."""

    right: float
    ahead: float
    up: float
    yaw: float
    """To the left."""
    pitch: float
    """Upwards."""
    roll: float
    """Clockwise."""


class Place(NamedTuple):
    """A desired camera and what stands round it."""

    name: str
    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    stands: tuple[Stand, ...]


HOUSE_SEED, HELD_OUT_SEED = 0, 7
PLACES: tuple[Place, ...] = (
    Place("living room", (1.15, 1.1, 1.55), (3.6, 2.9, 0.75), (
        Stand(-0.26, -0.08, 0.03, -3.0, 1.0, 0.5), Stand(0.31, 0.12, -0.04, 4.0, -1.5, -0.8),
        Stand(0.12, 0.40, 0.22, 2.0, -4.0, 0.0), Stand(-0.45, 0.25, -0.25, -6.0, 3.0, 1.0),
        Stand(0.62, -0.30, 0.30, 7.0, -3.0, -1.0),
    )),
    Place("kitchen", (5.95, 2.75, 1.5), (7.5, 1.0, 0.8), (
        Stand(-0.18, -0.22, -0.02, -4.0, 1.5, 0.4), Stand(0.22, 0.27, 0.05, 3.0, -2.0, -0.5),
        Stand(0.42, -0.15, 0.10, 6.0, -1.0, 0.0), Stand(0.10, -0.20, 0.45, 1.0, -8.0, 0.7),
        Stand(0.55, 0.20, -0.40, 8.0, 6.0, -1.2),
    )),
    Place("hall", (6.4, 5.2, 1.6), (3.4, 7.2, 1.7), (
        Stand(-0.33, 0.05, 0.02, -5.0, 0.5, -0.3), Stand(0.38, -0.14, -0.05, 5.0, 1.0, 0.6),
        Stand(-0.10, 0.45, -0.20, -2.0, 4.0, 0.0), Stand(0.30, 0.35, 0.35, 4.0, -3.0, 1.0),
        Stand(-0.20, -0.55, -0.30, 3.0, 3.0, -0.6),
    )),
)  # fmt: skip
"""What is looked at while a reconstructor is being made."""
HELD_OUT_PLACES: tuple[Place, ...] = (
    Place("living room, back", (4.1, 1.5, 1.5), (0.6, 3.0, 1.0), (
        Stand(-0.27, 0.12, -0.05, -4.0, 1.0, 1.0), Stand(0.24, -0.20, 0.06, 3.0, -1.0, -0.7),
        Stand(0.20, 0.36, -0.15, 2.0, 3.0, 0.0), Stand(0.30, 0.10, 0.40, 5.0, -6.0, 0.5),
        Stand(-0.40, -0.30, 0.35, -7.0, -4.0, -1.0),
    )),
    Place("kitchen, window", (8.35, 2.6, 1.45), (6.5, 0.9, 0.85), (
        Stand(0.27, 0.10, 0.04, 4.0, -1.0, -0.5), Stand(-0.32, 0.17, -0.03, -3.0, 0.5, 0.4),
        Stand(0.15, -0.42, 0.08, 2.0, -1.0, 0.3), Stand(-0.25, 0.05, 0.45, -3.0, -7.0, 0.0),
        Stand(0.50, 0.25, -0.35, 8.0, 5.0, -0.9),
    )),
    Place("hall, stairs", (2.6, 5.3, 1.6), (6.4, 7.2, 1.5), (
        Stand(-0.20, 0.26, 0.05, -4.0, -0.5, 0.3), Stand(0.25, -0.28, -0.02, 5.0, 0.5, -0.6),
        Stand(-0.44, -0.12, -0.10, -6.0, 2.0, 0.0), Stand(0.05, 0.38, 0.40, 1.0, -5.0, 0.8),
        Stand(-0.35, -0.50, -0.30, -5.0, 4.0, -1.0),
    )),
)  # fmt: skip
"""Other rooms' corners in a house of another seed: for checking that what was tuned still holds."""
MOST_REFERENCES = len(PLACES[0].stands)


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A desired view with its truth, and the references it is to be predicted from."""

    name: str
    references: tuple[ReferenceView, ...]
    """Nearest to the desired eye first; ``uint8`` colour, exact disparity, 0 in the sky."""
    camera: Camera
    """The desired camera."""
    color: U1
    """(H, W, 3) sRGB: what it truly shows, supersampled."""
    disparity: F4
    """(H, W) of the ray through each pixel's centre, 1/metre; 0 in the sky."""
    seen_by: Mask
    """(references, H, W) whether a reference truly saw the surface at the pixel's centre."""

    @property
    def slug(self) -> str:
        """The name as part of a file's name."""
        return _slug(self.name)

    def views(self, count: int) -> tuple[ReferenceView, ...]:
        """The ``count`` nearest references."""
        return self.references[: check_integer("Station", "count", count, 1, len(self.references))]

    def seen(self, count: int) -> Mask:
        """(H, W) whether any of the ``count`` nearest references truly saw a pixel's surface."""
        count = check_integer("Station", "count", count, 1, len(self.references))
        return np.logical_or.reduce(self.seen_by[:count])


def make_stations(
    size: int = 512,
    held_out: bool = False,
    cache: Path | None = None,
    threads: int | None = None,
    progress: Progress = silent,
) -> list[Station]:
    """Photograph three stations in different rooms.

    Args:
        size: pixels along both sides of every picture.
        held_out: other stations in a house with other textures, for checking what was tuned.
        cache: folder in which the pictures are kept between processes; None keeps nothing. A file
            made by other cameras or for another size is made anew.
        threads: how many photograph (the house is built by all there are); the pictures do not
            depend on it.
        progress: told how far it is.

    Raises:
        InputError: a size below 16 or above 4096.
        MissingDependencyError: embreex is not installed.
    """
    size = check_integer("make_stations", "size", size, 16, 4096)
    places = HELD_OUT_PLACES if held_out else PLACES
    stations = []
    for index, place in enumerate(places):
        progress(index, len(places), "photographing stations")
        file = None if cache is None else cache / f"station-{_slug(place.name)}-{size}.npz"
        station = None if file is None else _load(file, place, size)
        if station is None:
            station = _photograph(_house(held_out), place, size, threads)
            if file is not None:
                _save(file, station)
        stations.append(station)
    progress(len(places), len(places), "photographing stations")
    return stations


def station_cameras(place: Place, size: int) -> tuple[Camera, list[Camera]]:
    """The desired camera of a place, and its references, nearest first."""
    eye, target = np.array(place.eye), np.array(place.target)
    desired = Camera.look_at(eye, target, fov_deg=FOV_DEG, width=size, height=size)
    look = target - eye
    azimuth = np.arctan2(look[1], look[0])
    height = np.arctan2(look[2], np.hypot(look[0], look[1]))
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    side = np.array([level[1], -level[0], 0.0])
    cameras = []
    for stand in place.stands:
        at = eye + stand.right * side + stand.ahead * level + np.array([0, 0, stand.up])
        yaw, pitch = azimuth + np.radians(stand.yaw), height + np.radians(stand.pitch)
        forward = np.array(
            [np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)]
        )
        across = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
        upward = np.array([0.0, 0.0, 1.0]) + np.tan(np.radians(stand.roll)) * across
        cameras.append(
            Camera.look_at(at, at + forward, upward, FOV_DEG, width=size, height=size)
        )  # fmt: skip
    return desired, cameras


@lru_cache(maxsize=1)
def _house(held_out: bool) -> Interior:
    from belvedere.model import build_interior

    return build_interior(HELD_OUT_SEED if held_out else HOUSE_SEED, LIGHT_RAYS)


def _photograph(house: Interior, place: Place, size: int, threads: int | None) -> Station:
    from belvedere.model import photograph

    camera, others = station_cameras(place, size)
    truth = photograph(house, camera, SAMPLES, threads=threads)
    references = tuple(photograph(house, one, SAMPLES, threads=threads) for one in others)
    seen = truly_seen(house, camera, truth.disparity, others, threads)
    return Station(place.name, references, camera, truth.color, truth.disparity, seen)


def truly_seen(
    house: Interior, camera: Camera, disparity: F4, others: list[Camera], threads: int | None = None
) -> Mask:
    """Which cameras see the surface at the centre of each pixel of ``camera``.

    A camera sees it where the point projects into its picture (its border's half pixels included),
    nothing stands on the way to it, and the surface turns the same side to both eyes.

    Args:
        house: what stands there.
        camera: the desired camera.
        disparity: (H, W) exact disparity of its pixel centres; 0 is the sky, a direction alone.
        others: planar cameras.
        threads: how many to use.

    Returns:
        (len(others), H, W).
    """
    v, u = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1)
    rays, delta = camera.rays(u, v), disparity.reshape(-1).astype(np.float64)
    sky = delta == 0
    normals = house.mesh.normals()
    origins = np.broadcast_to(camera.center, rays.shape)
    face = house.caster.cast(origins, rays, threads).face
    outward = np.where(sky[:, None], 0.0, normals[face])
    result = np.zeros((len(others), *disparity.shape), bool)
    for index, other in enumerate(others):
        # towards the point, in lengths of one over its disparity: the sky needs no point
        toward = rays + delta[:, None] * (camera.center - other.center)
        image = toward @ np.linalg.inv(other.matrix).T
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = image[:, 0] / image[:, 2], image[:, 1] / image[:, 2]
        inside = (image[:, 2] > 0) & (abs(x - (other.width - 1) / 2) <= other.width / 2)
        inside &= abs(y - (other.height - 1) / 2) <= other.height / 2
        facing = np.einsum("ij,ij->i", outward, toward) * np.einsum("ij,ij->i", outward, rays) > 0
        asked = np.flatnonzero(inside & (facing | sky))
        scale = np.where(sky, 1.0, 1.0 / np.where(sky, 1.0, delta))[asked]
        way = toward[asked] * scale[:, None]
        hits = house.caster.cast(np.broadcast_to(other.center, way.shape), way, threads)
        free = np.where(sky[asked], np.isinf(hits.t), hits.t >= 1.0 - OCCLUSION_TOLERANCE)
        result[index].reshape(-1)[asked] = free
    return result


def _slug(name: str) -> str:
    return name.replace(",", "").replace(" ", "-")


def _matrices(place: Place, size: int) -> F8:
    """(1 + references, 3, 4) what a kept file must have been made with."""
    camera, others = station_cameras(place, size)
    return np.array([np.column_stack([one.matrix, one.center]) for one in (camera, *others)])


def _save(file: Path, station: Station) -> None:
    from belvedere.scene.io.atomic import atomic_write

    cameras = [station.camera, *(view.camera for view in station.references)]
    planar = [one for one in cameras if isinstance(one, Camera)]
    with atomic_write(file) as temporary:
        np.savez(
            temporary,
            cameras=np.array([np.column_stack([one.matrix, one.center]) for one in planar]),
            colors=np.array([station.color, *(view.color for view in station.references)]),
            disparities=np.array(
                [station.disparity, *(view.disparity for view in station.references)]
            ),
            seen=station.seen_by,
        )


def _load(file: Path, place: Place, size: int) -> Station | None:
    """What is kept, or None if nothing is or it was made with other cameras."""
    if not file.is_file():
        return None
    with np.load(file, allow_pickle=False) as kept:
        cameras, colors = kept["cameras"], kept["colors"]
        disparities, seen = kept["disparities"], kept["seen"]
    wanted = _matrices(place, size)
    if cameras.shape != wanted.shape or not np.allclose(cameras, wanted, rtol=0, atol=1e-12):
        return None
    camera, others = station_cameras(place, size)
    references = tuple(
        ReferenceView(one, color, disparity)
        for one, color, disparity in zip(others, colors[1:], disparities[1:], strict=True)
    )
    return Station(place.name, references, camera, colors[0], disparities[0], seen)
