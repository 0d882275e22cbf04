"""Vertices and cells go to work in an order of their own, and come back in the file's."""

import numpy as np
import pytest

from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.order import BITS, hilbert
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.session import Workspace
from support.meshes import tet_grid

ASPECT_RATIO = QUALITIES["aspect-ratio"].judge


def test_curve_goes_from_neighbour_to_neighbour():
    """On the corners of a full grid, each step of the curve has length one."""
    n = 8
    grid = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    # The grid of the curve is finer: put every point at the start of its part.
    points = np.concatenate([grid * 2**BITS / n, [[2**BITS - 1] * 3]])
    order = hilbert(points)
    order = order[order < n**3]
    steps = np.abs(np.diff(grid[order], axis=0)).sum(axis=1)
    assert np.all(steps == 1)


@pytest.mark.parametrize("points", [np.zeros((5, 3)), np.zeros((0, 3)), np.ones((1, 3))])
def test_points_without_extent_keep_their_order(points):
    np.testing.assert_array_equal(hilbert(points), np.arange(len(points)))


def test_order_does_not_depend_on_place_and_size():
    points = np.random.default_rng(1).random((200, 3))
    np.testing.assert_array_equal(hilbert(points), hilbert(4.0 * points))


def test_untouched_mesh_comes_back_as_it_was():
    source = cast(tet_grid(3))
    worked, origin = Workspace(source, ASPECT_RATIO).result()
    np.testing.assert_array_equal(origin, np.arange(len(source.points)))
    np.testing.assert_array_equal(worked.points, source.points)
    rows = [np.unique(mesh.cells, axis=0) for mesh in (worked, source)]
    np.testing.assert_array_equal(*rows)
