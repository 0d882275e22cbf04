"""What facets, edges and vertices let each cell be, and who could still gain."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.kernels.shape.angles import angle_range
from meshopt_cli.mesh.cast import cast
from meshopt_cli.quality import room as rooms
from meshopt_cli.quality.measures import QUALITIES, cell_quality
from meshopt_cli.quality.room import allowed, best_at_angle, boundary_edges
from support.edits import shaken
from support.meshes import icosahedron, mesh, tet_grid, tri_grid
from support.samples import sample
from support.settings import examples

ASPECT_RATIO = QUALITIES["aspect-ratio"]
ONE = np.array([[0, 1, 2, 3]])


def room(part, measure):
    return rooms.room(part, measure, cell_quality(part.points, part.cells, measure))


@examples(200)
@given(st.lists(st.floats(-1, 1), min_size=12, max_size=12))
def test_no_tetrahedron_is_better_than_its_least_angle_allows(numbers):
    points = np.array(numbers).reshape(4, 3)
    q = cell_quality(points, ONE, ASPECT_RATIO)
    assume(abs(q[0]) > 1e-3)
    cells = ONE if q[0] > 0 else ONE[:, [1, 0, 2, 3]]
    least, _ = angle_range(points, cells)
    assert abs(q[0]) <= best_at_angle(ASPECT_RATIO, np.array([math.degrees(least)]))[0] * 1.01


def test_the_angle_of_the_regular_tetrahedron_forbids_nothing():
    best = best_at_angle(ASPECT_RATIO, np.array([0.0, 20.0, 40.0, 70.5288, 120.0]))
    assert best[0] == 0.0
    assert np.all(np.diff(best) >= 0)
    np.testing.assert_allclose(best[3:], 1.0, atol=1e-2)


def test_edges_of_a_cube():
    """Twelve at right angles, and the diagonals of its faces, which are flat."""
    edges = boundary_edges(cast(tet_grid(2)))
    assert np.count_nonzero(np.isclose(edges.angles, 90.0)) == 24
    assert np.all(np.isclose(edges.angles, 90.0) | np.isclose(edges.angles, 180.0))


def test_a_cell_alone_is_as_good_as_it_can_be():
    alone = cast(mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.1, 0.1, 0.2]], tetra=[[0, 1, 2, 3]]))
    found = room(alone, ASPECT_RATIO)
    assert (found.held, found.near, found.places) == (1, 1, ())
    assert allowed(alone, ASPECT_RATIO) == cell_quality(alone.points, alone.cells, ASPECT_RATIO)


def test_what_is_not_where_it_should_be_has_room():
    """The centre of an icosahedron, moved: its cells stand on facets that allow nearly all."""
    moved = icosahedron((0.4, 0.2, 0.1))
    found = room(cast(moved), ASPECT_RATIO)
    there = room(cast(icosahedron()), ASPECT_RATIO)
    assert found.held == there.held == 20
    assert there.near == 20
    assert not there.places
    assert found.near < 20
    assert len(found.places) == min(5, 20 - found.near)
    ratios = [place.worst / place.allowed for place in found.places]
    assert ratios == sorted(ratios, reverse=True)
    assert min(ratios) > 1.1


@pytest.mark.parametrize("name", ["raw_ball.mesh", "two_regions.msh", "grid.vtk"])
def test_counts(name):
    part = sample(name)
    q = cell_quality(part.points, part.cells, ASPECT_RATIO)
    best = allowed(part, ASPECT_RATIO)
    assert np.all((best >= 0) & (best <= 1))
    found = room(part, ASPECT_RATIO)
    held = np.maximum(best, q) < 1
    assert found.held == np.count_nonzero(held)
    assert found.near == np.count_nonzero(held & (1.1 * q >= np.maximum(best, q)))


def test_triangles_may_all_be_regular():
    assert room(cast(shaken(tri_grid(3))), ASPECT_RATIO) is None
