"""`meshopt report --metric` and `--size`."""

import csv
import io

import meshio
import numpy as np
import pytest

from meshopt_cli.formats.medit_sol import SCALAR, TENSOR, VECTOR, Solution, write_sol
from meshopt_cli.jobs.metric import ARRAYS
from meshopt_cli.metric.field import VTK, components, from_array
from meshopt_cli.reports.metric import CSV_HEADINGS
from support.edits import shaken
from support.files import strict, write
from support.meshes import hex_grid, in_space, octahedron, tet_grid, tri_grid
from support.metrics import judged, of_matrices, random_tensors

LENGTH_KEYS = {"count", "tau", "share", "least", "mean", "greatest", "histogram"}
KEYS = {"kind", "source", "edges", "inner_edges", "measure", "worst", "mean", "best", "invalid",
        "histogram", "content", "unit_cells", "ne", "unit", "optimal"}  # fmt: skip


def told(meshopt, path, *more):
    ran = meshopt("report", path, "--format", "json", *more)
    assert ran.status == 0, ran.err
    return strict(ran.out)["metric"]


def with_sol(folder, one, values, kind, name="m.sol"):
    path = folder / name
    write_sol(path, Solution(one.points.shape[1], [(kind, values)]))
    return path


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
@pytest.mark.parametrize("name", ["m.sol", "m.solb"])
def test_a_file_of_tensors(meshopt, tmp_path, make, name):
    one = shaken(make(3))
    n, d = one.points.shape
    tensors = random_tensors(d, n, 0.3)
    path = write(tmp_path / "a.mesh", one)
    sol = with_sol(tmp_path, one, components(tensors), TENSOR, name)
    value = told(meshopt, path, "--metric", sol)
    assert set(value) == KEYS
    assert set(value["edges"]) == set(value["inner_edges"]) == LENGTH_KEYS
    assert set(value["unit"]) == set(value["optimal"]) == {"worst", "mean", "share"}
    expected = judged(one, of_matrices(tensors)).summary
    assert value["kind"] == "tensors"
    assert name in value["source"]
    for key, lengths in (("edges", expected.edges), ("inner_edges", expected.inner)):
        assert value[key]["count"] == lengths.n_edges
        for what in ("tau", "share", "least", "mean", "greatest"):
            assert value[key][what] == pytest.approx(getattr(lengths, what), rel=1e-12)
        assert value[key]["histogram"]["counts"] == list(lengths.counts)
        assert sum(value[key]["histogram"]["percent"]) == pytest.approx(100.0)
    assert value["worst"] == pytest.approx(expected.worst, rel=1e-12)
    assert value["content"] == pytest.approx(expected.content, rel=1e-12)
    assert value["unit_cells"] == pytest.approx(expected.n_unit, rel=1e-12)
    assert value["ne"] == sum(value["histogram"]["counts"]) == len(one.blocks[0].cells)


@pytest.mark.parametrize("form", ["table", "markdown", "csv", "json"])
def test_every_form_tells_of_it(meshopt, tmp_path, form):
    path = write(tmp_path / "a.vtu", shaken(tet_grid(3)))
    ran = meshopt("report", path, "--size", "0.2+0.1*x", "--format", form)
    assert (ran.status, ran.err) == (0, "")
    value = told(meshopt, path, "--size", "0.2+0.1*x")
    assert f"{value['edges']['tau']:.4f}"[:5] in ran.out
    if form == "csv":
        (row,) = csv.DictReader(io.StringIO(ran.out))
        assert set(CSV_HEADINGS) < set(row)
        assert float(row["tau inner"]) == value["inner_edges"]["tau"]
        assert float(row["metric Q_T"]) == value["worst"]
        assert float(row["unit cells"]) == value["unit_cells"]
    elif form != "json":
        for part in ("all edges", "inner edges", "metric of sizes: size 0.2+0.1*x", "unit cells"):
            assert part in ran.out
    plain = meshopt("report", path, "--format", form).out
    assert "tau" not in plain
    assert ('"metric": null' in plain) == (form == "json")


def test_a_formula_is_a_field_of_sizes(meshopt, tmp_path):
    one = tet_grid(2)
    path = write(tmp_path / "a.mesh", one)
    sizes = 0.2 + 0.1 * one.points[:, :1]
    sol = with_sol(tmp_path, one, sizes, SCALAR)
    by_file = told(meshopt, path, "--metric", sol)
    by_formula = told(meshopt, path, "--size", "0.2+0.1*x")
    assert by_file.pop("source") != by_formula.pop("source")
    assert by_file == by_formula
    # shapes are those of the mesh: Q is as without a metric
    before = strict(meshopt("report", path, "--format", "json").out)["before"]
    assert by_file["worst"] == pytest.approx(before["worst"])
    assert by_file["histogram"]["counts"] == before["histogram"]["counts"]


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
@pytest.mark.parametrize("kind", ["six", "nine", "sizes"])
def test_arrays_of_a_mesh(meshopt, tmp_path, make, kind):
    one = shaken(make(2))
    n, d = one.points.shape
    tensors = np.zeros((n, 3, 3))  # the third dimension of a plane is not there
    tensors[:, :d, :d] = random_tensors(d, n, 0.3)
    if d == 2:
        in_space(one)
    values = {
        "six": tensors[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]],
        "nine": tensors.reshape(n, 9),
        "sizes": np.linspace(0.1, 0.2, n),
    }[kind]
    one.point_data["m"] = values
    path = write(tmp_path / "a.vtu", one)
    value = told(meshopt, path, "--metric", "m")
    if kind == "sizes":
        metric = from_array(values, np.ones(n, bool), "m", VTK)
    else:
        metric = of_matrices(tensors[:, :d, :d])
        assert ("(xx, yy, zz, xy, yz, xz)" in value["source"]) == (kind == "six")
    expected = judged(one, metric).summary
    assert value["edges"]["tau"] == pytest.approx(expected.edges.tau, rel=1e-12)
    assert value["worst"] == pytest.approx(expected.worst, rel=1e-12)


@pytest.mark.parametrize("make", [tri_grid, tet_grid, hex_grid, octahedron])
def test_the_metric_of_the_mesh_itself(meshopt, tmp_path, make):
    one = make() if make is octahedron else shaken(make(2), 0.05)
    value = told(meshopt, write(tmp_path / "a.vtu", one), "--metric", "implied")
    assert value["source"] == "the mesh itself"
    assert value["edges"]["tau"] > 0.9


def test_the_measure_that_ranks_is_that_of_the_metric_too(meshopt, tmp_path):
    path = write(tmp_path / "a.vtu", shaken(tet_grid(2)))
    value = told(meshopt, path, "--metric", "implied", "--measure", "radius-ratio")
    assert value["measure"] == "radius-ratio"


def test_of_several_fields_the_first_tensor_is_taken_and_said(meshopt, tmp_path):
    one = tri_grid(2)
    path = write(tmp_path / "a.mesh", one)
    tensors = components(random_tensors(2, 9, 0.2))
    fields = [(SCALAR, np.ones((9, 1))), (VECTOR, np.ones((9, 2))), (TENSOR, tensors)]
    sol = tmp_path / "m.sol"
    write_sol(sol, Solution(2, fields))
    ran = meshopt("report", path, "--metric", sol, "--format", "json")
    assert strict(ran.out)["metric"]["kind"] == "tensors"
    assert "field 3" in ran.complaint
    write_sol(sol, Solution(2, fields[:2]))
    assert told(meshopt, path, "--metric", sol)["kind"] == "sizes"
    write_sol(sol, Solution(2, fields[1:2]))
    ran = meshopt("report", path, "--metric", sol)
    assert (ran.status, "no field" in ran.complaint) == (2, True)


def test_cells_of_second_order_are_judged_by_their_corners(meshopt, tmp_path):
    points = np.array([[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]], dtype=float)
    path = tmp_path / "a.vtu"
    meshio.write_points_cells(
        path, np.column_stack([points, np.zeros(6)]), [("triangle6", [[0, 1, 2, 3, 4, 5]])],
        point_data={"h": np.array([2.0, 2.0, 2.0, -1.0, np.nan, 0.0])},
    )  # fmt: skip
    value = told(meshopt, path, "--metric", "h")
    assert value["edges"]["count"] == 3
    assert value["edges"]["least"] == pytest.approx(1.0)


def test_how_far_each_cell_is_goes_to_the_cells(meshopt, tmp_path):
    one = shaken(tet_grid(2))
    path, marked = write(tmp_path / "a.vtu", one), tmp_path / "q.vtu"
    ran = meshopt("report", path, "--size", "0.3", "--write-quality", marked)
    assert (ran.status, ran.err) == (0, "")
    data = meshio.read(marked).cell_data
    expected = judged(one, from_array(np.full(27, 0.3), np.ones(27, bool), "h"))
    for name, found in zip(
        ARRAYS, (expected.quality, expected.unit, expected.optimal), strict=True
    ):
        assert data[name][0] == pytest.approx(found["tetra"])


# What is refused -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("suffix", "name", "first"), [(".mesh", "vertex", 1), (".msh", "node", 1), (".vtu", "point", 0)]
)
def test_bad_ones_are_named_as_the_file_counts_them(meshopt, tmp_path, suffix, name, first):
    one = tet_grid(2)
    path = write(tmp_path / f"a{suffix}", one)
    tensors = np.tile([1.0, 0.0, 1.0, 0.0, 0.0, 1.0], (27, 1))
    tensors[[4, 7], 2] = -1.0
    sol = with_sol(tmp_path, one, tensors, TENSOR)
    ran = meshopt("report", path, "--metric", sol)
    assert (ran.status, ran.out) == (2, "")
    assert f"not positive definite at {name} {4 + first}, {name} {7 + first}" in ran.complaint
    assert str(path) in ran.complaint


@pytest.mark.parametrize(
    ("options", "status", "what"),
    [
        (["--size", "x.real"], 2, "letter 1"),
        (["--size", "0.1*"], 2, "no formula"),
        (["--size", "0.1", "--metric", "implied"], 2, "exclude each other"),
        (["--size", "x-0.5"], 2, "not positive at vertex"),
        (["--size", "1/x"], 2, "not finite at vertex"),
        (["--size", "9**9**9**9**9"], 2, "not finite at vertex"),
        (["--metric", "impled"], 2, "did you mean 'implied'"),
        (["--metric", "missing.sol"], 3, "no such file"),
    ],
)
def test_what_is_no_metric_is_refused(meshopt, tmp_path, options, status, what):
    path = write(tmp_path / "a.mesh", tri_grid(2))
    ran = meshopt("report", path, *options)
    assert (ran.status, ran.out) == (status, "")
    assert what in ran.complaint


def test_metrics_that_do_not_fit(meshopt, tmp_path):
    one = tri_grid(2)
    path = write(tmp_path / "a.mesh", one)
    other = with_sol(tmp_path, one, np.ones((8, 1)), SCALAR)
    ran = meshopt("report", path, "--metric", other)
    assert (ran.status, "8 rows" in ran.complaint, "9 vertices" in ran.complaint) == (2, True, True)
    solid = write(tmp_path / "b.mesh", tet_grid(1))
    flat = with_sol(tmp_path, one, np.tile([1.0, 0.0, 1.0], (8, 1)), TENSOR)
    ran = meshopt("report", solid, "--metric", flat)
    assert (ran.status, "of the plane" in ran.complaint) == (2, True)
    (tmp_path / "c.sol").write_text("Dimension 2\nSolAtVertices\n9\n1 1\n1 1 1\nEnd\n")
    ran = meshopt("report", path, "--metric", tmp_path / "c.sol")
    assert (ran.status, "c.sol" in ran.complaint) == (3, True)


def test_the_file_of_the_metric_is_not_written_over(meshopt, tmp_path):
    one = tri_grid(2)
    path, sol = write(tmp_path / "a.mesh", one), with_sol(tmp_path, one, np.ones((9, 1)), SCALAR)
    before = sol.read_bytes()
    ran = meshopt("report", path, "--metric", sol, "--format", "json", "-o", sol)
    assert (ran.status, "is an input itself" in ran.complaint) == (2, True)
    assert sol.read_bytes() == before


def test_other_meshes_are_still_told_of(meshopt, tmp_path):
    one, other = (write(tmp_path / name, tri_grid(n)) for name, n in (("a.mesh", 2), ("b.mesh", 3)))
    sol = with_sol(tmp_path, tri_grid(3), np.full((16, 1), 0.3), SCALAR)
    ran = meshopt("report", one, other, "--metric", sol, "--format", "csv")
    assert ran.status == 2
    (row,) = csv.DictReader(io.StringIO(ran.out))
    assert row["file"] == str(other)
