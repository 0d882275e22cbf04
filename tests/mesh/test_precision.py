"""Single and double precision."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.mesh.cast import cast
from support.edits import shaken, turned_over
from support.meshes import tet_grid, tri_grid
from support.places import areas
from support.planes import every_axis_plane, in_plane, in_tilted_plane
from support.runs import optimized, worked_on


def single(one):
    return replace(one, points=one.points.astype(np.float32))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("preset", ["standard", "best"])
def test_coordinates_of_tets_are_written_as_they_were_worked_out(dtype, preset):
    one = shaken(tet_grid(4))
    one.points = one.points.astype(dtype)
    _, worked, result = worked_on(one, preset=preset)
    assert result.points.dtype == dtype
    assert np.array_equal(result.points.astype(np.float64), worked.points)
    assert np.any(~np.isin(result.points, one.points))


@every_axis_plane
@pytest.mark.parametrize("clockwise", [False, True])
def test_single_precision_in_a_plane_is_written_as_it_was_worked_out(axes, clockwise):
    flat = shaken(tri_grid(6))
    one = single(in_plane(turned_over(flat) if clockwise else flat, axes, 0.1))
    before, worked, result = worked_on(one)
    assert before.single
    assert result.points.dtype == np.float32
    assert np.array_equal(before.frame.flatten(result.points.astype(np.float64)), worked.points)
    assert np.any(result.points != one.points)


@pytest.mark.parametrize("seed", range(4))
def test_single_precision_in_a_tilted_plane(seed):
    one = single(in_tilted_plane(shaken(tri_grid(6), seed=seed), seed))
    result = optimized(one)
    assert result.points.dtype == np.float32
    after = cast(result)
    assert np.all(areas(after.points, after.cells) > 0)
