"""The report as one page of HTML that needs nothing else: no scripts, no requests; pictures are
in it.

Its characters are all of ASCII, so that it reads alike whatever it is taken for.
"""

from __future__ import annotations

from collections.abc import Callable

from . import sections
from .markup import paragraph, quality, table, text
from .model import Report
from .style import STYLE

# Nothing is loaded, whatever names in meshes may say.
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
    "form-action 'none'"
)
SECTIONS: dict[str, Callable[[Report], list[str]]] = {
    "Quality": sections.quality_section,
    "Pictures": sections.pictures_section,
    "Course of the run": sections.course_section,
    "Measures": sections.measures_section,
    "In the metric": sections.metric_section,
    "Worst cells": sections.worst_section,
    "Room": sections.room_section,
    "Types of cells": sections.types_section,
    "Angles": sections.angles_section,
    "Worst Q by measure": sections.by_measure_section,
    "Census": sections.census_section,
}


def to_html(reports: list[Report]) -> str:
    """One page for all reports, with an index where they are several."""
    several = len(reports) > 1
    title = f"Quality of {len(reports):,} meshes" if several else f"Quality of {reports[0].name}"
    version = " and ".join(dict.fromkeys(report.version for report in reports))
    commands = list(dict.fromkeys(report.command for report in reports if report.command))
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        f"<title>{text(title)}</title>",
        f"<style>\n{STYLE}\n</style>",
        "</head>",
        "<body>",
        f"<header>\n<h1>{text(title)}</h1>",
        *(_index(reports) if several else []),
        "</header>",
        "<main>",
    ]
    for number, report in enumerate(reports, 1):
        lines += _mesh(report, number, several)
    lines += ["</main>", "<footer>"]
    if commands:
        lines.append('<p class="faint">Made by</p>')
        lines += [f"<pre><code>{text(command)}</code></pre>" for command in commands]
    lines += [f'<p class="faint">meshopt {text(version)}</p>', "</footer>", "</body>", "</html>"]
    page = "\n".join(lines) + "\n"
    return page.encode("ascii", "xmlcharrefreplace").decode("ascii")


def _index(reports: list[Report]) -> list[str]:
    """A line a mesh, with a link to its part of the page."""
    rows = []
    for number, report in enumerate(reports, 1):
        one = report.after or report.before
        rows.append(
            [f'<a href="#mesh-{number}">{text(_path(report))}</a>', f"{one.n_cells:,}",
             f"{one.n_points:,}", quality(one.worst), quality(one.mean), f"{one.percent[0]:.1f} %"]
        )  # fmt: skip
    heads = ["mesh", "cells", "vertices", "worst Q", "mean Q", "Q up to 2"]
    return ['<nav aria-label="Meshes">', table("Meshes of this page", heads, rows), "</nav>"]


def _path(report: Report) -> str:
    """The file that the figures of the index are of."""
    facts = report.output if report.is_comparison and report.output else report.input
    return facts.path


def _mesh(report: Report, number: int, several: bool) -> list[str]:
    """All that is said of one mesh; its headings are one lower where there are several."""
    level = 3 if several else 2
    only = "" if several else ' class="only"'
    lines = [f'<article id="mesh-{number}"{only}>']
    if several:
        lines.append(f"<h2>{text(report.name)}</h2>")
    lines += [paragraph(report.title), *sections.head(report)]
    for title, section in SECTIONS.items():
        if content := section(report):
            lines += ["<section>", f"<h{level}>{title}</h{level}>", *content, "</section>"]
    lines += ["<section>", f"<h{level}>Files</h{level}>", *sections.files(report), "</section>"]
    return [*lines, "</article>"]
