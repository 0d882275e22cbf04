"""Whether two cells overlap: by arrays, compiled, and in rational arithmetic."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshopt_cli.mesh.sizes import contents
from meshopt_cli.validity import check, overlap
from meshopt_cli.validity.examination import Examination
from support.broken import CORNER, CUBE, PRISM, PYRAMID
from support.edits import shifted, together
from support.meshes import hex_grid, mesh, tet_grid, tri_grid

CELLS = {"tetra": CORNER, "hexahedron": CUBE, "wedge": PRISM, "pyramid": PYRAMID}
FAMILIES = st.sampled_from(list(CELLS))
SEEDS = st.integers(0, 2**32 - 1)
NOTHING = 1e-12


def pairs(families, seed, n=50):
    """Points, and pairs of cells in random places and of random shapes."""
    generator = np.random.default_rng(seed)
    points, rows = [], []
    for family in families:
        base = np.array(CELLS[family], dtype=float)
        for _ in range(n):
            change = np.linalg.qr(generator.normal(size=(3, 3)))[0] * generator.uniform(0.2, 1.0, 3)
            points.append(base @ change + generator.uniform(-0.7, 0.7, 3))
            first = sum(map(len, points[:-1]))
            rows.append(np.arange(first, first + len(base)))
    return np.concatenate(points), np.array(rows[:n]), np.array(rows[n:])


def tables(families):
    return overlap.axes_of(families[0]), overlap.axes_of(families[1])


def by_arrays(points, one, other, limit, families):
    columns = overlap._columns(points, one), overlap._columns(points, other)
    return overlap._not_separated(*columns, limit, tables(families))[0]


@settings(max_examples=25, deadline=None)
@given(FAMILIES, FAMILIES, SEEDS)
def test_compiled_code_and_arrays_agree(first, second, seed):
    families = (first, second)
    points, one, other = pairs(families, seed)
    limit = np.full(len(one), NOTHING)
    depth = overlap._compiled_depths(points, one, other, limit, tables(families))
    np.testing.assert_array_equal(
        np.flatnonzero(depth > limit), by_arrays(points, one, other, limit, families)
    )


@settings(max_examples=10, deadline=None)
@given(FAMILIES, FAMILIES, SEEDS)
def test_rational_arithmetic_agrees(first, second, seed):
    families = (first, second)
    points, one, other = pairs(families, seed, 8)
    left = by_arrays(points, one, other, np.full(len(one), NOTHING), families)
    apart = [
        overlap.exactly_separated(points[a].T, points[b].T, tables(families))
        for a, b in zip(one, other, strict=True)
    ]
    np.testing.assert_array_equal(np.flatnonzero(~np.array(apart)), left)


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_points_inside_both_tell_that_tets_overlap(seed):
    points, one, other = pairs(("tetra", "tetra"), seed, 20)
    left = set(by_arrays(points, one, other, np.full(20, NOTHING), ("tetra", "tetra")).tolist())
    weights = np.random.default_rng(seed).dirichlet(np.ones(4), 2000)
    for pair in range(20):
        inside = weights @ points[one[pair]]
        corners = points[other[pair]]
        at = np.linalg.solve((corners[1:] - corners[0]).T, (inside - corners[0]).T)
        if ((at > 1e-9).all(axis=0) & (at.sum(axis=0) < 1 - 1e-9)).any():
            assert pair in left


def test_arithmetic_is_exact_where_floating_point_is_not():
    # Two tets on different sides of a plane that no rounded normal fits.
    a, b, c = np.array([[0.1, 0.7, 0.3], [1e6, 0.2, 0.9], [0.4, 1e6, 0.6]])
    up, down = np.array([0.3, 0.3, 1e6]), np.array([0.2, 0.2, -1e6])
    one, other = np.stack([a, b, c, up]), np.stack([a, c, b, down])
    assert overlap.exactly_separated(one.T, other.T, tables(("tetra", "tetra")))
    deeper = other.copy()
    deeper[0, 2] = np.nextafter(np.nextafter(a[2], 1), 1)
    assert not overlap.exactly_separated(one.T, deeper.T, tables(("tetra", "tetra")))


@pytest.mark.parametrize("grid", [tet_grid(3), hex_grid(3), tri_grid(4)])
@pytest.mark.parametrize("by", [1e-3, 0.05, 1 / 3])
def test_a_shifted_copy_overlaps(grid, by):
    shift = np.full(grid.points.shape[1], by)
    assert "M209" in check(together(grid, shifted(grid, *shift))).codes


@pytest.mark.parametrize("grid", [tet_grid(2), hex_grid(2), tri_grid(2)])
@pytest.mark.parametrize("gap", [0, 1e-12, 1e-3])
def test_parts_side_by_side_do_not(grid, gap):
    shift = np.zeros(grid.points.shape[1])
    shift[0] = 1 + gap
    assert "M209" not in check(together(grid, shifted(grid, *shift))).codes


def test_many_cells_take_the_compiled_way(monkeypatch):
    of = together(tet_grid(3), shifted(tet_grid(3), 0.1, 0.2, 0.3))
    by_hand = overlap.overlapping_cells(Examination(of))
    called = []
    compiled = overlap._compiled_depths
    monkeypatch.setattr(overlap, "MANY", 1)
    monkeypatch.setattr(
        overlap, "_compiled_depths", lambda *given: called.append(1) or compiled(*given)
    )
    np.testing.assert_array_equal(overlap.overlapping_cells(Examination(of)), by_hand)
    assert called


def test_large_facets_among_small_cells():
    big = mesh(CORNER * 20.0 - 5.0, tetra=[[0, 1, 2, 3]])
    assert "M209" in check(together(tet_grid(2), big)).codes


@pytest.mark.parametrize("family", CELLS)
def test_parts_of_a_cell_fill_it(family):
    points = np.array(CELLS[family], dtype=float)
    cells = np.arange(len(points))[None]
    tets = overlap._divided(points, cells, family)[0]
    volume = np.linalg.det(tets[:, 1:] - tets[:, :1]) / 6
    assert (volume < 0).all() or (volume > 0).all()
    assert abs(volume).sum() == pytest.approx(contents(points, cells, family)[0])
