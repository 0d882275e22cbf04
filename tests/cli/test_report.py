"""`meshopt report`."""

import csv
import io
import re

import pytest

from meshopt_cli import formats
from meshopt_cli.quality.measures import OF_SIMPLICES
from meshopt_cli.reports.rows import HEADINGS
from support.files import strict, worst_of, write
from support.meshes import in_space, tet_grid, tri_grid
from support.refused import bad_mesh
from support.reports import TOP_KEYS, check_summary


@pytest.mark.parametrize("form", ["table", "json", "markdown", "csv"])
@pytest.mark.parametrize("to_file", [False, True])
def test_report_of_several_meshes(meshopt, tets, triangles, broken, tmp_path, form, to_file):
    paths = [tets, triangles, broken]
    where = tmp_path / "report"
    ran = meshopt("report", *paths, "--format", form, *(["-o", where] if to_file else []))
    assert (ran.status, ran.err) == (0, "")
    text = where.read_text(encoding="utf-8") if to_file else ran.out
    assert bool(ran.out) != to_file
    if form == "json":
        values = strict(text)
        assert [v["input"]["path"] for v in values] == [str(path) for path in paths]
        assert all(set(v) == TOP_KEYS for v in values)
        assert all(v["after"] is v["output"] is v["stopped"] is None for v in values)
        check_summary(values[0]["before"], formats.read(tets)[0])
        check_summary(values[1]["before"], formats.read(triangles)[0])
        assert values[2]["before"]["worst"] is None
        assert values[2]["before"]["invalid"] > 0
    elif form == "csv":
        rows = list(csv.DictReader(io.StringIO(text)))
        assert [row["file"] for row in rows] == [str(path) for path in paths]
        assert [float(row["Q_T"]) for row in rows] == pytest.approx([worst_of(p) for p in paths])
    else:
        assert [text.index(path.name) for path in paths] == sorted(
            text.index(path.name) for path in paths
        )
        for heading in HEADINGS:
            assert text.count(heading) >= len(paths)
        assert "before" not in text


def test_report_of_one_mesh_as_json_is_an_object(meshopt, tets):
    assert set(strict(meshopt("report", tets, "--format", "json").out)) == TOP_KEYS


@pytest.mark.parametrize("measure", OF_SIMPLICES)
def test_report_by_any_measure(meshopt, tets, measure):
    ran = meshopt("report", tets, "--measure", measure, "--format", "csv")
    (row,) = csv.DictReader(io.StringIO(ran.out))
    assert float(row["Q_T"]) == pytest.approx(worst_of(tets, measure), rel=1e-12)
    assert measure.replace("-", " ") in meshopt("report", tets, "--measure", measure).out


def test_report_goes_on_after_a_mesh_that_cannot_be_read(meshopt, tets, triangles, tmp_path):
    lines, _, _ = bad_mesh(tmp_path, "lines")
    missing = tmp_path / "missing.vtk"
    ran = meshopt("report", tets, missing, lines, triangles, "--format", "csv")
    assert ran.status == 3
    assert [row["file"] for row in csv.DictReader(io.StringIO(ran.out))] == [
        str(tets),
        str(triangles),
    ]
    errors = ran.err.splitlines()
    assert len(errors) == 2
    assert str(missing) in errors[0]
    assert str(lines) in errors[1]


@pytest.mark.parametrize("make", [lambda: in_space(tri_grid(2)), lambda: tet_grid(2)])
def test_report_of_a_mesh_with_vertices_that_are_not_there(meshopt, tmp_path, make):
    """What check calls M002 is a bad mesh, not a bug of ours."""
    one = make()
    one.blocks[0].cells[0, 0] = len(one.points) + 3
    path = write(tmp_path / "out_of_range.vtu", one)
    assert meshopt("check", path).status == 1
    ran = meshopt("report", path)
    assert (ran.status, ran.out) == (1, "")
    assert str(path) in ran.complaint


def test_the_report_tells_where_there_is_room(meshopt, samples):
    """Of tetrahedra; any triangle may be regular."""
    shown = meshopt("report", samples / "raw_ball.mesh").out
    assert "cells are held by facets, edges or vertices" in shown
    assert "most room is left at (" in shown
    assert "most room" not in meshopt("report", samples / "quadtree.vtk").out


def test_the_report_counts_types(meshopt, samples, tmp_path):
    """Those that are bad; of an optimization before and after."""
    shown = meshopt("report", samples / "raw_ball.mesh").out
    assert re.search(r"types of cells: .*sliver \d", shown)
    shown = meshopt("optimize", samples / "raw_ball.mesh", tmp_path / "out.mesh").out
    before, after = re.search(r"sliver (\d+) -> (\d+)", shown).groups()
    assert int(after) < int(before)
