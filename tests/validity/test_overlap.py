"""Whether two cells overlap: by arrays, compiled, and in rational arithmetic."""

import contextlib

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.kernels.search import separate
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check, overlap
from meshopt_cli.validity.examination import Examination
from support.broken import CORNER, CUBE, PRISM, PYRAMID
from support.edits import shifted, together
from support.meshes import hex_grid, mesh, tet_grid, tri_grid
from support.settings import examples

CELLS = {"tetra": CORNER, "hexahedron": CUBE, "wedge": PRISM, "pyramid": PYRAMID}
FAMILIES = st.sampled_from(list(CELLS))
SEEDS = st.integers(0, 2**32 - 1)
APART = 9.0  # from pair to pair, wider than any


def pairs(families, seed, n=50):
    """Corners of pairs of cells of random shapes that lie near each other, (n, k, 3) each."""
    generator = np.random.default_rng(seed)
    both = []
    for family in families:
        cells = np.empty((n, len(CELLS[family]), 3))
        for cell in cells:
            change = np.linalg.qr(generator.normal(size=(3, 3)))[0] * generator.uniform(0.2, 1.0, 3)
            change *= np.sign(np.linalg.det(change))
            cell[:] = CELLS[family] @ change + generator.uniform(-0.7, 0.7, 3)
        both.append(cells)
    return both


def in_a_row(families, one, other):
    """A mesh of pairs of cells, each pair far from the next: first the ones, then the others."""
    shift = APART * np.arange(len(one))[:, None, None] * [1.0, 0.0, 0.0]
    points = [(cells + shift).reshape(-1, 3) for cells in (one, other)]
    first = np.arange(one.shape[0] * one.shape[1]).reshape(one.shape[:2])
    second = first.size + np.arange(other.shape[0] * other.shape[1]).reshape(other.shape[:2])
    blocks = [Block(f, cells) for f, cells in zip(families, (first, second), strict=True)]
    return Mesh(np.concatenate(points), blocks)


def overlapping(families, one, other):
    """Numbers of the pairs whose cells overlap."""
    later, earlier = overlap.overlapping_cells(Examination(in_a_row(families, one, other)))
    assert np.array_equal(later, earlier + len(one))
    return set(earlier.tolist())


@contextlib.contextmanager
def compiled():
    """Any number of cells is enough for compiled code to look at them; yields how often it did."""
    calls = []
    depths = separate.depths
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(overlap, "MANY", 1)
        patch.setattr(separate, "depths", lambda *given: calls.append(1) or depths(*given))
        yield calls


def shrunk(cells, by):
    middle = cells.mean(axis=1, keepdims=True)
    return middle + (1.0 - by) * (cells - middle)


def exactly(families, one, other):
    """The pairs that no plane separates, in rational arithmetic."""
    tables = overlap.axes_of(families[0]), overlap.axes_of(families[1])
    return {
        k for k, (a, b) in enumerate(zip(one, other, strict=True))
        if not overlap.exactly_separated(a.T, b.T, tables)
    }  # fmt: skip


@examples(15)
@given(FAMILIES, FAMILIES, SEEDS)
def test_compiled_code_and_arrays_agree(first, second, seed):
    families, cells = (first, second), pairs((first, second), seed)
    by_arrays = overlapping(families, *cells)
    with compiled() as calls:
        assert overlapping(families, *cells) == by_arrays
    assert calls
    assert by_arrays


@examples(10)
@given(FAMILIES, FAMILIES, SEEDS)
def test_rational_arithmetic_agrees(first, second, seed):
    """But where cells with warped faces could be no deeper in each other than their warp."""
    families, cells = (first, second), pairs((first, second), seed, 8)
    found = overlapping(families, *cells)
    assert found <= exactly(families, *cells)
    by = 0.0 if first == second == "tetra" else 0.02
    assert exactly(families, *(shrunk(c, by) for c in cells)) <= found


@examples(25)
@given(SEEDS)
def test_points_inside_both_tell_that_tets_overlap(seed):
    one, other = pairs(("tetra", "tetra"), seed, 20)
    weights = np.random.default_rng(seed).dirichlet(np.ones(4), 2000)
    shared = set()
    for pair, (a, b) in enumerate(zip(one, other, strict=True)):
        at = np.linalg.solve((b[1:] - b[0]).T, (weights @ a - b[0]).T)
        if ((at > 1e-9).all(axis=0) & (at.sum(axis=0) < 1 - 1e-9)).any():
            shared.add(pair)
    assume(shared)
    assert shared <= overlapping(("tetra", "tetra"), one, other)


def test_arithmetic_is_exact_where_floating_point_is_not():
    # Two tets on different sides of a plane that no rounded normal fits.
    a, b, c = np.array([[0.1, 0.7, 0.3], [1e6, 0.2, 0.9], [0.4, 1e6, 0.6]])
    up, down = np.array([0.3, 0.3, 1e6]), np.array([0.2, 0.2, -1e6])
    tables = (overlap.axes_of("tetra"),) * 2
    one, other = np.stack([a, b, c, up]), np.stack([a, c, b, down])
    assert overlap.exactly_separated(one.T, other.T, tables)
    deeper = other.copy()
    deeper[0, 2] = np.nextafter(np.nextafter(a[2], 1), 1)
    assert not overlap.exactly_separated(one.T, deeper.T, tables)


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


def test_many_cells_take_the_compiled_way():
    of = together(tet_grid(3), shifted(tet_grid(3), 0.1, 0.2, 0.3))
    by_hand = overlap.overlapping_cells(Examination(of))
    with compiled() as calls:
        np.testing.assert_array_equal(overlap.overlapping_cells(Examination(of)), by_hand)
    assert calls


def test_large_facets_among_small_cells():
    big = mesh(CORNER * 20.0 - 5.0, tetra=[[0, 1, 2, 3]])
    assert "M209" in check(together(tet_grid(2), big)).codes


@pytest.mark.parametrize("family", CELLS)
def test_no_place_inside_a_cell_is_overlooked(family):
    """A small tet overlaps the cell that it lies in, wherever it lies there."""
    n = 60
    generator = np.random.default_rng(3)
    cell = np.array(CELLS[family], dtype=float)
    places = generator.dirichlet(np.ones(len(cell)), n) @ shrunk(cell[None], 0.05)[0]
    small = 0.02 * (CORNER - 0.25) + places[:, None]
    cells = np.broadcast_to(cell, (n, *cell.shape))
    assert overlapping((family, "tetra"), cells, small) == set(range(n))
