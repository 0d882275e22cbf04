"""Lengths in a metric, and the efficiency index (18.12)."""

import numpy as np
import pytest

from meshopt_cli.metric.field import Metric
from meshopt_cli.metric.lengths import (
    RANKS,
    UNIT,
    edge_lengths,
    efficiency,
    mean_of_inverse,
    shares,
    told_of,
)
from support.metrics import of_matrices, random_tensors, tensors_of

GAUSS = np.polynomial.legendre.leggauss(60)


def integral(function):
    """Of a function on [0, 1], by many points on many parts."""
    parts = np.linspace(0.0, 1.0, 33)
    places = (GAUSS[0] + 1.0) / 2.0 / 32.0
    return sum(w / 64.0 * function(a + s) for a in parts[:-1] for s, w in zip(places, GAUSS[1]))  # noqa: B905


def test_table_18_1():
    """All edges l times too long or too short; the book prints 0.51 for 3, where (18.12) gives
    0.556."""
    printed = {100: 0.019, 20: 0.097, 10: 0.19, 5: 0.36, 2: 0.75, np.sqrt(2.0): 0.91,
               1.3: 0.9467, 1.2: 0.9722, 1.1: 0.9917, 1: 1.0}  # fmt: skip
    for length, tau in printed.items():
        digits = len(f"{tau}".split(".")[1])
        # some are rounded, and some are cut off
        assert tau - 1e-12 <= efficiency(np.full(5, length)) + 0.5 * 10.0**-digits
        assert efficiency(np.full(5, length)) < tau + 10.0**-digits
        assert efficiency(np.full(5, 1 / length)) == pytest.approx(efficiency(np.full(5, length)))
    assert efficiency(np.full(5, 3.0)) == pytest.approx(5.0 / 9.0)


def test_efficiency_by_hand():
    assert shares(np.array([0.5, 1.0, 4.0])).tolist() == [0.5, 1.0, 0.25]
    # 1 - (0.5^2 + 0^2 + 0.75^2) / 3
    assert efficiency(np.array([0.5, 1.0, 4.0])) == pytest.approx(1.0 - 0.8125 / 3.0)
    assert efficiency(np.array([0.0])) == 0.0
    assert np.isnan(efficiency(np.empty(0)))


def test_what_is_told_of_lengths():
    told = told_of(np.array([0.1, 0.2, 0.8, 1.0, UNIT[0], UNIT[1], 1.5, 9.0]))
    assert (told.n_edges, told.least, told.greatest) == (8, 0.1, 9.0)
    assert told.mean == pytest.approx((0.1 + 0.2 + 0.8 + 1.0 + sum(UNIT) + 1.5 + 9.0) / 8)
    assert told.share == 4 / 8  # both ends belong to it
    assert told.counts == (2, 0, 1, 1, 1, 1, 1, 0, 1)
    none = told_of(np.empty(0))
    assert (none.n_edges, sum(none.counts)) == (0, 0)
    assert np.isnan([none.tau, none.share, none.least, none.mean, none.greatest]).all()


def test_ranks_of_lengths_lie_across_from_each_other():
    inner = np.array(RANKS[1:-1])
    assert inner == pytest.approx(1.0 / inner[::-1])


@pytest.mark.parametrize("h1", [0.3, 0.3 * (1 + 1e-9), 0.3001, 0.2999, 0.31, 1.0, 5.6, 5.8, 6.0])
def test_linear_sizes_are_integrated_exactly(h1):
    h0 = 0.3
    for a, b in ((h0, h1), (h1, h0)):
        found = mean_of_inverse(np.array([a]), np.array([b]))[0]
        assert found == pytest.approx(integral(lambda t: 1.0 / (a + (b - a) * t)), rel=1e-11)  # noqa: B023
    points = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 2.0]])
    metric = Metric(np.array([[h0], [h1]]), "")
    length = edge_lengths(points, metric, np.array([[0, 1]]))[0]
    assert length == pytest.approx(3.0 * found, rel=1e-12)


def test_sizes_that_are_as_good_as_nothing_at_one_end():
    found = mean_of_inverse(np.array([1e-40, 2.0]), np.array([3.0, 1e-30]))
    assert found == pytest.approx([np.log(3e40) / 3.0, np.log(2e30) / 2.0], rel=1e-12)


def test_lengths_scale_as_sizes_do():
    rng = np.random.default_rng(1)
    points, h = rng.normal(size=(9, 3)), rng.uniform(0.1, 2.0, (9, 1))
    edges = np.array([[i, i + 1] for i in range(8)])
    plain = np.linalg.norm(points[1:] - points[:-1], axis=1)
    constant = edge_lengths(points, Metric(np.full((9, 1), 0.25), ""), edges)
    assert constant == pytest.approx(4.0 * plain, rel=1e-15)
    once, twice = (edge_lengths(points, Metric(k * h, ""), edges) for k in (1.0, 2.0))
    assert once == pytest.approx(2.0 * twice, rel=1e-14)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("spread", [0.01, 0.5, 1.0])
def test_tensors_are_interpolated_by_their_logarithms(d, spread):
    matrices = random_tensors(d, 12, spread)
    metric = of_matrices(matrices)
    points = np.zeros((12, 3))
    points[:, :d] = np.random.default_rng(2).normal(size=(12, d))
    edges = np.array([[i, i + 1] for i in range(11)])
    values, axes = np.linalg.eigh(matrices)
    logarithms = np.einsum("nij,nj,nkj->nik", axes, np.log(values), axes)

    def at(t):
        values, axes = np.linalg.eigh((1 - t) * logarithms[:-1] + t * logarithms[1:])
        along = np.einsum("nij,ni->nj", axes, (points[1:] - points[:-1])[:, :d])
        return np.sqrt((np.exp(values) * along**2).sum(axis=1))

    assert edge_lengths(points, metric, edges) == pytest.approx(integral(at), rel=2e-6)


def test_sizes_that_grow_geometrically_by_hand():
    """Isotropic tensors 1 and exp(-2): h goes as exp(t), and 1 / h has the mean 1 - 1 / e."""
    metric = of_matrices(np.array([np.eye(3), np.exp(-2.0) * np.eye(3)]))
    length = edge_lengths(np.array([[0.0, 0, 0], [0, 0, 2.0]]), metric, np.array([[0, 1]]))
    assert length[0] == pytest.approx(2.0 * (1.0 - np.exp(-1.0)), rel=1e-10)


@pytest.mark.parametrize("d", [2, 3])
def test_a_turn_of_mesh_and_tensors_changes_no_length(d):
    rng = np.random.default_rng(3)
    matrices = random_tensors(d, 10, 1.0)
    turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
    points = np.zeros((10, 3))
    points[:, :d] = rng.normal(size=(10, d))
    turned = points.copy()
    turned[:, :d] = points[:, :d] @ turn.T
    edges = rng.permutation(10).reshape(5, 2)
    before = edge_lengths(points, of_matrices(matrices), edges)
    after = edge_lengths(turned, of_matrices(turn @ matrices @ turn.T), edges)
    assert after == pytest.approx(before, rel=1e-12)


def test_an_edge_has_the_same_length_from_both_ends():
    metric = tensors_of(np.eye(3), 4)
    varying = of_matrices(random_tensors(3, 4, 1.5))
    points = np.random.default_rng(4).normal(size=(4, 3))
    edges = np.array([[0, 1], [2, 3]])
    for one in (metric, varying, Metric(np.array([[1.0], [2.0], [0.1], [0.4]]), "")):
        there = edge_lengths(points, one, edges)
        assert there == pytest.approx(edge_lengths(points, one, edges[:, ::-1]), rel=1e-14)
