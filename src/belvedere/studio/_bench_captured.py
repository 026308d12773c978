"""The suite "warp" on a scene that somebody brings: its views held out one after the other.

Each view is predicted from its best neighbours by every reconstructor and every rival, and judged
on the pixels that all of them cover: so nobody gains by leaving out what is hard. There is no truth
but the photograph, so depth, cracks and ghosts are not judged; what is left open is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from belvedere.ground.color import color_to_srgb8
from belvedere.ground.errors import CameraError, MissingDependencyError
from belvedere.ground.progress import Progress, silent
from belvedere.scene import Camera, ReferenceView
from belvedere.scene.views import ViewSet
from belvedere.studio._bench_field import FIELD
from belvedere.studio._bench_memory import peak_megabytes
from belvedere.studio._bench_rival import Rival, shown
from belvedere.studio._bench_rows import BenchRow
from belvedere.studio._bench_timing import Contestant, Times, time_interleaved
from belvedere.studio._bench_warp import Pictures, Plan, counted_references, finite, our_entries
from belvedere.studio.difference import picture_with_holes, signed_difference
from belvedere.studio.evaluate import plan_hold_out, truth_mask
from belvedere.studio.metrics import Mask, psnr, ssim


@dataclass(slots=True, eq=False)
class Tally:
    """What one contestant has shown so far."""

    psnr: list[float] = field(default_factory=list)
    ssim: list[float] = field(default_factory=list)
    holes: list[float] = field(default_factory=list)
    ms: list[float] = field(default_factory=list)
    first_s: float = 0.0
    megabytes: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class HeldOut:
    """One view that is predicted, and what it is predicted from."""

    name: str
    camera: Camera
    color: np.ndarray
    """(H, W, 3) ``uint8``: the photograph."""
    valid: Mask
    """(H, W) where the photograph has content."""
    references: tuple[ReferenceView, ...]


def captured_rows(
    views: ViewSet, plan: Plan, progress: Progress, pictures: Pictures | None = None
) -> list[BenchRow]:
    """Every contestant's means over all views; pictures are added to ``pictures`` if given.

    Raises:
        SceneError: too few views with depth.
        CameraError: a view that is not planar.
    """
    rows: list[BenchRow] = []
    for count in plan.references:
        rivals, missing = _present(plan, views.entries[0].camera.width, count)
        tallies = [Tally() for _ in rivals]
        held = plan_hold_out(views, 1, count)
        rounds = -(-plan.repeats // len(held))
        common: list[float] = []
        samples = 0
        for index, (target, chosen) in enumerate(held):
            progress(index, len(held), f"predicting views from {counted_references(count)}")
            one = held_out_view(views, target, chosen)
            samples = sum(view.disparity.size for view in one.references)
            common.append(_predict(one, rivals, tallies, plan.threads[0], rounds, pictures, count))
        progress(len(held), len(held), f"predicting views from {counted_references(count)}")
        text = f"{100 * float(np.mean(common)):.1f} % of the pixels are covered by all"
        unit = float(np.median(tallies[0].ms))
        rows += [
            _row(rival, tally, plan, views.entries[0].camera.width, count, samples, unit,
                 text if rival is rivals[0] else "")
            for rival, tally in zip(rivals, tallies, strict=True)
        ]  # fmt: skip
        rows += missing
    return rows


def _present(plan: Plan, width: int, count: int) -> tuple[list[Rival], list[BenchRow]]:
    """Contestants whose libraries are here, and rows of the others."""
    blank = Camera.look_at((0, 0, 0), (0, 1, 0), width=8, height=8)
    view = ReferenceView(blank, np.zeros((8, 8, 3), np.uint8), np.full((8, 8), np.float32(0.5)))
    present, missing = [], []
    for rival in [*our_entries(), *(FIELD if plan.peers else ())]:
        try:
            rival.prepare([view], 1)
            present.append(rival)
        except MissingDependencyError as absent:
            text = f"{absent} is not installed: {rival.install}"
            missing.append(
                BenchRow(rival.name, rival.what, width, None, references=count, note=text)
            )
    return present, missing


def held_out_view(views: ViewSet, target: int, chosen: Sequence[int]) -> HeldOut:
    """The photograph and its references as everybody takes them: planar, 8-bit RGB."""
    photograph, camera = views.color(target), views.entries[target].camera
    if not isinstance(camera, Camera):
        raise CameraError(
            f"{views.names[target]} has a {type(camera).__name__}, but others warp planar views "
            "only: resample the panorama into planar views first"
        )
    references = []
    for index in chosen:
        view = views[index]
        color = np.ascontiguousarray(color_to_srgb8(view.color)[..., :3])
        references.append(ReferenceView(view.camera, color, view.disparity))
    color = np.ascontiguousarray(color_to_srgb8(photograph)[..., :3])
    return HeldOut(views.names[target], camera, color, truth_mask(photograph), tuple(references))


def _predict(
    one: HeldOut,
    rivals: Sequence[Rival],
    tallies: Sequence[Tally],
    threads: int,
    rounds: int,
    pictures: Pictures | None,
    count: int,
) -> float:
    """Judge and time everybody on one view; gives the share of pixels that all of them cover."""
    contestants: list[Contestant] = []
    seen: list[tuple[np.ndarray, Mask]] = []
    for rival, tally in zip(rivals, tallies, strict=True):
        prepared = rival.prepare(one.references, threads)
        run = partial(rival.warp, prepared, one.camera, threads)
        color, _, covered = shown(run())
        seen.append((color, covered))
        contestants.append(Contestant(rival.name, rival.what, threads, run, 0))
        if not tally.megabytes:
            tally.megabytes = peak_megabytes(run)
    common = np.logical_and.reduce([covered for _, covered in seen]) & one.valid
    taken = time_interleaved(contestants, rounds, silent)
    for tally, (color, covered), times in zip(tallies, seen, taken, strict=True):
        if common.any():
            tally.psnr.append(psnr(color, one.color, common))
            tally.ssim.append(ssim(color, one.color, common))
        tally.holes.append(100.0 * float(np.mean(~covered[one.valid])))
        tally.ms.extend(times.ms)
        tally.first_s = tally.first_s or times.first_s
    if pictures is not None:
        pictures[f"{one.name}-truth.png"] = one.color
        for rival, (color, covered) in zip(rivals, seen, strict=True):
            stem = f"{one.name}-{count}-{rival.name}"
            pictures[f"{stem}.png"] = picture_with_holes(color, covered.astype(np.float32))
            pictures[f"{stem}-difference.png"] = signed_difference(color, one.color, covered)
    return float(common[one.valid].mean()) if one.valid.any() else 0.0


def _row(
    rival: Rival,
    tally: Tally,
    plan: Plan,
    width: int,
    count: int,
    samples: int,
    unit: float,
    note: str,
) -> BenchRow:
    times = Times(tally.first_s, tuple(tally.ms))
    return BenchRow(
        name=rival.name,
        what=rival.what,
        size=width,
        threads=plan.threads[0] if rival.threads is None else rival.threads or None,
        references=count,
        ms_median=times.median,
        ms_min=min(times.ms),
        ms_p90=times.percentile(90),
        ns_per_sample=times.median * 1e6 / samples,
        ratio=times.median / unit,
        compile_s=times.first_s,
        psnr=finite(float(np.mean(tally.psnr))) if tally.psnr else None,
        ssim=float(np.mean(tally.ssim)) if tally.ssim else None,
        holes=float(np.mean(tally.holes)),
        megabytes=tally.megabytes,
        note=note,
    )
