"""Figures, headings, and the text around the table."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.reports.rows import (
    HEADINGS,
    closing_lines,
    count_row,
    figure,
    pass_rows,
    percent_row,
)
from support.reports import INFINITE, OF_A_MESH, OF_A_RUN, qualities, report, summaries, summary


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


@given(st.floats(1.0, 1e300))
def test_a_figure_says_the_value_to_half_a_percent(value):
    assert float(figure(value)) == pytest.approx(value, rel=6e-3)
    assert len(figure(value)) <= len("1.23e+100")


@given(qualities, qualities)
def test_figures_keep_their_order(one, other):
    low, high = sorted([one, other])
    assert float(figure(low)) <= float(figure(high))


def test_headings_are_those_of_the_table():
    assert HEADINGS == ("1 - 2", "2 - 3", "3 - 10", "> 10", "target", "Q_T", "ne", "np")


@given(summaries)
def test_rows_are_as_long_as_the_headings(one):
    assert len(percent_row(one)) == len(count_row(one)) == len(HEADINGS)
    numbers = [int(cell.replace(",", "")) for cell in count_row(one) if cell]
    assert numbers == list(one.counts)
    n_cells, n_points = (int(cell.replace(",", "")) for cell in percent_row(one)[-2:])
    assert (n_cells, n_points) == (one.n_cells, one.n_points)


@pytest.mark.parametrize(
    ("family", "kind", "equation"),
    [("triangle", "triangles", "(18.6)"), ("tetra", "tetrahedra", "(18.7)")],
)
def test_the_title_says_what_the_mesh_is(family, kind, equation):
    one = report(summary((1000, 200, 34, 0), family=family, n_points=5678))
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
    assert "dihedral" not in "\n".join(closing_lines(report(summary(family="triangle"))))


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
