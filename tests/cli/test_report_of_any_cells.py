"""`meshopt report` on meshes of quads, hexahedra and of several kinds of cells, by any measure."""

import csv
import io

import meshio
import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.jobs.quality_arrays import ARRAYS
from meshopt_cli.mesh.model import Mesh
from meshopt_cli.quality.measures import MEASURES, QUALITIES
from meshopt_cli.quality.verdict.table import every_measure
from support.files import strict, write
from support.meshes import hex_grid, mesh, quad_grid, tet_grid, tri_grid

PLANE = mesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5]], quad=[[0, 1, 2, 3]], triangle=[[1, 4, 2]])


def one_of(family):
    """A mesh of one ideal cell."""
    points = FAMILIES[family].reference
    return mesh(points, **{family: [list(range(len(points)))]})


def as_json(meshopt, path, *more):
    ran = meshopt("report", path, "--format", "json", *more)
    assert ran.status == 0
    return strict(ran.out), ran


@pytest.mark.parametrize("family", [f for f in FAMILIES if FAMILIES[f].dimension >= 2])
def test_an_ideal_cell_is_ideal_by_every_measure(meshopt, tmp_path, family):
    path = write(tmp_path / "one.vtu", one_of(family))
    value, ran = as_json(meshopt, path, "--measure", "all")
    assert ran.err == ""
    before = value["before"]
    assert (before["ne"], before["invalid"]) == (1, 0)
    assert before["worst"] == pytest.approx(1.0)
    assert before["families"] == {}
    told = {row["measure"]: row for row in value["statistics"]}
    assert set(told) == {name for name, m in every_measure().items() if family in m.ways}
    for row in told.values():
        assert row["family"] == family
        assert row["least"] == row["mean"] == row["greatest"]
        if row["ideal"] is not None:
            assert row["mean"] == pytest.approx(row["ideal"], abs=1e-9)


def test_families_are_told_of_one_by_one_and_together(meshopt, tmp_path):
    path = write(tmp_path / "both.vtu", PLANE)
    value, ran = as_json(meshopt, path)
    assert ran.err == ""
    before, parts = value["before"], value["before"]["families"]
    assert list(parts) == ["triangle", "quad"]
    assert (before["ne"], before["np"]) == (2, 5)
    assert [part["ne"] for part in parts.values()] == [1, 1]
    assert [part["np"] for part in parts.values()] == [3, 4]
    assert parts["quad"]["worst"] == pytest.approx(1.0)
    assert before["worst"] == parts["triangle"]["worst"]
    assert before["mean"] == pytest.approx((parts["triangle"]["worst"] + 1.0) / 2.0)
    assert before["target"] == 1.0
    counts = np.array([part["histogram"]["counts"] for part in parts.values()])
    assert before["histogram"]["counts"] == counts.sum(axis=0).tolist()
    out = meshopt("report", path).out
    assert "2 cells (1 triangle, 1 quad), 5 vertices, aspect ratio (18.6, 18.10)" in out
    assert [line.split()[0] for line in out.splitlines()[2:8:2]] == ["triangles", "quads", "all"]


@pytest.mark.parametrize("form", ["table", "markdown", "csv", "json"])
def test_measures_stand_in_every_form(meshopt, tmp_path, form):
    path = write(tmp_path / "both.vtu", PLANE)
    out = meshopt("report", path, "--format", form, "--measure", "corner-min,quad.skew").out
    assert "corner-min" in out
    assert "quad.skew" in out
    if form == "csv":
        rows = list(csv.DictReader(io.StringIO(out)))
        assert [row["mesh"] for row in rows] == ["triangles", "quads", "all"]
        assert float(rows[-1]["corner-min quad mean"]) == pytest.approx(90.0)


@pytest.mark.parametrize("make", [tet_grid, hex_grid, tri_grid, quad_grid])
def test_no_cell_of_a_mesh_that_is_turned_is_worse(meshopt, tmp_path, make):
    one = make(2)
    turned = Mesh(one.points * np.array([1.0, -1.0, 1.0])[: one.points.shape[1]], one.blocks)
    paths = [write(tmp_path / name, m) for name, m in (("a.vtu", one), ("b.vtu", turned))]
    a, b = (as_json(meshopt, path)[0]["before"] for path in paths)
    if make is quad_grid:  # seen from above, a quad that runs clockwise is negative
        assert (a["invalid"], b["invalid"]) == (0, b["ne"])
    else:
        assert b["worst"] == pytest.approx(a["worst"])


def test_a_cell_that_is_inverted_has_no_quality(meshopt, tmp_path):
    one = hex_grid(2)
    one.points[13] = [1.2, 1.3, 1.1]  # the middle
    before = as_json(meshopt, write(tmp_path / "bad.vtu", one))[0]["before"]
    assert before["invalid"] > 0
    assert before["worst"] is None
    assert before["target"] is None


def test_quads_of_a_surface_are_measured_where_they_are(meshopt, tmp_path):
    cube = hex_grid(1)
    quads = cube.blocks[0].cells[0][np.concatenate(FAMILIES["hexahedron"].facets)]
    path = write(tmp_path / "cube.vtu", mesh(cube.points, quad=quads))
    value, ran = as_json(meshopt, path)
    assert "own plane" in ran.err
    assert value["before"]["worst"] == pytest.approx(1.0)


def test_what_no_cell_has_is_said(meshopt, tmp_path):
    path = write(tmp_path / "quads.vtu", quad_grid(2))
    ran = meshopt("report", path, "--measure", "dihedral-min,quad.skew")
    assert (ran.status, "no cell has the measure dihedral-min" in ran.err) == (0, True)
    ran = meshopt("report", path, "--measure", "radius-edge")
    assert (ran.status, ran.out) == (2, "")
    assert "radius-edge is no measure of quads" in ran.err
    ran = meshopt("report", path, "--measure", "quad.skiw")
    assert (ran.status, "did you mean 'quad.skew'" in ran.err) == (2, True)


@pytest.mark.parametrize("name", [name for name, m in QUALITIES.items() if "hexahedron" in m.ways])
def test_the_first_q_ranks_the_cells(meshopt, tmp_path, name):
    one = hex_grid(2)
    one.points[13] += [0.02, 0.05, -0.03]
    value, _ = as_json(meshopt, write(tmp_path / "a.vtu", one), "--measure", f"edge-min,{name}")
    (row,) = [row for row in value["statistics"] if row["measure"] == name]
    assert value["measure"] == name
    assert value["before"]["worst"] == row["greatest"]
    assert value["before"]["mean"] == pytest.approx(row["mean"])


# Arrays --------------------------------------------------------------------------------------


def test_quality_is_written_to_the_cells(meshopt, tmp_path):
    path, marked = write(tmp_path / "both.vtu", PLANE), tmp_path / "q.vtu"
    ran = meshopt("report", path, "--measure", "edge-max,quad.skew", "--write-quality", marked)
    assert (ran.status, ran.err) == (0, "")
    read = meshio.read(marked)
    own = {name for name in read.cell_data if name.startswith("meshopt:")}
    assert own == {*ARRAYS, "meshopt:edge-max", "meshopt:quad.skew"}
    for k, block in enumerate(read.cells):
        q = MEASURES["aspect-ratio"].of(read.points, block.data, block.type)
        assert read.cell_data["meshopt:Q"][k] == pytest.approx(q)
        assert np.isnan(read.cell_data["meshopt:quad.skew"][k]).all() == (block.type != "quad")
        assert read.cell_data["meshopt:class"][k].tolist() == [0 if block.type != "quad" else -1]
        assert read.cell_data["meshopt:region"][k].tolist() == [0]
    other = write(tmp_path / "other.vtu", PLANE)
    many = meshopt("report", path, other, "--write-quality", tmp_path / "r.vtu")
    assert (many.status, (tmp_path / "r.vtu").exists()) == (2, False)


def test_quality_goes_along_with_the_output(meshopt, tets, tmp_path):
    out, again = tmp_path / "out.vtu", tmp_path / "again.vtu"
    assert meshopt("optimize", tets, out, "--write-quality", "-q").status == 0
    data = meshio.read(out).cell_data
    assert max(data["meshopt:Q"][0]) == pytest.approx(
        strict(meshopt("report", out, "--format", "json").out)["before"]["worst"]
    )
    assert (
        as_json(meshopt, out)[0]["regions"]["arrays"]
        == as_json(meshopt, tets)[0]["regions"]["arrays"]
    )
    ran = meshopt("optimize", out, again)
    assert ran.status == 0
    assert "--write-quality makes it anew" in ran.err
    assert not set(ARRAYS) & set(meshio.read(again).cell_data)
