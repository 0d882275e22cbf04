"""The command `meshopt` and the table of its subcommands."""

from __future__ import annotations

import importlib
import os

import click

from ..errors import (
    EXIT_BAD_MESH,
    EXIT_DONE,
    EXIT_FILES,
    EXIT_HUNG_UP,
    EXIT_INTERRUPTED,
    EXIT_INVARIANT,
    EXIT_PIPE,
    EXIT_TERMINATED,
    EXIT_USAGE,
    hint,
)
from ..memory import FOR_NUMPY, require_memory
from ..version import __version__

STATUSES = {
    EXIT_DONE: "done",
    EXIT_BAD_MESH: "a mesh was judged bad",
    EXIT_USAGE: "wrong usage or configuration",
    EXIT_FILES: "cannot read or cannot write",
    EXIT_INVARIANT: "a bug of meshopt: nothing is written",
    EXIT_INTERRUPTED: "interrupted",
    EXIT_TERMINATED: "terminated",
    EXIT_HUNG_UP: "the terminal hung up",
    EXIT_PIPE: "nobody reads stdout",
}
EPILOG = "Exit status: " + "; ".join(f"{code} {what}" for code, what in STATUSES.items()) + "."

# Subcommand, module, help: the modules are imported when the command runs.
COMMANDS = {
    "optimize": ("optimize", "Optimize a mesh and report what changed."),
    "check": ("check", "Look for everything that makes meshes invalid."),
    "report": ("report", "Show the quality of meshes."),
    "view": ("view", "Draw a mesh, its cells coloured by their quality."),
    "repair": ("repair", "Mend what is wrong with a mesh, on request."),
    "split": ("split", "Cut a mesh in pieces."),
    "join": ("join", "Put the pieces of a mesh together."),
    "schema": ("schema", "Print the JSON schema of pipeline files."),
    "list": ("listing", "List passes, measures, formats, outputs, rules or presets."),
}


class LazyGroup(click.Group):
    """A group that knows the names of its commands, and imports the one that is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        require_memory(FOR_NUMPY)
        module = importlib.import_module(f".{COMMANDS[cmd_name][0]}", __package__)
        return module.command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"no command {args[0]!r}{_meant(args)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


def _meant(args: list[str]) -> str:
    """What somebody may have meant whose first word is no command."""
    word = args[0]
    if word == "help":
        named = args[1] if len(args) > 1 and args[1] in COMMANDS else ""
        return f": did you mean 'meshopt {named}{' ' * bool(named)}--help'?"
    if os.path.exists(word) or _is_named_like_mesh(word):
        return (
            f": what is to be done with it? meshopt check {word}, report {word}, view {word}, "
            f"optimize {word} OUTPUT, repair --all {word} OUTPUT"
        )
    return hint(word, COMMANDS)


def _is_named_like_mesh(word: str) -> bool:
    from pathlib import Path

    from ..formats import FORMATS, extension

    rows = FORMATS.whole().values()
    return any(extension(Path(word)) in (*row.extensions, *row.others) for row in rows)


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="meshopt")
def main() -> None:
    """Optimize, check and report on triangle and tetrahedral meshes."""
