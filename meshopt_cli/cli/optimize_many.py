"""`meshopt optimize` of many meshes at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import EXIT_DONE, ConfigError, WriteError, reason
from ..files.places import require_places
from ..files.sink import PIPE, is_stream
from ..jobs.destinations import destinations
from ..jobs.meshes import files_in
from ..jobs.optimize_many import Outcome, optimize_all
from ..jobs.optimize_mesh import accepted
from ..reports.many import last_line, line_of
from ..reports.outputs import Manner, ReportOutput, write_reports
from .options import LOG_FILE
from .output import print_findings, print_reports, with_command
from .terminal import compile_kernels, say, set_up_log

if TYPE_CHECKING:
    from ..jobs.optimize_file import FileTask


@dataclass(frozen=True)
class Many:
    """What to optimize, and where the results go; see `jobs.destinations`."""

    inputs: list[Path]
    folder: Path | None
    pattern: Path | None
    in_place: bool
    jobs: int | None


def optimize_many(
    many: Many,
    task: FileTask,
    shown: ReportOutput | None,
    written: dict[Path, ReportOutput],
    verbosity: int,
) -> int:
    """Optimize all, and report a line each; returns the worst exit status.

    Parameters
    ----------
    task : FileTask
        What to do with each.
    shown : ReportOutput, optional
        The form of a report on all instead of lines.
    written : dict of Path to ReportOutput
        Files of reports on all, and their forms.
    """
    tasks = _tasks(many, task)
    read = [path for one in tasks for path in one.sources]
    require_places([*_places(tasks), *written], read, read if many.in_place else ())
    compile_kernels(verbosity < 0, accepted(task.task).plan.kernels())
    set_up = partial(set_up_log, file=click.get_current_context().meta[LOG_FILE])
    outcomes = list(_told(optimize_all(tasks, many.jobs, set_up, verbosity), shown, verbosity))
    reports = [with_command(one.report) for one in outcomes if one.report is not None]
    manner = Manner(verbosity)
    for path, row in written.items():
        write_reports(path, reports, row, manner)
    if shown is not None and PIPE not in written:
        print_reports(reports, shown, manner)
    elif verbosity >= 0:
        click.echo(last_line(len(outcomes), sum(one.status == EXIT_DONE for one in outcomes)))
    return max((one.status for one in outcomes), default=EXIT_DONE)


def _tasks(many: Many, task: FileTask) -> list[FileTask]:
    """A task for each input.

    Raises
    ------
    ConfigError, WriteError
        The places of the results are wrong, or cannot be made.
    """
    inputs = files_in(many.inputs)
    if not inputs:
        raise click.UsageError("Missing argument 'INPUT'.")
    if any(is_stream(path) for path in inputs):
        raise ConfigError("pipes are optimized one by one, without --output-dir or a pattern")
    if task.metric_path is not None:
        raise ConfigError("--metric-out takes the name of an array where there are many meshes")
    pairs = destinations(inputs, many.folder, many.pattern)
    if many.folder is not None:
        try:
            many.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise WriteError(f"{many.folder}: cannot be made: {reason(error)}") from error
    return [replace(task, input=path, output=place) for path, place in pairs]


def _places(tasks: list[FileTask]) -> list[Path]:
    return [place for one in tasks for place in one.places]


def _told(
    outcomes: Iterator[Outcome], shown: ReportOutput | None, verbosity: int
) -> Iterator[Outcome]:
    """The outcomes, of each of which a line is said as soon as it is known."""
    for one in outcomes:
        if one.verdict is not None:
            print_findings(one.verdict)
        if one.error:
            say(one.error)
        elif one.report is not None and shown is None and verbosity >= 0:
            click.echo(line_of(one.report))
        yield one
