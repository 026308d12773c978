"""A builder whose curved surfaces can be cut as finely as a number of polygons asks for.

What furniture adds is a cage: quads whose corners lie on the surface and know its normal there. The
cage carries the light; the surface between its corners is smooth and is cut into triangles at the
end, so that coarse and fine versions of one house have the same shape, charts and light:

    cage quad, corner normals        edges: cubic curves that leave        cut k_s by k_t times,
       3 ------- 2                   the corners at right angles to           +--+--+--+
       |         |          ->       the normals; inside: a patch     ->      +--+--+--+
       0 ------- 1                   blended from its four edges              +--+--+--+

Flat quads stay two triangles. Source: Vlachos et al. 2001 (edges), Coons 1967 (patches).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from belvedere.model.charts import F8, UNIT, Builder, Charts
from belvedere.scene.mesh import Mesh

CREASE = 0.62
"""An edge whose end leans further out of its corner's tangent plane (a sine) is straight: there the
corner's normal is a mean over a crease."""
MOST_CUTS = 64
"""Cuts along one side of a quad."""
PIECE = 1 << 18
"""Points worked out at a time."""

_EDGES = ((0, 1), (3, 2), (0, 3), (1, 2))
"""Corners of the two edges along s, then of the two along t."""
_HALVES = np.array([[0, 1, 2], [0, 2, 3]])


@dataclass(frozen=True, slots=True, eq=False)
class _Curved:
    """All curved quads of a cage."""

    corners: F8
    """(Q, 4, 3) world positions."""
    controls: F8
    """(Q, 4, 2, 3) inner control points of the four edges of `_EDGES`."""
    uv: F8
    """(Q, 4, 2) texture coordinates."""
    chart: npt.NDArray[np.int32]
    """(Q,) chart of each quad."""
    block: npt.NDArray[np.intp]
    """(Q,) which call added the quad; all quads of one call are cut alike."""
    bend: F8
    """(B, 2) how far the edges of each block leave their chords along s and t, metres."""
    phase: F8
    """(B,) in [0, 1): spreads the moments at which pieces are cut once more."""


class SmoothBuilder(Builder):
    """Collects a cage of quads; gives the cage for light, and the smooth surface for pictures."""

    def __init__(self) -> None:
        super().__init__()
        self._smooth: dict[int, int] = {}
        self._bends: dict[int, F8] = {}
        self._depth = self._piece = 0

    @contextmanager
    def placed(
        self, x: float, y: float, z: float = 0.0, yaw_deg: float = 0.0, pitch_deg: float = 0.0
    ) -> Iterator[None]:
        """As `Builder.placed`; what one outermost place holds is one piece."""
        self._depth += 1
        self._piece += self._depth == 1
        with super().placed(x, y, z, yaw_deg, pitch_deg):
            yield
        self._depth -= 1

    def patches(
        self,
        corners: npt.ArrayLike,
        material: int,
        uv: npt.ArrayLike,
        normals: F8 | None = None,
        bends: F8 | None = None,
    ) -> None:
        """As `Builder.patches`; quads with normals are smooth."""
        if normals is not None:
            k = len(self._vertices)
            self._smooth[k] = self._piece
            if bends is not None:
                self._bends[k] = bends @ self._rotation.T
        super().patches(corners, material, uv, normals)

    def refined(self, polygons: int) -> tuple[Mesh, Charts]:
        """The smooth surfaces in about ``polygons`` triangles, on the charts of `finish`.

        Args:
            polygons: triangles wanted; never fewer come than the cage has.
        """
        blocks = [k for k in range(len(self._vertices)) if k not in self._smooth]
        halves = [self._flat_faces(k) for k in blocks]
        fine: list[tuple[F8, npt.NDArray[np.int64], F8, F8, npt.NDArray[np.int32]]] = halves
        flat = sum(len(part[1]) for part in fine)
        if self._smooth:
            curved = self._curved()
            cuts = _choose_cuts(curved, (polygons - flat) / 2.0)
            fine = fine + _cut_all(curved, cuts)
        return self._join(fine)

    def _flat_faces(
        self, k: int
    ) -> tuple[F8, npt.NDArray[np.int64], F8, F8, npt.NDArray[np.int32]]:
        count = len(self._chart[k])
        faces = (4 * np.arange(count)[:, None, None] + _HALVES).reshape(-1, 3)
        uv, st = (a[:, _HALVES].reshape(-1, 3, 2) for a in (self._uv[k], self._st[k]))
        return self._vertices[k], faces, uv, st, np.repeat(self._chart[k], 2)

    def _curved(self) -> _Curved:
        blocks = list(self._smooth)
        corners = np.concatenate([self._vertices[k].reshape(-1, 4, 3) for k in blocks])
        normals = np.concatenate([self._normals[k] for k in blocks])
        bends = np.concatenate([self._bends.get(k, self._normals[k]) for k in blocks])
        size = np.array([len(self._chart[k]) for k in blocks])
        controls, bend = _edge_controls(corners, bends, normals)
        first = np.concatenate([[0], np.cumsum(size)[:-1]])
        return _Curved(
            corners,
            controls,
            np.concatenate([self._uv[k] for k in blocks]),
            np.concatenate([self._chart[k] for k in blocks]),
            np.repeat(np.arange(len(blocks)), size),
            np.maximum.reduceat(bend, first, axis=0),
            np.array([self._smooth[k] * 0.6180339887498949 % 1.0 for k in blocks]),
        )

    def _join(
        self, parts: list[tuple[F8, npt.NDArray[np.int64], F8, F8, npt.NDArray[np.int32]]]
    ) -> tuple[Mesh, Charts]:
        """One mesh and its charts out of (vertices, faces, uv, st, chart) pieces."""
        first = np.concatenate([[0], np.cumsum([len(part[0]) for part in parts])[:-1]])
        faces = np.concatenate(
            [(part[1] + start).astype(np.int32) for part, start in zip(parts, first, strict=True)]
        )
        of_face = np.concatenate([part[4] for part in parts])
        _, cage = self.finish()
        mesh = Mesh(
            np.concatenate([part[0] for part in parts]),
            faces,
            cage.material[of_face],
            np.concatenate([part[2].astype(np.float32) for part in parts]),
            tuple(self.materials),
        )
        st = np.concatenate([part[3].astype(np.float32) for part in parts])
        return mesh, replace(cage, of_face=of_face, st=st)

    def finish(self) -> tuple[Mesh, Charts]:
        """The cage: flat quads, and the charts for it and for `refined`."""
        mesh, charts = super().finish()
        joined = np.zeros(len(charts.corners), dtype=bool)
        for k in self._smooth:
            joined[self._chart[k]] = True
        return mesh, replace(charts, joined=joined)


def _edge_controls(corners: F8, along_s: F8, along_t: F8) -> tuple[F8, F8]:
    """(Q, 4, 2, 3) inner control points of cubic edges; (Q, 2) how far those leave the chords.

    ``along_s`` and ``along_t`` (Q, 4, 3) are the normals from which edges along s and t are bent.
    """
    controls = np.empty((len(corners), 4, 2, 3))
    bend = np.zeros((len(corners), 2))
    for edge, (a, c) in enumerate(_EDGES):
        p, q, normals = corners[:, a], corners[:, c], along_s if edge < 2 else along_t
        along = q - p
        chord = np.maximum(np.linalg.norm(along, axis=1), 1e-12)
        up = np.einsum("ij,ij->i", along, normals[:, a]) / chord
        down = -np.einsum("ij,ij->i", along, normals[:, c]) / chord
        smooth = np.maximum(np.abs(up), np.abs(down)) <= CREASE
        ways = ((up, a, p, along), (down, c, q, -along))
        for end, (lean, corner, start, way) in enumerate(ways):
            sine = np.where(smooth, lean, 0.0)
            cosine = np.sqrt(1.0 - sine**2)
            tangent = way - (sine * chord)[:, None] * normals[:, corner]
            # so long that an arc of a circle stays one: 2 / 3 chord / (1 + cos) along the tangent
            reach = 2.0 / (3.0 * cosine * (1.0 + cosine))
            controls[:, edge, end] = start + tangent * reach[:, None]
        leaves = np.where(smooth, (np.abs(up) + np.abs(down)) * chord / 8.0, 0.0)
        bend[:, edge // 2] = np.maximum(bend[:, edge // 2], leaves)
    return controls, bend


def _choose_cuts(curved: _Curved, quads: float) -> npt.NDArray[np.intp]:
    """(B, 2) cuts of each block along s and t that make about ``quads`` quads in all.

    A chord cut k times leaves its curve by 1 / k**2 of what it did: all blocks get cuts for one
    distance between chord and curve, and that distance is sought by halving.
    """
    count = np.bincount(curved.block)

    def cuts(tolerance: float) -> npt.NDArray[np.intp]:
        wanted = np.sqrt(curved.bend / tolerance) + curved.phase[:, None]
        return np.clip(wanted.astype(np.intp), 1, MOST_CUTS)

    low, high = -40.0, 2.0  # exponents of two, metres
    for _ in range(60):
        middle = (low + high) / 2.0
        if (count * cuts(2.0**middle).prod(axis=1)).sum() > quads:
            low = middle
        else:
            high = middle
    return cuts(2.0**high)


def _cut_all(
    curved: _Curved, cuts: npt.NDArray[np.intp]
) -> list[tuple[F8, npt.NDArray[np.int64], F8, F8, npt.NDArray[np.int32]]]:
    """Cut every quad; quads with like cuts are worked out together."""
    each = cuts[curved.block]
    code = each[:, 0] * (MOST_CUTS + 1) + each[:, 1]
    parts = []
    for value in np.unique(code):
        ks, kt = divmod(int(value), MOST_CUTS + 1)
        which = np.flatnonzero(code == value)
        step = max(PIECE // ((ks + 1) * (kt + 1)), 1)
        parts += [_cut(curved, which[k : k + step], ks, kt) for k in range(0, len(which), step)]
    return parts


def _cut(
    curved: _Curved, which: npt.NDArray[np.intp], ks: int, kt: int
) -> tuple[F8, npt.NDArray[np.int64], F8, F8, npt.NDArray[np.int32]]:
    s, t = np.linspace(0.0, 1.0, ks + 1), np.linspace(0.0, 1.0, kt + 1)
    p, inner = curved.corners[which], curved.controls[which]
    curves = []
    for edge, (a, c) in enumerate(_EDGES):
        at = s if edge < 2 else t
        points = np.stack([p[:, a], inner[:, edge, 0], inner[:, edge, 1], p[:, c]], axis=1)
        curves.append(np.einsum("nk,qkc->qnc", _bernstein(at), points))
    low, high, left, right = curves
    f, g = s[None, None, :, None], t[None, :, None, None]
    points = (1.0 - g) * low[:, None] + g * high[:, None]
    points += (1.0 - f) * left[:, :, None] + f * right[:, :, None]
    weights = np.stack(
        [np.outer(1 - t, 1 - s), np.outer(1 - t, s), np.outer(t, s), np.outer(t, 1 - s)], axis=2
    )
    points -= np.einsum("tsk,qkc->qtsc", weights, p)
    uv = np.einsum("tsk,qkc->qtsc", weights, curved.uv[which]).reshape(len(which), -1, 2)
    st = np.einsum("tsk,kc->tsc", weights, UNIT).reshape(-1, 2)
    place = np.arange((ks + 1) * (kt + 1)).reshape(kt + 1, ks + 1)
    quads = np.stack([place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]], axis=2)
    local = quads.reshape(-1, 4)[:, _HALVES].reshape(-1, 3)
    faces = local + place.size * np.arange(len(which))[:, None, None]
    return (
        points.reshape(-1, 3),
        faces.reshape(-1, 3),
        uv[:, local].reshape(-1, 3, 2),
        np.broadcast_to(st[local], (len(which), *local.shape, 2)).reshape(-1, 3, 2),
        np.repeat(curved.chart[which], len(local)),
    )


def _bernstein(x: F8) -> F8:
    """(n, 4) weights of a cubic's control points at ``x``."""
    y = 1.0 - x
    return np.stack([y**3, 3 * y**2 * x, 3 * y * x**2, x**3], axis=1)
