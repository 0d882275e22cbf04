"""Agreement with VTK's cell validator and mesh quality, cell by cell."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Mesh
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import check
from support.meshes import hex_grid, mesh, quad_grid, tet_grid, tri_grid
from support.settings import examples

pyvista = pytest.importorskip("pyvista")

VTK = {"triangle": 5, "quad": 9, "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14}
GRIDS = {"triangle": tri_grid(3), "quad": quad_grid(3), "tetra": tet_grid(3),
         "hexahedron": hex_grid(3)}  # fmt: skip
PRISM = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]
PYRAMID = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]
seeds = st.integers(0, 2**32 - 1)
strengths = st.sampled_from([0.05, 0.15, 0.25])


def to_vtk(of):
    points = np.zeros((len(of.points), 3))
    points[:, : of.points.shape[1]] = of.points
    return pyvista.UnstructuredGrid({VTK[b.type]: b.cells for b in of.blocks}, points)


def jumbled(kind, seed, strength):
    """A grid with every vertex moved, whatever becomes of the cells."""
    base = GRIDS[kind]
    by = np.random.default_rng(seed).uniform(-strength, strength, base.points.shape)
    return Mesh(base.points + by, base.blocks)


def cells_with(of, *codes):
    """Which cells a rule names."""
    named = np.zeros(len(of.blocks[0].cells), dtype=bool)
    for group in check(of, select=codes).groups:
        if group.places.cells is not None:
            rows = group.places.cells[:, 1]
            named[rows[rows >= 0]] = True
    return named


def turned_over(of):
    """Which cells of a plane have their normal below it: VTK knows no side of a cell."""
    return np.asarray(to_vtk(of).extract_surface(algorithm=None).face_normals)[:, 2] < 0


def quality(of, name):
    return np.asarray(to_vtk(of).cell_quality([name]).cell_data[name])


@examples(40)
@given(st.sampled_from(["tetra", "triangle"]), seeds, strengths)
def test_inverted_simplices(kind, seed, strength):
    of = jumbled(kind, seed, strength)
    jacobian = quality(of, "scaled_jacobian")
    if kind == "tetra":
        expected = jacobian < 0
        assert expected.any() or strength < 0.2
        np.testing.assert_array_equal(cells_with(of, "M101"), expected)
    else:
        np.testing.assert_array_equal(cells_with(of, "M101"), turned_over(of))


@examples(40)
@given(seeds, strengths)
def test_inverted_corners_of_hexahedra(seed, strength):
    of = jumbled("hexahedron", seed, strength)
    np.testing.assert_array_equal(
        cells_with(of, "M101", "M102"), quality(of, "scaled_jacobian") <= 0
    )


@examples(40)
@given(seeds, st.sampled_from([0.1, 0.2]))
@example(seed=1738885, strength=0.2)  # convex, and turned over
def test_quads_that_are_not_convex(seed, strength):
    of = jumbled("quad", seed, strength)
    found = to_vtk(of).cell_validator().cell_data["validity_state"]
    # Of the validator's bits: not convex, edges that intersect.
    crossed_or_not_convex = (np.asarray(found) & (0x10 | 0x02)) > 0
    expected = crossed_or_not_convex | (quality(of, "scaled_jacobian") < 0) | turned_over(of)
    np.testing.assert_array_equal(cells_with(of, "M101", "M104"), expected)


@pytest.mark.parametrize(
    ("of", "name"),
    [
        (mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 0]], tetra=[range(4)]), "volume"),
        (mesh([[0, 0], [1, 0], [3, 0]], triangle=[range(3)]), "area"),
        (mesh([[0, 0], [1, 0], [2, 0], [3, 0]], quad=[range(4)]), "area"),
        (mesh([[*p[:2], 0] for p in PRISM], wedge=[range(6)]), "volume"),
        (mesh([[*p[:2], 0] for p in PYRAMID], pyramid=[range(5)]), "volume"),
    ],
)
def test_flat_cells(of, name):
    assert quality(of, name) == pytest.approx(0, abs=1e-15)
    assert cells_with(of, "M102").all()


@examples(20)
@given(st.sampled_from(list(GRIDS)), seeds)
def test_contents_of_cells(kind, seed):
    of = jumbled(kind, seed, 0.05)
    points = np.zeros((len(of.points), 3))
    points[:, : of.points.shape[1]] = of.points
    content = MEASURES["content"].of(points, of.blocks[0].cells, kind)
    sizes = to_vtk(of).compute_cell_sizes()
    name = "Area" if kind in ("triangle", "quad") else "Volume"
    # VTK divides a quad, or the face of a hexahedron, along one of its diagonals.
    rough = 0.02 if kind == "hexahedron" else 1e-9
    np.testing.assert_allclose(content, np.abs(sizes.cell_data[name]), rtol=rough)


@examples(20)
@given(st.sampled_from(["triangle", "quad"]), seeds)
def test_angles_of_faces(kind, seed):
    of = jumbled(kind, seed, 0.05)
    points = np.column_stack([of.points, np.zeros(len(of.points))])
    for gate, name in (("corner-min", "min_angle"), ("corner-max", "max_angle")):
        ours = MEASURES[gate].of(points, of.blocks[0].cells, kind)
        np.testing.assert_allclose(ours, quality(of, name), rtol=1e-7)
