"""Writing that either happens or does not.

A file is built under a hidden temporary name beside its place, flushed to the disk and renamed;
a folder likewise. Whoever looks sees the old state or the new one, never half of it.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from belvedere.ground.errors import BelvedereError, OutputError

PARTIAL = ".belvedere-partial"
"""Mark of a file or folder that is being written: its name is hidden and holds this word."""
_REPLACED = ".belvedere-replaced"

_counter = itertools.count()
_DISK = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC), errno.EFBIG}
_REFUSED = {errno.EACCES, errno.EPERM, errno.EROFS}
_NAMES = {errno.ENAMETOOLONG, errno.EEXIST, errno.EISDIR, errno.ENOTDIR, errno.EINVAL, errno.EIO}


def output_error(path: Path, error: OSError) -> OutputError:
    """What an operating system's refusal to write ``path`` means, and how to mend it."""
    if error.errno in _DISK:
        return OutputError(
            f"{path}: the disk is full ({error.strerror}): free some space or write elsewhere; "
            "nothing was changed"
        )
    if error.errno in _REFUSED:
        return OutputError(
            f"{path}: cannot be written here ({error.strerror}): the place is read-only or belongs "
            "to somebody else; choose another with -o"
        )
    return OutputError(f"{path}: cannot be written ({error.strerror or error})")


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn the system's refusals to write into `OutputError`; let every other error pass."""
    try:
        yield
    except BelvedereError:
        raise
    except OSError as error:
        if error.errno in _DISK | _REFUSED | _NAMES:
            raise output_error(path, error) from error
        raise


def require_free(path: str | Path, force: bool = False) -> Path:
    """``path``, unless something is there already.

    Args:
        path: file or folder that is about to be written.
        force: the caller agreed to replace what is there.

    Raises:
        OutputError: it exists and ``force`` is False.
    """
    target = Path(path)
    if not force and (target.exists() or target.is_symlink()):
        raise OutputError(f"{target} exists: pass --force (force=True) to replace it")
    return target


@contextlib.contextmanager
def atomic_write(path: str | Path, *, force: bool = True) -> Iterator[Path]:
    """Give a temporary path to write to; on success it becomes ``path``.

    The temporary name lies in the same folder and keeps the suffix, since many writers choose the
    format by it. Missing parent folders are made. On any exception, Ctrl-C included, the temporary
    file is removed and ``path`` keeps what it had.

    Args:
        path: the file to write.
        force: replace an existing file.

    Raises:
        OutputError: it exists without ``force``; the disk is full, read-only, not ours.
    """
    target = require_free(path, force)
    if target.is_dir():
        raise OutputError(f"{target} is a folder, expected the name of a file to write")
    stem, suffix = target.stem[:80], target.suffix
    temporary = target.with_name(f".{stem}.{os.getpid()}-{next(_counter)}{PARTIAL}{suffix}")
    with writing(target):
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield temporary
            sync_file(temporary)
            os.replace(temporary, target)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise
        sync_folder(target.parent)


def write_bytes(path: str | Path, data: bytes, *, force: bool = True) -> None:
    """Write a whole file atomically (see `atomic_write`)."""
    with atomic_write(path, force=force) as temporary:
        temporary.write_bytes(data)


def sync_file(path: Path) -> None:
    """Wait until a file's bytes are on the disk."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def sync_folder(path: Path) -> None:
    """Wait until a folder's names are on the disk, where the system can do that."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    with contextlib.suppress(OSError):
        handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def staging_path(path: str | Path) -> Path:
    """The hidden sibling in which a folder is built before it gets its name."""
    target = Path(os.path.abspath(path))
    return target.with_name(f".{target.name}{PARTIAL}")


@contextlib.contextmanager
def staged_folder(
    path: str | Path, *, force: bool = False, owned_by: str = "", resume: bool = False
) -> Iterator[Path]:
    """Give a hidden sibling folder to fill; on success it becomes ``path``.

    An error removes it. With ``resume``, an interruption (Ctrl-C, a killed process) leaves it, and
    the next call gives it back with whatever was complete; without, it is always started anew.

    Args:
        path: the folder to make. With ``force`` it may exist and is replaced as a whole.
        force: replace an existing folder.
        owned_by: a file that must lie in a folder for it to be replaced (empty folders always
            may): a slip of the finger must not cost somebody their home folder.
        resume: keep and reuse what an interrupted call left.

    Raises:
        OutputError: it exists without ``force``; it is a file, or not a folder of ours; the disk
            is full, read-only, not ours.
    """
    target = Path(os.path.abspath(path))
    check_replaceable(target, force, owned_by)
    staging = staging_path(target)
    with writing(target):
        if staging.exists() and not resume:
            shutil.rmtree(staging)
        staging.mkdir(parents=True, exist_ok=True)
        try:
            yield staging
            sync_folder(staging)
            swap_folder(staging, target)
        except Exception:
            shutil.rmtree(staging, ignore_errors=True)
            raise
        except BaseException:
            if not resume:
                shutil.rmtree(staging, ignore_errors=True)
            raise
        sync_folder(target.parent)


def check_replaceable(target: Path, force: bool, owned_by: str) -> None:
    """Refuse to replace what is there, unless it is ours or empty and the caller agreed."""
    if not target.exists():
        return
    if not target.is_dir():
        raise OutputError(f"{target} is a file, expected the name of a folder to make")
    if not any(target.iterdir()):
        return
    require_free(target, force)
    if owned_by and not (target / owned_by).is_file():
        raise OutputError(
            f"{target} is not a folder that belvedere wrote (it has no {owned_by}), so it is not "
            "replaced even with --force: choose another name or remove it yourself"
        )


def swap_folder(staging: Path, target: Path) -> None:
    """Give a complete folder its name; what had the name is removed afterwards."""
    if not target.exists():
        os.rename(staging, target)
        return
    old = target.with_name(f".{target.name}.{os.getpid()}-{next(_counter)}{_REPLACED}")
    os.rename(target, old)
    try:
        os.rename(staging, target)
    except BaseException:
        os.rename(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)
