"""JSON, CSV and Markdown."""

import csv
import io
import math
import re
from dataclasses import replace

from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.errors import shown
from meshopt_cli.reports.csv import to_csv
from meshopt_cli.reports.json import to_json
from meshopt_cli.reports.markdown import to_markdown
from meshopt_cli.reports.model import FileFacts
from meshopt_cli.reports.rows import (
    HEADINGS,
    closing_lines,
    count_row,
    named_rows,
    pass_rows,
    percent_row,
)
from support.files import strict
from support.reports import INFINITE, OF_A_MESH, OF_A_RUN, ran, report, reports, summary


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
        assert (row["file"], row["mesh"]) == (shown(path), label)
        assert [int(row[heading]) for heading in HEADINGS[:4]] == list(s.counts)
        assert float(row["Q_T"]) == s.worst
        assert float(row["target"]) == s.target
        assert (int(row["ne"]), int(row["np"])) == (s.n_cells, s.n_points)
        assert float(row["angle_max"]) == s.angle_max


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
