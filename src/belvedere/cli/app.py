"""The program's commands, put together."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from belvedere.cli.bench import bench
from belvedere.cli.convert import convert
from belvedere.cli.demo import demo
from belvedere.cli.evaluate import evaluate
from belvedere.cli.info import info
from belvedere.cli.prepare import prepare
from belvedere.cli.render import render
from belvedere.cli.walk import walk
from belvedere.ground.version import __version__


class Command(TyperCommand):
    """A command whose ``--help`` lists the options under their headings, as plain text."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the sections: arguments, then options heading by heading."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                kind = "Arguments" if parameter.param_type_name == "argument" else "Options"
                heading = getattr(parameter, "rich_help_panel", None) or kind
                sections.setdefault(heading, []).append(record)
        for heading, records in sections.items():
            with formatter.section(heading):
                formatter.write_dl(records)


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

app.command(cls=Command)(demo)
app.command(cls=Command)(info)
app.command(cls=Command)(render)
app.command(cls=Command)(evaluate)
app.command(cls=Command)(convert)
app.command(cls=Command)(prepare)
app.command(cls=Command)(walk)
app.command(cls=Command)(bench)


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
