"""The rows of Table 18.3 as strings, for every output that shows a table."""

from __future__ import annotations

import math
from itertools import pairwise

from ..errors import shown
from ..quality.room import Room
from ..quality.summary import RANKS, Summary
from .model import Report

HEADINGS = (
    *(f"> {low:g}" if math.isinf(high) else f"{low:g} - {high:g}" for low, high in pairwise(RANKS)),
    "target",
    "Q_T",
    "ne",
    "np",
)


def figure(value: float) -> str:
    """Q in four digits: 1.87, 531.1, 2.56e+06."""
    if math.isinf(value):
        return "inf"
    if value >= 1e5:
        return f"{value:.2e}"
    return f"{value:.2f}" if value < 100 else f"{value:.1f}"


def percent_row(summary: Summary) -> list[str]:
    """Percent in each rank, then target, Q_T, ne, np."""
    return [
        *(f"{p:.1f}" for p in summary.percent),
        figure(summary.target),
        figure(summary.worst),
        f"{summary.n_cells:,}",
        f"{summary.n_points:,}",
    ]


def count_row(summary: Summary) -> list[str]:
    """Cells in each rank; nothing in the other columns."""
    return [*(f"{c:,}" for c in summary.counts), "", "", "", ""]


def named_rows(report: Report) -> list[tuple[str, Summary]]:
    """The meshes of a report with the names of their rows."""
    if report.after is None:
        return [("mesh", report.before)]
    return [("before", report.before), ("after", report.after)]


def pass_rows(report: Report, each_round: bool) -> list[list[str]]:
    """What the passes did: a row a pass, or with `each_round` a row a run of a pass.

    Columns: pass, rounds or round, tried, applied, refused, seconds, Q_T after it.
    """
    if each_round:
        return [
            [p.name, str(p.round), f"{p.visited:,}", f"{p.applied:,}",
             ", ".join(f"{v} {n:,}" for v, n in p.refused.items()), f"{p.seconds:.2f}",
             figure(p.worst)]
            for p in report.passes
        ]  # fmt: skip
    rows = []
    for name in dict.fromkeys(p.name for p in report.passes):
        runs = [p for p in report.passes if p.name == name]
        refused: dict[str, int] = {}
        for run in runs:
            for verdict, count in run.refused.items():
                refused[verdict] = refused.get(verdict, 0) + count
        rows.append(
            [name, str(len(runs)), f"{sum(p.visited for p in runs):,}",
             f"{sum(p.applied for p in runs):,}",
             ", ".join(f"{v} {n:,}" for v, n in refused.items()),
             f"{sum(p.seconds for p in runs):.2f}", figure(runs[-1].worst)]
        )  # fmt: skip
    return rows


def closing_lines(report: Report) -> list[str]:
    """Why the run stopped, what came and went, angles and times."""
    after = report.after or report.before
    kind = "dihedral angles" if after.dimension == 3 else "angles"
    angles = f"{kind} {after.angle_min:.1f} to {after.angle_max:.1f} degrees"
    if after.forced is not None and after.dimension == 3:
        angles += " (the boundary forces {:.1f} and {:.1f})".format(*after.forced)
    room = [*_type_lines(report), *_room_lines(after.room)]
    by, several = report.regions.arrays, report.regions.count > 1
    regions = [f"{report.regions.count:,} regions, by {shown(' and '.join(by))}"] * several
    lost = ["lost: " + ", ".join(report.lost)] * bool(report.lost)
    if report.after is None:
        return [angles, *room, *regions, *lost]
    change = report.after.n_points - report.before.n_points
    noun = "vertex" if abs(change) == 1 else "vertices"
    vertices = f"{abs(change):,} {noun} {'more' if change > 0 else 'less'}"
    times = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in report.seconds.items())
    return [
        f"stopped: {report.stopped}; {vertices if change else 'as many vertices as before'}",
        f"{angles}; {times}",
        *room,
        *regions,
        *lost,
    ]


def _type_lines(report: Report) -> list[str]:
    """The bad types that cells are of, of an optimization before and after."""
    summaries = [summary for _, summary in named_rows(report)]
    bad = []
    for name in summaries[0].types:
        counts = [summary.types.get(name, 0) for summary in summaries]
        if any(counts) and name != "regular":
            bad.append(f"{name} {' -> '.join(f'{n:,}' for n in counts)}")
    return ["types of cells: " + ", ".join(bad)] * bool(bad)


def _room_lines(room: Room | None) -> list[str]:
    """How many of the cells that something holds are as good as they may be, and who is not."""
    if room is None:
        return []
    lines = []
    if room.held:
        part = 100.0 * room.near / room.held
        lines = [
            f"{room.held:,} cells are held by facets, edges or vertices: {part:.1f} % of them are "
            "within 10 % of what these allow"
        ]
    if room.places:
        first = room.places[0]
        where = ", ".join(f"{x:.4g}" for x in first.where)
        lines.append(
            f"most room is left at ({where}): Q = {figure(first.worst)}, where "
            f"{figure(first.allowed)} is allowed"
        )
    return lines
