"""How fast every reconstructor is, in every use, beside others that do the same job."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np

from belvedere.ground.errors import MissingDependencyError
from belvedere.ground.progress import Progress
from belvedere.ground.threads import thread_count
from belvedere.scene import Frame
from belvedere.studio._bench_peers import PEERS, Peer, agreement
from belvedere.studio._bench_rows import BenchRow
from belvedere.studio._bench_scene import BenchScene, make_room
from belvedere.studio._bench_timing import Contestant, Times, time_interleaved

BYTES_PER_SAMPLE = 18
"""What a point warp of ``uint8`` RGB must move: 7 bytes of colour and disparity in, 11 of colour,
disparity and coverage out."""


def warp_choices() -> dict[str, dict[str, Any]]:
    """The reconstructors as they are measured: name to choices of `belvedere.warp`."""
    from belvedere.warp import OffsetOptions, SplatOptions

    return {
        "point": {"reconstruction": "point"},
        "splat3": {"reconstruction": "splat", "splat": SplatOptions(size=3)},
        "splat-jacobian": {"reconstruction": "splat", "splat": SplatOptions(size="jacobian")},
        "gaussian": {"reconstruction": "gaussian"},
        "mesh": {"reconstruction": "mesh"},
        "offset": {"reconstruction": "offset"},
        "inverse": {"reconstruction": "inverse"},
        "offset-full": {"reconstruction": "offset", "offset": OffsetOptions(density=4)},
    }


def warp_contestants(scene: BenchScene, threads: int | None = None) -> Iterator[Contestant]:
    """Our own ways of warping the room, the baseline first."""
    from belvedere.warp import prepare, warp

    most = thread_count(threads)
    views, camera = scene.views, scene.camera
    prepared = tuple(prepare(view) for view in views)
    samples = views[0].disparity.size
    uses = [
        ("order", "order", prepared[0], "one prepared reference", most),
        ("order/view", "order", views[0], "one view, preparing it included", most),
        ("zbuffer", "zbuffer", prepared[0], "one prepared reference", most),
        ("order/two", "order", prepared, "two prepared references, blended", most),
    ]
    if threads is None and most > 1:
        uses.insert(1, ("order/1t", "order", prepared[0], "one prepared reference", 1))
    for suffix, visibility, given, text, count in uses:
        for name, choices in warp_choices().items():
            references = len(given) if isinstance(given, tuple) else 1

            def run(
                given: Any = given,
                visibility: Any = visibility,
                count: int = count,
                choices: dict[str, Any] = choices,
            ) -> Frame:
                return warp(given, camera, visibility=visibility, threads=count, **choices)

            yield Contestant(
                f"{name}/{suffix}", f"{text}, {visibility}", count, run, samples * references
            )


def copy_contestant(samples: int) -> Contestant:
    """Copying as many bytes as a point warp must move: the least time it could take."""
    source = np.ones(samples * BYTES_PER_SAMPLE // 2, np.uint8)
    target = np.empty_like(source)

    def run() -> None:
        np.copyto(target, source)

    return Contestant("copy", "memory copy, half of the bytes read and half written", 1, run,
                      samples)  # fmt: skip


def speed_rows(
    size: int, repeats: int, threads: int | None, peers: bool, progress: Progress
) -> tuple[list[BenchRow], str]:
    """Rows of the suite "speed", and the name of the baseline."""
    progress(0, 1, "making the room")
    scene = make_room(size)
    contestants = [*warp_contestants(scene, threads), copy_contestant(size * size)]
    baseline = contestants[0].name
    missing: list[BenchRow] = []
    for peer in PEERS if peers else ():
        rival = _peer_contestant(peer, scene, threads)
        if isinstance(rival, Contestant):
            contestants.append(rival)
        else:
            missing.append(rival)
    times = time_interleaved(contestants, repeats, progress)
    agreed = _agreements(scene, contestants)
    unit = times[0].median
    rows = [
        _row(one, taken, size, unit, agreed.get(one.name))
        for one, taken in zip(contestants, times, strict=True)
    ]
    return rows + missing, baseline


def _peer_contestant(peer: Peer, scene: BenchScene, threads: int | None) -> Contestant | BenchRow:
    told = thread_count(threads)
    used = {None: told, 0: os.cpu_count() or 1}.get(peer.threads, peer.threads)
    view = scene.views[0]
    try:
        run = peer.make(view, scene.camera, told)
    except MissingDependencyError as missing:
        return BenchRow(peer.name, peer.what, view.camera.width, None,
                        note=f"{missing} is not installed: {peer.install}")  # fmt: skip
    return Contestant(peer.name, peer.what, used, run, view.disparity.size)


def _agreements(scene: BenchScene, contestants: list[Contestant]) -> dict[str, tuple[float, float]]:
    """Each peer's picture beside our point warp with a z-buffer, which is the job they do."""
    from belvedere.warp import warp

    names = {peer.name for peer in PEERS}
    ours = warp(scene.views[0], scene.camera, reconstruction="point", visibility="zbuffer")
    return {one.name: agreement(one.run(), ours) for one in contestants if one.name in names}


def _row(
    one: Contestant, taken: Times, size: int, unit: float, agreed: tuple[float, float] | None
) -> BenchRow:
    note = one.note
    if one.name == "copy":
        speed = one.samples * BYTES_PER_SAMPLE / (taken.median * 1e6)
        note = f"{BYTES_PER_SAMPLE} bytes a sample at {speed:.1f} GB/s on one thread"
    surface, color = agreed if agreed is not None else (None, None)
    return BenchRow(
        name=one.name,
        what=one.what,
        size=size,
        threads=one.threads,
        ms_median=taken.median,
        ms_min=min(taken.ms),
        ms_p90=taken.percentile(90),
        ns_per_sample=taken.median * 1e6 / one.samples,
        ratio=taken.median / unit,
        compile_s=taken.first_s,
        same_surface=surface,
        same_color=color,
        note=note,
    )
