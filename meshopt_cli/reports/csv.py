"""The figures of each mesh as comma-separated values, a line a mesh."""

from __future__ import annotations

import csv
import io
from typing import Any

from ..errors import shown
from ..metric.summary import MetricSummary
from ..quality.statistics import Statistic
from .metric import CSV_HEADINGS, csv_values
from .model import Report
from .rows import HEADINGS, named_rows


def to_csv(reports: list[Report]) -> str:
    """A heading, then for each mesh: file, row, cells in each rank, and the other figures.

    Of measures that were asked for, three columns for each family of cells; of a metric, those of
    `CSV_HEADINGS`.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    angles = ["mean", "angle_min", "angle_max"]
    every = [s for report in reports for s in (*report.statistics, *report.statistics_after)]
    asked = list(dict.fromkeys(_key(s) for s in every))
    more = [f"{' '.join(key)} {end}" for key in asked for end in ("least", "mean", "greatest")]
    has_metric = any(report.metric is not None for report in reports)
    more += CSV_HEADINGS if has_metric else ()
    writer.writerow(["file", "mesh", *HEADINGS, *angles, *more])
    for report in reports:
        values = _values(report.statistics, report.metric, asked, has_metric)
        later = _values(report.statistics_after, report.metric_after, asked, has_metric)
        for name, s in named_rows(report):
            is_later = name.endswith("after")
            facts = report.input
            if is_later and report.is_comparison and report.output is not None:
                facts = report.output
            figures = [s.target, s.worst, s.n_cells, s.n_points, s.mean, s.angle_min, s.angle_max]
            own = later if is_later else values
            writer.writerow([shown(facts.path), name, *s.counts, *figures, *own])
    return out.getvalue()


def _values(
    statistics: tuple[Statistic, ...],
    metric: MetricSummary | None,
    asked: list[tuple[str, str]],
    has_metric: bool,
) -> list[Any]:
    """The columns of the measures that were asked for, and of a metric."""
    found = {_key(s): [s.least, s.mean, s.greatest] for s in statistics}
    values = [value for key in asked for value in found.get(key, [""] * 3)]
    return [*values, *(csv_values(metric) if has_metric else ())]


def _key(statistic: Statistic) -> tuple[str, str]:
    return statistic.measure, statistic.family
