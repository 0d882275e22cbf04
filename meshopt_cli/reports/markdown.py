"""The report as GitHub-flavoured Markdown."""

from __future__ import annotations

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


def _row(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def to_markdown(reports: list[Report]) -> str:
    """A section a report."""
    lines = []
    for report in reports:
        lines += [f"### {report.title}", "", _row(["", *HEADINGS])]
        lines.append(_row(["---", *["---:"] * len(HEADINGS)]))
        for name, summary in named_rows(report):
            lines.append(_row([name, *percent_row(summary)]))
            lines.append(_row(["", *count_row(summary)]))
        if report.statistics:
            lines += ["", _row([*MEASURE_HEADINGS]), _row(["---"] * len(MEASURE_HEADINGS))]
            lines += [_row(row) for _, row in measure_rows(report)]
        for name, metric in metrics(report):
            lines += ["", f"{name}:"] if name else []
            lines += ["", _row([*LENGTH_HEADINGS]), _row(["---"] * len(LENGTH_HEADINGS))]
            lines += [_row(row) for row in length_rows(metric)]
            lines += ["", "; ".join(metric_lines(metric))]
        if report.passes:
            heads = ["pass", "runs", "tried", "applied", "refused", "s", "Q_T"]
            lines += ["", _row(heads), _row(["---"] * len(heads))]
            lines += [_row(row) for row in pass_rows(report, each_round=False)]
        lines += ["", "; ".join(closing_lines(report)), ""]
    return "\n".join(lines)
