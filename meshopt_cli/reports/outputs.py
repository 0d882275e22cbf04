"""The forms that reports, and what `check` finds, can be written in: a row each.

A row imports what it needs when it is asked for text: `--help` reads these tables too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from ..errors import ConfigError, WriteError, reason
from ..files.sink import is_stream, written
from ..registry import Table
from ..version import __version__

if TYPE_CHECKING:
    from rich.console import Console

    from .model import Report
    from .verdict import Verdict

Item = TypeVar("Item")


@dataclass(frozen=True)
class Manner:
    """How much is told.

    Attributes
    ----------
    verbosity : int
        -1 leaves out what is not asked for; 1 shows every run of every pass.
    statistics : bool
        Whether findings are counted instead of listed.
    """

    verbosity: int = 0
    statistics: bool = False


NORMAL = Manner()


@dataclass(frozen=True)
class Output(Generic[Item]):
    """A form of text.

    Attributes
    ----------
    name : str
    parts : function of items and a manner
        Gives the text part by part, each as soon as there are items for it.
    suffixes : tuple of str
        Of the files that are written in it.
    summary : str
        What it is for.
    """

    name: str
    parts: Callable[[Iterable[Item], Manner], Iterator[str]]
    suffixes: tuple[str, ...] = ()
    summary: str = ""

    def text(self, items: Iterable[Item], manner: Manner = NORMAL) -> str:
        """All of them as one text that ends its last line."""
        return "".join(self.parts(items, manner))


@dataclass(frozen=True)
class ReportOutput(Output["Report"]):
    """A form of reports.

    Attributes
    ----------
    all_measures : bool
        Whether it tells the worst Q by every measure.
    histograms : bool
        Whether it shows those of the measures that are asked for.
    pictures : bool
        Whether it shows some of the meshes.
    draw : function of a console, reports, `plain` and `each_round`, optional
        Prints them in colours, where the form has some.
    """

    all_measures: bool = False
    histograms: bool = False
    pictures: bool = False
    draw: Callable[[Console, Iterable[Report], bool, bool], None] | None = None


@dataclass(frozen=True)
class CheckOutput(Output["Verdict"]):
    """A form of verdicts.

    Attributes
    ----------
    has_statistics : bool
        Whether it can count the findings of each rule.
    """

    has_statistics: bool = False


# Reports -------------------------------------------------------------------------------------


def _draw_table(console: Console, reports: Iterable[Report], plain: bool, each_round: bool) -> None:
    from .table import draw

    draw(console, reports, plain, each_round)


def _table(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    from .table import to_text

    yield to_text(reports, manner.verbosity > 0)


def _json(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    from .json import to_json

    yield to_json(list(reports))


def _markdown(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    from .markdown import to_markdown

    yield to_markdown(list(reports))


def _csv(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    from .csv import to_csv

    yield to_csv(list(reports))


def _html(reports: Iterable[Report], manner: Manner) -> Iterator[str]:
    from .html import to_html

    yield to_html(list(reports))


OUTPUTS = Table[ReportOutput](
    "meshopt.outputs",
    "output",
    (
        ReportOutput("table", _table, (".txt",), "for a terminal, in colours", draw=_draw_table),
        ReportOutput("json", _json, (".json",), "for programs", all_measures=True),
        ReportOutput("markdown", _markdown, (".md",), "for a pull request"),
        ReportOutput("csv", _csv, (".csv",), "for a spreadsheet"),
        ReportOutput(
            "html",
            _html,
            (".html",),
            "a page of its own, with pictures",
            all_measures=True,
            histograms=True,
            pictures=True,
        ),
    ),
    lambda row: isinstance(row, ReportOutput),
)

SUFFIXES: dict[str, ReportOutput] = {s: row for row in OUTPUTS.values() for s in row.suffixes}


def output_of(path: Path) -> ReportOutput:
    """What a report file is written as.

    Raises
    ------
    ConfigError
        Its suffix says nothing: the message lists those that do.
    """
    row = SUFFIXES.get(path.suffix.lower()) or _of_others(path)
    if row is None and is_stream(path):
        return OUTPUTS["table"]
    if row is None:
        raise ConfigError(f"{path}: a report ends in {', '.join(SUFFIXES)}")
    return row


def _of_others(path: Path) -> ReportOutput | None:
    """The form that a package adds for a suffix."""
    end = path.suffix.lower()
    rows = OUTPUTS.whole().values() if end else ()
    return next((row for row in rows if end in row.suffixes), None)


def write_reports(
    path: Path, reports: Iterable[Report], output: ReportOutput, manner: Manner = NORMAL
) -> None:
    """Write reports to a file, which has all of it at once or stays as it was, or to a stream.

    Raises
    ------
    WriteError
        The file cannot be written.
    """
    text = output.text(reports, manner)
    try:
        with written(path, []) as whole:
            whole.write_text(text, "utf-8", "backslashreplace")
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {reason(error)}") from error


# What `check` finds --------------------------------------------------------------------------


def _titles() -> dict[str, str]:
    from ..validity.rules import RULES

    return {code: rule.title for code, rule in RULES.items()}


def _check_text(verdicts: Iterable[Verdict], manner: Manner) -> Iterator[str]:
    from .check_text import finding_lines, last_line, statistics_lines, summary_line

    told = []
    for verdict in verdicts:
        told.append(verdict)
        if verdict.counts is None:
            continue
        if not manner.statistics:
            yield from (f"{line}\n" for line in finding_lines(verdict))
        if manner.verbosity >= 0:
            yield f"{last_line(verdict)}\n"
    if manner.statistics:
        yield from (f"{line}\n" for line in statistics_lines(told, _titles()))
    if manner.verbosity >= 0 and len(told) > 1:
        yield f"{summary_line(told)}\n"


def _check_json(verdicts: Iterable[Verdict], manner: Manner) -> Iterator[str]:
    from .check_json import to_json

    yield to_json(list(verdicts), manner.statistics) + "\n"


def _github(verdicts: Iterable[Verdict], manner: Manner) -> Iterator[str]:
    from .check_github import commands

    titles = _titles()
    for verdict in verdicts:
        yield from (f"{line}\n" for line in commands(verdict, titles))


def _junit(verdicts: Iterable[Verdict], manner: Manner) -> Iterator[str]:
    from .check_junit import to_junit

    yield to_junit(list(verdicts), _titles())


def _sarif(verdicts: Iterable[Verdict], manner: Manner) -> Iterator[str]:
    from ..validity.rules import RULES
    from .check_sarif import to_sarif

    yield to_sarif(list(verdicts), RULES, __version__) + "\n"


CHECK_OUTPUTS: dict[str, CheckOutput] = {
    row.name: row
    for row in (
        CheckOutput("text", _check_text, has_statistics=True),
        CheckOutput("json", _check_json, has_statistics=True),
        CheckOutput("github", _github),
        CheckOutput("junit", _junit),
        CheckOutput("sarif", _sarif),
    )
}
