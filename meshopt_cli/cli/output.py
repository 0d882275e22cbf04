"""Reports from results, onto the terminal and into files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .. import __version__
from ..errors import ConfigError, WriteError
from ..report.model import FileFacts, PassFacts, Report

if TYPE_CHECKING:
    from ..formats import Source, Written
    from ..jobs.optimize import Result

# How a report can be written, by the suffix of its file.
SUFFIXES = {".json": "json", ".md": "markdown", ".csv": "csv", ".txt": "table"}
REPORT_FORMATS = tuple(SUFFIXES.values())


def facts_of(source: Source) -> FileFacts:
    return FileFacts(str(source.path), source.encoding.format, source.sha256)


def report_of(
    source: Source,
    result: Result,
    seconds: dict[str, float],
    written: Written | None,
) -> Report:
    """The report of an optimization; `written` is None when nothing was."""
    output = None if written is None else facts_of(written)
    passes = tuple(
        PassFacts(
            line.round,
            line.tally.name,
            line.tally.visited,
            line.tally.applied,
            line.tally.refused,
            line.tally.seconds,
            1.0 / line.standing.worst if line.standing.worst > 0 else float("inf"),
            line.standing.mean,
        )
        for line in result.lines
    )
    return Report(
        __version__,
        facts_of(source),
        result.before,
        output,
        result.after,
        passes,
        result.stopped,
        seconds,
        () if written is None else written.lost,
    )


def as_text(reports: list[Report], form: str, verbosity: int = 0) -> str:
    """The reports as one text; `form` is one of `REPORT_FORMATS`."""
    if form == "json":
        from ..report.json import to_json

        return to_json(reports)
    if form == "markdown":
        from ..report.markdown import to_markdown

        return to_markdown(reports)
    if form == "csv":
        from ..report.csv import to_csv

        return to_csv(reports)
    from rich.console import Console

    console = Console(width=120, color_system=None, highlight=False, emoji=False, markup=False)
    with console.capture() as capture:
        _print_tables(console, reports, plain=False, each_round=verbosity > 0)
    return capture.get()


def print_report(reports: list[Report], form: str, verbosity: int = 0, err: bool = False) -> None:
    """Print reports on stdout, or on stderr."""
    if form != "table":
        click.echo(as_text(reports, form), nl=False, err=err)
        return
    from .terminal import is_plain, report_console

    _print_tables(report_console(err), reports, is_plain(err), verbosity > 0)


def _print_tables(console, reports: list[Report], plain: bool, each_round: bool) -> None:
    from ..report.table import render

    for i, report in enumerate(reports):
        if i:
            console.print()
        console.print(render(report, plain, each_round))


def form_of(path: Path) -> str:
    """What a report file is written as.

    Raises
    ------
    ConfigError
        Its suffix says nothing: the message lists those that do.
    """
    form = SUFFIXES.get(path.suffix.lower())
    if form is None:
        raise ConfigError(f"{path}: a report ends in {', '.join(SUFFIXES)}")
    return form


def write_reports(paths: tuple[Path, ...], reports: list[Report], verbosity: int = 0) -> None:
    """Write the reports to each file, as its suffix says.

    Raises
    ------
    WriteError
        A file cannot be written.
    """
    for path in paths:
        try:
            path.write_text(as_text(reports, form_of(path), verbosity), "utf-8", "backslashreplace")
        except OSError as error:
            raise WriteError(f"{path}: cannot write the report: {error.strerror}") from error
