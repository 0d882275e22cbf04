"""The report on the terminal: Table 18.3 with a bar of the histogram under each row."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from ..metric.summary import MetricSummary
from ..quality.summary import Summary
from .metric import LENGTH_HEADINGS, length_rows, metric_lines, metrics
from .model import Report
from .rows import (
    HEADINGS,
    MEASURE_HEADINGS,
    closing_lines,
    count_row,
    measure_rows,
    named_rows,
    pass_rows,
    percent_row,
)

BAR_WIDTH = 64
BLOCKS = "\u2588\u2593\u2592\u2591"
PLAIN_BLOCKS = "#=+-"
NAMES = ("measure", "of", "unit")  # columns of words
STYLES = ("green", "yellow", "dark_orange", "red")


def bar(summary: Summary, plain: bool) -> Text:
    """One line, a part of it for each rank that has cells, the good ones first."""
    text = Text()
    total = max(summary.n_cells, 1)
    for count, block, style in zip(
        summary.counts, PLAIN_BLOCKS if plain else BLOCKS, STYLES, strict=True
    ):
        width = round(BAR_WIDTH * count / total)
        text.append(block * (max(width, 1) if count else 0), style=style)
    return text


def quality_table(report: Report) -> Table:
    """The rows of Table 18.3: percent over count, for one mesh or before and after."""
    table = Table(box=None, pad_edge=False, padding=(0, 1))
    table.add_column("")
    for heading in HEADINGS:
        table.add_column(heading, justify="right", no_wrap=True)
    for name, summary in named_rows(report):
        table.add_row(name, *percent_row(summary))
        table.add_row("", *count_row(summary))
    return table


def measures_table(report: Report) -> Table:
    """A row a measure that was asked for, and family of cells."""
    table = Table(box=None, pad_edge=False, padding=(0, 1))
    for heading in MEASURE_HEADINGS:
        table.add_column(heading, justify="left" if heading in NAMES else "right", no_wrap=True)
    for _, row in measure_rows(report):
        table.add_row(*row)
    return table


def lengths_table(metric: MetricSummary) -> Table:
    """Lengths in a metric: a row of all edges, and one of those inside."""
    table = Table(box=None, pad_edge=False, padding=(0, 1))
    for i, heading in enumerate(LENGTH_HEADINGS):
        table.add_column(heading, justify="right" if i else "left", no_wrap=True)
    for row in length_rows(metric):
        table.add_row(*row)
    return table


def passes_table(report: Report, each_round: bool) -> Table:
    """A row a pass."""
    table = Table(box=None, pad_edge=False, padding=(0, 1))
    for heading in ("pass", "round" if each_round else "runs", "tried", "applied"):
        table.add_column(heading, justify="left" if heading == "pass" else "right")
    table.add_column("refused", overflow="fold", max_width=64)
    table.add_column("s", justify="right")
    table.add_column("Q_T", justify="right")
    for row in pass_rows(report, each_round):
        table.add_row(*row)
    return table


def render(report: Report, plain: bool = False, each_round: bool = False) -> RenderableType:
    """The whole report.

    Parameters
    ----------
    plain : bool
        Draw the bar in ASCII.
    each_round : bool
        Show every run of every pass.
    """
    parts: list[RenderableType] = [Text(report.title, style="bold"), quality_table(report), ""]
    rows = named_rows(report)
    width = max(len(name) for name, _ in rows) + 1
    for name, summary in rows:
        parts.append(Text(f"{name:{width}}") + bar(summary, plain))
    if report.statistics:
        parts += ["", measures_table(report)]
    for name, metric in metrics(report):
        parts += ["", *([Text(name)] if name else []), lengths_table(metric), ""]
        parts += [Text(line) for line in metric_lines(metric)]
    if report.passes:
        parts += ["", passes_table(report, each_round)]
    parts += ["", *(Text(line) for line in closing_lines(report))]
    return Group(*parts)


def draw(console: Console, reports: Iterable[Report], plain: bool, each_round: bool) -> None:
    """Print reports one below the other; see `render`."""
    for i, report in enumerate(reports):
        if i:
            console.print()
        console.print(render(report, plain, each_round))


def to_text(reports: Iterable[Report], each_round: bool = False) -> str:
    """The reports as one text without colours."""
    console = Console(width=120, color_system=None, highlight=False, emoji=False, markup=False)
    with console.capture() as capture:
        draw(console, reports, plain=False, each_round=each_round)
    return capture.get()
