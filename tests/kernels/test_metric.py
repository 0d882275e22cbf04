"""Lengths and qualities in a metric, as the kernels see them."""

import numpy as np
import pytest

from meshopt_cli.compiled.decorators import entry
from meshopt_cli.kernels import judge as door
from meshopt_cli.kernels import metric
from meshopt_cli.kernels.gather import ball, star
from meshopt_cli.kernels.vectors import Vec
from meshopt_cli.metric.lengths import edge_lengths
from meshopt_cli.quality.measures import QUALITIES
from support.driven import layered, workspace_in
from support.edits import shaken
from support.invariants import workspace
from support.meshes import tet_grid, tri_grid
from support.metrics import of_matrices, random_tensors

GRIDS = [pytest.param(tri_grid, id="plane"), pytest.param(tet_grid, id="space")]


@entry
def lengths_of(points, edges, out):
    """`metric.length` of many edges."""
    for i in range(edges.shape[0]):
        out[i] = metric.length(points, edges[i, 0], edges[i, 1])


@entry
def there_and_back(points, i, v):
    """The square of a vector by M and by the map, and the vector mapped and taken back."""
    t = metric.root(metric.plus(metric.NO_TENSOR, points, i, 1.0))
    image = metric.mapped(t, v)
    square = image.x * image.x + image.y * image.y + image.z * image.z
    return metric.square_in(points, i, v), square, metric.unmapped(t, image)


@entry
def star_and_door(mesh, vertex, p, scratch, out):
    """q of the cells of a ball by its star, and by the door; their number."""
    n, _ = ball.gather_ball(mesh, vertex, scratch.ball, scratch)
    star.load_star(mesh, scratch.ball, n, scratch)
    star.measure_star(mesh, n, p, scratch)
    for i in range(n):
        out[i, 0] = scratch.values[i]
        out[i, 1] = door.q_with(mesh, scratch.ball[i], p)
    return n


@entry
def ideal_points(mesh, vertex, scratch, out):
    """The ideal points of a ball; their number."""
    n, _ = ball.gather_ball(mesh, vertex, scratch.ball, scratch)
    star.load_star(mesh, scratch.ball, n, scratch)
    star.star_heights(mesh, n, scratch)
    for i in range(n):
        p = star.ideal_point(mesh, i, scratch)
        out[i, 0] = p.x
        out[i, 1] = p.y
        out[i, 2] = p.z
    return n


def some(make, n=3, spread=0.5, seed=1):
    """A working mesh in a metric that differs from vertex to vertex."""
    one = shaken(make(n))
    return one, workspace_in(
        one, random_tensors(one.points.shape[1], len(one.points), spread, seed)
    )


@pytest.mark.parametrize("make", GRIDS)
def test_maps_have_the_lengths_of_the_metric(make):
    _, work = some(make)
    generator = np.random.default_rng(0)
    for i in range(len(work.mesh.points)):
        v = generator.normal(size=3) * ([1, 1, 0] if work.dimension == 2 else 1)
        square, mapped, back = there_and_back(work.mesh.points, i, Vec(*v))
        assert mapped == pytest.approx(square, rel=1e-9)
        np.testing.assert_allclose(back, v, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("make", GRIDS)
def test_lengths_are_those_of_the_report_where_the_metric_is_constant(make):
    one = shaken(make(3))
    d = one.points.shape[1]
    matrices = np.tile(random_tensors(d, 1, 0.5), (len(one.points), 1, 1))
    work = workspace_in(one, matrices)
    edges = np.unique(np.sort(work.mesh.cells[: work.n_cells, :2], axis=1), axis=0)
    found = np.empty(len(edges))
    lengths_of(work.mesh.points, edges, found)
    np.testing.assert_allclose(found, edge_lengths(work.places, of_matrices(matrices), edges))


def test_lengths_are_between_those_by_the_ends_and_the_same_from_both():
    _, work = some(tet_grid)
    cells = work.mesh.cells[: work.n_cells]
    one, other, first, last = np.empty((4, len(cells)))
    lengths_of(work.mesh.points, cells[:, :2].copy(), one)
    lengths_of(work.mesh.points, cells[:, 1::-1].copy(), other)
    np.testing.assert_allclose(one, other, rtol=1e-9)
    for end, out in ((0, first), (1, last)):
        points = work.mesh.points.copy()
        points[:, 3:] = 0.0
        for row, cell in enumerate(cells):
            points[cell[:2], 3:] = work.mesh.points[cell[end], 3:]
            lengths_of(points, cells[row : row + 1, :2].copy(), out[row : row + 1])
    assert np.all(one >= np.minimum(first, last) * (1 - 1e-9))
    assert np.all(one <= np.maximum(first, last) * (1 + 1e-9))


@pytest.mark.parametrize("measure", sorted(QUALITIES))
@pytest.mark.parametrize("make", GRIDS)
def test_quality_in_a_constant_metric_is_that_of_the_mapped_mesh(make, measure):
    one = shaken(make(3))
    d = one.points.shape[1]
    if not QUALITIES[measure].drives:
        pytest.skip("no kernel has it")
    matrix = random_tensors(d, 1, 0.5)[0]
    work = workspace_in(one, np.tile(matrix, (len(one.points), 1, 1)), measure)
    image = one.points @ np.linalg.cholesky(matrix)
    plain = workspace(type(one)(image, one.blocks), measure)
    rows = work.living()
    np.testing.assert_allclose(work.mesh.quality[rows], plain.mesh.quality[rows], atol=1e-8)


@pytest.mark.parametrize("make", GRIDS)
def test_the_star_and_the_door_agree(make):
    _, work = some(make, 4)
    inner = np.flatnonzero(~work.mesh.fixed)
    assert len(inner)
    generator = np.random.default_rng(2)
    for v in inner:
        shift = 0.02 * generator.normal(size=3) * ([1, 1, 0] if work.dimension == 2 else 1)
        out = np.empty((512, 2))
        n = star_and_door(work.mesh, v, Vec(*(work.places[v] + shift)), work.scratch, out)
        np.testing.assert_allclose(out[:n, 0], out[:n, 1], rtol=1e-9)


@pytest.mark.parametrize("make", GRIDS)
def test_ideal_points_make_ideal_cells_in_the_metric(make):
    one = shaken(make(3))
    d = one.points.shape[1]
    matrix = random_tensors(d, 1, 0.4)[0]
    work = workspace_in(one, np.tile(matrix, (len(one.points), 1, 1)))
    image = one.points @ np.linalg.cholesky(matrix)
    plain = workspace(type(one)(image, one.blocks))
    v = int(np.flatnonzero(~work.mesh.fixed)[0])
    found, expected = np.empty((2, 512, 3))
    n = ideal_points(work.mesh, v, work.scratch, found)
    assert n == ideal_points(plain.mesh, v, plain.scratch, expected)
    # Both choose their axes by themselves: the images differ by a turn at most.
    back = expected[:n, :d] @ np.linalg.inv(np.linalg.cholesky(matrix))
    np.testing.assert_allclose(np.sort(found[:n, :d], axis=0), np.sort(back, axis=0), atol=1e-9)


def test_layers_are_what_they_say():
    matrices = layered(np.array([[0.0, 0.0], [1.0, 1.0]]))
    sizes = 1 / np.sqrt(np.linalg.eigvalsh(matrices))
    np.testing.assert_allclose(np.sort(sizes, axis=1), [[0.03, 0.3], [0.3, 0.3]])
