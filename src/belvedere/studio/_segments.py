"""Joining pieces of one video without encoding them again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

_OPTIONS = {"movflags": "+faststart", "fflags": "+bitexact"}
"""As the pieces were written: it plays while it loads, and holds no time of day."""


def join_segments(segments: Sequence[Path], output: Path) -> None:
    """Write one video out of complete ones that the same encoder settings made.

    Packets are copied and their times moved on, so no picture is changed. Each segment starts with
    a key frame. Not atomic: the caller renames ``output``.

    Args:
        segments: videos of one stream each, in order; same size, rate and encoder.
        output: the file to write; its suffix chooses the container.

    Memory: one packet.
    """
    import av

    with av.open(str(output), "w", format="mp4", options=_OPTIONS) as joined:
        stream = None
        offset = 0
        for segment in segments:
            with av.open(str(segment)) as piece:
                source = piece.streams.video[0]
                if stream is None:
                    stream = joined.add_stream_from_template(source)
                end = offset
                for packet in piece.demux(source):
                    if packet.dts is None or packet.pts is None:  # the flushing packet
                        continue
                    packet.pts += offset
                    packet.dts += offset
                    end = max(end, packet.pts + (packet.duration or 0))
                    packet.stream = stream
                    joined.mux(packet)
                offset = end
