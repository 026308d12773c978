"""Cylinders and spheres in the warp: one equation for all central cameras; pictures that go on.

With the rays of each camera written in its own frame, ``D = M f(u, v)``, the warping equation is
that of planes with another way of reading it at both ends::

    Y = M2^-1 M1 f1(u, v) + delta M2^-1 (C1 - C2)          W (3, 4), as between planes
    (u2, v2) = proj2(Y),   delta2 = delta / |Y|2           by the desired camera's manifold

              f(u, v)                                  |Y|2             proj
    plane     (u, v, 1)                                Y2               Y0 / Y2, Y1 / Y2
    cylinder  (cos psi, sin psi, height)               hypot(Y0, Y1)    atan2, Y2 / |Y|2
    sphere    (cos lat cos psi, cos lat sin psi,       |Y|              atan2, atan2
               sin lat)

M is the planar camera's matrix or the panorama's rotation.

A panorama has no border at its seam, and a sphere none at its poles, but arrays do. So a reference
panorama is warped from a copy that goes on beyond them (`seamless`): whatever looks at a sample's
neighbours finds them, and knows nothing of seams. Only one turn of it is drawn.

Source: spec image-warping 3.5; McMillan and Bishop 1995, eq. 14 and 22.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import CameraError
from belvedere.scene import Camera, CameraModel, CylinderCamera, ReferenceView, SphereCamera
from belvedere.warp.equation import homography

F8 = npt.NDArray[np.float64]

BEYOND = 12
"""Columns and rows that a reference goes on beyond its seam and poles. Links, edges, un-mixing and
taps look at most six samples away, and at one another's results no further than that again."""
PLANE, CYLINDER, SPHERE = 0.0, 1.0, 2.0
CHART = 7
"""Numbers that tell kernels a camera's manifold; see `chart`."""


@dataclass(frozen=True, slots=True, eq=False)
class SeamlessCamera(CameraModel):
    """A panorama that goes on beyond its seam, and beyond its poles if it has them."""

    base: CylinderCamera | SphereCamera
    """The panorama itself; its pixel (0, 0) is this one's (columns, rows)."""
    columns: int
    """Columns that it goes on to either side."""
    rows: int
    """Rows that it goes on up and down."""

    @property
    def width(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Pixels across, more than a turn."""
        return self.base.width + 2 * self.columns

    @property
    def height(self) -> int:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Pixels down."""
        return self.base.height + 2 * self.rows

    @property
    def center(self) -> F8:  # pyright: ignore[reportIncompatibleVariableOverride]
        """(3,) the panorama's."""
        return self.base.center

    def rays(self, u: npt.ArrayLike, v: npt.ArrayLike) -> F8:
        """See `CameraModel.rays`."""
        return self.base.rays(
            np.asarray(u, np.float64) - self.columns, np.asarray(v, np.float64) - self.rows
        )

    def project(self, points: npt.ArrayLike) -> tuple[F8, F8, F8]:
        """See `CameraModel.project`; always in the one turn that is the panorama's own."""
        u, v, delta = self.base.project(points)
        return u + self.columns, v + self.rows, delta

    def resized(self, width: int, height: int) -> Any:
        """The panorama itself on another grid."""
        return self.base.resized(width, height)


def central(camera: CameraModel, role: str) -> CameraModel:
    """``camera`` if all its rays meet in one point, or a refusal that says which does not.

    Raises:
        CameraError: the camera is orthographic, or of a kind that the warp does not know.
    """
    if not isinstance(camera, CameraModel):
        raise CameraError(
            f"the {role} camera is a {type(camera).__name__}, expected a camera such as "
            "belvedere.Camera"
        )
    if not isinstance(camera, Camera | CylinderCamera | SphereCamera | SeamlessCamera):
        raise CameraError(
            f"the {role} view has a {type(camera).__name__}, but warping goes between cameras "
            "whose rays meet in one point (belvedere.Camera, CylinderCamera, SphereCamera): "
            "photograph the scene with one of them instead"
        )
    return camera


def check_planar(what: str, desired: CameraModel, references: Sequence[CameraModel]) -> Camera:
    """The desired camera, if all cameras are planar.

    Args:
        what: cannot be done with others; the beginning of a sentence.
        desired: of any kind.
        references: of any kind.

    Raises:
        CameraError: one of them is a cylinder, a sphere or orthographic.
    """
    for role, camera in (("desired", desired), *(("reference", one) for one in references)):
        if not isinstance(camera, Camera):
            kind = type(camera.base if isinstance(camera, SeamlessCamera) else camera).__name__
            raise CameraError(
                f"{what} between planar cameras only (belvedere.Camera), but the {role} view has "
                f"a {kind}"
            )
    assert isinstance(desired, Camera)
    return desired


def is_panoramic(camera: CameraModel) -> bool:
    """Whether a camera's picture is one whole turn."""
    return isinstance(camera, CylinderCamera | SphereCamera)


def unrolled(camera: CameraModel, columns: int) -> SeamlessCamera:
    """A panorama's camera that goes on beyond its seam, to either side."""
    assert isinstance(camera, CylinderCamera | SphereCamera)
    return SeamlessCamera(camera, columns, 0)


def same_pixels(reference: CameraModel, desired: CameraModel) -> bool:
    """Whether two cameras are one: every pixel of the one is that pixel of the other."""
    a = reference.base if isinstance(reference, SeamlessCamera) else reference
    b = desired.base if isinstance(desired, SeamlessCamera) else desired
    return (
        type(a) is type(b)
        and a.size == b.size
        and a.center.tolist() == b.center.tolist()  # of so few numbers, faster than NumPy's
        and np.array_equal(direction_frame(a), direction_frame(b))
        and np.array_equal(chart(a), chart(b))
    )


def seamless(view: ReferenceView, beyond: int = BEYOND) -> ReferenceView:
    """A panorama's view that goes on beyond its seam and poles.

    Beyond a pole the rows come back on the other side, half a turn away. With an odd number of
    columns that is half a column off: on the rows next to a pole, nothing that a pixel could show.
    """
    base = view.camera
    assert isinstance(base, CylinderCamera | SphereCamera)
    camera = SeamlessCamera(base, beyond, beyond if isinstance(base, SphereCamera) else 0)
    row = np.mod(np.arange(-camera.rows, base.height + camera.rows), 2 * base.height)
    other_side = row >= base.height
    row = np.where(other_side, 2 * base.height - 1 - row, row)
    column = np.arange(-beyond, base.width + beyond) + other_side[:, None] * (base.width // 2)
    at = row[:, None], np.mod(column, base.width)
    return ReferenceView(camera, view.color[at], view.disparity[at])


def own_samples(camera: CameraModel) -> tuple[slice, slice]:
    """Rows and columns of a picture that are a camera's own, each direction once."""
    if not isinstance(camera, SeamlessCamera):
        return slice(0, camera.height), slice(0, camera.width)
    base = camera.base
    return (
        slice(camera.rows, camera.rows + base.height),
        slice(camera.columns, camera.columns + base.width),
    )


def chart(camera: CameraModel) -> F8:
    """(CHART,) how pixels become directions, for kernels.

    Manifold; azimuth of column 0; radians a column; row that looks level; radians a row (sphere)
    or height on the unit cylinder; columns of a turn; where the panorama's own columns begin.
    """
    beyond = (0, 0)
    if isinstance(camera, SeamlessCamera):
        beyond, camera = (camera.columns, camera.rows), camera.base
    if not isinstance(camera, CylinderCamera | SphereCamera):
        return np.zeros(CHART)
    step = 2.0 * np.pi / camera.width
    if isinstance(camera, SphereCamera):
        kind, horizon, row_step = SPHERE, (camera.height - 1) / 2, np.pi / camera.height
    else:
        kind, horizon, row_step = CYLINDER, camera.horizon, camera.row_step
    return np.array([
        kind, camera.azimuth + beyond[0] * step, step, horizon + beyond[1], row_step,
        camera.width, beyond[0] - 0.5,
    ])  # fmt: skip


def passage_matrix(reference: CameraModel, desired: CameraModel) -> F8:
    """W, (3, 4), between any two central cameras; exactly the identity within one frame."""
    matrix = np.empty((3, 4))
    if isinstance(reference, Camera) and isinstance(desired, Camera):
        matrix[:, :3] = homography(reference, desired)
        inverse = np.linalg.inv(desired.matrix)
    else:
        here, there = direction_frame(reference), direction_frame(desired)
        inverse = np.linalg.inv(there)
        matrix[:, :3] = np.eye(3) if np.array_equal(here, there) else inverse @ here
    matrix[:, 3] = inverse @ (reference.center - desired.center)
    return matrix


def geometry(reference: CameraModel, desired: CameraModel) -> F8:
    """(12 + 2 CHART,) all that a kernel of `_landing` must know to go from one to the other."""
    matrix = passage_matrix(reference, desired)
    return np.concatenate([matrix.ravel(), chart(reference), chart(desired)])


def direction_frame(camera: CameraModel) -> F8:
    """(3, 3) world directions of the camera's own frame."""
    if isinstance(camera, SeamlessCamera):
        camera = camera.base
    if isinstance(camera, CylinderCamera | SphereCamera):
        return camera.rotation
    assert isinstance(camera, Camera)
    return camera.matrix
