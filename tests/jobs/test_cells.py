"""Quads, pyramids, wedges, hexahedra and mixed meshes, optimized by moving their vertices."""

import json

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.cells import FAMILIES
from meshopt_cli.cli.entry import status_of
from meshopt_cli.mesh.any_cells import cast_any
from meshopt_cli.mesh.model import Mesh
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import check
from support.corners import pyramid_grid, thrown, tri_quad_grid, wedge_grid
from support.files import strict, write
from support.meshes import hex_grid, in_space, mesh, quad_grid, tri_grid

GRIDS = {"quads": quad_grid, "triangles and quads": tri_quad_grid, "hexahedra": hex_grid,
         "wedges": wedge_grid, "pyramids and hexahedra": pyramid_grid}  # fmt: skip
every_grid = pytest.mark.parametrize("make", GRIDS.values(), ids=list(GRIDS))


def shaken(of, amount=0.3, seed=0):
    """A mesh whose free vertices were moved, by a part of the least edge at most."""
    points = of.points.copy()
    free = ~cast_any(of).fixed
    edges = [points[b.cells[:, j]] - points[b.cells[:, i]]
             for b in of.blocks for i, j in FAMILIES[b.type].edges]  # fmt: skip
    least = np.linalg.norm(np.concatenate(edges), axis=1).min()
    by = np.random.default_rng(seed).uniform(-1, 1, points[free].shape)
    points[free] += amount * least * by / np.sqrt(points.shape[1])
    return Mesh(points, of.blocks)


def run(tmp_path, one, *options, suffix=".vtu", status=0):
    """The mesh that comes of one, and the report."""
    source, out = write(tmp_path / f"in{suffix}", one), tmp_path / f"out{suffix}"
    report = tmp_path / "report.json"
    ask = ["optimize", source, out, "-q", "--report", report, *options]
    assert status_of([str(word) for word in ask]) == status
    return (formats.read(out)[0], strict(report.read_text())) if status == 0 else None


def least_jacobian(one):
    part = measurable(one)
    return [MEASURES["scaled-jacobian"].of(part.points, c, f).max() for f, c in part.cells.items()]


@every_grid
@pytest.mark.parametrize("preset", ["fast", "standard", "best"])
def test_shaken_cells_get_better_and_all_else_stays(tmp_path, make, preset):
    one = shaken(make(4))
    assert check(one).is_valid
    result, report = run(tmp_path, one, "--preset", preset)
    assert check(result).is_valid
    assert report["after"]["worst"] < report["before"]["worst"]
    assert max(least_jacobian(result)) < max(least_jacobian(one))
    for before, after in zip(one.blocks, result.blocks, strict=True):
        assert after.type == before.type
        assert len(after.cells) <= len(before.cells)
        if one.dimension() == 3:
            assert np.array_equal(after.cells, before.cells)
    fixed = cast_any(one).fixed
    width = one.points.shape[1]
    assert np.array_equal(result.points[fixed][:, :width], one.points[fixed])
    assert set(report["after"]["families"] or {b.type for b in one.blocks}) == {
        b.type for b in one.blocks
    }


@every_grid
def test_a_tangle_is_undone(tmp_path, make):
    one = thrown(make(3), seed=1)
    assert not check(one).is_valid
    result, report = run(tmp_path, one)
    assert check(result).is_valid
    assert report["before"]["invalid"] > 0
    assert report["after"]["invalid"] == 0


@every_grid
def test_a_second_run_leaves_it_as_it_is(tmp_path, make):
    once, _ = run(tmp_path, shaken(make(4)))
    twice, report = run(tmp_path, once)
    assert report["stopped"] == "nothing to gain"
    assert np.array_equal(once.points, twice.points)


@every_grid
def test_the_same_bytes_twice(tmp_path, make):
    one = shaken(make(3))
    a, b = (run(tmp_path / name, one)[0] for name in "ab" if not (tmp_path / name).mkdir())
    assert a.points.tobytes() == b.points.tobytes()


@pytest.mark.parametrize("suffix", [".vtu", ".vtk", ".msh", ".mesh", ".meshb"])
@pytest.mark.parametrize("make", [tri_quad_grid, pyramid_grid])
def test_every_format_carries_them(tmp_path, make, suffix):
    one = shaken(make(2))
    for k, block in enumerate(one.blocks):
        block.data["medit:ref" if suffix.startswith(".mesh") else "part"] = np.full(
            len(block.cells), k + 1
        )
    one.point_data["height"] = one.points[:, 0].copy() if suffix.startswith(".vt") else None
    if one.point_data["height"] is None:
        one.point_data = {}
    result, _ = run(tmp_path, one, suffix=suffix)
    assert {b.type: len(b.cells) for b in result.blocks} == {
        b.type: len(b.cells) for b in one.blocks
    }
    assert check(result).is_valid


def test_arrays_on_points_are_those_of_the_places_they_come_to(tmp_path):
    one = shaken(hex_grid(4))
    one.point_data["x"] = one.points[:, 0].copy()
    result, _ = run(tmp_path, one)
    assert result.point_data["x"] == pytest.approx(result.points[:, 0], abs=1e-6)
    region = (np.arange(64) > 31).astype(np.int64)
    one.blocks[0].data |= {"part": region, "load": np.random.default_rng(0).random(64)}
    bare, _ = run(tmp_path, one, "--no-data")
    assert bare.point_data == {}
    assert set(bare.blocks[0].data) == {"part"}


def test_interfaces_between_regions_stay(tmp_path):
    one = shaken(hex_grid(4))
    region = (one.points[one.blocks[0].cells].mean(axis=1)[:, 0] > 0.5).astype(np.int64)
    one.blocks[0].data["part"] = region
    result, report = run(tmp_path, one)
    sides = [set(one.blocks[0].cells[region == k].ravel().tolist()) for k in (0, 1)]
    shared = sorted(sides[0] & sides[1])
    assert np.array_equal(result.points[shared], one.points[shared])
    assert report["regions"]["count"] == 2


@pytest.mark.parametrize("plane", ["xz", "tilted", "mirrored"])
def test_a_plane_may_lie_anywhere(tmp_path, plane):
    flat = in_space(shaken(quad_grid(4)))
    tilted, _ = np.linalg.qr(np.arange(9).reshape(3, 3) ** 2 + np.eye(3))
    turns = {"xz": np.eye(3)[[0, 2, 1]], "mirrored": np.diag([1.0, -1.0, -1.0]), "tilted": tilted}
    one = Mesh(flat.points @ turns[plane], flat.blocks)
    result, report = run(tmp_path, one)
    assert report["after"]["worst"] < report["before"]["worst"]
    normal = np.cross(one.points[-1] - one.points[0], one.points[4] - one.points[0])
    heights = (result.points - one.points[0]) @ normal
    assert heights == pytest.approx(np.zeros(len(heights)), abs=1e-12)


def test_what_is_for_other_cells_is_left_out_and_said(tmp_path, capsys):
    path = write(tmp_path / "in.vtu", shaken(quad_grid(4)))
    ask = ["optimize", path, tmp_path / "out.vtu", "--passes", "odt,smooth,split", "--json"]
    assert status_of([str(word) for word in ask]) == 0
    value = json.loads(capsys.readouterr().out)
    assert value["left_out"] == ["odt", "split"]
    assert {line["name"] for line in value["passes"]} == {"smooth"}
    assert value["measure"] == "scaled-jacobian"


@pytest.mark.parametrize("measure", ["aspect-ratio", "volume-length", "radius-ratio", "mean-edge"])
@pytest.mark.parametrize("make", [tri_quad_grid, pyramid_grid])
def test_other_measures_steer_too(tmp_path, make, measure):
    _, report = run(tmp_path, shaken(make(3)), "--measure", measure)
    assert report["measure"] == measure
    assert report["after"]["worst"] < report["before"]["worst"]


@pytest.mark.parametrize(
    ("options", "status", "said"),
    [
        (["--measure", "angle-min"], 2, "cannot steer quads"),
        (["--measure", "worst-simplex"], 2, "cannot steer"),
        (["--boundary", "slide"], 3, "is for meshes of triangles or tetrahedra alone"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, capsys, options, status, said):
    run(tmp_path, quad_grid(3), *options, status=status)
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out.vtu").exists()


def test_cells_listed_the_other_way_round_are_turned(tmp_path):
    one = shaken(hex_grid(3))
    one.blocks[0].cells = one.blocks[0].cells[:, [4, 5, 6, 7, 0, 1, 2, 3]]
    result, report = run(tmp_path, one)
    assert check(result).is_valid
    assert report["after"]["invalid"] == 0


def test_a_surface_of_quads_is_refused(tmp_path, capsys):
    cube = hex_grid(1)
    quads = cube.blocks[0].cells[0][np.concatenate(FAMILIES["hexahedron"].facets)]
    run(tmp_path, mesh(cube.points, quad=quads), status=3)
    assert "do not lie in one plane" in capsys.readouterr().err


def test_triangles_alone_stay_with_the_passes_for_them(tmp_path):
    flat = tri_grid(6)
    _, report = run(tmp_path, flat)
    assert report["measure"] == "aspect-ratio"
    assert report["left_out"] == []


@every_grid
def test_the_report_tells_what_was_done_to_which_cells(tmp_path, make):
    one = shaken(make(4))
    _, report = run(tmp_path, one, "--passes", "smooth,swap,check", "--rounds", "1")
    kinds = {line["name"]: line["kinds"] for line in report["passes"]}
    assert kinds["check"] == {}
    assert set(kinds["smooth"]["moved"]) <= {block.type for block in one.blocks}
    part = cast_any(one)
    for group in part.cell_sets:
        free = np.unique(group.cells[~part.fixed[group.cells]])
        assert 0 < kinds["smooth"]["moved"][group.family] <= len(free)
    lines = [line for line in report["passes"] if line["name"] == "swap"]
    for line in lines:
        assert sum(line["kinds"].get("swapped", {}).values()) == line["applied"]
