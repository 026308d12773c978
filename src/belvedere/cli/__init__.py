"""The ``belvedere`` program: one command file per verb. No algorithm lives here.

Each command parses, calls one function of the library, saves, and prints what it wrote where. Our
own errors print as one line and exit with 2; ``--debug`` shows the traceback.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from belvedere.ground.errors import BelvedereError

EXIT_REFUSED = 2
EXIT_BROKEN = 3
EXIT_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and exit with its status.

    Args:
        arguments: what follows the program's name; by default the process's own.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    sys.exit(run(words, debug=debug))


def run(words: list[str], *, debug: bool = False) -> int:
    """The program's exit status for a list of arguments."""
    from belvedere.cli.app import app

    try:
        app(words, prog_name="belvedere")
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 0 if end.code is None else EXIT_REFUSED
        return _interrupted() if status == EXIT_INTERRUPTED else status
    except KeyboardInterrupt:
        return _interrupted()
    except BelvedereError as error:
        if debug:
            raise
        return _say(str(error), EXIT_REFUSED)
    except MemoryError:
        if debug:
            raise
        return _say("out of memory: use smaller pictures or fewer references", EXIT_REFUSED)
    except Exception as error:
        if debug:
            raise
        return _say(
            f"internal error, {type(error).__name__}: {error} (this is a bug in belvedere: repeat "
            "the command with --debug and report what it prints)",
            EXIT_BROKEN,
        )
    return 0


def _interrupted() -> int:
    return _say(
        "interrupted: nothing half-written is left; repeating the same render or convert goes on "
        "from what is complete",
        EXIT_INTERRUPTED,
    )


def _say(text: str, status: int) -> int:
    sys.stdout.flush()
    sys.stderr.write(f"belvedere: {text}\n")
    return status
