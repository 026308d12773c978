"""Where a visitor can stand and how far it is to the nearest wall: collision, and random walks.

The floors of a building are places on a grid in plan, several above one another where there are
storeys, linked where a person can step across. What has no link is in the way: walls, furniture
higher than a step, drops. A body is a circle that keeps its radius from all that.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import as_array, check_finite, check_number, check_shape
from belvedere.ground.errors import FileFormatError, InputError, MissingFileError, SceneError
from belvedere.scene.mesh import Mesh
from belvedere.walkthrough.columns import Columns, Grid, Layers, standing_layers, worth_standing

F8 = npt.NDArray[np.float64]
I4 = npt.NDArray[np.int32]

VERSION = 1
SMOOTHING_M = 0.2
"""Over how far steps are rounded for the eye."""

__all__ = ["Body", "FreeSpace"]


@dataclass(frozen=True, slots=True)
class Body:
    """How large a visitor is, in metres."""

    radius: float = 0.25
    """Half the shoulders."""
    head: float = 1.9
    """Free height that the body needs."""
    step: float = 0.25
    """Highest step it climbs."""
    eye: float = 1.6
    """Height of the eyes above the floor."""

    def __post_init__(self) -> None:
        for field, low, high in (
            ("radius", 0.05, 2.0), ("head", 0.5, 5.0), ("step", 0.0, 0.6), ("eye", 0.1, 4.9),
        ):  # fmt: skip
            check_number("Body", field, getattr(self, field), low, high)
        if self.eye > self.head:
            raise InputError(f"Body.eye is {self.eye} m, above its head at {self.head} m")


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The floors of a building that a body can stand on, ready to be walked."""

    layers: Layers
    """Places and their links."""
    far: F8
    """(N,) metres from each place to the nearest thing in the way."""
    body: Body
    """Whose free space it is."""

    @classmethod
    def of_mesh(cls, mesh: Mesh, body: Body | None = None, spacing: float = 0.05) -> FreeSpace:
        """Find the floors of a mesh.

        Door leaves that stand closed in the mesh block their doors: leave them out first (see
        `without_leaves`).

        Args:
            mesh: the building, metres, +z up.
            body: who walks; an adult by default.
            spacing: of the grid, metres; thin things are found whatever it is.

        Raises:
            SceneError: nothing in the mesh, not in metres, or nowhere to stand.
        """
        return cls.of_columns(Columns.of_mesh(mesh, spacing), body)

    @classmethod
    def of_columns(cls, columns: Columns, body: Body | None = None) -> FreeSpace:
        """As `of_mesh`, for a building already cut into columns."""
        body = body or Body()
        layers, front = standing_layers(columns, body.head, body.step)
        layers = layers.take(worth_standing(layers, front))
        if not len(layers.column):
            raise SceneError(
                f"The model has no floor: nowhere can a body {body.head:g} m high stand. Is +z "
                "up, and is its unit the metre?"
            )
        return cls(layers, layers.distance(), body)

    @cached_property
    def smooth_floor(self) -> F8:
        """(N,) floor heights with the steps rounded off, metres above the grid's corner."""
        from belvedere.walkthrough import _span_kernels

        rounds = max(round(2.5 * (SMOOTHING_M / self.layers.grid.spacing) ** 2), 1)
        one, two = np.empty_like(self.layers.floor), np.empty_like(self.layers.floor)
        _span_kernels.smooth_floor(self.layers.link, self.layers.floor, min(rounds, 100), one, two)
        return one

    @cached_property
    def _first(self) -> npt.NDArray[np.int64]:
        return self.layers.first()

    @cached_property
    def _free(self) -> I4:
        """Places where a body fits."""
        return np.flatnonzero(self.far >= self.body.radius).astype(np.int32)

    def place(self, position: npt.ArrayLike) -> F8:
        """(3,) eye position nearest to ``position`` at which a body fits.

        Raises:
            SceneError: a body fits nowhere.
        """
        p = self._local(position)
        if not len(self._free):
            raise SceneError(f"A body of radius {self.body.radius:g} m fits nowhere in this model")
        foot = p - [0.0, 0.0, self.body.eye]
        at = self.layers.centers[self._free]
        # another storey is farther away than it looks
        apart = (at - foot[:2]) ** 2
        rise = 3.0 * (self.layers.floor[self._free] - foot[2])
        n = int(self._free[np.argmin(apart.sum(axis=1) + rise**2)])
        if n == self._under(p):
            return self._eye(n, p[0], p[1])
        center = self.layers.centers[n]
        return self._eye(n, center[0], center[1])

    def eyes(self, spacing: float = 0.25) -> F8:
        """(N, 3) eye positions at which a body fits, about so many metres apart on every floor."""
        check_number("FreeSpace.eyes", "spacing", spacing, 0.0)
        step = max(round(spacing / self.layers.grid.spacing), 1)
        column, nx = self.layers.column[self._free], self.layers.grid.nx
        chosen = self._free[((column % nx) % step == 0) & ((column // nx) % step == 0)]
        heights = self.smooth_floor[chosen] + self.body.eye
        return np.column_stack([self.layers.centers[chosen], heights]) + self.layers.grid.origin

    def standable(self, position: npt.ArrayLike) -> bool:
        """Whether there is a floor under an eye at ``position``."""
        return self._under(self._local(position)) >= 0

    def clearance(self, position: npt.ArrayLike) -> float:
        """Metres from an eye to the nearest thing in the way of its body; 0 where it cannot be."""
        from belvedere.walkthrough._walk_kernels import field

        p = self._local(position)
        n = self._under(p)
        if n < 0:
            return 0.0
        grid, layers = self.layers.grid, self.layers
        edge = -0.5 * grid.spacing
        args = (layers.link, layers.column, grid.nx, grid.spacing, self.far, n, p[0], p[1])
        return max(float(field(*args, edge, False)[0]), 0.0)

    def walk(self, position: npt.ArrayLike, step: npt.ArrayLike) -> F8:
        """(3,) where a visitor is after a step.

        He slides along walls and furniture, passes doors, climbs stairs and keeps his eyes at
        their height above the floor. Many small steps lead where one long one does.

        Args:
            position: (3,) eye, world metres. Where nobody can stand, the nearest place is taken.
            step: (2,) or (3,) metres; only x and y count.

        Raises:
            InputError: wrong shapes, numbers that are not finite, a step over 100 m.
        """
        from belvedere.walkthrough._walk_kernels import stroll

        p = self._local(position)
        move = as_array("FreeSpace.walk", "step", step)
        if move.shape not in ((2,), (3,)):
            raise InputError(f"FreeSpace.walk.step has shape {move.shape}, expected (2,) or (3,)")
        check_finite("FreeSpace.walk", "step", move)
        if np.hypot(move[0], move[1]) > 100.0:
            raise InputError("FreeSpace.walk.step is over 100 m long: steps are in metres a frame")
        n = self._under(p)
        if n < 0:
            p = self._local(self.place(position))
            n = self._under(p)
        grid, layers, at = self.layers.grid, self.layers, np.empty(2)
        n = stroll(
            layers.link, layers.column, grid.nx, grid.spacing, self.far, self.body.radius, n,
            p[0], p[1], move[0], move[1], grid.spacing / 2.0, at,
        )  # fmt: skip
        return self._eye(n, at[0], at[1])

    def save(self, path: str | Path) -> None:
        """Write it as .npz, atomically.

        Raises:
            OutputError: the file cannot be written.
        """
        from belvedere.scene.io import atomic_write

        grid, body = self.layers.grid, self.body
        with atomic_write(path) as temporary, Path(temporary).open("wb") as file:
            np.savez_compressed(
                file,
                version=VERSION,
                grid=np.array([*grid.origin, grid.spacing, grid.nx, grid.ny]),
                body=np.array([getattr(body, entry.name) for entry in fields(body)]),
                column=self.layers.column,
                floor=self.layers.floor,
                ceiling=self.layers.ceiling,
                link=self.layers.link,
                far=self.far,
            )

    @classmethod
    def load(cls, path: str | Path) -> FreeSpace:
        """Read what `save` wrote.

        Raises:
            MissingFileError: no such file.
            FileFormatError: not such a file, or of a newer version.
        """
        file = Path(path)
        if not file.is_file():
            raise MissingFileError(f"{file}: no such file")
        try:
            with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as data:
                parts: dict[str, Any] = {name: data[name] for name in data.files}
            if int(parts["version"]) != VERSION:
                raise FileFormatError(
                    f"{file}: version {int(parts['version'])}, this belvedere reads {VERSION}: "
                    "prepare the scene again"
                )
            x, y, z, spacing, nx, ny = parts["grid"].tolist()
            layers = Layers(
                Grid((x, y, z), spacing, int(nx), int(ny)),
                parts["column"], parts["floor"], parts["ceiling"], parts["link"],
            )  # fmt: skip
            space = cls(layers, parts["far"], Body(*parts["body"].tolist()))
        except FileFormatError:
            raise
        except Exception as error:  # zip, NumPy and our own checks each say it in their way
            raise FileFormatError(f"{file}: no free space of ours: {error}") from error
        space._check(file)
        return space

    def _check(self, file: Path) -> None:
        layers, count = self.layers, len(self.layers.column)
        fits = (
            layers.link.shape == (count, 4)
            and layers.link.dtype == layers.column.dtype == np.int32
            and all(a.shape == (count,) for a in (layers.floor, layers.ceiling, self.far))
            and count > 0
            and layers.link.min() >= -1
            and layers.link.max() < count
            and layers.column.min() >= 0
            and layers.column.max() < layers.grid.nx * layers.grid.ny
            and bool((np.diff(layers.column) >= 0).all())
        )
        if not fits:
            raise FileFormatError(f"{file}: its arrays do not fit together: write it again")

    def _local(self, position: npt.ArrayLike) -> F8:
        p = as_array("FreeSpace", "position", position)
        check_shape("FreeSpace", "position", p, (3,))
        check_finite("FreeSpace", "position", p)
        return p - np.array(self.layers.grid.origin)

    def _under(self, p: F8) -> int:
        """The place an eye at a local position stands on, or -1."""
        grid = self.layers.grid
        i, j = (int(c) for c in np.floor(np.clip(p[:2] / grid.spacing, -1, 1e6)))
        if not (0 <= i < grid.nx and 0 <= j < grid.ny):
            return -1
        a, b = self._first[j * grid.nx + i], self._first[j * grid.nx + i + 1]
        if a == b:
            return -1
        off = np.abs(self.smooth_floor[a:b] - (p[2] - self.body.eye))
        best = int(np.argmin(off))
        return int(a) + best if off[best] <= 2.0 * self.body.step + 0.1 else -1

    def _eye(self, n: int, x: float, y: float) -> F8:
        from belvedere.walkthrough._walk_kernels import field

        grid, layers = self.layers.grid, self.layers
        args = (layers.link, layers.column, grid.nx, grid.spacing, self.smooth_floor, n, x, y)
        height = field(*args, 0.0, True)[0]
        return np.array([x, y, height + self.body.eye]) + np.array(grid.origin)
