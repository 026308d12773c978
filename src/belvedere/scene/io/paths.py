"""Paths that scenes name. They may not lead out of the scene's folder."""

from __future__ import annotations

import os
import re
from pathlib import Path

from belvedere.ground.errors import MissingFileError, SceneError, UnsafePathError

_DRIVE = re.compile(r"^[A-Za-z]:")
_SAFE_NAME = re.compile(r"^[A-Za-z0-9_][A-Za-z0-9_.+-]*(/[A-Za-z0-9_][A-Za-z0-9_.+-]*)*$")
_RESERVED = re.compile(r"^(con|prn|aux|nul|com[0-9]|lpt[0-9])$", re.IGNORECASE)
MAX_NAME = 120
"""Characters of a name that we write: every file system takes them."""


def inside(folder: str | Path, relative: object, where: str = "path") -> Path:
    """The path ``relative`` names, which must lie in ``folder``. The file need not exist.

    Args:
        folder: the scene's folder.
        relative: as a scene file writes it, with forward slashes.
        where: who names it, for the message: ``transforms.json: frames[3].file_path``.

    Raises:
        SceneError: it is not text, or empty.
        UnsafePathError: it is absolute, has a drive letter, backslashes, control characters or
            ``..`` that leaves the folder, or goes through a symbolic link that leaves the folder.
    """
    if not isinstance(relative, str) or not relative.strip():
        raise SceneError(f"{where} is {relative!r}, expected the path of a file in the scene")
    hint = "paths in a scene are relative to its folder and stay inside it"
    if any(ord(letter) < 32 for letter in relative):
        raise UnsafePathError(f"{where} has control characters ({relative!r}): {hint}")
    if "\\" in relative:
        raise UnsafePathError(
            f"{where} has a backslash ({relative!r}): write forward slashes; {hint}"
        )
    if relative.startswith(("/", "~")) or _DRIVE.match(relative):
        raise UnsafePathError(f"{where} is the absolute path {relative!r}: {hint}")
    depth = 0
    for part in relative.split("/"):
        depth += {"..": -1, ".": 0, "": 0}.get(part, 1)
        if depth < 0:
            raise UnsafePathError(f"{where} leads out of the scene's folder ({relative!r}): {hint}")
    base = os.path.realpath(folder)
    target = os.path.realpath(os.path.join(base, relative))
    if target != base and not target.startswith(base.rstrip(os.sep) + os.sep):
        raise UnsafePathError(
            f"{where}: {relative!r} is a symbolic link out of the scene's folder: {hint}"
        )
    return Path(folder, relative)


def existing(folder: str | Path, relative: object, where: str = "path") -> Path:
    """The file that ``relative`` names in ``folder`` (see `inside`).

    Raises:
        MissingFileError: there is no such file.
        UnsafePathError: see `inside`.
    """
    path = inside(folder, relative, where)
    if not path.is_file():
        raise MissingFileError(
            f"{where}: no file {relative!r} in {folder}: paths are relative to the scene's folder"
        )
    return path


def file_name(name: str, taken: set[str], index: int) -> str:
    """A relative path without suffix for a view called ``name``, and add it to ``taken``.

    The name itself where every file system takes it and it is free (whatever the case of its
    letters); its number otherwise.
    """
    good = bool(_SAFE_NAME.match(name)) and ".." not in name and len(name) <= MAX_NAME
    good = good and not any(
        _RESERVED.match(part.split(".")[0]) or part.endswith(".") for part in name.split("/")
    )
    choice = name if good else f"{index:05d}"
    while choice.lower() in taken:
        choice = f"{index:05d}-{len(taken)}"
    taken.add(choice.lower())
    return choice
