"""Angles of triangles, and the operators against obtuse ones."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.kernels.operators.clear import FANS, Clearing
from meshopt_cli.kernels.operators.nonobtuse import lacking
from meshopt_cli.kernels.shape.lack import Wants
from meshopt_cli.kernels.types import APPLIED, FIXED
from support import drivers
from support.angles import angles_of, n_obtuse
from support.invariants import assert_kept, snapshot, workspace
from support.meshes import fan, tri_grid
from support.operators import in_use, shaken_workspace

LEAST = np.sin(np.radians(20.0))
MARGIN = np.sin(np.radians(3.0))
WANTS = Wants(LEAST, MARGIN, 0.0)
coordinate = st.floats(-1.0, 1.0)


@given(st.lists(coordinate, min_size=6, max_size=6))
def test_extremes(numbers):
    points = np.column_stack([np.reshape(numbers, (3, 2)), np.zeros(3)])
    angles = angles_of(points, np.array([[0, 1, 2]]))[0]
    assume(np.abs(angles).min() > 0.1)
    if angles[0] < 0:
        points, angles = points[[0, 2, 1]], -angles
    greatest, least = drivers.extreme_angles(points, 0, 1, 2)
    assert greatest == pytest.approx(np.cos(np.radians(angles.max())), abs=1e-9)
    assert least == pytest.approx(np.sin(np.radians(angles.min())), abs=1e-9)


def test_an_inverted_triangle_is_sharp():
    points = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    assert drivers.extreme_angles(points, 0, 1, 2).least < 0


@pytest.mark.parametrize("seed", range(3))
def test_what_is_lacking(seed):
    """The same as numpy finds, in the order of the rows."""
    work = shaken_workspace(2, seed)
    cells = work.living()
    angles = angles_of(work.mesh.points, work.corners(cells))
    expected = cells[(angles.max(axis=1) > 90 + 1e-9) | (angles.min(axis=1) < 20)]
    rows = np.empty(len(cells), dtype=np.int64)
    n_obtuse_, n = lacking(work.mesh, WANTS, rows)
    np.testing.assert_array_equal(rows[:n], expected)
    assert n_obtuse_ == n_obtuse(work.mesh.points, work.corners(cells))
    assert lacking(work.mesh, WANTS, rows[:0]) == (n_obtuse_, n)


def is_allowed(outline, p):
    """Whether p is between the lines and outside the circle of each edge (Figure 18.13)."""
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        along = (p - a) @ (b - a) / ((b - a) @ (b - a))
        if not 0 <= along <= 1 or (p - a) @ (p - b) < 0:
            return False
    return True


@pytest.mark.parametrize("n", [5, 6, 7, 8])
@pytest.mark.parametrize("shift", [(0.5, 0.2), (-0.3, 0.6), (0.0, -0.6)])
def test_a_vertex_finds_the_region(n, shift):
    work = workspace(fan(n, shift))
    (centre,) = np.flatnonzero(~work.mesh.fixed)
    outline = work.mesh.points[work.mesh.fixed][:, :2]
    outline = outline[np.argsort(np.arctan2(outline[:, 1], outline[:, 0]))]
    assert not is_allowed(outline, work.mesh.points[centre, :2])
    plan = drivers.plan_placing(work.mesh, centre, WANTS, work.scratch)
    assert plan.verdict == APPLIED
    assert is_allowed(outline, np.array(plan.position)[:2])


def test_the_boundary_is_not_placed():
    work = shaken_workspace(2, 4)
    for vertex in np.flatnonzero(work.mesh.fixed):
        plan = drivers.plan_placing(work.mesh, vertex, WANTS, work.scratch)
        assert plan.verdict == FIXED


@pytest.mark.parametrize("seed", range(3))
def test_turns(seed):
    """No edge turns where that makes more triangles obtuse."""
    work = shaken_workspace(2, seed)
    n_applied = 0
    for cell in work.living():
        for local in range(3):
            before = n_obtuse(work.mesh.points, work.corners(work.living()))
            if drivers.do_turn(work.mesh, cell, local, WANTS, work.scratch):
                n_applied += 1
                assert n_obtuse(work.mesh.points, work.corners(work.living())) <= before
    assert n_applied


@pytest.mark.parametrize("n", FANS)
@pytest.mark.parametrize("side", [1, 2])
def test_splits_of_a_vertex(n, side):
    """One vertex and two triangles more, all positive; nothing else is lost."""
    source_work = workspace(tri_grid(4))
    source = source_work.result()[0]
    n_applied = 0
    for cell in source_work.living():
        work = workspace(source)
        work.reserve_points(work.n_points + 1)
        work.grow()
        for local in range(3):
            before = in_use(work)
            behind = (local + side) % 3
            if drivers.do_split_vertex(work.mesh, cell, local, behind, n, work.scratch):
                n_applied += 1
                assert work.n_vertices == source_work.n_vertices + 1
                assert work.n_cells == source_work.n_cells + 2
                assert_kept(source, work)
                break
            assert in_use(work) == before
    assert n_applied


def test_what_does_not_pay_is_undone():
    """All bytes that count are as they were where no way at a triangle helps."""
    work = workspace(tri_grid(1))  # two triangles, all of it boundary
    work.mesh.points[:, 0] += 0.8 * work.mesh.points[:, 1]
    before = in_use(work)
    how = Clearing(Wants(LEAST, MARGIN, 1.0), 0, 9, 5)
    assert not drivers.do_clear(work.mesh, 0, how, work.scratch)
    assert in_use(work) == before


def test_clearing_is_the_same_twice():
    works = [shaken_workspace(2, 5) for _ in range(2)]
    for work in works:
        work.reserve_points(work.n_points + 50)
        for _ in range(3):
            work.grow()
        how = Clearing(WANTS, len(work.mesh.points), 9, 5)
        for cell in work.living():
            if work.mesh.alive[cell]:
                drivers.do_clear(work.mesh, cell, how, work.scratch)
    assert snapshot(works[0]) == snapshot(works[1])
