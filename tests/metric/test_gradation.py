"""Gradation of sizes and of tensors."""

import heapq
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshopt_cli.metric import gradation
from meshopt_cli.metric.domain import domain_of
from meshopt_cli.metric.field import Metric
from meshopt_cli.metric.gradation import CEILING, SLACK, graded
from meshopt_cli.metric.lengths import edge_lengths
from support.edits import shaken
from support.meshes import hex_grid, icosahedron, tet_grid, tri_grid
from support.metrics import of_matrices, random_tensors

BETAS = (1.01, 1.3, 3.0)
MESHES = {2: shaken(tri_grid(7)), 3: shaken(tet_grid(4))}
of_every_kind = pytest.mark.parametrize("kind", ["sizes", "plane", "space"])
every_beta = pytest.mark.parametrize("beta", BETAS)


def case(kind, scale=3.0, spread=0.6, seed=0):
    """A mesh, and a metric that differs from vertex to vertex."""
    d = 2 if kind == "plane" else 3
    domain = domain_of(MESHES[d])
    n = len(domain.points)
    if kind == "sizes":
        sizes = np.exp(2.0 * spread * np.random.default_rng(seed).normal(size=(n, 1))) / scale
        return domain, Metric(sizes, "h")
    return domain, of_matrices(scale**2 * random_tensors(d, n, spread, seed))


def asked(metric, domain, beta, one, other):
    """What tensors ask of the other ends of edges, by the definition."""
    values, axes = np.linalg.eigh(metric.matrices[one])
    length = np.linalg.norm(domain.points[other] - domain.points[one], axis=1)
    grown = values**-0.5 + (length * math.log(beta))[:, None]
    return np.einsum("nij,nj,nkj->nik", axes, grown**-2.0, axes)


def excess(metric, wanted):
    """How many times as much as metrics have is wanted, in the direction in which that is most."""
    lower = np.linalg.cholesky(metric)
    half = np.linalg.solve(lower, wanted)
    return np.linalg.eigvalsh(np.linalg.solve(lower, half.transpose(0, 2, 1)))[:, -1]


@every_beta
@of_every_kind
def test_no_edge_asks_for_more_than_there_is(kind, beta):
    domain, metric = case(kind)
    found = graded(metric, domain.points, domain.edges, beta)
    for one, other in (domain.edges.T, domain.edges.T[::-1]):
        wanted = asked(found, domain, beta, one, other)
        assert excess(found.matrices[other], wanted).max() <= 1.0 + 2.0 * SLACK
        before = asked(metric, domain, beta, one, other)
        if beta < 3.0:
            assert excess(metric.matrices[other], before).max() > 1.1  # there was something to do


@every_beta
def test_sizes_grow_by_the_factor_along_an_edge_of_length_one(beta):
    domain, metric = case("sizes")
    found = graded(metric, domain.points, domain.edges, beta)
    one, other = found.values[domain.edges, 0].T
    shock = np.maximum(one / other, other / one) ** (
        1.0 / edge_lengths(domain.points, found, domain.edges)
    )
    assert shock.max() <= beta * (1.0 + 1e-9)


@every_beta
@of_every_kind
def test_nothing_becomes_coarser(kind, beta):
    domain, metric = case(kind)
    found = graded(metric, domain.points, domain.edges, beta)
    if kind == "sizes":
        assert (found.values <= metric.values).all()
        assert found.values.min() == metric.values.min()
        return
    least = np.linalg.eigvalsh(found.matrices - metric.matrices)[:, 0]
    greatest = np.linalg.eigvalsh(found.matrices)[:, -1]
    assert (least >= -1e-12 * greatest).all()
    assert greatest.max() <= CEILING * np.linalg.eigvalsh(metric.matrices).max() * (1.0 + 1e-9)


@every_beta
@of_every_kind
def test_it_stays_when_it_is_graded_once_more(kind, beta):
    domain, metric = case(kind)
    found = graded(metric, domain.points, domain.edges, beta)
    again = graded(found, domain.points, domain.edges, beta)
    assert again.values == pytest.approx(found.values, rel=1e-12, abs=1e-12)


@every_beta
@of_every_kind
def test_numbers_of_vertices_do_not_matter(kind, beta):
    domain, metric = case(kind)
    found = graded(metric, domain.points, domain.edges, beta)
    order = np.random.default_rng(1).permutation(len(domain.points))
    place = np.argsort(order)
    edges = np.random.default_rng(2).permutation(place[domain.edges][:, ::-1])
    other = graded(Metric(metric.values[order], ""), domain.points[order], edges, beta)
    scale = np.abs(found.values).max()
    assert other.values[place] == pytest.approx(found.values, rel=1e-9, abs=1e-9 * scale)


def test_sizes_are_the_greatest_that_obey():
    """They are those of the nearest vertices, by the way along edges: with a heap."""
    domain, metric = case("sizes")
    beta = 1.4
    least = metric.values[:, 0].copy()
    near = {i: [] for i in range(len(least))}
    for i, j in domain.edges.tolist():
        step = math.log(beta) * math.dist(domain.points[i], domain.points[j])
        near[i].append((j, step))
        near[j].append((i, step))
    heap = [(h, i) for i, h in enumerate(least.tolist())]
    heapq.heapify(heap)
    while heap:
        h, i = heapq.heappop(heap)
        if h > least[i]:
            continue
        for j, step in near[i]:
            if h + step < least[j]:
                least[j] = h + step
                heapq.heappush(heap, (h + step, j))
    found = graded(metric, domain.points, domain.edges, beta)
    assert found.values[:, 0] == pytest.approx(least, rel=1e-12)
    assert (found.values < metric.values).any()


@pytest.mark.parametrize("d", [2, 3])
def test_tensors_that_are_the_same_in_all_directions_are_graded_as_sizes(d):
    domain = domain_of(MESHES[d])
    sizes = np.exp(np.random.default_rng(0).normal(size=len(domain.points)))
    tensors = of_matrices(np.eye(d) / sizes[:, None, None] ** 2)
    found = graded(tensors, domain.points, domain.edges, 1.3)
    expected = graded(Metric(sizes[:, None], ""), domain.points, domain.edges, 1.3)
    assert np.linalg.eigvalsh(found.matrices) ** -0.5 == pytest.approx(
        np.repeat(expected.values, d, axis=1), rel=SLACK * 20
    )


@of_every_kind
def test_a_metric_that_obeys_stays_bit_for_bit(kind):
    domain, metric = case(kind)
    same = Metric(np.tile(metric.values[:1], (len(metric.values), 1)), "")
    found = graded(same, domain.points, domain.edges, 1.1)
    assert np.array_equal(found.values, same.values)


@of_every_kind
@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_it_does_not_depend_on_the_unit(kind, factor):
    domain, metric = case(kind)
    found = graded(metric, domain.points, domain.edges, 1.3)
    power = 1.0 if kind == "sizes" else -2.0
    other = Metric(metric.values * factor**power, "")
    scaled = graded(other, domain.points * factor, domain.edges, 1.3).values * factor**-power
    assert scaled == pytest.approx(found.values, rel=1e-6, abs=1e-6 * np.abs(found.values).max())


def test_a_jump_in_one_direction_is_smoothed_in_that_alone():
    """Thin layers at x = 0: they grow away from it, and stay as wide as they were."""
    domain = domain_of(tri_grid(20))
    x = domain.points[:, 0]
    thin = np.where(x == 0.0, 0.01, 0.5)
    metric = of_matrices([np.diag([1.0 / h**2, 4.0]) for h in thin])
    found = graded(metric, domain.points, domain.edges, 1.5)
    assert found.matrices[:, 0, 0] ** -0.5 == pytest.approx(
        np.minimum(0.01 + math.log(1.5) * x, 0.5), rel=1e-3
    )
    assert found.matrices[:, 1, 1] == pytest.approx(np.full(len(x), 4.0))
    assert found.matrices[:, 0, 1] == pytest.approx(np.zeros(len(x)), abs=1e-9)


def front(n):
    """Tensors that are thin across a sphere."""
    domain = domain_of(shaken(tet_grid(n)))
    away = domain.points - np.array([0.2, 0.3, 0.1])
    r = np.linalg.norm(away, axis=1)
    normal = away / r[:, None]
    thin = np.clip(np.abs(r - 0.5) / 2.0, 0.01, 0.2)
    outer = normal[:, :, None] * normal[:, None, :]
    return domain, of_matrices((thin**-2 - 25.0)[:, None, None] * outer + 25.0 * np.eye(3))


def test_thin_tensors_that_turn_ask_for_hardly_finer_sizes_than_those_given():
    domain, metric = front(8)
    found = np.linalg.eigvalsh(graded(metric, domain.points, domain.edges, 1.3).matrices)
    assert found.max() <= 1.2 * np.linalg.eigvalsh(metric.matrices).max()


@pytest.mark.parametrize("beta", [1.01, 1.05])
def test_thin_tensors_that_turn_obey_small_factors_too(beta):
    """Though what they ask for together is much finer than each."""
    domain, metric = front(12)
    found = graded(metric, domain.points, domain.edges, beta)
    for one, other in (domain.edges.T, domain.edges.T[::-1]):
        wanted = asked(found, domain, beta, one, other)
        assert excess(found.matrices[other], wanted).max() <= 1.0 + 2.0 * SLACK


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10_000),
    st.floats(0.0, 2.2),
    st.floats(-4.0, 4.0),
    st.floats(1.01, 5.0),
    st.sampled_from(["plane", "space"]),
)
def test_it_ends_whatever_the_tensors(seed, spread, power, beta, kind):
    domain, metric = case(kind, 10.0**power, spread, seed)
    found = graded(metric, domain.points, domain.edges, beta)
    eigenvalues = np.linalg.eigvalsh(found.matrices)
    assert np.isfinite(found.values).all()
    assert (eigenvalues[:, -1] > 0.0).all()


@pytest.mark.parametrize("make", [lambda: hex_grid(3), icosahedron, lambda: tri_grid(1)])
def test_cells_of_every_family_and_points_without_cells(make):
    one = make()
    one.points = np.concatenate([one.points, one.points[:1] + 9.0])
    domain = domain_of(one)
    sizes = np.ones((len(one.points), 1))
    sizes[0] = 0.01
    found = graded(Metric(sizes, ""), domain.points, domain.edges, 1.2).values
    assert found[-1] == 1.0
    assert (found[domain.used] < 1.0).all()


@pytest.mark.parametrize("d", [2, 3])
def test_intersections_are_within_both(d):
    one, other = random_tensors(d, 100, 0.8, 1), random_tensors(d, 100, 0.8, 2)
    parts = [gradation._sizes_and_axes(tensors) for tensors in (one, other)]
    found = gradation.intersection(one, *parts[0], *parts[1])
    for tensors in (one, other):
        assert excess(found, tensors).max() <= 1.0 + 1e-9
    for tensors, both in ((one, parts[0]), (found, gradation._sizes_and_axes(found))):
        same = gradation.intersection(tensors, *both, *both)
        assert same == pytest.approx(tensors, rel=1e-9)
