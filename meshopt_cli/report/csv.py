"""The figures of each mesh as comma-separated values, a line a mesh."""

from __future__ import annotations

import csv
import io

from ..errors import shown
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
    asked = list(dict.fromkeys(_key(s) for report in reports for s in report.statistics))
    more = [f"{' '.join(key)} {end}" for key in asked for end in ("least", "mean", "greatest")]
    has_metric = any(report.metric is not None for report in reports)
    more += CSV_HEADINGS if has_metric else ()
    writer.writerow(["file", "mesh", *HEADINGS, *angles, *more])
    for report in reports:
        found = {_key(s): [s.least, s.mean, s.greatest] for s in report.statistics}
        values = [value for key in asked for value in found.get(key, [""] * 3)]
        if has_metric:
            values += csv_values(report.metric)
        for name, s in named_rows(report):
            figures = [s.target, s.worst, s.n_cells, s.n_points, s.mean, s.angle_min, s.angle_max]
            writer.writerow([shown(report.input.path), name, *s.counts, *figures, *values])
    return out.getvalue()


def _key(statistic: Statistic) -> tuple[str, str]:
    return statistic.measure, statistic.family
