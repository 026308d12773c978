"""Camera paths: keyframes with times, and the smooth movement between them.

How we move between keyframes, and why:

- **Position**: a cubic Hermite curve through the keyframes whose velocities are Catmull and Rom's
  for uneven times (the slope of the parabola through three neighbours), cut to three times the
  slower of the two neighbouring chords. So a key moves only its neighbourhood, a visitor who
  stops (two keys at one place) stands still, and nowhere does the path stray farther from both
  keys of a stretch than the stretch is long. A natural cubic spline is one derivative smoother,
  but overshoots round uneven keys, through walls if need be, and a jump in acceleration does not
  show in a video.
- **Orientation**: the same curve on the sphere of quaternions, as cumulative Bezier products (Kim,
  Kim & Shin 1995), with angular velocities chosen and cut in the same way. Unlike SciPy's
  ``RotationSpline`` it closes loops and stands still where the keys do.
- **Lens**: logarithm of the focal lengths (an even zoom looks even), skew and principal point.

Presets that build paths are in `belvedere.scene.moves`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from belvedere.ground.checks import check_integer, check_number
from belvedere.ground.errors import PathError
from belvedere.scene.camera import Camera
from belvedere.scene.camera_model import F8
from belvedere.scene.pose import pose_matrix

SPEED_LIMIT = 3.0
"""Velocity at a key, in units of the slower neighbouring chord: with 3, a Bezier control point lies
no farther from its key than the neighbouring key does (Fritsch & Carlson 1980, for vectors)."""

TIME_SLACK = 1e-9
"""Relative overrun of a path's end that rounding of ``start + i / fps`` may leave."""

MAX_FRAMES = 1_000_000
"""Frames of one path that we are willing to believe in (nine hours at 30 a second)."""


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """Where the camera is at one moment."""

    time: float
    """Seconds."""
    camera: Camera
    """Planar camera; all of a path have the same size."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraPath:
    """A smooth movement through keyframes. One keyframe stands still.

    Build one from keyframes, from a file (`load`), or with `belvedere.scene.moves`.
    """

    keyframes: tuple[Keyframe, ...]
    """In order of time, no two at one time."""
    period: float | None = None
    """Seconds of one round of a closed path: after the last keyframe the camera moves on to the
    first and arrives there at ``start + period``. None: the path ends at its last keyframe."""
    _held: tuple[F8, F8, F8] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "keyframes", tuple(self.keyframes))
        if not self.keyframes:
            raise PathError("CameraPath.keyframes is empty, expected at least one")
        for index, key in enumerate(self.keyframes):
            _check_keyframe(index, key, self.keyframes)
        if self.period is not None:
            span = self.keyframes[-1].time - self.keyframes[0].time
            check_number("CameraPath", "period", self.period, error=PathError)
            if self.period <= span:
                raise PathError(
                    f"CameraPath.period is {self.period:g} s, expected more than the {span:g} s "
                    "between the first and the last keyframe: it includes the way back"
                )

    @classmethod
    def of(
        cls, cameras: Iterable[Camera], times: Sequence[float], period: float | None = None
    ) -> CameraPath:
        """A path from cameras and their times in seconds, one each.

        Raises:
            PathError: their numbers differ; see `CameraPath` for the rest.
        """
        held, moments = list(cameras), [float(time) for time in times]
        if len(held) != len(moments):
            raise PathError(f"CameraPath.times has {len(moments)} times for {len(held)} cameras")
        return cls(tuple(Keyframe(t, c) for t, c in zip(moments, held, strict=True)), period)

    # ---- what it is ----------------------------------------------------------------------------

    @property
    def start(self) -> float:
        """Time of the first keyframe, seconds."""
        return self.keyframes[0].time

    @property
    def duration(self) -> float:
        """Seconds from start to end, or of one round."""
        return self.keyframes[-1].time - self.start if self.period is None else self.period

    @property
    def closed(self) -> bool:
        """Whether it leads back to its start."""
        return self.period is not None

    @property
    def size(self) -> tuple[int, int]:
        """``(height, width)`` of its pictures."""
        return self.keyframes[0].camera.size

    # ---- what it does --------------------------------------------------------------------------

    def camera(self, time: float) -> Camera:
        """The camera at a time in seconds.

        Raises:
            PathError: no finite number, or outside an open path.
        """
        return self.cameras_at_times([time])[0]

    def cameras(self, count: int) -> list[Camera]:
        """``count`` cameras evenly spaced in time.

        An open path's include both ends; a closed path's leave out the end, which is the start
        again, so that a video of them loops.
        """
        number = check_integer("CameraPath", "count", count, 1, MAX_FRAMES, PathError)
        steps = number if self.closed else max(number - 1, 1)
        return self.cameras_at_times(self.start + self.duration * np.arange(number) / steps)

    def cameras_at(self, fps: float) -> list[Camera]:
        """One camera per video frame: at ``start``, ``start + 1 / fps``, ... up to the end.

        Raises:
            PathError: the rate is not positive, or makes more than a million frames.
        """
        rate = check_number("CameraPath", "fps", fps, 0.0, open_low=True, error=PathError)
        spans = self.duration * rate
        if spans >= MAX_FRAMES:
            raise PathError(
                f"CameraPath of {self.duration:g} s at {rate:g} frames a second has {spans:.3g} "
                f"frames, expected at most {MAX_FRAMES}"
            )
        slack = TIME_SLACK * (1.0 + spans)
        count = max(math.ceil(spans - slack), 1) if self.closed else math.floor(spans + slack) + 1
        return self.cameras_at_times(self.start + np.arange(count) / rate)

    def cameras_at_times(self, times: npt.ArrayLike) -> list[Camera]:
        """The cameras at several times in seconds.

        Raises:
            PathError: see `camera`.
        """
        moments = self._checked_times(times)
        first = self.keyframes[0].camera
        if len(self.keyframes) == 1:
            return [first] * moments.size
        knots, poses, lens = self._knots()
        index = np.clip(np.searchsorted(knots, moments, side="right") - 1, 0, len(knots) - 2)
        step = np.diff(knots)
        at = _Stretch(index, step, (moments - knots[index]) / step[index], self.closed)
        positions = at.hermite(poses[:, :3, 3])
        rotations = at.rotations(poses[:, :3, :3])
        lenses = np.concatenate([at.hermite(column[:, None]) for column in lens.T], axis=1)
        return [
            Camera.from_intrinsics(_intrinsics(values), pose_matrix(turn, place),
                                   first.width, first.height)
            for values, turn, place in zip(lenses, rotations, positions, strict=True)
        ]  # fmt: skip

    def resized(self, width: int, height: int) -> CameraPath:
        """The same path with pictures of another size and the same field of view."""
        return CameraPath(
            tuple(Keyframe(key.time, key.camera.resized(width, height)) for key in self.keyframes),
            self.period,
        )

    def _knots(self) -> tuple[F8, F8, F8]:
        """Times (N,), poses (N, 4, 4) and lenses (N, 5); a closed path's end with the first again.

        Worked out once, since asking a camera for its pose costs more than moving between two.
        """
        if self._held is not None:
            return self._held
        knots = np.array([key.time for key in self.keyframes], dtype=np.float64)
        poses = np.stack([key.camera.camera_to_world for key in self.keyframes])
        lens = np.stack([_lens(key.camera) for key in self.keyframes])
        if self.period is not None:
            knots = np.append(knots, self.start + self.period)
            poses, lens = np.concatenate([poses, poses[:1]]), np.concatenate([lens, lens[:1]])
        object.__setattr__(self, "_held", (knots, poses, lens))
        return knots, poses, lens

    def _checked_times(self, times: npt.ArrayLike) -> F8:
        moments = np.atleast_1d(np.asarray(times, dtype=np.float64))
        if not np.isfinite(moments).all():
            raise PathError("CameraPath.camera: a time is not a finite number of seconds")
        if self.closed:
            return self.start + np.mod(moments - self.start, self.duration)
        end = self.start + self.duration
        slack = TIME_SLACK * (1.0 + abs(self.start) + self.duration)
        outside = (moments < self.start - slack) | (moments > end + slack)
        if outside.any() and len(self.keyframes) > 1:
            raise PathError(
                f"CameraPath.camera: time {moments[outside][0]:g} s is outside the path, which "
                f"runs from {self.start:g} to {end:g} s"
            )
        return np.clip(moments, self.start, end)

    # ---- files ---------------------------------------------------------------------------------

    def save(self, path: str | Path, *, force: bool = True) -> None:
        """Write the path as JSON (docs: `belvedere.scene.path_file`), atomically.

        Raises:
            OutputError: the file cannot be written, or exists and ``force`` is False.
        """
        from belvedere.scene.path_file import save_path

        save_path(path, self, force=force)

    @classmethod
    def load(cls, path: str | Path) -> CameraPath:
        """Read a path from JSON (docs: `belvedere.scene.path_file`).

        Raises:
            MissingFileError: no such file.
            FileFormatError: the file is no JSON.
            PathError: the file, key and index of whatever else is wrong.
        """
        from belvedere.scene.path_file import load_path

        return load_path(path)


def _check_keyframe(index: int, key: Any, keyframes: tuple[Any, ...]) -> None:
    place = f"CameraPath.keyframes[{index}]"
    if not isinstance(key, Keyframe):
        raise PathError(f"{place} is a {type(key).__name__}, expected a Keyframe(time, camera)")
    check_number(place, "time", key.time, error=PathError)
    if not isinstance(key.camera, Camera):
        raise PathError(
            f"{place}.camera is a {type(key.camera).__name__}, expected a planar Camera"
        )
    first = keyframes[0].camera
    if key.camera.size != first.size:
        raise PathError(
            f"{place}.camera is {key.camera.width} x {key.camera.height} pixels, the first is "
            f"{first.width} x {first.height}: resize it (Camera.resized)"
        )
    if index and key.time <= keyframes[index - 1].time:
        before = keyframes[index - 1].time
        same = key.time == before
        raise PathError(
            f"{place}.time is {key.time:g} s, "
            + ("the same as" if same else f"before the {before:g} s of")
            + f" keyframes[{index - 1}]: "
            + ("give them different times" if same else "sort keyframes by time")
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """Moments on a curve: which stretch between two knots, and how far along it."""

    index: npt.NDArray[np.intp]
    """(M,) stretch of each moment."""
    step: F8
    """(N - 1,) seconds of each stretch."""
    s: F8
    """(M,) 0 at the stretch's start, 1 at its end."""
    closed: bool
    """Whether the last knot is the first again."""

    def hermite(self, values: F8) -> F8:
        """(M, D) on the curve through (N, D) values at the knots."""
        i, s = self.index, self.s[:, None]
        start, end = values[i], values[i + 1]
        slope = np.diff(values, axis=0) / self.step[:, None]
        velocity = _velocities(slope, self.step, self.closed)
        h = self.step[i][:, None]
        rest = 1.0 - s
        # Bezier form: each point is a weighted mean of these four
        before, after = start + velocity[i] * h / 3, end - velocity[i + 1] * h / 3
        return (
            start
            + 3 * s * rest**2 * (before - start)
            + 3 * s**2 * rest * (after - start)
            + s**3 * (end - start)
        )

    def rotations(self, values: F8) -> F8:
        """(M, 3, 3) on the curve through (N, 3, 3) rotations at the knots."""
        from scipy.spatial.transform import Rotation

        knots = Rotation.from_matrix(values)
        turn = (knots[:-1].inv() * knots[1:]).as_rotvec()
        slope = turn / self.step[:, None]
        velocity = _velocities(slope, self.step, self.closed)
        i, s = self.index, self.s[:, None]
        h = self.step[i][:, None]
        leave = Rotation.from_rotvec(velocity[i] * h / 3)
        arrive = Rotation.from_rotvec(velocity[i + 1] * h / 3)
        start, end = Rotation.from_matrix(values[i]), Rotation.from_matrix(values[i + 1])
        middle = ((start * leave).inv() * (end * arrive.inv())).as_rotvec()
        return (
            start
            * Rotation.from_rotvec(velocity[i] * h / 3 * (1.0 - (1.0 - s) ** 3))
            * Rotation.from_rotvec(middle * (3 * s**2 - 2 * s**3))
            * Rotation.from_rotvec(velocity[i + 1] * h / 3 * s**3)
        ).as_matrix()


def _velocities(slope: F8, step: F8, closed: bool) -> F8:
    """(N, D) velocity at each knot from the (N - 1, D) mean velocity of each stretch.

    Angular velocities fit too: the turn from one key to the next has the same components in the
    axes of either.
    """
    h = step[:, None]
    velocity = np.empty((len(slope) + 1, slope.shape[1]))
    velocity[1:-1] = (h[1:] * slope[:-1] + h[:-1] * slope[1:]) / (h[1:] + h[:-1])
    if closed:
        velocity[0] = velocity[-1] = (h[0] * slope[-1] + h[-1] * slope[0]) / (h[0] + h[-1])
        left, right = np.vstack([slope[-1:], slope]), np.vstack([slope, slope[:1]])
    else:
        velocity[0] = 1.5 * slope[0] - 0.5 * velocity[1] if len(slope) > 1 else slope[0]
        velocity[-1] = 1.5 * slope[-1] - 0.5 * velocity[-2] if len(slope) > 1 else slope[-1]
        left, right = np.vstack([slope[:1], slope]), np.vstack([slope, slope[-1:]])
    speed = np.linalg.norm(velocity, axis=1)
    limit = SPEED_LIMIT * np.minimum(np.linalg.norm(left, axis=1), np.linalg.norm(right, axis=1))
    cut = np.where(speed > limit, limit / np.where(speed > 0, speed, 1.0), 1.0)
    return velocity * cut[:, None]


def _lens(camera: Camera) -> F8:
    """(5,) log fx, log fy, skew, cx, cy."""
    k = camera.intrinsics
    return np.array([math.log(k[0, 0]), math.log(k[1, 1]), k[0, 1], k[0, 2], k[1, 2]])


def _intrinsics(lens: F8) -> F8:
    fx, fy = np.exp(lens[:2])
    return np.array([[fx, lens[2], lens[3]], [0.0, fy, lens[4]], [0.0, 0.0, 1.0]])
