"""Ray casting on triangles through Embree.

Embree works in float32: it is trusted with *which* face a ray meets; whoever needs an exact
distance intersects the ray with that face's plane in float64 (`photograph` does).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import InputError, MissingDependencyError
from belvedere.ground.threads import run_parallel
from belvedere.scene.mesh import Mesh

__all__ = ["CHUNK", "Hits", "RayCaster"]

CHUNK = 1 << 16
"""Rays per piece of work. Fixed, so that results cannot depend on the number of threads."""


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """What N rays met first."""

    t: npt.NDArray[np.float32]
    """(N,) distance in lengths of the direction; inf where nothing was met."""
    face: npt.NDArray[np.int32]
    """(N,) face index; -1 where nothing was met."""
    barycentric: npt.NDArray[np.float32]
    """(N, 2) weights of the face's second and third corner."""


class RayCaster:
    """A mesh made ready for rays. Several threads may cast at once."""

    def __init__(self, mesh: Mesh) -> None:
        """Build Embree's hierarchy over the mesh.

        Raises:
            MissingDependencyError: embreex is not installed.
            InputError: the mesh has no faces.
        """
        if not len(mesh.faces):
            raise InputError("RayCaster.mesh has no faces: there is nothing to cast rays at")
        self.mesh = mesh
        self._scene = _embree_scene(mesh)

    def cast(
        self, origins: npt.ArrayLike, directions: npt.ArrayLike, threads: int | None = None
    ) -> Hits:
        """The first face that each ray meets, from either side.

        Args:
            origins: (N, 3) world positions, metres.
            directions: (N, 3) of any length but zero; `Hits.t` counts in these lengths.
            threads: how many to use; None for as many as there are processors.
        """
        start, along = _check_rays(origins, directions)
        face = np.empty(len(start), dtype=np.int32)
        t = np.empty(len(start), dtype=np.float32)
        barycentric = np.empty((len(start), 2), dtype=np.float32)

        def piece(first: int) -> None:
            part = slice(first, first + CHUNK)
            found = self.cast_piece(start[part], along[part])
            face[part], t[part] = found["primID"], found["tfar"]
            barycentric[part, 0], barycentric[part, 1] = found["u"], found["v"]

        run_parallel(piece, range(0, len(start), CHUNK), threads)
        t[face < 0] = np.inf
        return Hits(t, face, barycentric)

    def blocked(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        reach: npt.ArrayLike = np.inf,
        threads: int | None = None,
    ) -> npt.NDArray[np.bool_]:
        """(N,) whether anything stands within ``reach`` lengths of each direction.

        Any face ends the search, so this is quicker than `cast`: what shadows need.
        """
        start, along = _check_rays(origins, directions)
        limit = np.broadcast_to(np.asarray(reach, dtype=np.float32), (len(start),))
        result = np.empty(len(start), dtype=bool)

        def piece(first: int) -> None:
            part = slice(first, first + CHUNK)
            result[part] = self.blocked_piece(start[part], along[part], limit[part])

        run_parallel(piece, range(0, len(start), CHUNK), threads)
        return result

    def cast_piece(
        self, origins: npt.NDArray[np.float32], directions: npt.NDArray[np.float32]
    ) -> dict[str, npt.NDArray[Any]]:
        """Embree's own answer (primID, tfar, u, v) for contiguous float32 rays, unchecked."""
        return self._scene.run(origins, directions, query="INTERSECT", output=True)

    def blocked_piece(
        self,
        origins: npt.NDArray[np.float32],
        directions: npt.NDArray[np.float32],
        reach: npt.NDArray[np.float32],
    ) -> npt.NDArray[np.bool_]:
        """As `blocked`, for contiguous float32 rays, unchecked and on this thread alone."""
        limit = np.ascontiguousarray(np.minimum(reach, np.float32(1e30)))
        return self._scene.run(origins, directions, query="OCCLUDED", dists=limit) >= 0


def _embree_scene(mesh: Mesh) -> Any:
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as error:
        raise MissingDependencyError.for_extra("embreex", "model", "cast rays") from error
    scene = EmbreeScene(robust=True)  # watertight: no light between neighbouring triangles
    TriangleMesh(scene, mesh.vertices.astype(np.float32), mesh.faces)
    # The first ray commits the scene, and two threads must not both do that.
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
    return scene


def _check_rays(
    origins: npt.ArrayLike, directions: npt.ArrayLike
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    start = np.ascontiguousarray(origins, dtype=np.float32)
    along = np.ascontiguousarray(directions, dtype=np.float32)
    if start.ndim != 2 or start.shape[1] != 3 or start.shape != along.shape:
        raise InputError(
            f"RayCaster: origins {start.shape} and directions {along.shape} must both be (N, 3)"
        )
    for name, value in (("origins", start), ("directions", along)):
        bad = np.flatnonzero(~np.isfinite(value).all(axis=1))
        if len(bad):
            raise InputError(
                f"RayCaster: {name}[{bad[0]}] is {value[bad[0]].tolist()}, expected finite numbers"
            )
    empty = np.flatnonzero(~along.any(axis=1))
    if len(empty):
        raise InputError(f"RayCaster: directions[{empty[0]}] is zero: a ray must lead somewhere")
    return start, along
