"""Periodic sides: whatever else slides, they go on to match, point by point and facet by facet."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.periodic import Link
from meshopt_cli.plans.config import Request, plan_for
from support.driven import adapted, same_everywhere
from support.edits import shaken
from support.meshes import tet_grid, tri_grid

GRIDS = {"plane": tri_grid(6), "space": tet_grid(4)}


def periodic(grid):
    """A shaken grid of which the side x = 1 is the image of the side x = 0.

    Vertices of other sides are shaken within them, so that sliding has something to do.
    """
    mesh = shaken(grid, 0.3, 7)
    points = mesh.points.copy()
    random = np.random.default_rng(1)
    free = (points[:, 1] == 0) & (points[:, 0] > 0) & (points[:, 0] < 1)
    points[free, 0] += 0.08 * random.uniform(-1, 1, np.count_nonzero(free))
    low, high = (np.flatnonzero(points[:, 0] == x) for x in (0.0, 1.0))
    order = [low[np.lexsort(points[low, 1:].T)], high[np.lexsort(points[high, 1:].T)]]
    shift = (1.0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
    link = Link(points.shape[1] - 1, 2, 1, shift, np.column_stack(order[::-1]))
    return replace(mesh, points=points, periodic=[link])


def side_facets(mesh, of_points, number):
    """Facets of the boundary between some points, by the numbers of these."""
    outer = cast(mesh).outer
    mine = np.isin(outer, of_points).all(axis=1)
    return {frozenset(number[i] for i in facet) for facet in outer[mine].tolist()}


@pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=["fixed", "slide"])
@pytest.mark.parametrize("name", GRIDS)
def test_sides_go_on_to_match(name, policy):
    mesh = periodic(GRIDS[name])
    plan = plan_for(Request(preset="standard"), mesh.dimension())
    assert_match(mesh, job.optimize(mesh, plan.pipeline, plan.measure, policy=policy).mesh)


@pytest.mark.parametrize("name", GRIDS)
def test_sides_go_on_to_match_where_others_are_split(name):
    mesh = periodic(GRIDS[name])
    result = adapted(mesh, same_everywhere(0.1), Slide()).mesh
    assert_match(mesh, result)
    assert len(cast(result).outer) > len(cast(mesh).outer)


def assert_match(mesh, result):
    """Periodic sides are as they were."""
    ((before,), (link,)) = mesh.periodic, result.periodic
    assert len(link.pairs) == len(before.pairs)
    slave, master = link.pairs.T
    assert np.array_equal(
        result.points[slave], result.points[master] + [1, 0, 0][: result.points.shape[1]]
    )
    one = {int(i): k for k, i in enumerate(slave)}
    other = {int(i): k for k, i in enumerate(master)}
    facets = side_facets(result, slave, one)
    assert facets == side_facets(result, master, other)
    assert facets


@pytest.mark.parametrize("name", GRIDS)
def test_the_other_sides_slide(name):
    mesh = periodic(GRIDS[name])
    plan = plan_for(Request(preset="standard"), mesh.dimension())
    result = job.optimize(mesh, plan.pipeline, plan.measure, policy=Slide()).mesh
    low = mesh.points[(mesh.points[:, 1] == 0) & (mesh.points[:, 0] % 1 > 0)]
    after = {tuple(point) for point in result.points.tolist()}
    assert any(tuple(point) not in after for point in low.tolist())
