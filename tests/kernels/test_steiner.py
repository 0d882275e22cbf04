"""The triangulation that Steiner points are looked for in: it stays whole whatever is tried."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.kernels.steiner import net as columns
from meshopt_cli.kernels.steiner.anneal import anneal, measure_all
from meshopt_cli.kernels.steiner.net import Goal, Schedule
from meshopt_cli.kernels.types import Judge
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from meshopt_cli.work.steiner import net_of
from support.edits import halves, shaken
from support.invariants import volumes
from support.meshes import tri_grid

GOAL = Goal(Judge(0, 0.0), 1e-3, 1e-3, 0.4, 0.05, 0.2, 200, False)


def net_of_grid(amount, seed):
    source = cast(halves(shaken(tri_grid(4), amount, seed)))
    keys = adjacency.distinct(adjacency.row_keys(source.skin, len(source.points)))
    net = net_of(
        source.points, source.cells, source.region, source.neighbours < 0, source.fixed, keys,
        200, seed,
    )  # fmt: skip
    measure_all(net, GOAL)
    return source, net


def living(net):
    return np.flatnonzero(net.cells[:, columns.ALIVE] == 1)


def assert_whole(net):
    rows = living(net)
    cells = net.cells[rows, :3]
    assert np.all(volumes(net.points, cells) > 0)
    for local in range(3):
        handle = net.cells[rows, columns.BEYOND + local]
        inner = handle >= 0
        other, beyond = handle[inner] >> 2, handle[inner] & 3
        assert np.all(net.cells[other, columns.BEYOND + beyond] == 4 * rows[inner] + local)
        border = columns.BORDER + beyond
        np.testing.assert_array_equal(
            net.cells[other, border], net.cells[rows[inner], columns.BORDER + local]
        )
        across = net.cells[other, columns.BORDER + beyond] == columns.NO_BORDER
        regions = net.cells[other, columns.REGION] == net.cells[rows[inner], columns.REGION]
        assert np.all(regions[across])
        edge = cells[inner][:, [(local + 1) % 3, (local + 2) % 3]]
        np.testing.assert_array_equal(edge[:, 0], net.cells[other, (beyond + 2) % 3])
        np.testing.assert_array_equal(edge[:, 1], net.cells[other, (beyond + 1) % 3])
    used = np.unique(cells)
    assert len(used) == net.state[columns.N_VERTICES]
    assert np.all(net.vertices[used, columns.VERTEX_ALIVE] == 1)


@given(st.integers(0, 2**31), st.floats(0.0, 0.5), st.floats(0.01, 1.0))
def test_whatever_is_kept_or_undone(seed, amount, heat):
    source, net = net_of_grid(amount, seed)
    n_bad = net.state[columns.N_BAD]
    schedule = Schedule(0, 2000, 2000, heat, heat, 0.8, -1, 0)
    tries, kept, is_better = anneal(net, GOAL, schedule)
    assert (tries, is_better) == (2000, False)
    assert_whole(net)
    rows = living(net)
    area = np.bincount(net.cells[rows, columns.REGION], volumes(net.points, net.cells[rows, :3]))
    before = np.bincount(source.region, volumes(source.points, source.cells))
    np.testing.assert_allclose(area, before, rtol=1e-12)
    # What undoing puts back is what is measured anew.
    costs, total = net.cost[rows].copy(), net.total[0]
    bad = sorted(net.bad[: net.state[columns.N_BAD]])
    measure_all(net, GOAL)
    np.testing.assert_array_equal(net.cost[rows], costs)
    assert total == pytest.approx(costs.sum(), abs=1e-9)
    assert sorted(net.bad[: net.state[columns.N_BAD]]) == bad
    assert kept > 0 or n_bad == 0


def test_the_best_is_told_at_once():
    _, net = net_of_grid(0.3, 1)
    n_bad, n_vertices = int(net.state[columns.N_BAD]), int(net.state[columns.N_VERTICES])
    assert n_bad > 0
    _, _, is_better = anneal(
        net, GOAL, Schedule(0, 10**5, 10**5, 0.2, 0.02, 0.8, n_bad, n_vertices)
    )
    assert is_better
    assert net.state[columns.N_BAD] <= n_bad
