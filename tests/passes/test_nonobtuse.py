"""Triangles without obtuse angles: fewer of them, and nothing given up for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes.nonobtuse import NonObtuse
from meshopt_cli.passes.swap import Swap
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.work.standing import Standing
from support.angles import angles_of, n_obtuse
from support.edits import declaring_some, halves, shaken
from support.invariants import assert_kept, snapshot, workspace
from support.meshes import fan, hexagon, tet_grid, tri_grid
from support.samples import sample


def angles(work):
    return angles_of(work.mesh.points, work.corners(work.living()))


def count(work):
    return n_obtuse(work.mesh.points, work.corners(work.living()))


@pytest.mark.parametrize("seed", [7, 8])
@pytest.mark.parametrize("amount", [0.1, 0.3, 0.45])
def test_nearly_all_go(amount, seed):
    """Of a shaken grid at least 99 of a hundred."""
    source = cast(shaken(tri_grid(20), amount, seed))
    work = workspace(source)
    before, worst = count(work), work.standing().worst
    assert before > 100
    for _ in range(2):
        NonObtuse().run(work)
    assert count(work) <= 0.01 * before
    assert angles(work).min() >= 25.0 - 1e-9
    assert work.standing().worst >= worst
    assert_kept(source, work)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.6), st.floats(0.0, 30.0))
def test_never_more(seed, amount, least):
    """Nor a worse cell, nor an angle that is smaller than it was and than the least one."""
    source = cast(declaring_some(halves(shaken(tri_grid(5), amount, seed))))
    work = workspace(source)
    before, sharpest, standing = count(work), angles(work).min(), work.standing()
    NonObtuse(sweeps=8, least_angle=least).run(work)
    assert count(work) <= before
    assert angles(work).min() >= min(sharpest, least) - 1e-9
    assert work.standing().worst >= standing.worst
    assert_kept(source, work)


def test_the_boundary_stays_bit_for_bit():
    source = cast(shaken(tri_grid(8), 0.4, 5))
    work = workspace(source)
    rim = np.flatnonzero(work.mesh.fixed)
    before = work.mesh.points[rim].copy()
    NonObtuse().run(work)
    np.testing.assert_array_equal(work.mesh.points[rim], before)


def test_areas_add_up():
    source = cast(shaken(tri_grid(8), 0.4, 5))
    work = workspace(source)
    NonObtuse().run(work)
    after, _ = work.result()

    def area(part):
        u, v = (part.points[part.cells[:, k]] - part.points[part.cells[:, 0]] for k in (1, 2))
        return np.sum(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2

    assert area(after) == pytest.approx(area(source), rel=1e-12)


@pytest.mark.parametrize("patch", [hexagon(4), tri_grid(5)], ids=["regular", "right angles"])
def test_a_mesh_without_obtuse_triangles_stays(patch):
    work = workspace(patch)
    before = work.mesh.points.copy(), work.mesh.cells.copy()
    assert NonObtuse().run(work).visited == 0
    np.testing.assert_array_equal(work.mesh.points, before[0])
    np.testing.assert_array_equal(work.mesh.cells, before[1])


def test_a_vertex_goes_where_the_region_is():
    """Out of a corner of its ball to a place all edges of which leave (Figure 18.13)."""
    work = workspace(fan(6, (0.55, 0.3)))
    assert count(work) > 0
    NonObtuse(steps=0).run(work)
    assert count(work) == 0
    assert work.n_cells == 6


def test_a_vertex_is_split_where_the_boundary_needs_it():
    """Four triangles in a square around a vertex off its middle: moves make them right at best."""
    work = workspace(fan(4, (0.2, 0.1)))
    NonObtuse(least_angle=15.0, max_vertices=4.0).run(work)
    assert count(work) == 0


def test_same_bytes_twice():
    works = [workspace(shaken(tri_grid(10), 0.4, 3)) for _ in range(2)]
    for work in works:
        NonObtuse().run(work)
    assert snapshot(works[0]) == snapshot(works[1])


def test_a_second_run_finds_little():
    work = workspace(shaken(tri_grid(16), 0.4, 3))
    first = NonObtuse().run(work)
    assert NonObtuse().run(work).applied <= 0.05 * first.applied


def test_vertices_are_counted():
    work = workspace(shaken(tri_grid(10), 0.45, 3))
    most = int(1.02 * work.n_points) + 1
    NonObtuse(max_vertices=1.02).run(work)
    assert work.n_points <= most


# In space -------------------------------------------------------------------------------------

SPACE = {
    "grid": lambda: shaken(tet_grid(5), 0.3, 1),
    "regions": lambda: halves(shaken(tet_grid(5), 0.2, 2)),
    "declared": lambda: declaring_some(shaken(tet_grid(4), 0.3, 3)),
}
in_space = pytest.mark.parametrize("name", SPACE)


def n_off(work):
    """Tets that do not contain their circumcentre, by its distances from their vertices."""
    corners = work.mesh.points[work.corners(work.living())]
    edges = corners[:, 1:] - corners[:, :1]
    centre = np.linalg.solve(2 * edges, (edges**2).sum(axis=2)[..., None])
    weights = np.linalg.solve(edges.transpose(0, 2, 1), centre)[..., 0]
    return int((np.column_stack([weights, 1 - weights.sum(axis=1)]) < -1e-9).any(axis=1).sum())


@in_space
def test_more_tets_are_self_centered(name):
    work = workspace(cast(SPACE[name]()))
    before, worst, source = n_off(work), work.standing().worst, work._source
    assert NonObtuse().left(work) == pytest.approx(before, abs=2)
    NonObtuse().run(work)
    assert n_off(work) < 0.8 * before
    assert work.standing().worst >= worst
    assert_kept(source, work)


@in_space
def test_a_second_run_in_space_finds_little(name):
    work = workspace(cast(SPACE[name]()))
    first = NonObtuse().run(work)
    left = n_off(work)
    assert NonObtuse().run(work).applied <= 0.3 * first.applied
    assert n_off(work) <= left


@pytest.mark.parametrize("least", [0.2, 0.5])
def test_no_tet_comes_to_be_worse_than_asked(least):
    work = workspace(cast(shaken(tet_grid(5), 0.1, 1)))
    q = work.quality(work.living())
    assert q.min() > 0.2
    NonObtuse(least_quality=least).run(work)
    assert work.quality(work.living()).min() >= min(least, q.min()) - 1e-12


# Among other passes ---------------------------------------------------------------------------


def test_fewer_obtuse_ones_come_before_the_mean():
    """But not before the worst Q."""
    few, many = Standing(0.5, 1.3, 1.9, 1), Standing(0.5, 1.1, 1.8, 5)
    assert few.is_better_than(many)
    assert not many.is_better_than(few)
    assert Standing(0.6, 1.3, 1.9, 5).is_better_than(few)


def test_a_result_is_kept_though_its_mean_is_worse():
    """A run of this pass alone, on a mesh that is good already."""
    good = plan_for(Request(preset="standard"), 2).pipeline.run(workspace(sample("quadtree.vtk")))
    work = good.work
    obtuse, before = count(work), work.standing()
    assert obtuse
    after = plan_for(Request(passes=("nonobtuse",)), 2).pipeline.run(work).work
    assert count(after) < obtuse
    assert after.standing().mean > before.mean
    assert after.standing().worst >= before.worst - 1e-9
    assert after.standing().left == count(after)


def test_other_passes_do_not_undo_it():
    """Rounds end on the mesh with the fewest obtuse triangles among those that are as good."""
    work = workspace(shaken(tri_grid(10), 0.3, 3))
    before = count(work)
    plan = plan_for(Request(passes=("swap", "smooth", "nonobtuse")), 2)
    after = plan.pipeline.run(work).work
    assert count(after) <= 0.01 * before


def test_other_passes_have_no_aim_of_their_own():
    assert Swap().left(workspace(tri_grid(2))) == 0
