"""One change to a valid mesh, at random: a rule names it, whatever the change."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from support.edits import inside, shaken, with_cells
from support.meshes import hex_grid, quad_grid, tet_grid, tri_grid
from support.settings import examples

N = 4
GRIDS = {"tetra": tet_grid(N), "triangle": tri_grid(N), "hexahedron": hex_grid(N),
         "quad": quad_grid(N)}  # fmt: skip
SIMPLICES = ("tetra", "triangle")
PARTS = {"tetra": tet_grid(1), "triangle": tri_grid(1)}
FACETS = {
    "tetra": [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]],
    "triangle": [[1, 2], [2, 0], [0, 1]],
}
# A change of order that turns a cell over, and that leaves a valid cell but for its sign.
FLIPS = {"tetra": [1, 0, 2, 3], "triangle": [1, 0, 2], "quad": [3, 2, 1, 0],
         "hexahedron": [4, 5, 6, 7, 0, 1, 2, 3]}  # fmt: skip

kinds = st.sampled_from(list(GRIDS))
simplices = st.sampled_from(SIMPLICES)
seeds = st.integers(0, 2**32 - 1)
many = examples(40)


def little_shaken(kind, seed):
    return shaken(GRIDS[kind], 0.1, seed)


def codes(of):
    return set(check(of).codes)


def boundary_of(of, kind):
    """The boundary of a grid of simplices, with the boundary declared as a file may do it."""
    cells = of.blocks[0].cells
    facets = cells[:, FACETS[kind]].reshape(-1, len(FACETS[kind][0]))
    _, first, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    name = {"tetra": "triangle", "triangle": "line"}[kind]
    return Mesh(of.points, [Block(name, facets[first[count == 1]]), *of.blocks])


@pytest.mark.parametrize("kind", list(GRIDS))
def test_what_is_mutated_is_valid(kind):
    assert codes(little_shaken(kind, 0)) == set()
    if kind in SIMPLICES:
        assert codes(boundary_of(little_shaken(kind, 0), kind)) == set()


@many
@given(kinds, seeds, st.data())
def test_a_cell_turned_over_is_inverted(kind, seed, data):
    of = little_shaken(kind, seed)
    cells = of.blocks[0].cells.copy()
    row = data.draw(st.integers(0, len(cells) - 1))
    cells[row] = cells[row][FLIPS[kind]]
    assert codes(with_cells(of, cells)) == {"M101"}


@many
@given(kinds, seeds, st.data())
def test_a_doubled_cell_is_a_duplicate(kind, seed, data):
    of = little_shaken(kind, seed)
    cells = of.blocks[0].cells
    row = data.draw(st.integers(0, len(cells) - 1))
    assert "M201" in codes(with_cells(of, np.concatenate([cells, cells[[row]]])))


@many
@given(kinds, seeds, st.data())
def test_a_deleted_cell_inside_is_missing(kind, seed, data):
    of = little_shaken(kind, seed)
    inner = inside(of)
    cells = of.blocks[0].cells
    n_outer = (~inner[cells]).sum(axis=1)
    # Without a facet in the boundary: too few of its vertices lie there.
    rows = np.flatnonzero(n_outer < (2 if kind in ("triangle", "quad") else 3))
    row = rows[data.draw(st.integers(0, len(rows) - 1))]
    assert codes(with_cells(of, np.delete(cells, row, axis=0))) == {"M211"}


@many
@given(simplices, seeds, st.data())
def test_a_deleted_cell_leaves_what_is_declared(kind, seed, data):
    of = boundary_of(little_shaken(kind, seed), kind)
    cells = of.blocks[1].cells
    row = data.draw(st.integers(0, len(cells) - 1))
    found = codes(Mesh(of.points, [of.blocks[0], Block(kind, np.delete(cells, row, axis=0))]))
    assert found & {"M208", "M211"}


@many
@given(kinds, seeds, st.data())
def test_a_point_far_out_of_its_ball_inverts_cells(kind, seed, data):
    of = little_shaken(kind, seed)
    inner = inside(of)
    vertex = data.draw(st.sampled_from(np.flatnonzero(inner).tolist()))
    direction = data.draw(st.sampled_from([-1.0, 1.0]))
    points = of.points.copy()
    points[vertex] += direction * 2.5 / N
    found = codes(Mesh(points, of.blocks))
    assert found & {"M101", "M104"}


@many
@given(kinds, seeds, st.data())
def test_a_vertex_with_another_number_is_caught(kind, seed, data):
    of = little_shaken(kind, seed)
    cells = of.blocks[0].cells.copy()
    row = data.draw(st.integers(0, len(cells) - 1))
    place = data.draw(st.integers(0, cells.shape[1] - 1))
    number = data.draw(st.integers(0, len(of.points) - 1))
    assume(number not in cells[row])
    cells[row, place] = number
    assert not check(with_cells(of, cells)).is_valid


@many
@given(simplices, seeds, st.data())
def test_a_point_split_in_two_is_a_crack(kind, seed, data):
    of = little_shaken(kind, seed)
    inner = inside(of)
    cells = of.blocks[0].cells.copy()
    vertex = data.draw(st.sampled_from(np.flatnonzero(inner).tolist()))
    ball = np.flatnonzero((cells == vertex).any(axis=1))
    n = data.draw(st.integers(1, len(ball) - 1))
    torn = ball[:n]
    cells[torn] = np.where(cells[torn] == vertex, len(of.points), cells[torn])
    points = np.concatenate([of.points, of.points[[vertex]]])
    found = codes(Mesh(points, [Block(kind, cells)]))
    assert {"M202", "M205"} <= found


@many
@given(simplices, seeds, st.data())
def test_cells_of_a_tangle_turned_positive_are_not_valid(kind, seed, data):
    of = little_shaken(kind, seed)
    inner = inside(of)
    vertex = data.draw(st.sampled_from(np.flatnonzero(inner).tolist()))
    points = of.points.copy()
    points[vertex] += data.draw(st.sampled_from([-1.3, 1.3, 1.7])) / N
    cells = of.blocks[0].cells.copy()
    corners = points[cells]
    negative = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    assume(negative.any())
    cells[negative] = cells[negative][:, FLIPS[kind]]
    found = codes(Mesh(points, [Block(kind, cells)]))
    assert found & {"M207", "M102", "M202", "M205"}
    if not found & {"M102", "M202", "M205"}:
        assert {"M207", "M209"} <= found


@many
@given(simplices, seeds, st.lists(st.floats(0.0, 0.5), min_size=3, max_size=3))
def test_a_second_mesh_across_the_first_overlaps_it(kind, seed, by):
    """Wherever a part of another grid lies in the first one."""
    of, part = little_shaken(kind, seed), PARTS[kind]
    both = np.concatenate([of.points, 0.4 * part.points + 0.013 + by[: of.points.shape[1]]])
    cells = np.concatenate([of.blocks[0].cells, part.blocks[0].cells + len(of.points)])
    assert "M209" in codes(Mesh(both, [Block(kind, cells)]))
