"""Planar meshes, wherever their plane lies."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.mesh.cast import cast, with_simplices
from support.edits import shaken, turned_over
from support.meshes import mesh, tet_grid, tri_grid
from support.places import areas, cells_of
from support.planes import every_axis_plane, in_plane, in_tilted_plane, rotation
from support.runs import optimized
from support.settings import examples


def moved(one, vertex, by):
    """A mesh, cast, after the work moved one vertex, and put together again."""
    before = cast(one)
    points = before.points.copy()
    points[vertex, : len(by)] += by
    worked = replace(before, points=points)
    return before, worked, with_simplices(one, worked, np.arange(len(points)), before)


@every_axis_plane
@examples(25)
@given(
    height=st.floats(-1e6, 1e6),
    scale=st.sampled_from([1e-9, 1.0, 3e7]),
    seed=st.integers(0, 99),
    clockwise=st.booleans(),
)
def test_an_axis_plane_loses_no_bit(axes, height, scale, seed, clockwise):
    flat = shaken(tri_grid(3), seed=seed)
    flat.points *= scale
    one = in_plane(turned_over(flat) if clockwise else flat, axes, height)
    before = cast(one)
    assert np.all(before.points[:, 2] == 0.0)
    assert np.array_equal(before.frame.unflatten(one.points, before.points), one.points)
    for column in np.abs(before.points[:, :2]).T:
        assert any(np.array_equal(column, np.abs(other)) for other in flat.points.T)


@every_axis_plane
@pytest.mark.parametrize("clockwise", [False, True])
def test_only_the_moved_vertex_of_a_plane_changes(axes, clockwise):
    flat = shaken(tri_grid(4))
    one = in_plane(turned_over(flat) if clockwise else flat, axes, 0.1)
    before, worked, result = moved(one, 12, (0.01, 0.003))
    assert np.array_equal(np.delete(result.points, 12, axis=0), np.delete(one.points, 12, axis=0))
    assert np.any(result.points[12] != one.points[12])
    assert np.array_equal(before.frame.flatten(result.points), worked.points)


def test_two_columns_stay_two_columns():
    flat = shaken(tri_grid(4))
    _, worked, result = moved(flat, 12, (0.01, 0.003))
    assert result.points.shape == flat.points.shape
    assert np.array_equal(result.points, worked.points[:, :2])


@examples(40)
@given(seed=st.integers(0, 10_000), clockwise=st.booleans())
def test_triangles_are_positive_in_every_plane(seed, clockwise):
    flat = shaken(tri_grid(3), seed=seed)
    one = in_tilted_plane(turned_over(flat) if clockwise else flat, seed)
    before = cast(one)
    wanted = areas(flat.points, cells_of(flat, "triangle"))
    found = areas(before.points, before.cells)
    assert np.all(found > 0)
    assert found == pytest.approx(np.abs(wanted), rel=1e-9)


@examples(40)
@given(seed=st.integers(0, 10_000))
def test_a_tilted_plane_is_kept_to_rounding(seed):
    one = in_tilted_plane(shaken(tri_grid(4), seed=seed), seed)
    _, _, result = moved(one, 12, (0.02, -0.01))
    assert np.array_equal(np.delete(result.points, 12, axis=0), np.delete(one.points, 12, axis=0))
    normal = rotation(seed)[:, 2]
    heights = (result.points - one.points[0]) @ normal
    assert np.max(np.abs(heights)) < 1e-13
    assert np.linalg.norm(result.points[12] - one.points[12]) == pytest.approx(np.hypot(0.02, 0.01))


@every_axis_plane
def test_heights_over_an_axis_plane_are_kept(axes):
    one = in_plane(shaken(tri_grid(4)), axes, 0.25)
    (across,) = {0, 1, 2} - set(axes)
    one.points[:, across] += np.random.default_rng(1).uniform(-2e-7, 2e-7, len(one.points))
    result = optimized(one, passes=("smooth",))
    assert len(result.points) == len(one.points)
    assert np.any(result.points != one.points)
    assert np.array_equal(result.points[:, across], one.points[:, across])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("clockwise", [False, True])
def test_a_run_keeps_a_tilted_plane_and_its_boundary(seed, clockwise):
    flat = shaken(tri_grid(6), seed=seed)
    one = in_tilted_plane(turned_over(flat) if clockwise else flat, seed)
    result = optimized(one)
    normal = rotation(seed)[:, 2]
    assert np.max(np.abs((result.points - one.points[0]) @ normal)) < 1e-13
    rim = np.any((flat.points < 1e-9) | (flat.points > 1 - 1e-9), axis=1)
    assert set(map(tuple, one.points[rim])) <= set(map(tuple, result.points))
    assert np.any(~np.isin(result.points[:, 0], one.points[:, 0]))


def spiked(side=10):
    """Triangles that only a new vertex mends: a square around long cells without inner points."""
    ticks = np.linspace(0, 1, side + 1)[:-1]
    ring = np.concatenate([
        np.column_stack([ticks, 0 * ticks]),
        np.column_stack([1 + 0 * ticks, ticks]),
        np.column_stack([1 - ticks, 1 + 0 * ticks]),
        np.column_stack([0 * ticks, 1 - ticks]),
    ])  # fmt: skip
    points = np.concatenate([ring, [[0.42, 0.45]]])
    n = len(ring)
    return mesh(points, triangle=[[i, (i + 1) % n, n] for i in range(n)])


@every_axis_plane
@pytest.mark.parametrize("stray", [False, True])
def test_new_vertices_lie_in_the_plane(axes, stray):
    """Also when points that no cell uses do not."""
    one = in_plane(spiked(), axes, 0.25)
    if stray:
        one.points = np.concatenate([one.points, [[7.0, 8.0, 9.0]]])
    (across,) = {0, 1, 2} - set(axes)
    result = optimized(one, passes=("split", "smooth", "swap"))
    assert len(result.points) > len(one.points)
    used = result.points[np.unique(cells_of(result, "triangle"))]
    assert np.all(used[:, across] == 0.25)
    assert np.all((used[:, list(axes)] >= 0) & (used[:, list(axes)] <= 1))


@pytest.mark.parametrize("shift", [(5e5, 5.2e6, 120.0), (-1e7, 0.0, 0.0)])
def test_a_plane_far_from_the_origin(shift):
    """As in projected geographic coordinates."""
    flat = shaken(tri_grid(5))
    flat.points *= 100.0
    one = in_tilted_plane(flat, seed=2, shift=shift)
    result = optimized(one)
    normal = rotation(2)[:, 2]
    assert np.max(np.abs((result.points - one.points.mean(axis=0)) @ normal)) < 1e-7


@pytest.mark.parametrize("seed", range(3))
def test_single_precision_in_a_plane_far_from_the_origin(seed):
    """Coordinates are rounded to more than the usual tolerance there."""
    flat = shaken(tri_grid(5))
    one = in_tilted_plane(flat, seed=seed, shift=(700.0, -300.0, 500.0))
    one.points = one.points.astype(np.float32)
    normal = rotation(seed)[:, 2].astype(np.float64)
    heights = one.points.astype(np.float64) @ normal
    result = optimized(one)
    assert result.points.dtype == np.float32
    assert not np.array_equal(result.points, one.points)
    assert np.ptp(result.points.astype(np.float64) @ normal) <= 2 * np.ptp(heights)


@pytest.mark.parametrize("power", [-100, -30, 30, 100])
@pytest.mark.parametrize("make", [lambda: shaken(tet_grid(4)), lambda: shaken(tri_grid(6))])
def test_the_scale_does_not_matter(make, power):
    """Every tolerance is relative: a power of two changes exponents only."""
    one = make()
    plain = optimized(one)
    one.points = np.ldexp(one.points, power)
    result = optimized(one)
    assert np.array_equal(np.ldexp(plain.points, power), result.points)
    kind = "tetra" if one.dimension() == 3 else "triangle"
    assert np.array_equal(cells_of(plain, kind), cells_of(result, kind))
