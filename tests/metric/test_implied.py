"""The metric of a mesh itself."""

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.metric.domain import domain_of
from meshopt_cli.metric.field import Metric, fitted, require_definite
from meshopt_cli.metric.implied import implied
from support.edits import shaken
from support.meshes import mesh, octahedron, tet_grid, tri_grid
from support.metrics import judged


def of(one):
    domain = domain_of(one)
    return implied(domain.points, domain.cells, domain.is_flat)


@pytest.mark.parametrize("family", [f for f in FAMILIES if FAMILIES[f].dimension >= 2])
def test_a_cell_is_optimal_in_its_own_metric(family):
    """Wherever a linear map takes the ideal cell."""
    row = FAMILIES[family]
    matrix = np.eye(3)
    matrix[: row.dimension, : row.dimension] += np.array(
        [[1.0, 0.4, 0.2], [-0.3, 0.5, 0.1], [0.2, 0.6, 2.0]]
    )[: row.dimension, : row.dimension]
    one = mesh(row.reference @ matrix.T, **{family: [list(range(row.n_corners))]})
    told = judged(one, of(one))
    assert told.optimal[family] == pytest.approx([0.0], abs=1e-9)
    assert told.quality[family] == pytest.approx([1.0])
    assert told.summary.n_unit == pytest.approx(1.0)


@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_the_mean_is_of_the_logarithms(make):
    """Of the cells at a vertex, each with its own metric, all of which count alike."""
    one = shaken(make(2))
    cells = one.blocks[0].cells
    alone = [of(mesh(one.points[c], **{one.blocks[0].type: [list(range(len(c)))]})) for c in cells]
    metric = of(one)
    for v in range(len(one.points)):
        at = [metric.logarithms[0] for metric, c in zip(alone, cells, strict=True) if v in c]
        assert metric.logarithms[v] == pytest.approx(np.mean(at, axis=0), abs=1e-9)


def test_a_mesh_is_better_in_its_own_metric_than_plainly():
    one = shaken(tet_grid(3))
    one.points *= [1.0, 10.0, 0.1]
    n = len(one.points)
    own, plain = (judged(one, m).summary for m in (of(one), Metric(np.ones((n, 1)), "")))
    assert own.edges.tau > 0.9
    assert own.mean < plain.mean
    assert own.n_unit == pytest.approx(own.n_cells, rel=0.2)


def test_a_surface_has_one_too():
    metric = of(octahedron())
    assert metric.width == 3
    assert judged(octahedron(), metric).summary.edges.tau == pytest.approx(1.0, abs=0.05)


def test_flat_cells_count_for_nothing():
    points = [[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [0.5, 0.0]]
    metric = of(mesh(points, triangle=[[0, 1, 2], [0, 1, 3]]))
    assert metric.values[:3] == pytest.approx(np.tile([1.0, 0.0, 1.0], (3, 1)), abs=1e-12)
    assert np.isnan(metric.values[3]).all()  # which from_array refuses by its number


def test_it_is_definite_where_cells_are_stretched():
    one = tri_grid(3)
    one.points *= [1.0, 1e-6]
    metric = fitted(of(one), domain_of(one).is_flat)
    assert require_definite(metric, domain_of(one).used) is metric
