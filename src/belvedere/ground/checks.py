"""Checks at the door: cheap, and each refusal says what, where and how to mend it.

The first two arguments are always the owner and the name of the value, as a person would write
them: ``check_shape("ReferenceView", "disparity", array, (480, 640), hint="...")``.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.errors import CameraError, InputError

MAX_SIDE = 1 << 20
"""Pixels along one side of an image that we are willing to believe in."""

RIGID_TOLERANCE = 2e-3
"""How far ``R.T @ R`` may be from the identity. Poses written with 4 decimals (common in data
sets) are off by up to 3e-4, and float32 pipelines by 1e-6; a wrong convention is off by 0.1 up."""


def shape_text(shape: Sequence[int | None]) -> str:
    """A shape as people write it: ``(480, 640, 3)``, with ``n`` for "any"."""
    parts = ["n" if side is None else str(side) for side in shape]
    return "(" + ", ".join(parts) + ("," if len(parts) == 1 else "") + ")"


def as_array(
    owner: str, name: str, value: Any, dtype: npt.DTypeLike | None = np.float64
) -> npt.NDArray[Any]:
    """``value`` as an array of ``dtype`` (None: of its own), or a refusal that names it.

    Raises:
        InputError: the value is ragged, text, or otherwise no array of numbers.
    """
    try:
        return np.asarray(value, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{owner}.{name} is not an array of numbers ({error}): pass a list or NumPy array"
        ) from error


def check_shape(
    owner: str,
    name: str,
    array: npt.NDArray[Any],
    shape: Sequence[int | None],
    hint: str = "",
    error: type[InputError] = InputError,
) -> None:
    """Refuse an array whose shape is not ``shape`` (None matches any length)."""
    fits = len(array.shape) == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise error(
            f"{owner}.{name} has shape {shape_text(array.shape)}, expected {shape_text(shape)}"
            + (f": {hint}" if hint else "")
        )


def check_finite(
    owner: str,
    name: str,
    array: npt.NDArray[Any] | float,
    error: type[InputError] = InputError,
) -> None:
    """Refuse NaN and infinity, naming the first place they stand at."""
    values = np.asarray(array)
    bad = ~np.isfinite(values)
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        place = f"[{', '.join(map(str, index))}]" if index else ""
        raise error(
            f"{owner}.{name}{place} is {values[index] if index else values}, "
            "expected a finite number: check the file or calculation it comes from"
        )


def check_choice(owner: str, name: str, value: object, choices: Iterable[str]) -> None:
    """Refuse a word that is not one of ``choices``."""
    allowed = list(choices)
    if value not in allowed:
        raise InputError(
            f"{owner}.{name} is {value!r}, expected one of "
            + ", ".join(repr(choice) for choice in allowed)
        )


def check_path(owner: str, name: str, value: object) -> Path:
    """``value`` as a path; anything but text or a path object is refused."""
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(text, str):
        raise InputError(
            f"{owner}.{name} is {value!r:.60}, expected the name of a file or folder (str or Path)"
        )
    return Path(text)


def check_number(
    owner: str,
    name: str,
    value: object,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    open_low: bool = False,
    error: type[InputError] = InputError,
) -> float:
    """``value`` as a finite float in [low, high] (or (low, high] with ``open_low``)."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise error(f"{owner}.{name} is {value!r}, expected a number") from None
    if not math.isfinite(number) or number > high or number < low or (open_low and number == low):
        bounds = f"{'above' if open_low else 'from'} {low:g}" if low > -math.inf else ""
        if high < math.inf:
            bounds += f"{' ' if bounds else ''}up to {high:g}"
        raise error(f"{owner}.{name} is {number:g}, expected a finite number {bounds}".rstrip())
    return number


def check_integer(
    owner: str,
    name: str,
    value: object,
    low: int,
    high: int,
    error: type[InputError] = InputError,
) -> int:
    """``value`` as an int in [low, high]; booleans and fractions are refused."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool | np.bool_)
    if not whole or not low <= int(value) <= high:  # type: ignore[arg-type, call-overload]
        raise error(f"{owner}.{name} is {value!r}, expected a whole number from {low} to {high}")
    return int(value)  # type: ignore[arg-type, call-overload]


def check_image_size(
    owner: str, width: object, height: object, error: type[InputError] = CameraError
) -> tuple[int, int]:
    """``(width, height)`` as positive ints that an image can have."""
    return (
        check_integer(owner, "width", width, 1, MAX_SIDE, error),
        check_integer(owner, "height", height, 1, MAX_SIDE, error),
    )


def check_pose(owner: str, name: str, pose: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """``pose`` as a (4, 4) rigid transform: finite, rotation orthonormal and right-handed.

    Rotations rounded by a file (see `RIGID_TOLERANCE`) are projected to the nearest rotation, so
    that what follows can rely on it.

    Raises:
        CameraError: wrong shape, NaN, a last row other than 0 0 0 1, a scaled, sheared or
            mirrored rotation.
    """
    matrix = as_array(owner, name, pose)
    if matrix.shape == (3, 4):
        matrix = np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]])
    check_shape(owner, name, matrix, (4, 4), "a pose is a 4x4 matrix", CameraError)
    check_finite(owner, name, matrix, CameraError)
    if not np.allclose(matrix[3], [0, 0, 0, 1], atol=1e-9):
        raise CameraError(
            f"{owner}.{name} has the last row {matrix[3].tolist()}, expected [0, 0, 0, 1]: "
            "is it transposed, or a projection matrix?"
        )
    rotation = matrix[:3, :3]
    off = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if off > RIGID_TOLERANCE:
        scale = float(np.cbrt(abs(np.linalg.det(rotation))))
        raise CameraError(
            f"{owner}.{name} is not rigid: R^T R is off the identity by {off:.3g} "
            f"(scale about {scale:.4g}): remove scale and shear from the pose"
        )
    if np.linalg.det(rotation) < 0:
        raise CameraError(
            f"{owner}.{name} mirrors space (determinant -1): flip one axis; OpenGL to OpenCV "
            "flips two (y and z)"
        )
    left, _, right = np.linalg.svd(rotation)
    rigid = matrix.copy()
    if off > 1e-12:
        rigid[:3, :3] = left @ right
    rigid[3] = [0.0, 0.0, 0.0, 1.0]
    return rigid
