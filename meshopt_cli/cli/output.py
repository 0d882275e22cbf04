"""Reports and verdicts onto the terminal."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from ..reports.outputs import Manner, ReportOutput
from .terminal import is_plain, report_console

if TYPE_CHECKING:
    from ..reports.model import Report
    from ..reports.verdict import Verdict


def print_reports(
    reports: Iterable[Report], output: ReportOutput, manner: Manner, err: bool = False
) -> None:
    """Print reports on stdout, or on stderr, in colours where form and terminal have some."""
    if output.draw is None:
        click.echo(output.text(reports, manner), nl=False, err=err)
    else:
        output.draw(report_console(err), reports, is_plain(err), manner.verbosity > 0)


def with_command(report: Report) -> Report:
    """A report that tells the words that the program was called with."""
    words = click.get_current_context().find_object(tuple) or ()
    return replace(report, command=shlex.join(["meshopt", *words]) if words else "")


def print_findings(verdict: Verdict) -> None:
    """Print on stderr what was found, the first of each rule, then how many more there are."""
    from ..reports.check_text import finding_lines

    for line in finding_lines(verdict):
        click.echo(line, err=True)
