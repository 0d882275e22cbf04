"""The figures of each mesh as comma-separated values, a line a mesh."""

from __future__ import annotations

import csv
import io

from ..errors import shown
from .model import Report
from .rows import HEADINGS, named_rows


def to_csv(reports: list[Report]) -> str:
    """A heading, then for each mesh: file, row, cells in each rank, and the other figures."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    angles = ["mean", "angle_min", "angle_max"]
    writer.writerow(["file", "mesh", *HEADINGS, *angles])
    for report in reports:
        for name, s in named_rows(report):
            figures = [s.target, s.worst, s.n_cells, s.n_points, s.mean, s.angle_min, s.angle_max]
            writer.writerow([shown(report.input.path), name, *s.counts, *figures])
    return out.getvalue()
