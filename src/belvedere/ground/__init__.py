"""Floor 0: pure ground that every room stands on.

Errors that say what, where and how to mend it; checks at the door; colour transfer; the one
decorator that compiles kernels; the one way to run work on several threads. Nothing here knows a
camera or an image file.
"""

from belvedere.ground.color import decode_srgb8, encode_srgb8, linear_to_srgb, srgb_to_linear
from belvedere.ground.errors import (
    BelvedereError,
    CameraError,
    FileFormatError,
    InputError,
    MissingDependencyError,
    MissingFileError,
    OutputError,
    PathError,
    SceneError,
    UnsafePathError,
    ViewError,
)
from belvedere.ground.progress import Progress, silent
from belvedere.ground.threads import run_parallel, thread_count

__all__ = [
    "BelvedereError",
    "CameraError",
    "FileFormatError",
    "InputError",
    "MissingDependencyError",
    "MissingFileError",
    "OutputError",
    "PathError",
    "Progress",
    "SceneError",
    "UnsafePathError",
    "ViewError",
    "decode_srgb8",
    "encode_srgb8",
    "linear_to_srgb",
    "run_parallel",
    "silent",
    "srgb_to_linear",
    "thread_count",
]
