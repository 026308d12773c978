"""What the library says no with.

Every message names what is wrong, where, and how to mend it, with the value seen and the value
wanted. Each error also descends from the built-in one that a caller would expect, so that
``except ValueError`` and ``except FileNotFoundError`` keep working.
"""

from __future__ import annotations


class BelvedereError(Exception):
    """The parent of every error the library raises on purpose."""


class InputError(BelvedereError, ValueError):
    """An argument has a wrong shape, type, range or value."""


class CameraError(InputError):
    """A camera that no picture could have been taken with."""


class ViewError(InputError):
    """A reference view whose parts do not fit together."""


class PathError(InputError):
    """A camera path that cannot be walked."""


class SceneError(BelvedereError, ValueError):
    """A scene, or a file of it, that does not say what it must."""


class FileFormatError(SceneError):
    """A file that is not what its name or header claims: truncated, corrupt or too large."""


class UnsafePathError(SceneError):
    """A path inside a scene that leads out of the scene's folder."""


class MissingFileError(SceneError, FileNotFoundError):
    """A file that the caller or a scene names and that is not there."""


class OutputError(BelvedereError, OSError):
    """A result that cannot be written: it exists already, the disk is full or read-only."""


class MissingDependencyError(BelvedereError, ImportError):
    """An optional package is needed for this and is not installed."""

    @classmethod
    def for_extra(cls, package: str, extra: str, purpose: str) -> MissingDependencyError:
        """The error for a missing optional package.

        Args:
            package: the package that could not be imported.
            extra: the extra of belvedere that brings it.
            purpose: what it is needed for, as the end of "... is needed to".
        """
        return cls(
            f"{package} is needed to {purpose} and is not installed: "
            f"pip install 'belvedere[{extra}]'"
        )
