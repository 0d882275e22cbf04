"""Figures, rows and the files that reports are written as."""

import csv
import io
import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import patches
import pytest
from builders import mesh, tet_grid, tri_grid
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from meshopt_cli.cli import output, terminal
from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality.summary import (
    MEASURES,
    RANKS,
    Summary,
    forced_angles,
    histogram,
    measure_named,
    summarize,
)
from meshopt_cli.report.csv import to_csv
from meshopt_cli.report.json import to_json
from meshopt_cli.report.markdown import to_markdown
from meshopt_cli.report.model import FileFacts, PassFacts, Report
from meshopt_cli.report.rows import (
    HEADINGS,
    closing_lines,
    count_row,
    figure,
    named_rows,
    pass_rows,
    percent_row,
)
from meshopt_cli.report.table import BAR_WIDTH, BLOCKS, PLAIN_BLOCKS, bar

INFINITE = math.inf


def summary(counts=(60, 30, 10, 0), worst=7.5, **changes):
    """Figures of a mesh that does not exist."""
    values = {
        "measure": "aspect-ratio",
        "dimension": 3,
        "n_cells": sum(counts),
        "n_points": sum(counts) // 4 + 1,
        "counts": tuple(counts),
        "n_invalid": 0,
        "worst": worst,
        "mean": 1.5,
        "best": 1.01,
        "target": 1.45,
        "angle_min": 10.0,
        "angle_max": 160.0,
        "worst_by_measure": {"edge-ratio": 3.5, "mean-edge": INFINITE},
    }
    return Summary(**{**values, **changes})


def ran(round, name, visited=10, applied=4, **changes):
    """What a pass is said to have done; the rest was refused."""
    refused = {"not-better": visited - applied} if visited > applied else {}
    return PassFacts(round, name, visited, applied, refused, 0.25, 7.5, 1.5, **changes)


def report(before=None, after=None, path="in/some.mesh", passes=(), **changes):
    """A report on one mesh, or on a run when there is a mesh after it."""
    values = {"input": FileFacts(path, "medit", "0" * 64), "before": before or summary()}
    if after is not None:
        values |= {
            "output": FileFacts("out.mesh", "medit", "1" * 64),
            "after": after,
            "stopped": "no change",
            "seconds": {"read": 0.1, "optimize": 2.0, "write": 0.01},
        }
    return Report(version="0", **{**values, "passes": tuple(passes), **changes})


ROUNDS = [ran(0, "check", 0, 0), ran(1, "smooth"), ran(1, "swap", 2000, 1000), ran(2, "smooth", 5)]
OF_A_MESH = report()
OF_A_RUN = report(after=summary((99, 1, 0, 0), worst=2.25), passes=ROUNDS)
both_kinds = pytest.mark.parametrize("one", [OF_A_MESH, OF_A_RUN], ids=["mesh", "run"])

qualities = st.floats(1.0, 1e300) | st.just(INFINITE)
ranks = st.lists(st.integers(0, 10**7), min_size=4, max_size=4).filter(sum)
summaries = st.builds(
    summary,
    ranks,
    qualities,
    mean=qualities,
    best=qualities,
    target=qualities,
    angle_min=st.floats(0, 60),
    angle_max=st.floats(60, 180),
    dimension=st.sampled_from([2, 3]),
    measure=st.sampled_from(list(MEASURES)),
    worst_by_measure=st.dictionaries(st.sampled_from(list(MEASURES)), qualities),
)
reports = st.builds(report, summaries) | st.builds(report, summaries, summaries)


# Figures ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.0, "1.00"),
        (1.8666, "1.87"),
        (12.345, "12.35"),
        (531.123, "531.1"),
        (2_560_000.0, "2.56e+06"),
        (INFINITE, "inf"),
    ],
)
def test_examples_of_figures(value, text):
    assert figure(value) == text


@settings(deadline=None)
@given(st.floats(1.0, 1e300))
def test_a_figure_says_the_value_to_half_a_percent(value):
    assert float(figure(value)) == pytest.approx(value, rel=6e-3)
    assert len(figure(value)) <= len("1.23e+100")


@settings(deadline=None)
@given(qualities, qualities)
def test_figures_keep_their_order(one, other):
    low, high = sorted([one, other])
    assert float(figure(low)) <= float(figure(high))


# The ranks of Table 18.3 ------------------------------------------------------------------


def test_the_upper_end_belongs_to_a_rank():
    for k, (low, high) in enumerate(pairwise(RANKS)):
        own = [0] * (len(RANKS) - 1)
        own[k] = 1
        assert histogram(np.array([np.nextafter(low, INFINITE)])) == tuple(own)
        assert histogram(np.array([high])) == tuple(own)


def test_a_regular_cell_is_in_the_first_rank_whatever_its_rounding():
    values = np.array([1.0 - 1e-15, 1.0, 1.0 + 1e-15])
    assert histogram(values) == (3, 0, 0, 0)


@settings(deadline=None)
@given(st.lists(st.floats(1.0, 20.0) | st.sampled_from(RANKS), max_size=50))
def test_every_cell_is_in_the_rank_of_its_quality(values):
    counts = histogram(np.array(values, dtype=float))
    assert len(counts) == len(RANKS) - 1
    assert sum(counts) == len(values)
    for k, high in enumerate(RANKS[1:]):
        assert sum(counts[: k + 1]) == sum(value <= high for value in values)


@settings(deadline=None)
@given(ranks)
def test_percentages_sum_to_a_hundred(counts):
    one = summary(counts)
    assert sum(one.percent) == pytest.approx(100.0, abs=1e-9)
    shown = [float(cell) for cell in percent_row(one)[: len(counts)]]
    assert sum(shown) == pytest.approx(100.0, abs=0.21)


def test_headings_are_those_of_the_table():
    assert HEADINGS == ("1 - 2", "2 - 3", "3 - 10", "> 10", "target", "Q_T", "ne", "np")


@settings(deadline=None)
@given(summaries)
def test_rows_are_as_long_as_the_headings(one):
    assert len(percent_row(one)) == len(count_row(one)) == len(HEADINGS)
    numbers = [int(cell.replace(",", "")) for cell in count_row(one) if cell]
    assert numbers == list(one.counts)
    n_cells, n_points = (int(cell.replace(",", "")) for cell in percent_row(one)[-2:])
    assert (n_cells, n_points) == (one.n_cells, one.n_points)


# Figures of real meshes ---------------------------------------------------------------------


@pytest.mark.parametrize("grid", [tri_grid(3), tet_grid(2)], ids=["triangles", "tetrahedra"])
@pytest.mark.parametrize("name", MEASURES)
def test_a_summary_agrees_with_itself(grid, name):
    simplices = cast(grid)
    one = summarize(simplices, measure_named(name), tuple(MEASURES.values()))
    assert sum(one.counts) == one.n_cells == len(simplices.cells)
    assert one.n_points == len(simplices.points)
    assert 1.0 - 1e-9 <= one.best <= one.mean * (1 + 1e-9) <= one.worst * (1 + 2e-9)
    assert one.worst_by_measure[name] == one.worst
    assert set(one.worst_by_measure) == set(MEASURES)
    assert 1.0 - 1e-9 <= one.target <= one.worst * (1 + 1e-9)
    assert 0 < one.angle_min <= one.angle_max < 180
    assert one.n_invalid == 0


def test_flat_and_inverted_cells_are_counted_and_infinite():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 0], [0, 0, -1]]
    good, flat, inverted = [0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]
    one = summarize(cast(mesh(points, tetra=[good, flat, inverted])), MEASURES["aspect-ratio"])
    assert one.n_invalid == 2
    assert one.worst == INFINITE
    assert one.counts[-1] == 2
    assert one.mean == pytest.approx(one.best)
    assert "NaN" not in to_json([report(one)])


# Text around the table ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("dimension", "kind", "equation"), [(2, "triangles", "(18.6)"), (3, "tetrahedra", "(18.7)")]
)
def test_the_title_says_what_the_mesh_is(dimension, kind, equation):
    one = report(summary((1000, 200, 34, 0), dimension=dimension, n_points=5678))
    assert one.title == f"some.mesh: 1,234 {kind}, 5,678 vertices, aspect ratio {equation}"


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        (100, 100, "as many vertices as before"),
        (5000, 1000, "4,000 vertices less"),
        (1000, 5000, "4,000 vertices more"),
        (100, 99, "1 vertex less"),
        (99, 100, "1 vertex more"),
    ],
)
def test_the_last_lines_say_how_many_vertices_came_or_went(before, after, said):
    one = report(summary(n_points=before), summary(n_points=after))
    assert said in "\n".join(closing_lines(one))


def test_the_last_lines_of_a_mesh_speak_of_no_run():
    text = "\n".join(closing_lines(OF_A_MESH))
    assert "stopped" not in text
    assert "vert" not in text
    assert "dihedral angles 10.0 to 160.0" in text
    assert "dihedral" not in "\n".join(closing_lines(report(summary(dimension=2))))


def test_the_last_lines_of_a_run_say_why_it_stopped_and_how_long_it_took():
    text = "\n".join(closing_lines(OF_A_RUN))
    assert "stopped: no change" in text
    assert "read 0.10 s, optimize 2.00 s, write 0.01 s" in text


def test_passes_are_summed_or_told_one_by_one():
    each = pass_rows(OF_A_RUN, each_round=True)
    assert [row[0] for row in each] == ["check", "smooth", "swap", "smooth"]
    assert [row[1] for row in each] == ["0", "1", "1", "2"]
    summed = {row[0]: row for row in pass_rows(OF_A_RUN, each_round=False)}
    assert list(summed) == ["check", "smooth", "swap"]
    assert summed["smooth"][1:4] == ["2", "15", "8"]
    assert summed["swap"][2:4] == ["2,000", "1,000"]
    assert summed["smooth"][4] == "not-better 7"
    assert summed["smooth"][5] == "0.50"


# JSON ---------------------------------------------------------------------------------------


def strict(text):
    """Read JSON as the standard has it, without NaN and Infinity."""

    def refuse(constant):
        raise ValueError(constant)

    return json.loads(text, parse_constant=refuse)


@settings(deadline=None)
@given(reports)
def test_json_is_json(one):
    value = strict(to_json([one]))
    assert value["before"]["histogram"]["counts"] == list(one.before.counts)
    assert value["before"]["ne"] == one.before.n_cells
    worst = value["before"]["worst"]
    assert worst == one.before.worst if math.isfinite(one.before.worst) else worst is None
    assert (value["after"] is None) == (one.after is None)


def test_json_of_passes_without_figures():
    worst = ran(1, "smooth")
    one = report(after=summary(), passes=[replace(worst, worst=INFINITE, mean=INFINITE)])
    (shown,) = strict(to_json([one]))["passes"]
    assert (shown["worst"], shown["mean"]) == (None, None)
    assert shown["refused"] == {"not-better": 6}


def test_one_report_is_an_object_and_several_are_a_list():
    assert isinstance(strict(to_json([OF_A_RUN])), dict)
    values = strict(to_json([OF_A_RUN, OF_A_MESH]))
    assert [value["stopped"] for value in values] == ["no change", None]


# CSV ----------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.lists(reports, min_size=1, max_size=4), st.text(st.characters(codec="utf-8")))
def test_csv_reads_back(ones, name):
    assume("\0" not in name and "\r" not in name)
    ones = [replace(one, input=FileFacts(name, "vtu", "")) for one in ones]
    rows = list(csv.DictReader(io.StringIO(to_csv(ones), newline="")))
    expected = [(name, label, s) for one in ones for label, s in named_rows(one)]
    assert len(rows) == len(expected)
    for row, (path, label, s) in zip(rows, expected, strict=True):
        assert None not in row
        assert None not in row.values()
        assert (row["file"], row["mesh"]) == (path, label)
        assert [int(row[heading]) for heading in HEADINGS[:4]] == list(s.counts)
        assert float(row["Q_T"]) == s.worst
        assert float(row["target"]) == s.target
        assert (int(row["ne"]), int(row["np"])) == (s.n_cells, s.n_points)
        assert float(row["angle_max"]) == s.angle_max


# Markdown -----------------------------------------------------------------------------------


def tables(text):
    """The tables of a Markdown text, each a list of rows of cells."""
    found, current = [], []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            current.append([cell.strip() for cell in line.strip("|").split("|")])
        elif current:
            found.append(current)
            current = []
    return found


@settings(deadline=None)
@given(st.lists(reports, min_size=1, max_size=3))
def test_markdown_tables_read_back(ones):
    text = to_markdown(ones)
    assert re.findall(r"^### (.*)$", text, re.M) == [one.title for one in ones]
    for one, table in zip(ones, tables(text), strict=True):
        head, line, *rows = table
        assert head == ["", *HEADINGS]
        assert all(re.fullmatch("-+:?", cell) for cell in line)
        assert {len(row) for row in table} == {len(HEADINGS) + 1}
        for (name, s), percent, counts in zip(named_rows(one), rows[::2], rows[1::2], strict=True):
            assert percent == [name, *percent_row(s)]
            assert counts == ["", *count_row(s)]


def test_markdown_has_the_passes_of_a_run():
    quality, passes = tables(to_markdown([OF_A_RUN]))
    assert [row[0] for row in quality[2:]] == ["before", "", "after", ""]
    assert passes[2:] == pass_rows(OF_A_RUN, each_round=False)
    assert all(line in to_markdown([OF_A_RUN]) for line in closing_lines(OF_A_RUN))


# The table ----------------------------------------------------------------------------------


@both_kinds
def test_the_table_has_the_rows_of_the_report(one):
    lines = [line.split() for line in output.as_text([one], "table").splitlines()]
    assert [word for heading in HEADINGS for word in heading.split()] in lines
    for name, s in named_rows(one):
        assert [name, *percent_row(s)] in lines
        assert [cell for cell in count_row(s) if cell] in lines
    for row in pass_rows(one, each_round=False):
        assert [word for cell in row for word in cell.split()] in lines


@both_kinds
def test_the_first_and_the_last_lines_are_not_broken(one):
    lines = output.as_text([one], "table").splitlines()
    last = closing_lines(one)
    assert lines[0] == one.title
    assert lines[-len(last) :] == last


def test_a_long_run_does_not_break_the_last_lines():
    """As wide as it gets: ten million vertices, a day of work."""
    seconds = {"read": 12345.67, "optimize": 123456.78, "write": 12345.67}
    before, after = summary(n_points=10**7), summary(n_points=10**6)
    one = report(before, after, seconds=seconds, stopped="target quality")
    assert output.as_text([one], "table").splitlines()[-2:] == closing_lines(one)


def test_each_round_is_shown_when_asked():
    short, long = (output.as_text([OF_A_RUN], "table", verbosity) for verbosity in (0, 1))
    assert len(re.findall("^smooth ", short, re.M)) == 1
    assert len(re.findall("^smooth ", long, re.M)) == 2


@settings(deadline=None)
@given(ranks)
def test_the_bar_shows_every_rank_that_has_cells(counts):
    for plain, blocks in ((True, PLAIN_BLOCKS), (False, BLOCKS)):
        drawn = bar(summary(counts), plain).plain
        assert drawn == "".join(sorted(drawn, key=blocks.index))
        assert [block in drawn for block in blocks] == [count > 0 for count in counts]
        assert abs(len(drawn) - BAR_WIDTH) <= len(blocks)


@pytest.mark.parametrize(
    ("encoding", "term", "plain"),
    [
        ("utf-8", "xterm", False),
        ("UTF-8", "xterm", False),
        ("ascii", "xterm", True),
        ("ANSI_X3.4-1968", "xterm", True),
        ("cp1252", "xterm", True),
        (None, "xterm", True),
        ("utf-8", "dumb", True),
    ],
)
def test_blocks_are_for_terminals_that_have_them(monkeypatch, encoding, term, plain):
    monkeypatch.setenv("TERM", term)
    monkeypatch.setattr(terminal, "sys", SimpleNamespace(stdout=SimpleNamespace(encoding=encoding)))
    assert terminal.is_plain() is plain


@both_kinds
@pytest.mark.parametrize(("encoding", "blocks"), [("ascii", PLAIN_BLOCKS), ("utf-8", BLOCKS)])
def test_the_table_is_ascii_where_the_terminal_is(monkeypatch, one, encoding, blocks):
    monkeypatch.delenv("TERM", raising=False)
    stdout = io.TextIOWrapper(io.BytesIO(), encoding, write_through=True)
    monkeypatch.setattr("sys.stdout", stdout)
    output.print_report([one], "table")
    text = stdout.buffer.getvalue().decode(encoding)
    assert blocks[0] * 10 in text
    assert text.isascii() == (encoding == "ascii")


def test_every_form_is_reached_by_a_suffix(tmp_path):
    for suffix, form in output.SUFFIXES.items():
        path = tmp_path / f"r{suffix.upper()}"
        assert output.form_of(path) == form
        output.write_reports((path,), [OF_A_RUN])
        assert path.read_text(encoding="utf-8") == output.as_text([OF_A_RUN], form)
        assert path.read_bytes().endswith(b"\n")


# What the boundary forces -----------------------------------------------------------------


def test_a_regular_tet_is_as_its_boundary_forces_it():
    corners = [[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]]
    regular = math.degrees(math.acos(1 / 3))
    forced = forced_angles(cast(mesh(corners, tetra=[[0, 1, 2, 3]])))
    assert forced == pytest.approx((regular, regular), abs=0.05)


@pytest.mark.parametrize("opening", [10.0, 25.0, 40.0])
def test_a_sharp_edge_forces_its_angle(opening):
    """No tet at the edge of a wedge has a greater angle there than the wedge."""
    turned = math.radians(opening)
    points = [[0, 0, 0], [0, 0, 1], [1, 0, 0.5], [math.cos(turned), math.sin(turned), 0.5]]
    least, _ = forced_angles(cast(mesh(points, tetra=[[0, 1, 2, 3]])))
    assert least == pytest.approx(opening, abs=1e-9)


def test_an_edge_has_one_tet_or_half_its_angle():
    """At a right angle of a flat box the tet between both facets has a sharper angle than 45."""
    box = tet_grid(4)
    box.points *= [1, 1, 0.6]
    least, _ = forced_angles(cast(box))
    assert least == pytest.approx(45.0, abs=1e-9)


@pytest.mark.parametrize("name", ["raw_ball.mesh", "two_regions.msh", "grid.vtk"])
def test_no_mesh_is_better_than_its_boundary_forces(name):
    source = patches.sample(name)
    least, greatest = forced_angles(source)
    one = summarize(source, MEASURES["aspect-ratio"])
    assert one.angle_min <= least <= greatest <= one.angle_max
