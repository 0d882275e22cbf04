"""The page of HTML: well formed, alone in the world, and with every figure."""

import base64
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.errors import shown
from meshopt_cli.jobs.report import Wanted, report_on
from meshopt_cli.mesh.tags import Regions
from meshopt_cli.quality.census import Census, Degrees
from meshopt_cli.quality.room import Place, Room
from meshopt_cli.quality.statistics import Histogram, Statistic
from meshopt_cli.quality.worst import WorstCell
from meshopt_cli.reports.html import to_html
from meshopt_cli.reports.metric import length_rows, metric_lines
from meshopt_cli.reports.model import FileFacts, Picture, Pictures
from meshopt_cli.reports.rows import HEADINGS, count_row, named_rows, pass_rows, percent_row
from support.edits import shaken
from support.meshes import tet_grid
from support.metrics import judged, of_matrices
from support.reports import (
    INFINITE,
    OF_A_MESH,
    OF_A_RUN,
    both_kinds,
    qualities,
    ran,
    report,
    reports,
    summary,
)

CELLS = {"td", "th", "small", "dd", "li", "p", "code", "figcaption"}
INFINITE_SIGN = "\u221e"
VOID = {"meta", "br", "hr", "img", "input", "link"}
HOSTILE = "<script>alert('&amp;\"')</script>\x1b[31m\n\x00\u202e"


class Page(HTMLParser):
    """A page as it is read, which must close what it opens."""

    def __init__(self, source):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.cells, self.words = [], [], [], [], []
        self.feed(source)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        assert len(dict(attrs)) == len(attrs)
        if tag not in VOID:
            self.open.append(tag)
        if tag in CELLS:
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" in self.open:
            return
        self.words.append(data)
        if CELLS & set(self.open):
            self.cells[-1] += data

    @property
    def text(self):
        return "".join(self.words)

    def values(self, name):
        return [value for key, value in self.attributes if key == name]


def drawings(source):
    return [ET.fromstring(svg) for svg in re.findall(r"<svg.*?</svg>", source, re.DOTALL)]


@both_kinds
def test_every_figure_of_the_table_is_there(one):
    page = Page(to_html([one]))
    for name, s in named_rows(one):
        percents, counts = percent_row(s), count_row(s)
        assert name in page.cells
        assert all(f"{p} %" in page.cells for p in percents[:4])
        assert all(p in page.cells for p in percents[4:])
        assert all(c in page.cells for c in counts if c)
    assert all(heading in page.cells for heading in HEADINGS)
    for each_round in (False, True):
        for row in pass_rows(one, each_round):
            assert all(cell in page.cells for cell in row)
    assert one.title in page.cells
    assert one.input.sha256 in page.cells


def test_a_page_of_a_run_tells_of_both_meshes_and_of_the_run():
    source = to_html([OF_A_RUN])
    text = Page(source).text
    assert "Stopped: no change" in text
    assert "read 0.10 s, optimize 2.00 s, write 0.01 s" in text
    assert len(drawings(source)) == 2
    assert "Course" not in Page(to_html([OF_A_MESH])).text


@both_kinds
def test_a_page_asks_for_nothing(one):
    source = to_html([one])
    page = Page(source)
    assert {"script", "link", "img", "iframe", "object", "form"}.isdisjoint(page.tags)
    plain = source.replace("http-equiv", "")
    assert not re.search(r"http|src=|@import|url\(|//", plain)
    (policy,) = [v for v in page.values("content") if "default-src" in v]
    assert policy.startswith("default-src 'none'")
    assert all(value.startswith("#") for value in page.values("href"))


@both_kinds
def test_a_page_says_what_browsers_ask(one):
    source = to_html([one])
    page = Page(source)
    assert source.startswith("<!DOCTYPE html>\n<html lang=")
    assert source.isascii()
    assert source.count("</title>\n") == page.tags.count("h1") == 1
    assert page.tags.count("figure") == page.tags.count("figcaption") == page.tags.count("svg")
    assert set(page.values("scope")) == {"row", "col"}
    for svg in drawings(source):
        assert svg.get("role") == "img"
        assert svg.get("aria-label")
        assert svg.get("viewBox")


@both_kinds
def test_the_same_report_is_the_same_page(one):
    assert to_html([one]) == to_html([replace(one)])


def test_pictures_are_in_the_page():
    pictures = Pictures(
        (Picture(b"one", 40, 30, "<cells>"), Picture(b"two", 40, 30, "cells")),
        ((Picture(b"three", 9, 9, "element 12"),), ()),
        "Q", ("#a50026", "#6aaad4"), ((1.0, "1"), (0.0, INFINITE_SIGN)),
    )  # fmt: skip
    worst = (WorstCell("tetra", 6, (0.25, 1.0, -3.5), 7.5, "sliver", "element 12"),)
    one = replace(OF_A_RUN, before=summary(worst_cells=worst), pictures=pictures)
    source = to_html([one])
    page = Page(source)
    data = [value.removeprefix("data:image/png;base64,") for value in page.values("src")]
    assert [base64.b64decode(value) for value in data] == [b"one", b"two", b"three"]
    assert page.values("alt") == ["before: <cells>", "after: cells", "element 12"]
    assert page.values("alt") == [c for c in page.cells if c in page.values("alt")][:3]
    (policy,) = [v for v in page.values("content") if "default-src" in v]
    assert "img-src data:" in policy
    (legend,) = [d for d in drawings(source) if "Colours" in d.get("aria-label")]
    assert [r.get("fill") for r in legend.iter("rect")] == list(pictures.colours)
    assert {t.text for t in legend.iter("text")} == {"Q", "1", INFINITE_SIGN}


def test_a_page_says_why_it_has_no_pictures():
    one = replace(OF_A_MESH, pictures=Pictures(missing="pictures need a library"))
    page = Page(to_html([one]))
    assert "There are none: pictures need a library." in page.cells
    assert "img" not in page.tags
    assert "Pictures" not in Page(to_html([OF_A_MESH])).text


def test_names_are_text():
    odd = replace(
        OF_A_RUN,
        input=FileFacts(f"in/{HOSTILE}.vtk", "vtk", "0"),
        lost=(f"the array {HOSTILE}",),
        notes=(HOSTILE,),
        regions=Regions((HOSTILE,), 2),
        command=f"meshopt optimize '{HOSTILE}'",
    )
    source = to_html([odd, odd])
    page = Page(source)
    assert "script" not in page.tags
    assert "\x1b" not in source
    assert "\x00" not in source
    assert page.text.count(shown(HOSTILE)) > 8
    assert page.tags.count("article") == 2


def test_a_name_that_cannot_be_decoded_is_shown():
    odd = replace(OF_A_MESH, input=FileFacts("in/\udcff.vtk", "vtk", "0"))
    assert r"\udcff" in Page(to_html([odd])).text


def test_several_meshes_have_an_index():
    page = Page(to_html([OF_A_MESH, OF_A_RUN, OF_A_MESH]))
    links = [value.removeprefix("#") for value in page.values("href")]
    assert len(links) == 3
    assert [i for i in page.values("id") if i in links] == links
    assert Page(to_html([OF_A_MESH])).values("href") == []


def test_families_are_told_apart():
    parts = (summary(family="triangle"), summary((1, 2, 3, 4), family="quad"))
    one = report(_whole(parts))
    page = Page(to_html([one]))
    assert {"triangles", "quads", "all"} <= set(page.cells)
    assert page.tags.count("svg") == 3


def _whole(parts):
    counts = tuple(map(sum, zip(*(part.counts for part in parts), strict=True)))
    return replace(parts[0], counts=counts, n_cells=sum(counts), family="", parts=parts)


def test_what_is_infinite_or_undefined_has_a_sign():
    one = report(summary(worst=INFINITE, target=float("nan"), n_invalid=3))
    page = Page(to_html([one]))
    assert "\u221e" in page.cells
    assert "\u2013" in page.cells
    assert not {"inf", "nan"} & set(page.cells)
    assert "flat or inverted cells" in page.text


def statistic(values, unit="1", **changes):
    edges = tuple(float(v) for v in range(len(values) + 1))
    found = Statistic("edge-ratio", "tetra", unit, 1.0, sum(values), 0, 0.0, 1.5, edges[-1],
                      Histogram(edges, tuple(values)))  # fmt: skip
    return replace(found, **changes)


def test_a_histogram_has_a_bar_for_each_bin_with_cells():
    source = to_html([report(statistics=(statistic([5, 0, 7]), statistic([1], n_infinite=4)))])
    one, other = drawings(source)[1:]
    assert [bar.find("title").text for bar in one.iter("rect")] == [
        "0 to 1: 5 cells", "2 to 3: 7 cells",
    ]  # fmt: skip
    heights = [float(bar.get("height")) for bar in one.iter("rect")]
    assert heights[0] / heights[1] == pytest.approx(5 / 7, abs=0.01)
    assert len(list(other.iter("rect"))) == 1
    text = Page(source).text
    assert "the most, 7 of 12, at 2 to 3" in text
    assert "ideal 1" in text
    without = to_html([report(statistics=(statistic([1], histogram=None),))])
    assert len(drawings(without)) == 1


def test_what_is_told_in_a_metric_is_in_the_page():
    one = shaken(tet_grid(2))
    found = judged(one, of_matrices(np.tile(4.0 * np.eye(3), (len(one.points), 1, 1)))).summary
    source = to_html([report(metric=found)])
    page = Page(source)
    for row in length_rows(found):
        assert set(row) <= set(page.cells)
    assert set(metric_lines(found)) <= set(page.cells)
    lengths, quality = drawings(source)[1:]
    titles = [bar.find("title").text for bar in lengths.iter("rect")]
    for name, counts in (("all edges", found.edges.counts), ("inner edges", found.inner.counts)):
        told = [t for t in titles if t.startswith(f"{name}, ")]
        assert [int(t.split()[-4].replace(",", "")) for t in told] == list(counts)
    assert len(list(quality.iter("rect"))) == len(found.counts)
    assert "In the metric" not in Page(to_html([report()])).text


def test_worst_cells_have_their_names_and_places():
    worst = (
        WorstCell("tetra", 6, (0.25, 1.0, -3.5), INFINITE, "sliver", "element 12"),
        WorstCell("tetra", 0, (0.0, 0.0, 0.0), 7.5, "cap"),
    )
    cells = Page(to_html([report(summary(worst_cells=worst))])).cells
    at = cells.index("element 12")
    assert cells[at : at + 4] == ["element 12", "\u221e", "sliver", "(0.25, 1, -3.5)"]
    assert "tetra 1" in cells


def test_census_room_and_notes_are_there():
    degrees = Degrees({5: 3, 12: 9}, {-7: 3, 0: 9, 4: 2})
    census = Census(1, 2, 3, degrees, Degrees(), degrees, 100, 1234, 56, {})
    room = Room(10, 4, (Place((1.0, 2.0, 3.0), 7.5, 2.25),))
    one = report(
        summary(census=census, room=room, forced=(11.5, 140.0), types={"cap": 0, "spade": 21}),
        lost=("the array a",), left_out=("swap",), notes=("a note",),
    )  # fmt: skip
    page = Page(to_html([one]))
    for cell in ("1,234", "56", "21", "spade", "(1, 2, 3)", "2.25", "11.5", "140.0", "a note",
                 "lost: the array a", "inner vertices"):  # fmt: skip
        assert cell in page.cells
    assert "cap" not in page.cells
    assert "40.0 % of them" in page.text
    assert any(cell.startswith("left out: swap") for cell in page.cells)
    at = page.cells.index("inner vertices")
    assert page.cells[at + 1 : at + 8] == ["3", "0", "0", "9", "0", "0", "2"]


numbers = st.floats(allow_nan=True, allow_infinity=True)
facts = st.builds(
    lambda name, round, worst, mean: replace(ran(round, name), worst=worst, mean=mean),
    st.sampled_from(["smooth", "swap"]), st.integers(0, 9), qualities, qualities,
)  # fmt: skip
histograms = st.lists(
    st.floats(-1e300, 1e300), min_size=2, max_size=9, unique=True
).map(sorted).flatmap(
    lambda edges: st.lists(
        st.integers(0, 10**9), min_size=len(edges) - 1, max_size=len(edges) - 1
    ).filter(any).map(lambda counts: Histogram(tuple(edges), tuple(counts)))
)  # fmt: skip
statistics = st.builds(
    lambda found, least, mean, ideal: statistic([1], least=least, mean=mean, ideal=ideal,
                                                histogram=found),
    st.none() | histograms, numbers, numbers, st.none() | st.floats(-1e300, 1e300),
)  # fmt: skip


@given(st.lists(reports, min_size=1, max_size=3), st.lists(facts, max_size=30),
       st.lists(statistics, max_size=3))  # fmt: skip
def test_any_figures_make_a_page(ones, passes, found):
    ones = [
        replace(one, passes=tuple(passes) if one.after else (), statistics=tuple(found))
        for one in ones
    ]
    source = to_html(ones)
    page = Page(source)
    assert page.tags.count("article") == len(ones)
    for svg in drawings(source):
        for element in svg.iter():
            for value in element.attrib.values():
                assert "nan" not in value.split()
                assert "inf" not in value.split()
            for key in ("width", "height"):
                assert float(element.get(key, "0")) >= 0.0


def test_no_cells_make_a_page():
    nothing = summary((0, 0, 0, 0), worst=1.0, mean=INFINITE, best=INFINITE)
    Page(to_html([report(nothing), report(nothing, nothing, passes=[ran(1, "smooth")])]))


def test_a_page_of_files(samples):
    """Of a mesh in a plane, one with quads, and one with cells turned the wrong way."""
    names = ("plate.vtu", "quadtree.vtk", "tangled.vtk")
    wanted = Wanted(("edge-ratio", "corner-min"), all_measures=True, with_histograms=True)
    ones = [report_on(samples / name, wanted) for name in names]
    source = to_html(ones)
    page = Page(source)
    assert page.tags.count("article") == 3
    for one in ones:
        assert one.before.worst_cells[0].cell in page.cells
        assert all(s.histogram is not None for s in one.statistics)
