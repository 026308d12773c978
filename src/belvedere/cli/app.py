"""The program's commands, put together."""

from __future__ import annotations

from typing import Annotated

import typer

from belvedere.cli.bench import bench
from belvedere.cli.convert import convert
from belvedere.cli.demo import demo
from belvedere.cli.evaluate import evaluate
from belvedere.cli.info import info
from belvedere.cli.prepare import prepare
from belvedere.cli.render import render
from belvedere.cli.walk import walk
from belvedere.ground.version import __version__

app = typer.Typer(
    name="belvedere",
    help="Walk through pictures that know their depth.\n\nFirst time here? `belvedere demo` builds "
    "a small house and walks you through it. Then try `belvedere info` on a folder of your own.",
    epilog="Any command takes --help, and --debug to show a traceback.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)

app.command()(demo)
app.command()(info)
app.command()(render)
app.command()(evaluate)
app.command()(convert)
app.command()(prepare)
app.command()(walk)
app.command()(bench)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"belvedere {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    del version
