"""`meshopt repair`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE
from ..repairs import MENDS
from .options import file_options, number_option, verbosity_options


def mend_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """A flag for each mend."""
    for mend in reversed(MENDS.values()):
        function = click.option(f"--{mend.name}", is_flag=True, help=f"{mend.summary}.")(function)
    return function


@click.command("repair")
@file_options
@mend_options
@click.option("--all", "every", is_flag=True, help="All of these.")
@number_option("tolerance", metavar="T",
               help="Points nearer than T of the extent are in one place.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@verbosity_options()
def command(
    input: Path,
    output: Path | None,
    every: bool,
    tolerance: float | None,
    as_json: bool,
    file_format: str | None,
    input_format: str | None,
    binary: bool | None,
    max_size: int | None,
    in_place: bool,
    verbosity: int,
    **chosen: bool,
) -> int:
    """Mend what is wrong with the mesh in INPUT, and write it to OUTPUT.

    Nothing is mended that is not asked for. What was done is counted, and what `meshopt check`
    still finds is shown; errors among it make the exit status 1, although OUTPUT is written.
    """
    from ..formats import PIPE
    from ..jobs.optimize_file import place_of
    from ..jobs.repair_file import RepairTask, repair_file
    from ..reports.repair import left_lines, repair_lines, to_json
    from ..validity.rules import RULES

    names = tuple(name for name in MENDS if every or chosen[name])
    if not names:
        flags = ", ".join(f"--{name}" for name in MENDS)
        raise click.UsageError(f"say what to mend: --all, or some of {flags}")
    place = place_of(input, output, in_place)
    task = RepairTask(input, place, names, tolerance, input_format, file_format, binary, max_size)
    report = repair_file(task)
    err = place == PIPE
    if as_json:
        click.echo(to_json(report), nl=False, err=err)
    elif verbosity >= 0:
        titles = {code: rule.title for code, rule in RULES.items()}
        for line in repair_lines(report, titles):
            click.echo(line, err=err)
        for line in left_lines(report):
            click.echo(line, err=True)
    return EXIT_DONE if report.after.is_valid else EXIT_BAD_MESH
