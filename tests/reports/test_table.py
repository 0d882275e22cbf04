"""The table on a terminal."""

import io
import re
from types import SimpleNamespace

import pytest
from hypothesis import given

from meshopt_cli.cli import output, terminal
from meshopt_cli.reports.outputs import NORMAL, OUTPUTS, Manner
from meshopt_cli.reports.rows import (
    HEADINGS,
    closing_lines,
    count_row,
    named_rows,
    pass_rows,
    percent_row,
)
from meshopt_cli.reports.table import BAR_WIDTH, BLOCKS, PLAIN_BLOCKS, bar, to_text
from support.reports import OF_A_RUN, both_kinds, ranks, report, summary


@both_kinds
def test_the_table_has_the_rows_of_the_report(one):
    lines = [line.split() for line in to_text([one]).splitlines()]
    assert [word for heading in HEADINGS for word in heading.split()] in lines
    for name, s in named_rows(one):
        assert [name, *percent_row(s)] in lines
        assert [cell for cell in count_row(s) if cell] in lines
    for row in pass_rows(one, each_round=False):
        assert [word for cell in row for word in cell.split()] in lines


@both_kinds
def test_the_first_and_the_last_lines_are_not_broken(one):
    lines = to_text([one]).splitlines()
    last = closing_lines(one)
    assert lines[0] == one.title
    assert lines[-len(last) :] == last


def test_a_long_run_does_not_break_the_last_lines():
    """As wide as it gets: ten million vertices, a day of work."""
    seconds = {"read": 12345.67, "optimize": 123456.78, "write": 12345.67}
    before, after = summary(n_points=10**7), summary(n_points=10**6)
    one = report(before, after, seconds=seconds, stopped="target quality")
    assert to_text([one]).splitlines()[-2:] == closing_lines(one)


def test_each_round_is_shown_when_asked():
    short, long = (OUTPUTS["table"].text([OF_A_RUN], Manner(verbosity)) for verbosity in (0, 1))
    assert len(re.findall("^smooth ", short, re.M)) == 1
    assert len(re.findall("^smooth ", long, re.M)) == 2


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
    output.print_reports([one], OUTPUTS["table"], NORMAL)
    text = stdout.buffer.getvalue().decode(encoding)
    assert blocks[0] * 10 in text
    assert text.isascii() == (encoding == "ascii")
