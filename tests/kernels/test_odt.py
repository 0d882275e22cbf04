"""Relocation to the circumcentres, Delaunay flips, and the pass of both."""

import numpy as np
import pytest

from meshopt_cli.kernels import accept
from meshopt_cli.kernels.types import APPLIED, FIXED
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes.odt import Odt, densities
from support import drivers
from support.edits import shaken
from support.invariants import assert_kept, workspace
from support.meshes import fan, hexagon, tet_grid, tri_grid
from support.operators import pull, shaken_workspace
from support.samples import sample


def edge_lengths(work):
    """Mean length of the edges at each vertex."""
    cells = work.corners(work.living())
    ends = np.concatenate([np.roll(cells, k, axis=1).ravel() for k in range(1, cells.shape[1])])
    starts = np.tile(cells.ravel(), cells.shape[1] - 1)
    length = np.linalg.norm(work.mesh.points[starts] - work.mesh.points[ends], axis=1)
    n = len(work.mesh.points)
    return np.bincount(starts, length, n) / np.maximum(np.bincount(starts, minlength=n), 1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_circumcentres(dimension):
    """As far from one vertex of the cell as from another; with d! times its measure."""
    work = shaken_workspace(dimension, 3)
    for cell in work.living():
        corners = work.mesh.points[work.mesh.cells[cell]]
        centre, measure = drivers.centre_of(work.mesh, cell)
        radii = np.linalg.norm(corners - np.array(centre), axis=1)
        np.testing.assert_allclose(radii, radii[0], rtol=1e-9)
        edges = (corners[1:] - corners[0])[:, :dimension]
        assert measure == pytest.approx(np.linalg.det(edges))


def test_the_centre_of_a_ring_is_found_at_once():
    """All triangles of its ball have their circumcentres around it: their mean is the middle."""
    work = workspace(fan(6, (0.3, -0.2)))
    centre = int(np.flatnonzero(~work.mesh.fixed)[0])
    operator = pull(1.0)
    for _ in range(30):
        plan = operator.simulate(work, centre, accept.VALID, 0.0)
        if plan.verdict != APPLIED:
            break
        operator.apply(work, centre, plan)
    np.testing.assert_allclose(work.mesh.points[centre], 0.0, atol=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_boundary_stays(dimension):
    work = shaken_workspace(dimension, 4)
    fixed = np.flatnonzero(work.mesh.fixed)
    assert len(fixed)
    for vertex in fixed:
        assert pull().simulate(work, vertex, accept.VALID, 0.0).verdict == FIXED


def graded(n, ratio):
    """A regular triangulation of a ring by its logarithm: sizes grow in proportion to radius."""
    around = round(2 * np.pi / np.log(ratio))
    rows = np.arange(n + 1)
    angle = (np.arange(around)[None] + 0.5 * rows[:, None]) * 2 * np.pi / around
    radius = np.exp(rows * np.pi * np.sqrt(3) / around)[:, None]
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], -1).reshape(-1, 2)
    cells = []
    for i in range(n):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            cells += [[a, c, b], [b, c, d]]
    return Mesh(points, [Block("triangle", np.array(cells))])


def test_graded_sizes_are_where_they_should_be():
    """The density balances a mesh whose sizes grow with the distance: nothing goes far."""
    work = workspace(graded(20, 1.2))
    before = work.mesh.points.copy()
    length = edge_lengths(work)
    Odt(sweeps=10).run(work)
    moved = np.linalg.norm(work.mesh.points - before, axis=1)
    assert np.max(moved / length) < 0.05
    # Without regard to sizes, vertices would go out by half an edge and more.
    even = densities(work)
    assert even.max() > 100 * even.min()


def test_all_edges_are_delaunay():
    """After a sweep without relocation, but for what the boundary and the quality forbid."""
    work = workspace(shaken(tri_grid(6), 0.3, 5))
    for _ in range(3):
        Odt(relaxation=0.0, sweeps=1, accept="floor", least_quality=0.0).run(work)
    cells = work.corners(work.living())
    for row, cell in zip(work.living(), cells, strict=True):
        centre, _ = drivers.centre_of(work.mesh, row)
        radius = np.linalg.norm(work.mesh.points[cell[0]] - np.array(centre))
        for local in range(3):
            beyond = work.mesh.neighbours[row, local]
            if beyond >= 0:
                apex = work.mesh.cells[beyond >> 2, beyond & 3]
                away = np.linalg.norm(work.mesh.points[apex] - np.array(centre))
                assert away >= radius * (1 - 1e-6)


@pytest.mark.parametrize("grid", [tri_grid, tet_grid], ids=["plane", "space"])
@pytest.mark.parametrize("order", ["index", "random"])
def test_the_pass(grid, order):
    """Shapes get better where the connectivity is good; what is to be kept is kept."""
    source = cast(shaken(grid(5), 0.3, 3))
    work = workspace(source)
    mean = work.standing().mean
    tally = Odt(sweeps=5, order=order).run(work)
    assert tally.applied
    assert work.standing().mean < mean
    assert_kept(source, work)


@pytest.mark.parametrize("name", ["quadtree.vtk", "raw_ball.mesh"])
@pytest.mark.parametrize("least", [0.1, 0.4])
def test_quality_falls_to_the_floor_at_most(name, least):
    work = workspace(sample(name))
    before = work.standing().worst
    Odt(sweeps=3, least_quality=least).run(work)
    assert work.standing().worst >= min(before, least)


def test_regular_triangles_stay():
    work = workspace(hexagon(3))
    before = work.mesh.points.copy()
    Odt().run(work)
    np.testing.assert_allclose(work.mesh.points, before, atol=1e-9)
