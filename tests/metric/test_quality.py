"""Cells in a metric: Q by (18.13) to (18.18), contents, unit and optimal cells."""

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.metric.domain import domain_of
from meshopt_cli.metric.field import Metric
from meshopt_cli.metric.lengths import edge_lengths
from meshopt_cli.metric.quality import metric_contents, metric_quality, rule, unit_content
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import MEASURES, OF_SIMPLICES, QUALITIES
from meshopt_cli.quality.statistics import values_of
from support.curved import of_second_order
from support.edits import shaken
from support.meshes import hex_grid, in_space, mesh, octahedron, quad_grid, tet_grid, tri_grid
from support.metrics import judged, of_matrices, random_tensors, tensors_of

GRIDS = {"triangle": tri_grid, "tetra": tet_grid, "quad": quad_grid, "hexahedron": hex_grid}


def mapped(one, matrix):
    """A mesh whose points a matrix takes to others."""
    return Mesh(one.points @ matrix.T, one.blocks)


def some_map(d, seed=5):
    """A matrix with a positive determinant that stretches and shears."""
    matrix = np.eye(d) * np.array([3.0, 0.7, 1.6])[:d]
    matrix += 0.4 * np.random.default_rng(seed).normal(size=(d, d))
    return matrix if np.linalg.det(matrix) > 0 else matrix[::-1]


@pytest.mark.parametrize("measure", OF_SIMPLICES)
@pytest.mark.parametrize("family", ["triangle", "tetra"])
def test_the_identity_changes_nothing(family, measure):
    one = shaken(GRIDS[family](3))
    n, d = one.points.shape
    plain = values_of(measurable(one), MEASURES[measure], family)
    for metric in (Metric(np.ones((n, 1)), ""), tensors_of(np.eye(d), n)):
        assert judged(one, metric, measure).quality[family] == pytest.approx(plain, rel=1e-12)


@pytest.mark.parametrize("measure", OF_SIMPLICES)
@pytest.mark.parametrize("family", ["triangle", "tetra"])
def test_a_constant_tensor_is_a_map(family, measure):
    """To judge by M = T^t T is to map the mesh by T and to judge plainly."""
    one = shaken(GRIDS[family](3))
    n, d = one.points.shape
    matrix = some_map(d)
    there = mapped(one, matrix)
    by_tensor = judged(one, tensors_of(matrix.T @ matrix, n), measure)
    plainly = judged(there, Metric(np.ones((n, 1)), ""), measure)
    for name in ("quality", "unit", "optimal"):
        assert getattr(by_tensor, name)[family] == pytest.approx(
            getattr(plainly, name)[family], rel=1e-12, abs=1e-12
        )
    assert plainly.quality[family] == pytest.approx(
        values_of(measurable(there), MEASURES[measure], family), rel=1e-12
    )
    a, b = by_tensor.summary, plainly.summary
    for told, other in ((a.edges, b.edges), (a.inner, b.inner)):
        assert told.tau == pytest.approx(other.tau, abs=1e-12)
        assert told.counts == other.counts
    assert a.content == pytest.approx(b.content, rel=1e-12)
    assert a.n_unit == pytest.approx(b.n_unit, rel=1e-12)
    assert a.counts == b.counts


@pytest.mark.parametrize("family", ["quad", "hexahedron"])
def test_a_constant_tensor_is_a_map_for_cells_of_any_family(family):
    one = shaken(GRIDS[family](2), 0.1)
    n, d = one.points.shape
    matrix = some_map(d)
    by_tensor = judged(one, tensors_of(matrix.T @ matrix, n))
    plainly = judged(mapped(one, matrix), Metric(np.ones((n, 1)), ""))
    for name in ("quality", "unit", "optimal"):
        assert getattr(by_tensor, name)[family] == pytest.approx(
            getattr(plainly, name)[family], rel=1e-10, abs=1e-10
        )


def test_18_18_by_hand():
    """The determinant of the edges stands outside the root of that of the metric."""
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 1.0, 0.0]])
    tensors = random_tensors(2, 3, 0.7)
    edges = [points[b, :2] - points[a, :2] for a, b in ((0, 1), (0, 2), (1, 2))]
    worst = 0.0
    for m in tensors:
        lengths = [np.sqrt(e @ m @ e) for e in edges]
        area = np.sqrt(np.linalg.det(m)) * np.linalg.det(np.array(edges[:2]))
        worst = max(worst, max(lengths) * sum(lengths) / area)
    found = metric_quality(
        points, np.array([[0, 1, 2]]), "triangle", of_matrices(tensors), MEASURES["aspect-ratio"]
    )
    # alpha = sqrt(3) / 6 is for the half perimeter and the area, so for twice both
    assert found[0] == pytest.approx(np.sqrt(3.0) / 6.0 * worst, rel=1e-12)


def test_18_16_as_printed_is_another_metric():
    """T = H P^-1 takes the metric to the usual space, and H P does not."""
    m = random_tensors(2, 1, 1.0)[0]
    values, p = np.linalg.eigh(m)
    p = p @ np.diag([1.0, np.linalg.det(p)])  # a turn: Det(P) = 1
    h = np.diag(np.sqrt(values))
    assert (h @ p.T).T @ (h @ p.T) == pytest.approx(m)
    assert not np.allclose((h @ p).T @ (h @ p), m)
    t = of_matrices([m]).maps[0]
    assert t[:2, :2].T @ t[:2, :2] == pytest.approx(m)
    assert t[1, 0] == 0.0


@pytest.mark.parametrize("family", ["triangle", "tetra"])
def test_a_turn_of_mesh_and_tensors_changes_nothing(family):
    one = shaken(GRIDS[family](2))
    n, d = one.points.shape
    turn = np.linalg.qr(np.random.default_rng(6).normal(size=(d, d)))[0]
    turn *= np.sign(np.linalg.det(turn)) if d == 3 else 1.0
    if np.linalg.det(turn) < 0:
        turn = turn[::-1]
    tensors = random_tensors(d, n, 0.6)
    before = judged(one, of_matrices(tensors))
    after = judged(mapped(one, turn), of_matrices(turn @ tensors @ turn.T))
    assert after.quality[family] == pytest.approx(before.quality[family], rel=1e-11)
    assert after.optimal[family] == pytest.approx(before.optimal[family], abs=1e-11)
    assert after.summary.content == pytest.approx(before.summary.content, rel=1e-11)
    assert after.summary.edges.tau == pytest.approx(before.summary.edges.tau, abs=1e-11)


def test_inverted_cells_have_no_quality_in_any_metric():
    one = tet_grid(2)
    one.points[13] = [1.2, 1.3, 1.1]
    told = judged(one, of_matrices(random_tensors(3, len(one.points), 0.5))).summary
    assert told.n_invalid > 0
    assert (told.worst, told.counts[-1] >= told.n_invalid) == (np.inf, True)
    assert np.isfinite(told.mean)


# Contents ------------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [2, 3])
def test_the_rule_is_exact_for_polynomials(d):
    places, weights = rule(d)
    assert places.sum(axis=1) == pytest.approx(np.ones(len(places)))
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ places == pytest.approx(np.full(d + 1, 1.0 / (d + 1)))
    # the mean of b0^2 b1^2 over a simplex: d! 2! 2! / (d + 4)!
    by_hand = {2: 2.0 * 4.0 / 720.0, 3: 6.0 * 4.0 / 5040.0}[d]
    assert weights @ (places[:, 0] ** 2 * places[:, -1] ** 2) == pytest.approx(by_hand)


def test_contents_of_unit_cells():
    assert unit_content("triangle") == pytest.approx(np.sqrt(3.0) / 4.0)
    assert unit_content("tetra") == pytest.approx(np.sqrt(2.0) / 12.0)
    assert [unit_content(f) for f in ("quad", "hexahedron")] == pytest.approx([1.0, 1.0])


def test_contents_by_hand():
    square = tri_grid(4)
    n = len(square.points)
    assert judged(square, Metric(np.full((n, 1), 0.1), "")).summary.content == pytest.approx(100.0)
    # h = 1 + x in the unit square: the integral of 1 / h^2 is 1 / 2; of exp(2 x) e^2 likewise
    sizes = Metric(1.0 + square.points[:, :1], "")
    assert judged(square, sizes).summary.content == pytest.approx(0.5, rel=1e-8)
    x = square.points[:, 0]
    tensors = np.exp(2.0 * x)[:, None, None] * np.eye(2)
    by_hand = (np.exp(2.0) - 1.0) / 2.0
    assert judged(square, of_matrices(tensors)).summary.content == pytest.approx(by_hand, rel=1e-8)
    cube = tet_grid(2)
    sizes = Metric(1.0 + cube.points[:, :1], "")
    assert judged(cube, sizes).summary.content == pytest.approx(3.0 / 8.0, rel=1e-6)


def test_tensors_of_space_on_a_surface():
    """A face has the area that its image has; where all is flat, that of the plane."""
    one = octahedron()
    m = random_tensors(3, 1, 0.4)[0]
    t = np.linalg.cholesky(m).T
    metric = tensors_of(m, len(one.points))
    there = metric_contents(one.points, one.blocks[0].cells, "triangle", metric)
    images = one.points @ t.T
    cells = one.blocks[0].cells
    a, b = (images[cells[:, k]] - images[cells[:, 0]] for k in (1, 2))
    assert there == pytest.approx(np.linalg.norm(np.cross(a, b), axis=1) / 2.0, rel=1e-12)
    told = judged(one, metric).summary
    assert told.inner.n_edges == told.edges.n_edges == 12  # closed: it has no boundary
    tensors = random_tensors(2, 9, 0.4)
    whole = np.tile(np.eye(3), (9, 1, 1))
    whole[:, :2, :2] = tensors
    flat, lying = tri_grid(2), in_space(tri_grid(2), 0.0)
    points, cells = lying.points, lying.blocks[0].cells
    assert metric_contents(points, cells, "triangle", of_matrices(whole)) == pytest.approx(
        metric_contents(domain_of(flat).points, cells, "triangle", of_matrices(tensors)), rel=1e-6
    )


# Unit and optimal cells ----------------------------------------------------------------------


@pytest.mark.parametrize("family", [f for f in FAMILIES if FAMILIES[f].dimension >= 2])
def test_an_ideal_cell_is_unit_and_optimal(family):
    row = FAMILIES[family]
    one = mesh(row.reference, **{family: [list(range(row.n_corners))]})
    told = judged(one, Metric(np.ones((row.n_corners, 1)), ""))
    assert told.unit[family] == pytest.approx([0.0], abs=1e-12)
    assert told.optimal[family] == pytest.approx([0.0], abs=1e-12)
    assert told.summary.n_unit == pytest.approx(1.0)
    assert told.summary.edges.tau == pytest.approx(1.0)
    assert (told.summary.unit.share, told.summary.optimal.share) == (1.0, 1.0)
    twice = judged(one, Metric(np.full((row.n_corners, 1), 0.5), ""))
    assert twice.unit[family] == pytest.approx([0.5])  # all edges are twice too long
    assert twice.optimal[family] == pytest.approx([0.5])
    assert twice.summary.n_unit == pytest.approx(2.0**row.dimension)


def test_a_sliver_may_be_nearly_unit_and_is_far_from_optimal():
    """Footnote 4: four edges of length 1, two of sqrt(2), and no volume."""
    half = np.sqrt(0.5)
    points = [[half, 0, 0], [0, half, 1e-6], [-half, 0, 0], [0, -half, 1e-6]]
    one = mesh(points, tetra=[[0, 1, 2, 3]])
    told = judged(one, Metric(np.ones((4, 1)), ""))
    assert told.unit["tetra"] == pytest.approx([1.0 - half], abs=1e-6)
    assert told.optimal["tetra"][0] > 0.95


def test_a_rhombus_is_unit_and_not_optimal():
    """Quads have diagonals of sqrt(2) too (18.3.2)."""
    one = mesh([[0, 0], [1, 0], [1.5, np.sqrt(0.75)], [0.5, np.sqrt(0.75)]], quad=[[0, 1, 2, 3]])
    told = judged(one, Metric(np.ones((4, 1)), ""))
    assert told.unit["quad"] == pytest.approx([0.0], abs=1e-12)
    assert told.optimal["quad"] == pytest.approx([1.0 - np.sqrt(0.5)])


# Cells ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [tri_grid, tet_grid, hex_grid])
def test_a_mesh_that_is_listed_the_other_way_round_is_judged_alike(make):
    one = shaken(make(2), 0.1)
    n, d = one.points.shape
    mirror = np.diag([-1.0, 1.0, 1.0][:d])
    tensors = random_tensors(d, n, 0.4)
    a = judged(one, of_matrices(tensors)).summary
    b = judged(mapped(one, mirror), of_matrices(mirror @ tensors @ mirror)).summary
    assert (a.n_invalid, b.n_invalid) == (0, 0)
    assert (b.worst, b.mean) == pytest.approx((a.worst, a.mean), rel=1e-9)


def _of_several_blocks():
    one = tet_grid(2)
    cells = one.blocks[0].cells
    line = Block("line", np.array([[0, 1]]))
    return Mesh(one.points, [Block("tetra", cells[20:]), line, Block("tetra", cells[:20])])


def _of_several_families():
    points = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5], [3, 0], [3, 1]]
    one = mesh(points, quad=[[0, 1, 2, 3]], triangle=[[1, 4, 2]])
    return Mesh(one.points, [*one.blocks, Block("quad", np.array([[1, 5, 6, 4]]))])


@pytest.mark.parametrize(
    "one", [_of_several_blocks(), _of_several_families(), mapped(tet_grid(1), -np.eye(3)),
            of_second_order(tet_grid(1)), of_second_order(tri_grid(2))]
)  # fmt: skip
def test_cells_stand_in_the_order_in_which_they_are_measured(one):
    """Which cells are turned the wrong way is known in that order."""
    domain, part = domain_of(one), measurable(one)
    assert list(domain.cells) == list(part.cells)
    for family, cells in domain.cells.items():
        centres = domain.points[cells].mean(axis=1)
        assert centres == pytest.approx(part.points[part.cells[family]].mean(axis=1))


# Edges ---------------------------------------------------------------------------------------


def test_edges_of_a_mesh_stand_once_and_know_their_cells():
    one = mesh(
        [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5]], quad=[[0, 1, 2, 3]], triangle=[[1, 4, 2]]
    )
    domain = domain_of(one)
    assert domain.edges.tolist() == [[0, 1], [0, 3], [1, 2], [1, 4], [2, 3], [2, 4]]
    for family, edges in domain.edges_of_cells.items():
        ends = domain.cells[family][:, FAMILIES[family].edges]
        assert np.sort(ends, axis=2).tolist() == domain.edges[edges].tolist()
    assert not domain.is_inner.any()


def test_inner_edges_have_an_end_off_the_boundary():
    domain = domain_of(tri_grid(2))
    assert (~domain.bound).sum() == 1
    middle = np.flatnonzero(~domain.bound)[0]
    assert (domain.edges[domain.is_inner] == middle).any(axis=1).all()
    assert domain.is_inner.sum() == (domain.edges == middle).sum() == 6
    lengths = edge_lengths(domain.points, Metric(np.ones((9, 1)), ""), domain.edges)
    assert sorted(set(lengths.round(9))) == [0.5, round(np.sqrt(0.5), 9)]


@pytest.mark.parametrize("measure", [m for m in QUALITIES if "hexahedron" in QUALITIES[m].ways])
def test_every_measure_is_one_in_a_metric(measure):
    one = shaken(hex_grid(2), 0.05)
    n = len(one.points)
    plain = values_of(measurable(one), MEASURES[measure], "hexahedron")
    found = judged(one, tensors_of(np.eye(3), n), measure).quality["hexahedron"]
    assert found == pytest.approx(plain, rel=1e-9)
