"""Meshes of other libraries: all that they hold goes in and comes back."""

import meshio
import numpy as np
import pytest
import pyvista

import meshopt_cli as meshopt
from support.edits import shaken
from support.meshes import quad_grid, tet_grid, tri_grid


def tets():
    mesh = shaken(tet_grid(4), 0.3, 1)
    return mesh.points, np.concatenate([b.cells for b in mesh.blocks if b.type == "tetra"])


def with_tags():
    points, cells = tets()
    high = points[cells].mean(axis=1)[:, 2] > np.median(points[:, 2])
    order = np.argsort(high, kind="stable")
    cells, high = cells[order], high[order]
    x = points[:, 0]
    return meshio.Mesh(
        points, {"tetra": cells}, {"x": x}, {"gmsh:physical": [high.astype(int) + 1]},
        field_data={"low": np.array([1, 3]), "high": np.array([2, 3])},
        cell_sets={"upper": [np.flatnonzero(high)]},
        point_sets={"left": np.flatnonzero(x == x.min())},
    )  # fmt: skip


def volumes(points, cells):
    p = points[cells]
    return np.abs(np.einsum("ij,ij->i", p[:, 1] - p[:, 0],
                            np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 0]))) / 6  # fmt: skip


def test_sets_names_and_arrays_of_meshio_come_back():
    given = with_tags()
    made = meshopt.optimize(given).mesh
    assert {n: list(v) for n, v in made.field_data.items()} == {"low": [1, 3], "high": [2, 3]}
    assert np.allclose(made.point_data["x"], made.points[:, 0])
    left = made.point_sets["left"]
    assert (made.points[left, 0] == made.points[:, 0].min()).all()
    assert len(left) == len(given.point_sets["left"])
    for mesh in (given, made):
        parts = zip(mesh.cells, mesh.cell_sets["upper"], mesh.cell_data["gmsh:physical"],
                    strict=True)  # fmt: skip
        found = 0.0
        for block, rows, tags in parts:
            assert np.array_equal(rows, np.flatnonzero(tags == 2))
            found += volumes(mesh.points, block.data[rows]).sum()
        mesh.info = found
    assert np.isclose(given.info, made.info)
    assert set(made.cell_data) == {"gmsh:physical"}
    assert set(made.point_data) == {"x"}


def test_sets_of_meshio_stay_with_their_vertices():
    """Also of those that move: what a set has is its vertices, not its places."""
    points, cells = tets()
    inner = np.flatnonzero(((points > points.min(0)) & (points < points.max(0))).all(axis=1))
    given = meshio.Mesh(points, {"tetra": cells}, point_sets={"some": inner[:5]})
    made = meshopt.optimize(given, passes="smooth").mesh
    assert np.array_equal(made.point_sets["some"], inner[:5])
    assert not np.array_equal(made.points[inner[:5]], points[inner[:5]])


def test_grids_of_pyvista_keep_their_arrays():
    points, cells = tets()
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: cells}, points)
    grid.point_data["x"] = points[:, 0]
    grid.cell_data["part"] = (np.arange(len(cells)) >= 0).astype(np.int32) * 7
    grid.field_data["time"] = [2.5]
    made = meshopt.optimize(grid).mesh
    assert np.allclose(made.point_data["x"], made.points[:, 0])
    assert (made.cell_data["part"] == 7).all()
    assert made.field_data["time"][0] == 2.5
    assert np.isclose(made.volume, grid.volume)
    assert grid.n_cells == len(cells)


def test_surfaces_of_pyvista_are_surfaces_still():
    mesh = shaken(tri_grid(5), 0.3, 1)
    points = np.pad(mesh.points, ((0, 0), (0, 3 - mesh.points.shape[1])))
    rows = np.concatenate([b.cells for b in mesh.blocks if b.type == "triangle"])
    surface = pyvista.PolyData.from_regular_faces(points, rows)
    surface.cell_data["tag"] = np.ones(len(rows), np.int32)
    made = meshopt.optimize(surface).mesh
    assert type(made) is pyvista.PolyData
    assert np.isclose(made.area, surface.area)
    assert made.is_all_triangles
    assert (made.cell_data["tag"] == 1).all()
    curved = pyvista.Sphere()
    assert meshopt.check(curved).is_valid
    assert meshopt.report(curved).worst >= 1.0
    with pytest.raises(meshopt.MeshoptError):
        meshopt.optimize(curved)


def test_quads_of_plain_arrays():
    mesh = shaken(quad_grid(4), 0.2, 1)
    rows = mesh.blocks[0].cells
    points, cells = meshopt.optimize((mesh.points[:, :2].copy(), rows)).mesh
    assert cells.shape[1] == 4
    assert points.shape[1] == 2


def test_lists_are_arrays():
    points = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert meshopt.check((points, [[0, 1, 2], [0, 2, 3]]))
    assert not meshopt.check((points, [[0, 1, 2], [0, 3, 2]]))


def test_other_data_sets_of_pyvista_are_named():
    with pytest.raises(meshopt.ReadError, match="cast_to_unstructured_grid"):
        meshopt.check(pyvista.ImageData(dimensions=(2, 2, 2)))


def test_the_accessor_comes_by_itself():
    points, cells = tets()
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: cells}, points)
    assert grid.meshopt.check()
    better = grid.meshopt.optimize()
    q, after = grid.meshopt.quality("aspect-ratio"), better.meshopt.quality()
    assert q.shape == (grid.n_cells,)
    assert after.max() < q.max()
    assert np.isclose(q.max(), grid.meshopt.report().worst)
    volume = grid.meshopt.quality("content")
    assert np.isclose(volume.sum(), grid.volume)


def test_quality_follows_the_cells_of_a_mixed_grid():
    """In their order, and NaN for what is of less dimension."""
    points, cells = tets()
    types = [("triangle", cells[:3, :3]), ("tetra", cells), ("line", cells[:2, :2])]
    q = meshopt.report((points, types)).quality()
    assert np.isnan(q[:3]).all()
    assert np.isnan(q[-2:]).all()
    assert np.isfinite(q[3:-2]).all()
