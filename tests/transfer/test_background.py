"""The metric of the input between its vertices."""

import numpy as np
import pytest

from meshopt_cli.mesh.cast import cast
from meshopt_cli.metric.field import Metric, components, matrices
from meshopt_cli.metric.formula import formula_of
from meshopt_cli.transfer.background import MetricOfInput
from support.edits import shaken, transformed
from support.meshes import in_space, tet_grid, tri_grid
from support.metrics import random_tensors

GRIDS = [pytest.param(tri_grid, id="plane"), pytest.param(tet_grid, id="space")]


def places(part, n=40, seed=0):
    """Points in cells: which, with which weights, and where."""
    generator = np.random.default_rng(seed)
    rows = generator.integers(len(part.cells), size=n)
    weights = generator.dirichlet(np.ones(part.cells.shape[1]), size=n)
    return rows, weights, np.einsum("nk,nki->ni", weights, part.points[part.cells[rows]])


@pytest.mark.parametrize("make", GRIDS)
def test_sizes_are_linear_in_cells(make):
    part = cast(shaken(make(3)))
    h = 0.1 + np.random.default_rng(1).random(len(part.points))
    background = MetricOfInput(part, Metric(h[:, None], "h"))
    rows, weights, points = places(part)
    found = background.values_at(points, part.region[rows])
    expected = np.einsum("nk,nk->n", weights, h[part.cells[rows]])
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-9)
    assert background.is_isotropic
    np.testing.assert_allclose(background.at(points, part.region[rows])[:, 0], expected**-2)


@pytest.mark.parametrize("make", GRIDS)
def test_logarithms_of_tensors_are_linear_in_cells(make):
    part = cast(shaken(make(3)))
    d = part.cells.shape[1] - 1
    tensors = random_tensors(d, len(part.points), 0.5)
    background = MetricOfInput(part, Metric(components(tensors), "M"))
    rows, weights, points = places(part)
    found = matrices(background.values_at(points, part.region[rows]))
    values, axes = np.linalg.eigh(tensors)
    logarithms = np.einsum("nij,nj,nkj->nik", axes, np.log(values), axes)
    mean = np.einsum("nk,nkij->nij", weights, logarithms[part.cells[rows]])
    values, axes = np.linalg.eigh(found)
    again = np.einsum("nij,nj,nkj->nik", axes, np.log(values), axes)
    np.testing.assert_allclose(again, mean, atol=1e-8)
    assert not background.is_isotropic


def test_a_formula_is_exact_everywhere():
    part = cast(tri_grid(3))
    formula = formula_of("0.1 + x*x")
    h = formula.at(part.points)[:, None]
    background = MetricOfInput(part, Metric(h, "f"), formula)
    rows, _, points = places(part)
    found = background.values_at(points, part.region[rows])[:, 0]
    np.testing.assert_allclose(found, 0.1 + points[:, 0] ** 2, rtol=1e-12)


def test_tensors_turn_with_the_plane():
    """Lengths of edges are the same in the plane of an inclined mesh and in space."""
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    flat = in_space(shaken(tri_grid(4)))
    one = transformed(flat, lambda points: points @ turn.T)
    part = cast(one)
    tensors = random_tensors(3, len(one.points), 0.4)
    background = MetricOfInput(part, Metric(components(tensors), "M"))
    rows = background.at_points
    np.testing.assert_array_equal(rows[:, 3:], np.tile([0.0, 0.0, 1.0], (len(rows), 1)))
    for a, b in part.cells[:, :2]:
        e, flat_e = one.points[b] - one.points[a], part.points[b] - part.points[a]
        expected = e @ tensors[a] @ e
        x, y, _ = flat_e
        xx, xy, yy = rows[a, :3]
        assert xx * x * x + 2 * xy * x * y + yy * y * y == pytest.approx(expected, rel=1e-9)


def test_tensors_that_are_the_same_in_all_directions_change_no_shape():
    part = cast(tri_grid(2))
    tensors = np.eye(2) * (1.0 + np.arange(len(part.points)))[:, None, None]
    assert MetricOfInput(part, Metric(components(tensors), "M")).is_isotropic
