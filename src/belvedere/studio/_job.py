"""The record of a render job: which job the pieces in a work folder belong to."""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from belvedere.ground.errors import BelvedereError, OutputError
from belvedere.scene.camera_model import CameraModel
from belvedere.scene.io.atomic import PARTIAL
from belvedere.scene.io.json_files import read_json, write_json
from belvedere.scene.scene import Scene

RECORD = "render.json"
"""Name of the record in the work folder, and in a finished folder of pictures."""
VERSION = 1
SAVE_EVERY_S = 2.0
"""How often the record is renewed while rendering; pieces count even if the record lags."""


def camera_digest(cameras: Sequence[CameraModel]) -> str:
    """A short hash of where cameras are, how they look and how large their pictures are.

    Three rays and the center tell every camera model apart; the numbers are rounded to nine digits
    so that a path read back from JSON is the same path.
    """
    digest = hashlib.sha256()
    for camera in cameras:
        corners = camera.rays([0, camera.width - 1, 0], [0, 0, camera.height - 1])
        numbers = np.concatenate([np.ravel(corners), np.ravel(camera.center)])
        text = ",".join(f"{value + 0.0:.9g}" for value in numbers)
        digest.update(f"{type(camera).__name__} {camera.size} {text};".encode())
    return digest.hexdigest()[:16]


def describe_job(
    scene: Scene,
    cameras: Sequence[CameraModel],
    fps: float,
    kind: str,
    options: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """What makes two jobs the same: the scene, every frame's camera, rate, size and options."""
    region = scene.viewing_region
    bounds = ",".join(f"{value:.9g}" for value in np.concatenate([region.low, region.high]))
    looks = f"{type(scene).__name__} {scene.affords.as_dict()} {bounds}"
    return {
        "kind": kind,
        "frames": len(cameras),
        "size": [cameras[0].width, cameras[0].height],
        "fps": fps,
        "path": camera_digest(cameras),
        "scene": hashlib.sha256(looks.encode()).hexdigest()[:16],
        "options": json.loads(json.dumps(dict(options or {}), default=str)),
    }


@dataclass(eq=False)
class RenderJob:
    """A work folder and its record."""

    folder: Path
    """Where the pieces are."""
    description: dict[str, Any]
    """See `describe_job`."""
    holes: list[float | None] = field(default_factory=list)
    """Share of holes of each frame; None where the frame is not rendered or its record was lost."""
    saved_at: float = 0.0

    @classmethod
    def begin(
        cls, folder: Path, target: Path, description: dict[str, Any], force: bool, resume: bool
    ) -> RenderJob:
        """Make the work folder, or take up what an interrupted call of the same job left.

        Raises:
            OutputError: the folder belongs to another job and ``force`` is False.
        """
        job = cls(folder, description, [None] * description["frames"])
        earlier = _earlier(folder)
        if earlier is not None and resume and not force:
            _refuse_other(earlier, description, target)
        if earlier is not None and resume and _differing(earlier, description) == []:
            known = earlier.get("holes")
            if isinstance(known, list) and len(known) == len(job.holes):
                job.holes = known
            for leftover in folder.glob(f"*{PARTIAL}*"):
                leftover.unlink()
        elif folder.exists():
            shutil.rmtree(folder)
        folder.mkdir(parents=True, exist_ok=True)
        job.save()
        return job

    def save(self, state: str = "unfinished") -> None:
        """Write the record."""
        write_json(
            self.folder / RECORD,
            {
                "schema": "belvedere.render",
                "version": VERSION,
                "state": state,
                "job": self.description,
                "holes": self.holes,
            },
        )
        self.saved_at = time.monotonic()

    def save_now_and_then(self) -> None:
        """Write the record if the last time is a while ago."""
        if time.monotonic() - self.saved_at > SAVE_EVERY_S:
            self.save()

    def complete(self) -> None:
        """Write the record of a finished job."""
        self.save("complete")

    def remove(self) -> None:
        """The work is done and lies elsewhere."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _earlier(folder: Path) -> dict[str, Any] | None:
    """The record an interrupted call left, or None if there is none that can be trusted."""
    if not (folder / RECORD).is_file():
        return None
    try:
        record = read_json(folder / RECORD).data
    except BelvedereError:
        return None
    return record if isinstance(record.get("job"), dict) else None


def _differing(earlier: dict[str, Any], description: dict[str, Any]) -> list[str]:
    """What tells the earlier job from this one, as "fps 25 then, 30 now"."""
    before = {**earlier["job"], "version": earlier.get("version")}
    now = {**description, "version": VERSION}
    differing = []
    for key, value in now.items():
        then = before.get(key)
        if then == value:
            continue
        if key in ("path", "scene"):
            differing.append(f"another {key}")
        elif isinstance(value, dict) and isinstance(then, dict):
            differing += [
                f"{name} {then.get(name)!r} then, {value.get(name)!r} now"
                for name in sorted({*then, *value})
                if then.get(name) != value.get(name)
            ]
        else:
            differing.append(f"{key} {then} then, {value} now")
    return differing


def _refuse_other(earlier: dict[str, Any], description: dict[str, Any], target: Path) -> None:
    differing = _differing(earlier, description)
    if differing:
        raise OutputError(
            f"{target}: an interrupted render of another job waits to be resumed "
            f"({'; '.join(differing)}): render it with the same options, choose another name, or "
            "pass --force (force=True) to start anew"
        )
