"""The sections of a page on one mesh, each as lines of HTML; none where there is nothing to say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ..cells import FAMILIES, SIMPLICES
from ..quality.census import Degrees
from ..quality.summary import Summary
from ..quality.worst import WorstCell
from . import svg
from .markup import amount, drawing, paragraph, picture, quality, table, text
from .metric import LENGTH_HEADINGS, LENGTH_RANK_HEADINGS, length_rows, metric_lines, metrics
from .model import Picture, Pictures, Report
from .rows import (
    HEADINGS,
    MEASURE_HEADINGS,
    count_row,
    grouped_rows,
    measure_rows,
    named_rows,
    pass_rows,
    percent_row,
    states,
)

ARROW = " \u2192 "
MOST_OFF = 3  # by how much a degree is off its target at most that has a column of its own
DEGREES_OF = {
    "inner_vertices": "inner vertices",
    "boundary_vertices": "boundary vertices",
    "inner_edges": "inner edges",
}


def _course(values: Sequence[str]) -> str:
    """What a figure was and what it is; once where it stays."""
    return ARROW.join(f"<span>{text(value)}</span>" for value in dict.fromkeys(values))


def head(report: Report) -> list[str]:
    """The figures that matter most, and what there is to heed."""
    ones = [summary for _, summary in states(report)]
    angle = "dihedral angles" if ones[-1].dimension == 3 else "angles"
    ranges = [f"{s.angle_min:.1f}\u2013{s.angle_max:.1f}\u00b0" for s in ones]
    tiles = {
        "worst Q": [quality(s.worst) for s in ones],
        "mean Q": [quality(s.mean) for s in ones],
        "cells with Q up to 2": [f"{s.percent[0]:.1f} %" for s in ones],
        angle: ranges,
        "cells": [f"{s.n_cells:,}" for s in ones],
    }
    if any(s.n_invalid for s in ones):
        tiles["flat or inverted cells"] = [f"{s.n_invalid:,}" for s in ones]
    lines = ['<dl class="tiles">']
    for name, values in tiles.items():
        lines.append(f"<div><dt>{text(name)}</dt><dd>{_course(values)}</dd></div>")
    lines.append("</dl>")
    notes = [*report.notes, *(f"lost: {what}" for what in report.lost)]
    if report.left_out:
        passes = ", ".join(report.left_out)
        notes.append(f"left out: {passes}, for the connectivity of these cells stays")
    if notes:
        lines += ['<ul class="notes">', *(f"<li>{text(note)}</li>" for note in notes), "</ul>"]
    return lines


def files(report: Report) -> list[str]:
    """Where the mesh came from and where it went, and its regions."""
    names = ("before", "after") if report.is_comparison else ("input", "output")
    rows = [
        [name, f"<code>{text(facts.path)}</code>", text(facts.format),
         f"<code>{text(facts.sha256)}</code>"]
        for name, facts in zip(names, (report.input, report.output), strict=True)
        if facts is not None
    ]  # fmt: skip
    lines = [table("Files", ["", "path", "format", "SHA-256"], rows, words=(2, 3), long=1)]
    if report.regions.count > 1:
        arrays = " and ".join(report.regions.arrays)
        lines.append(paragraph(f"{report.regions.count:,} regions, by {arrays}."))
    return lines


def quality_section(report: Report) -> list[str]:
    """Table 18.3 and its bars."""
    cells = []
    for name, summary in named_rows(report):
        percents, counts = percent_row(summary), count_row(summary)
        ranks = len(summary.counts)
        pairs = zip(percents[:ranks], counts, strict=False)
        cells.append(
            [text(name), *(f"{text(p)} %<small>{text(c)}</small>" for p, c in pairs),
             quality(summary.target), quality(summary.worst), *map(text, percents[ranks + 2 :])]
        )  # fmt: skip
    lines = [
        table("Percentage and number of cells in each rank of Q (Table 18.3)", ["", *HEADINGS],
              cells),
        '<div class="drawings">',
    ]  # fmt: skip
    for family, rows in grouped_rows(report):
        of = FAMILIES[family].plural if family else "all cells"
        bars = svg.ranks(HEADINGS[:4], [(name, summary.counts) for name, summary in rows])
        lines.append(drawing(bars, f"Percentage of {of} in each rank of Q"))
    return [
        *lines, "</div>",
        '<p class="faint">Q is 1 for the ideal cell and infinite for one that is flat or inverted; '
        "target is the best Q that the worst facet of the boundary allows, Q_T the worst there is, "
        "ne and np count cells and vertices.</p>",
    ]  # fmt: skip


def pictures_section(report: Report) -> list[str]:
    """The mesh, or before and after, coloured by Q (Figure 18.14)."""
    found = report.pictures
    if found is None:
        return []
    if not found.wholes:
        return [paragraph(f"There are none: {found.missing}.")]
    return [
        '<div class="pictures">', *(picture(one) for one in _named(report, found)), "</div>",
        f'<figure class="legend">\n{svg.legend(found)}\n</figure>',
    ]  # fmt: skip


def _named(report: Report, found: Pictures) -> list[Picture]:
    """The pictures of whole meshes; before and after, that is said."""
    if report.after is None:
        return list(found.wholes)
    names = [name for name, _ in states(report)]
    each = max(len(found.wholes) // len(names), 1)
    return [
        replace(one, words=f"{names[i // each]}: {one.words}") for i, one in enumerate(found.wholes)
    ]


def course_section(report: Report) -> list[str]:
    """What the passes did, and why they stopped."""
    if report.after is None or report.is_comparison:
        return []
    change = report.after.n_points - report.before.n_points
    noun = "vertex" if abs(change) == 1 else "vertices"
    vertices = f"{abs(change):,} {noun} {'more' if change > 0 else 'less'}"
    vertices = vertices if change else "as many vertices as before"
    times = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in report.seconds.items())
    lines = [
        paragraph(f"Stopped: {report.stopped}; {vertices}."),
        *([paragraph(f"Times: {times}.")] if times else []),
    ]
    if not report.passes:
        return lines
    words = "Worst Q (above, by its logarithm) and mean Q (below) after each run of a pass"
    lines.append(drawing(svg.course(report.before, report.passes), words))
    heads = ["pass", "runs", "tried", "applied", "refused", "s", "Q_T"]
    lines.append(table("Passes", heads, _passes(report, False), long=4))
    if len(report.passes) > 1:
        heads = ["pass", "round", "tried", "applied", "refused", "s", "Q_T", "mean Q"]
        each = zip(_passes(report, True), report.passes, strict=True)
        rows = [[*row, quality(p.mean)] for row, p in each]
        lines += ["<details>", "<summary>Each run of each pass</summary>"]
        lines += [table("Runs of passes", heads, rows, long=4), "</details>"]
    return lines


def _passes(report: Report, each_round: bool) -> list[list[str]]:
    last = {p.name: p.worst for p in report.passes}
    worst = [p.worst for p in report.passes] if each_round else list(last.values())
    rows = pass_rows(report, each_round)
    return [[*map(text, row[:-1]), quality(q)] for row, q in zip(rows, worst, strict=True)]


def measures_section(report: Report) -> list[str]:
    """What measures say that were asked for, with their histograms."""
    found = measure_rows(report)
    if not found:
        return []
    rows = []
    for s, row in found:
        figures = [amount(s.least), amount(s.mean), amount(s.greatest)]
        rows.append([*map(text, row[:2]), *figures, *map(text, row[5:])])
    lines = [table("Measures of all cells", MEASURE_HEADINGS, rows, words=(1, 6))]
    drawn = [(s, row[1]) for s, row in found if s.histogram is not None]
    if drawn:
        lines.append('<div class="drawings">')
        for s, of_which in drawn:
            of = f"{s.measure} of {of_which}: {svg.histogram_words(s)}"
            ideal = "" if s.ideal is None else f"; ideal {s.ideal:g}"
            lines.append(drawing(svg.histogram(s), of + ideal))
        lines.append("</div>")
    return lines


def metric_section(report: Report) -> list[str]:
    """Lengths and Q in a metric, and how far cells are off unit ones."""
    lines = []
    for name, metric in metrics(report):
        when = f" {name}" if name else ""
        rows = [[text(cell) for cell in row] for row in length_rows(metric)]
        lengths = [("all edges", metric.edges.counts), ("inner edges", metric.inner.counts)]
        edges = svg.ranks(LENGTH_RANK_HEADINGS, lengths, "edges of length")
        cells = svg.ranks(HEADINGS[:4], [(name or "mesh", metric.counts)])
        lines += [
            table(f"Lengths of edges in the metric{when}", LENGTH_HEADINGS, rows),
            "<ul>", *(f"<li>{text(line)}</li>" for line in metric_lines(metric)), "</ul>",
            '<div class="drawings">',
            drawing(edges, f"Percentage of edges in each rank of length{when}; 1 is ideal"),
            drawing(cells, f"Percentage of cells in each rank of Q in the metric{when}"),
            "</div>",
        ]  # fmt: skip
    return lines


def worst_section(report: Report) -> list[str]:
    """The worst cells one by one."""
    lines = []
    for name, summary in reversed(states(report)):
        if summary.worst_cells:
            several = len({one.family for one in summary.worst_cells}) > 1 or summary.parts
            caption = "The worst cells" if report.after is None else f"The worst cells {name}"
            heads = ["cell", "Q", *(["of"] if several else []), "type", "centre"]
            rows = [_worst(one, bool(several)) for one in summary.worst_cells]
            lines.append(table(caption, heads, rows, words=(2, 3, 4)))
    if not lines:
        return []
    lines = ['<div class="drawings">', *lines, "</div>"]
    if report.pictures is not None:
        pairs = zip(states(report), report.pictures.worst, strict=False)
        for (name, _), some in reversed([pair for pair in pairs if pair[1]]):
            when = "" if report.after is None else f" {name}"
            lines.append(paragraph(f"The worst cells{when}, each with those around it:"))
            lines += ['<div class="cells">', *(picture(one, "cell") for one in some), "</div>"]
    return lines


def _worst(one: WorstCell, several: bool) -> list[str]:
    plain = FAMILIES[one.family].name
    name = one.cell or f"{plain} {one.number + 1}"
    kind = [text(FAMILIES[one.family].plural)] if several else []
    return [text(name), quality(one.quality), *kind, text(one.type) or "\u2013", _place(one.where)]


def _place(where: tuple[float, ...]) -> str:
    return f"({', '.join(amount(x) for x in where)})"


def room_section(report: Report) -> list[str]:
    """What the boundary allows, and where there is most to gain."""
    room = (report.after or report.before).room
    if room is None:
        return []
    lines = []
    if room.held:
        part = 100.0 * room.near / room.held
        lines.append(
            paragraph(
                f"{room.held:,} cells are held by facets, edges or vertices: {part:.1f} % of them "
                "are within 10 % of what these allow."
            )
        )
    if room.places:
        rows = [[_place(p.where), quality(p.worst), quality(p.allowed)] for p in room.places]
        lines.append(table("Places with most to gain", ["centre", "Q", "Q allowed"], rows))
    return lines


def types_section(report: Report) -> list[str]:
    """Cells of each type, and quads by their cases."""
    ones = states(report)
    kinds = [s.types | (s.census.quads if s.census else {}) for _, s in ones]
    rows = [
        [text(name), *(f"{kind.get(name, 0):,}" for kind in kinds)]
        for name in dict.fromkeys(name for kind in kinds for name in kind)
        if any(kind.get(name, 0) for kind in kinds)
    ]
    return [table("Number of cells of each type", ["type", *_names(ones)], rows)] if rows else []


def _names(ones: list[tuple[str, Summary]]) -> list[str]:
    return ["cells"] if len(ones) == 1 else [name for name, _ in ones]


def angles_section(report: Report) -> list[str]:
    """The range of angles, and what the boundary forces."""
    kind = "Dihedral angles" if report.before.dimension == 3 else "Angles"
    rows = [[text(name), *_angles(s.angle_min, s.angle_max)] for name, s in states(report)]
    forced = (report.after or report.before).forced
    if forced is not None and report.before.dimension == 3:
        rows.append(["forced by the boundary", *_angles(*forced)])
    return [table(f"{kind} in degrees", ["", "least", "greatest"], rows)]


def _angles(*angles: float) -> list[str]:
    return [f"{angle:.1f}" if math.isfinite(angle) else amount(angle) for angle in angles]


def by_measure_section(report: Report) -> list[str]:
    """The worst Q by every measure."""
    ones = states(report)
    rows = [
        [text(name), *(quality(s.worst_by_measure.get(name, math.nan)) for _, s in ones)]
        for name in dict.fromkeys(name for _, s in ones for name in s.worst_by_measure)
    ]
    heads = ["measure", *(["worst Q"] if len(ones) == 1 else _names(ones))]
    return [table("Worst Q by every measure", heads, rows)] if rows else []


def census_section(report: Report) -> list[str]:
    """Obtuse cells, what the boundary constrains, and degrees beside their targets."""
    ones = [(name, s) for name, s in states(report) if s.census is not None]
    found = [s.census for _, s in ones if s.census is not None]
    if not found:
        return []
    counts: dict[str, list[int]] = {}
    if found[-1].n_simplices:
        kind = FAMILIES[SIMPLICES[ones[-1][1].dimension]].plural
        counts[kind] = [c.n_simplices for c in found]
        counts[f"{kind} that are obtuse"] = [c.obtuse for c in found]
        counts[f"{kind} that contain their circumcentre"] = [c.self_centered for c in found]
    counts["over-constrained cells"] = [c.constrained_cells for c in found]
    counts["over-constrained inner edges"] = [c.constrained_edges for c in found]
    if ones[-1][1].dimension == 3:
        counts["over-constrained inner faces"] = [c.constrained_faces for c in found]
    rows = [[text(name), *(f"{n:,}" for n in of)] for name, of in counts.items()]
    lines = [table("Obtuse cells, and what the boundary constrains", ["", *_names(ones)], rows)]
    off = [
        [text(what if len(ones) == 1 else f"{what} {name}"), *_excess(getattr(s.census, key))]
        for key, what in DEGREES_OF.items()
        for name, s in ones
        if getattr(s.census, key).total
    ]
    if off:
        within = range(1 - MOST_OFF, MOST_OFF)
        columns = [f"{n:+d}" if n else "on target" for n in within]
        heads = ["", f"-{MOST_OFF} or less", *columns, f"+{MOST_OFF} or more"]
        lines.append(table("Entities by how much their degree is off its target", heads, off))
    return lines


def _excess(degrees: Degrees) -> list[str]:
    """How many entities are off their target by each number, what is beyond at the ends."""
    row = [0] * (2 * MOST_OFF + 1)
    for off, n in degrees.excess.items():
        row[max(-MOST_OFF, min(MOST_OFF, off)) + MOST_OFF] += n
    return [f"{n:,}" for n in row]
