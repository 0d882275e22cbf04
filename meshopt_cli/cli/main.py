"""The command `meshopt` and the table of its subcommands."""

from __future__ import annotations

import importlib

import click

from .. import __version__
from ..errors import (
    EXIT_BAD_MESH,
    EXIT_DONE,
    EXIT_FILES,
    EXIT_INTERRUPTED,
    EXIT_INVARIANT,
    EXIT_USAGE,
)

STATUSES = {
    EXIT_DONE: "done",
    EXIT_BAD_MESH: "a mesh was judged bad",
    EXIT_USAGE: "wrong usage or configuration",
    EXIT_FILES: "cannot read or cannot write",
    EXIT_INVARIANT: "a bug of meshopt: nothing is written",
    EXIT_INTERRUPTED: "interrupted: nothing is written",
}
EPILOG = "Exit status: " + "; ".join(f"{code} {what}" for code, what in STATUSES.items()) + "."

# Subcommand, module, help: the modules are imported when the command runs.
COMMANDS = {
    "optimize": ("optimize", "Optimize a mesh and report what changed."),
    "check": ("check", "Look for everything that makes meshes invalid."),
    "report": ("report", "Show the quality of meshes."),
    "repair": ("repair", "Mend what is wrong with a mesh, on request."),
    "list": ("listing", "List passes, measures, formats, rules or presets."),
}


class LazyGroup(click.Group):
    """A group that knows the names of its commands, and imports the one that is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f".{COMMANDS[cmd_name][0]}", __package__)
        return module.command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group(
    cls=LazyGroup,
    epilog=EPILOG,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, prog_name="meshopt")
def main() -> None:
    """Optimize, check and report on triangle and tetrahedral meshes."""
