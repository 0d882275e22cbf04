"""The rows of Table 18.3 as strings, for every output that shows a table."""

from __future__ import annotations

import math
from itertools import pairwise

from ..cells import FAMILIES, SIMPLICES
from ..errors import shown
from ..quality.room import Room
from ..quality.statistics import Statistic
from ..quality.summary import RANKS, Summary
from .model import Report

GOOD_TYPES = ("regular", "positive")

HEADINGS = (
    *(f"> {low:g}" if math.isinf(high) else f"{low:g} - {high:g}" for low, high in pairwise(RANKS)),
    "target",
    "Q_T",
    "ne",
    "np",
)


def figure(value: float) -> str:
    """Q in four digits: 1.87, 531.1, 2.56e+06; - for one that is not defined."""
    if math.isnan(value):
        return "-"
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


def states(report: Report) -> list[tuple[str, Summary]]:
    """The mesh, or before and after, with the names of their rows and columns."""
    if report.after is None:
        return [("mesh", report.before)]
    return [("before", report.before), ("after", report.after)]


def grouped_rows(report: Report) -> list[tuple[str, list[tuple[str, Summary]]]]:
    """The meshes of a report, of several families each and then all, with the names of their rows.

    Returns
    -------
    list of (str, rows)
        The rows of each family by its name, those of all cells by an empty one.
    """
    ones = states(report)
    by_family = [{p.family: p for p in one.parts or (one,)} for _, one in ones]
    families = list(dict.fromkeys(family for parts in by_family for family in parts))
    if not any(one.parts for _, one in ones) and len(families) == 1:
        return [(families[0], ones)]
    groups = []
    for family in families:
        kind = FAMILIES[family].plural
        some = zip(ones, by_family, strict=True)
        rows = [
            (f"{kind} {name}" if len(ones) > 1 else kind, parts[family])
            for (name, _), parts in some
            if family in parts
        ]
        groups.append((family, rows))
    whole = [(f"all {name}" if len(ones) > 1 else "all", one) for name, one in ones]
    return [*groups, ("", whole)]


def named_rows(report: Report) -> list[tuple[str, Summary]]:
    """The same without their groups."""
    return [row for _, rows in grouped_rows(report) for row in rows]


MEASURE_HEADINGS = ("measure", "of", "least", "mean", "greatest", "ideal", "unit", "infinite")


def measure_rows(report: Report) -> list[tuple[Statistic, list[str]]]:
    """What the measures say that were asked for, a row a measure and family; of two meshes that
    are compared a row each."""
    two = report.is_comparison
    rows = [(s, " before" if two else "") for s in report.statistics]
    rows += [(s, " after") for s in report.statistics_after]
    order = {s.measure: i for i, (s, _) in reversed(list(enumerate(rows)))}
    rows.sort(key=lambda row: order[row[0].measure])
    return [
        (s, [s.measure, f"{FAMILIES[s.family].plural}{when}", value(s.least), value(s.mean),
             value(s.greatest), "" if s.ideal is None else f"{s.ideal:g}",
             "" if s.unit == "1" else s.unit, f"{s.n_infinite:,}" if s.n_infinite else ""])
        for s, when in rows
    ]  # fmt: skip


def value(number: float) -> str:
    """A value of a measure in four digits; - for one that is not defined."""
    return "-" if math.isnan(number) else f"{number:.4g}"


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
    room = [*_type_lines(report), *_census_lines(report), *_room_lines(after.room)]
    by, several = report.regions.arrays, report.regions.count > 1
    regions = [f"{report.regions.count:,} regions, by {shown(' and '.join(by))}"] * several
    lost = ["lost: " + ", ".join(report.lost)] * bool(report.lost)
    if report.left_out:
        passes = ", ".join(report.left_out)
        lost.append(f"left out: {passes}, for the connectivity of these cells stays")
    if report.after is None:
        return [angles, *room, *regions, *lost]
    change = report.after.n_points - report.before.n_points
    noun = "vertex" if abs(change) == 1 else "vertices"
    vertices = f"{abs(change):,} {noun} {'more' if change > 0 else 'less'}"
    said = vertices if change else "as many vertices as before"
    times = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in report.seconds.items())
    told = [f"stopped: {report.stopped}; {said}", f"{angles}; {times}"]
    return [
        *([said, angles] if report.is_comparison else told),
        *room,
        *regions,
        *lost,
    ]


def _type_lines(report: Report) -> list[str]:
    """The bad types that cells are of, of an optimization before and after."""
    summaries = [report.before] if report.after is None else [report.before, report.after]
    kinds = [s.types | (s.census.quads if s.census else {}) for s in summaries]
    bad = []
    for name in dict.fromkeys(name for kind in kinds for name in kind):
        counts = [kind.get(name, 0) for kind in kinds]
        if any(counts) and name not in GOOD_TYPES:
            bad.append(f"{name} {_course(counts)}")
    return ["types of cells: " + ", ".join(bad)] * bool(bad)


def _course(counts: list[int]) -> str:
    """A count, or what it was and what it is."""
    return " -> ".join(f"{n:,}" for n in counts)


def _census_lines(report: Report) -> list[str]:
    """Obtuse cells, what the boundary constrains, and degrees beside their targets."""
    summaries = [report.before] if report.after is None else [report.before, report.after]
    found = [summary.census for summary in summaries if summary.census is not None]
    if not found:
        return []
    lines = []
    if found[-1].n_simplices:
        kind = FAMILIES[SIMPLICES[summaries[-1].dimension]].plural
        lines.append(
            f"{kind} that are obtuse: {_course([c.obtuse for c in found])}, self-centered: "
            f"{_course([c.self_centered for c in found])}, of {found[-1].n_simplices:,}"
        )
    constrained = [
        f"{name} {_course(counts)}"
        for name, counts in (
            ("cells", [c.constrained_cells for c in found]),
            ("inner edges", [c.constrained_edges for c in found]),
            ("inner faces", [c.constrained_faces for c in found]),
        )
        if any(counts)
    ]
    if constrained:
        lines.append("over-constrained by the boundary: " + ", ".join(constrained))
    degrees = []
    for name in ("inner_vertices", "boundary_vertices", "inner_edges"):
        of = [getattr(census, name) for census in found]
        off = [degree.under + degree.over for degree in of]
        if any(off):
            where = name.replace("_", " ")
            degrees.append(f"{where} {_course(off)} of {of[-1].total:,}")
    if degrees:
        lines.append("degree off its target: " + ", ".join(degrees))
    return lines


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
