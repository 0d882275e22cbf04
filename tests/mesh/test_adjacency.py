"""Neighbours, boundary, edges and degrees of small meshes and of very many points."""

from __future__ import annotations

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.handles import DECLARED, INTERFACE, OUTER
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from support.invariants import volumes
from support.meshes import tet_grid, tri_grid
from support.settings import examples

GRIDS = {"triangles": tri_grid(4), "tets": tet_grid(3)}
MANY = 2**21 + 7  # three vertex numbers no longer fit one word

on_grids = pytest.mark.parametrize("name", GRIDS)


@given(st.lists(st.tuples(st.integers(-2, 2), st.integers(0, 1), st.integers(-1, 1))))
def test_distinct_rows_are_those_of_numpy(rows):
    rows = np.array(rows, dtype=np.int64).reshape(-1, 3)
    distinct, number, count = np.unique(rows, axis=0, return_inverse=True, return_counts=True)
    for ours, theirs in zip(
        adjacency.distinct_rows(rows), (distinct, number.ravel(), count), strict=True
    ):
        np.testing.assert_array_equal(ours, theirs)


def parts(name):
    """Cells of a grid, with one region, and the number of its points."""
    grid = GRIDS[name]
    cells = grid.blocks[0].cells
    return cells, np.zeros(len(cells), dtype=np.int64), len(grid.points)


def facet(cells, handle):
    """Vertices of a facet by its handle: all of the cell but the one opposite."""
    return frozenset(np.delete(cells[handle >> 2], handle & 3).tolist())


def facet_counts(cells):
    """How many cells have each facet, counted one by one."""
    width = cells.shape[1]
    return Counter(frozenset(f) for c in cells.tolist() for f in combinations(c, width - 1))


def assert_mutual(cells, beyond):
    """Whoever is a neighbour has one, and they have the same facet."""
    for cell, local in np.argwhere(beyond >= 0):
        handle = 4 * cell + local
        other = beyond[cell, local]
        assert beyond[other >> 2, other & 3] == handle
        assert facet(cells, handle) == facet(cells, other)


@on_grids
@pytest.mark.parametrize("n_points", [None, MANY], ids=["few points", "many points"])
def test_neighbours(name, n_points):
    """Neighbours are mutual, and there are none only where a facet has one cell."""
    cells, region, n = parts(name)
    beyond = adjacency.neighbours(cells, region, n_points or n)
    assert_mutual(cells, beyond)
    counts = facet_counts(cells)
    for cell, local in np.argwhere(beyond < 0):
        assert counts[facet(cells, 4 * cell + local)] == 1


@on_grids
def test_facets_face_outwards(name):
    """A facet and the vertex opposite make a positive cell."""
    source = cast(GRIDS[name])
    width = source.cells.shape[1]
    rows = adjacency.facets(source.cells)
    cells = np.column_stack([rows, source.cells.ravel()])
    assert len(rows) == width * len(source.cells)
    assert np.all(volumes(source.points, cells) > 0)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_boundary_of_a_cube(n):
    """A cube of n^3 cells shows 12 n^2 triangles, closed, which see 3 times its volume."""
    source = cast(tet_grid(n))
    assert len(source.skin) == 12 * n**2
    edges = Counter(frozenset(e) for f in source.skin.tolist() for e in combinations(f, 2))
    assert set(edges.values()) == {2}
    a, b, c = source.points[source.skin].transpose(1, 0, 2)
    inwards = np.einsum("ij,ij->", np.cross(b - a, c - a), a) / 2
    assert inwards == pytest.approx(-3)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_boundary_of_a_square(n):
    """A square of n^2 cells shows 4 n edges, of total length 4."""
    source = cast(tri_grid(n))
    ends = source.points[source.skin]
    assert len(source.skin) == 4 * n
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(4)


@on_grids
@examples(20)
@given(data=st.data())
def test_interfaces_are_boundary(name, data):
    """Between two regions there are no neighbours, inside of one there are."""
    cells, region, n = parts(name)
    region = np.array(
        data.draw(st.lists(st.integers(0, 2), min_size=len(cells), max_size=len(cells)))
    )
    beyond = adjacency.neighbours(cells, region, n)
    plain = adjacency.neighbours(cells, 0 * region, n)
    across = (plain >= 0) & (region[plain >> 2] != region[:, None])
    assert_mutual(cells, beyond)
    np.testing.assert_array_equal(beyond, np.where(across, INTERFACE, plain))


@on_grids
@pytest.mark.parametrize("n_points", [None, MANY], ids=["few points", "many points"])
def test_declared_facets_are_boundary(name, n_points):
    """A facet that the file declares cuts, whichever way round its vertices are."""
    cells, region, n = parts(name)
    n = n_points or n
    plain = adjacency.neighbours(cells, region, n)
    inside = np.flatnonzero(plain.ravel() >= 0)[::11]
    cuts = adjacency.facets(cells)[inside][:, ::-1]
    beyond = adjacency.neighbours(cells, region, n, cuts)
    assert_mutual(cells, beyond)
    cut = {frozenset(f) for f in cuts.tolist()}
    width = cells.shape[1]
    for row, (was, now) in enumerate(zip(plain.ravel(), beyond.ravel(), strict=True)):
        handle = 4 * (row // width) + row % width
        assert now == (DECLARED if facet(cells, handle) in cut else was)


@on_grids
def test_what_lies_beyond_is_named(name):
    """A facet that is declared between regions is an interface, one at the end is outer."""
    cells, _, n = parts(name)
    region = np.arange(len(cells)) % 2
    plain = adjacency.neighbours(cells, 0 * region, n)
    beyond = adjacency.neighbours(cells, region, n, adjacency.facets(cells))
    assert set(np.unique(plain[plain < 0])) == {OUTER}
    across = (plain >= 0) & (region[plain >> 2] != region[:, None])
    expected = np.where(plain < 0, OUTER, np.where(across, INTERFACE, DECLARED))
    np.testing.assert_array_equal(beyond, expected)


def test_facet_of_three_cells():
    """Cells that crowd at a facet are no neighbours there, nor is the facet outer."""
    cells = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    beyond = adjacency.neighbours(cells, np.zeros(3, dtype=int), 5)
    np.testing.assert_array_equal(beyond, [[OUTER, OUTER, INTERFACE]] * 3)


def test_lone_cell():
    cells = np.array([[0, 1, 2, 3]])
    beyond = adjacency.neighbours(cells, np.zeros(1, dtype=int), 4)
    assert beyond.tolist() == [[-1] * 4]
    assert len(adjacency.boundary_facets(cells, beyond)) == 4


@on_grids
def test_edges_and_degrees(name):
    """Every edge once, sorted; the degree counts them (Definition 18.7)."""
    cells, _, n = parts(name)
    edges = adjacency.edges(cells, n)
    expected = {tuple(sorted(e)) for c in cells.tolist() for e in combinations(c, 2)}
    assert [tuple(e) for e in edges.tolist()] == sorted(expected)
    degree = adjacency.degrees(cells, n)
    assert degree.sum() == 2 * len(edges)
    assert degree.tolist() == [sum(v in e for e in expected) for v in range(n)]


def test_degree_of_an_unused_point():
    assert adjacency.degrees(np.array([[0, 1, 2]]), 5).tolist() == [2, 2, 2, 0, 0]


@examples(50)
@given(
    width=st.sampled_from([1, 2, 3, 4]),
    n_points=st.sampled_from([9, 2**20, MANY, 2**30]),
    data=st.data(),
)
def test_row_ids(width, n_points, data):
    """Rows have the same number when they have the same vertices, with any count of points."""
    low = st.integers(0, 4)
    vertex = st.one_of(low, low.map(lambda v: n_points - 1 - v))
    row = st.lists(vertex, min_size=width, max_size=width)
    rows = np.array(data.draw(st.lists(row, min_size=1, max_size=40)))
    ids = adjacency.row_ids(rows, n_points)
    sets = [tuple(sorted(r)) for r in rows.tolist()]
    for i, j in combinations(range(len(rows)), 2):
        assert (ids[i] == ids[j]) == (sets[i] == sets[j])
    assert ids.dtype == np.int64
    assert np.all(ids >= 0)


@examples(50)
@given(st.lists(st.tuples(*[st.integers(0, 20)] * 3), min_size=1, max_size=40))
def test_keys_sort_as_rows_do(rows):
    """Keys are ordered as the sorted rows are."""
    rows = np.sort(np.array(rows), axis=1)
    keys = adjacency.row_keys(rows[:, ::-1], 21)
    np.testing.assert_array_equal(rows[np.argsort(keys)], rows[np.lexsort(rows.T[::-1])])


@given(st.lists(st.integers(0, 2**62), max_size=40), st.integers(0, 61))
def test_ascending_keeps_the_order_of_equal_numbers(numbers, shift):
    values = np.array(numbers, dtype=np.int64) >> shift
    np.testing.assert_array_equal(adjacency.ascending(values), np.argsort(values, kind="stable"))
