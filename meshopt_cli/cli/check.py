"""`meshopt check`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE, EXIT_PIPE, NoReaderError
from ..reports.outputs import CHECK_OUTPUTS, Manner
from . import completion
from .check_config import Configured
from .options import (
    INPUT,
    LOG_FILE,
    OUTPUT,
    engine_options,
    measure_option,
    metric_options,
    names_in,
    number_option,
    reading_options,
    region_option,
    verbosity_options,
)
from .terminal import say

if TYPE_CHECKING:
    from ..jobs.check import Task
    from ..jobs.metric import Asked
    from ..reports.verdict import Verdict


def gate_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The limits that a user can set."""
    options = (
        number_option("fail-above", metavar="Q",
                      help="A cell worse than Q makes the mesh bad (M401)."),
        measure_option,
        number_option("min-angle", metavar="DEGREES",
                      help="Least dihedral angle, or angle of a face in the plane (M402)."),
        number_option("max-angle", metavar="DEGREES", help="Greatest such angle (M402)."),
        number_option("min-size", metavar="LENGTH", help="Least length of an edge (M403)."),
        number_option("max-aspect", metavar="Q",
                      help="Greatest aspect ratio, whatever --measure says (M404)."),
        click.option("--gate", "gates", multiple=True, metavar="GATE",
                     help='Any other limit, such as "height-min>=0.1" or, in one region, '
                          '"dihedral-min>=10 @ steel" (M404). Repeatable.',
                     shell_complete=completion.of(completion.gates)),
    )  # fmt: skip
    for option in reversed(options):
        function = option(function)
    return function


CODES = completion.of(completion.rules, many=True)


@click.command("check", cls=Configured)
@click.argument("meshes", nargs=-1, type=INPUT, metavar="MESH...")
@click.option("--select", callback=names_in, metavar="CODES", shell_complete=CODES,
              help="Only these rules, by prefixes.")  # fmt: skip
@click.option("--extend-select", "extend", callback=names_in, metavar="CODES", shell_complete=CODES,
              help="These rules too, such as those on request.")  # fmt: skip
@click.option("--ignore", callback=names_in, metavar="CODES", shell_complete=CODES,
              help="All but these, by prefixes.")  # fmt: skip
@gate_options
@metric_options("Gates on tau, unit-edges and others (M406) are in")
@region_option
@number_option("tolerance", metavar="T",
               help="Points nearer than T of the extent coincide; vertices nearer to a facet than "
                    "T of its size lie on it.")  # fmt: skip
@click.option("--format", "form", type=click.Choice(list(CHECK_OUTPUTS)),
              default="text", show_default=True)  # fmt: skip
@number_option("limit", default=10, show_default=True, metavar="N",
               help="Findings of a rule that are listed for a file; 0 lists all.")  # fmt: skip
@click.option("--statistics", is_flag=True, help="Count the findings of each rule instead.")
@click.option("--mark", type=OUTPUT, metavar="FILE",
              help="Write the cells and points that are found, with their codes.")  # fmt: skip
@number_option("jobs", metavar="N",
               help="Processes; as many as there are cores where it is worth it.")  # fmt: skip
@engine_options
@click.option("--exit-zero", is_flag=True, help="Exit with 0 although a mesh is bad.")
@click.option("--no-config", is_flag=True, help="Read no meshopt.toml or pyproject.toml.")
@click.option("--explain", metavar="CODE", help="Say what a rule means, and check nothing.",
              shell_complete=completion.of(completion.rules))  # fmt: skip
@reading_options
@verbosity_options(quiet="Say nothing of meshes in which nothing is found, and no warnings.",
                   verbose="Say more.")  # fmt: skip
def command(
    meshes: tuple[Path, ...],
    form: str,
    statistics: bool,
    jobs: int | None,
    engine: str | None,
    scheduler: str | None,
    exit_zero: bool,
    no_config: bool,
    explain: str | None,
    verbosity: int,
    **options: Any,
) -> int:
    """Look for everything that makes meshes invalid.

    MESH is a file, a folder with meshes, or a pattern. Rules of severity error make the exit
    status 1, warnings do not. Defaults of the options can stand in the table [check] of a
    meshopt.toml, or [tool.meshopt.check] of a pyproject.toml, from the working directory
    upwards. `meshopt list rules` says what the codes mean.
    """
    from ..jobs.check import examine_all, needs_kernels
    from ..jobs.meshes import files_in
    from .standard import forget_stdout
    from .terminal import compile_kernels, set_up_log

    if explain is not None:
        _explain(explain)
        return EXIT_DONE
    if not meshes:
        raise click.UsageError("Missing argument 'MESH...'.")
    output = CHECK_OUTPUTS[form]
    if statistics and not output.has_statistics:
        able = " and ".join(row.name for row in CHECK_OUTPUTS.values() if row.has_statistics)
        raise click.UsageError(f"--statistics goes with {able}, not with {form}")
    task = _task(verbosity, **options)
    task.require_metric()
    checked = task.checked  # an unknown code is an error before any file is read
    files = files_in(meshes)
    task.require_mark(files)
    if checked and needs_kernels(files, task.gates):
        compile_kernels(verbosity < 0, ("basic", "check"))
    statuses: list[int] = []
    log_file = click.get_current_context().meta[LOG_FILE]
    if engine or scheduler:
        from .engines import verdicts_on_pieces

        judged = verdicts_on_pieces(files, task, engine, scheduler, jobs, verbosity)
    else:
        judged = examine_all(files, task, jobs, partial(set_up_log, file=log_file))
    verdicts = _noted(judged, statuses)
    try:
        for part in output.parts(verdicts, Manner(verbosity, statistics)):
            click.echo(part, nl=False)
    except NoReaderError:
        # Whoever reads has seen enough. What is known to be bad is; the rest was not looked at.
        forget_stdout()
        statuses.append(EXIT_PIPE)
        return next(status for status in statuses if status != EXIT_DONE)
    status = max(statuses)
    return EXIT_DONE if exit_zero and status == EXIT_BAD_MESH else status


def _task(
    verbosity: int,
    select: tuple[str, ...] | None,
    ignore: tuple[str, ...] | None,
    extend: tuple[str, ...] | None,
    tolerance: float | None,
    limit: int,
    mark: Path | None,
    regions: tuple[str, ...],
    input_format: str | None,
    max_size: int | None,
    asked: Asked | None,
    **gates: Any,
) -> Task:
    from ..jobs.check import Task
    from ..quality.gates import gates_of

    codes = (select or (), ignore or (), extend or ())
    return Task(
        *codes, gates_of(**gates), tolerance, limit or None, mark, verbosity, regions,
        input_format, max_size, asked,
    )  # fmt: skip


def _noted(verdicts: Iterable[Verdict], statuses: list[int]) -> Iterator[Verdict]:
    """The verdicts, while errors are said at once and each status is kept."""
    for verdict in verdicts:
        statuses.append(verdict.status)
        if verdict.error:
            say(verdict.error)
        yield verdict


def _explain(code: str) -> None:
    """Print all that there is to say of a rule, or of each with this prefix."""
    from ..reports.check_text import explanation
    from ..validity import choose

    click.echo("\n\n".join(explanation(rule) for rule in choose([code])))
