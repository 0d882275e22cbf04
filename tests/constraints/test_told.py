"""Vertices that were told where to stay do so, and no mesh is the worse for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.constraints.grammar import keep_offs
from meshopt_cli.errors import BadMeshError, ConfigError
from meshopt_cli.jobs.optimize import optimize
from meshopt_cli.jobs.optimize_cells import optimize_cells
from meshopt_cli.mesh.cast import cast
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.work.kinds import CELLS, FACES
from support.meshes import hex_grid, quad_grid, tet_grid, tri_grid
from support.settings import examples

# What each text keeps off, as the distance of points (n, 3).
WAYS = {
    "x=0.5:0.08": lambda p: np.abs(p[:, 0] - 0.5),
    "plane=0.5,0.5/1,1:0.07": lambda p: np.abs((p - 0.5)[:, :2].sum(axis=1)) / np.sqrt(2),
    "point=0.5,0.5:0.1": lambda p: np.hypot(np.hypot(p[:, 0] - 0.5, p[:, 1] - 0.5), p[:, 2]),
    "boundary:0.12": lambda p: p.shape and np.minimum(p, 1 - p)[:, :2].min(axis=1),
}
NOISE = 1e-9


def shaken(grid, seed, amount=0.25):
    """A grid of the unit square or cube whose inner vertices are shaken."""
    generator = np.random.default_rng(seed)
    n = round(1.0 / np.diff(np.unique(grid.points[:, 0]))[0])
    step = generator.uniform(-amount / n, amount / n, grid.points.shape)
    step[((grid.points <= 0) | (grid.points >= 1)).any(axis=1)] = 0.0
    grid.points = grid.points + step
    return grid


def in_space(points):
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])


def inner(points):
    return ~((points <= 0) | (points >= 1)).any(axis=1)


def numbered(grid):
    """The same with the number of each point, which new ones do not share."""
    grid.point_data["number"] = np.arange(len(grid.points))
    return grid


def pairs(before, after):
    """Points before and after, of the vertices that are still there."""
    number = after.point_data["number"]
    old = np.flatnonzero(number < len(before.points))
    return in_space(before.points)[number[old]], in_space(after.points)[old]


def run(grid, preset="standard", offs=(), policy=Fixed()):  # noqa: B008
    plan = plan_for(Request(preset=preset), grid.dimension())
    result = optimize(
        grid, plan.pipeline, plan.measure, policy=policy, keep_offs=keep_offs(offs)
    )  # fmt: skip
    assert result.after.worst <= result.before.worst * (1 + 1e-6)
    return result.mesh


@given(
    st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from(sorted(WAYS)),
    st.sampled_from(sorted(PRESETS)), st.booleans(),
)  # fmt: skip
@examples(25)
def test_no_vertex_comes_nearer_than_it_may(seed, dimension, way, preset, slides):
    grid = numbered(shaken(tri_grid(7) if dimension == 2 else tet_grid(4), seed))
    if dimension == 3 and way.startswith("boundary"):
        distance = lambda p: np.minimum(p, 1 - p).min(axis=1)  # noqa: E731
    else:
        distance = WAYS[way]
    after = run(grid, preset, [way], Slide() if slides else Fixed())
    least = float(way.rpartition(":")[2])
    was, now = pairs(grid, after)
    inside = inner(was[:, :dimension])
    was, now = distance(was[inside]), distance(now[inside])
    assert np.all(now >= np.minimum(was, least) - NOISE)


@pytest.mark.parametrize("dimension", [2, 3])
def test_vertices_go_where_they_are_told(dimension):
    grid = numbered(tri_grid(8) if dimension == 2 else tet_grid(6))
    grid = shaken(grid, 1, 0.1)
    left = np.abs(grid.points[:, 0] - 0.5) < 0.04
    assert np.count_nonzero(left & inner(grid.points)) > 3
    was, now = pairs(grid, run(grid, offs=["x=0.5:0.04"]))
    assert np.all(np.abs(now[inner(was[:, :dimension]), 0] - 0.5) >= 0.04 - NOISE)


@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.sampled_from(sorted(PRESETS)))
@examples(15)
def test_vertices_stay_on_their_lines_and_planes(seed, dimension, preset):
    grid = numbered(shaken(tri_grid(7) if dimension == 2 else tet_grid(4), seed))
    generator = np.random.default_rng(seed)
    n = len(grid.points)
    kind = generator.integers(0, 5, n)
    vectors = generator.normal(size=(n, 3))
    if dimension == 2:
        vectors[:, 2] = 0.0
    grid.point_data["meshopt:along"] = np.where((kind == 1)[:, None], vectors, 0.0)
    grid.point_data["meshopt:within"] = np.where((kind == 2)[:, None], vectors, 0.0)
    grid.point_data["meshopt:fixed"] = (kind == 3).astype(np.int32)
    unit = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    points = in_space(grid.points)
    height = np.einsum("ij,ij->i", points, unit)
    limit = np.column_stack([unit, height - 0.02])
    grid.point_data["meshopt:limit"] = np.where((kind == 4)[:, None], limit, 0.0)
    after = run(grid, preset)
    number = after.point_data["number"]
    told = kind > 0
    assert set(np.flatnonzero(told)) <= set(number.tolist())  # none of them vanishes
    old = np.flatnonzero(number < n)
    step = in_space(after.points)[old] - points[number[old]]
    unit, kind = unit[number[old]], kind[number[old]]
    part = np.einsum("ij,ij->i", step, unit)
    assert np.all(np.abs(step - part[:, None] * unit)[kind == 1] < NOISE)
    assert np.all(np.abs(part[kind == 2]) < NOISE)
    assert np.all(step[kind == 3] == 0.0)
    assert np.all(part[kind == 4] > -0.02 - NOISE)
    for name in ("meshopt:along", "meshopt:within", "meshopt:limit"):
        values = after.point_data[name]
        assert np.array_equal(values[old], grid.point_data[name][number[old]])


def test_told_vertices_move():
    grid = numbered(shaken(tet_grid(4), 5))
    told = np.where(inner(grid.points)[:, None], [1.0, 0.0, 0.0], 0.0)
    grid.point_data["meshopt:along"] = told
    was, now = pairs(grid, run(grid))
    assert np.any(now[:, 0] != was[:, 0])
    assert np.allclose(now[:, 1:][inner(was)], was[:, 1:][inner(was)], atol=NOISE)


@pytest.mark.parametrize(("grid", "kind"), [(hex_grid, CELLS), (quad_grid, FACES)])
def test_vertices_of_other_cells_do_as_they_are_told(grid, kind):
    mesh = shaken(grid(6), 2, 0.3)
    d = mesh.points.shape[1]
    inside = inner(mesh.points)
    mesh.point_data["meshopt:within"] = np.where(
        (inside & (mesh.points[:, 1] > 0.5))[:, None], [0.0, 1.0, 0.0], 0.0
    )
    plan = plan_for(Request(), d, kind)
    result = optimize_cells(
        mesh, plan.pipeline, plan.measure, keep_offs=keep_offs(["x=0.5:0.03"])
    ).mesh
    assert np.any(result.points != mesh.points)
    was, now = (np.abs(m.points[inside, 0] - 0.5) for m in (mesh, result))
    assert np.all(now >= np.minimum(was, 0.03) - NOISE)
    held = inside & (mesh.points[:, 1] > 0.5)
    assert np.allclose(result.points[held, 1], mesh.points[held, 1], atol=NOISE)


def test_no_constraints_change_nothing():
    grid = shaken(tet_grid(4), 7)
    plain = run(grid)
    grid.point_data["meshopt:along"] = np.zeros((len(grid.points), 3))
    told = run(grid)
    assert cast(told).cells.shape == cast(plain).cells.shape


def test_a_group_that_is_not_there_is_named():
    with pytest.raises(ConfigError, match="no group or region core"):
        run(tri_grid(3), offs=["group=core:0.1"])


def test_interfaces_are_kept_off():
    grid = tri_grid(8)
    centre = grid.points[grid.blocks[0].cells].mean(axis=1)
    grid.blocks[0].data["medit:ref"] = (centre[:, 0] > 0.5).astype(np.int64)
    grid = numbered(shaken(grid, 3, 0.1))
    grid.points[tri_grid(8).points[:, 0] == 0.5, 0] = 0.5
    was, now = pairs(grid, run(grid, offs=["group=1:0.09"]))
    near = (np.abs(was[:, 0] - 0.5) > 0) & inner(was[:, :2])
    before, after = (np.abs(p[near, 0] - 0.5) for p in (was, now))
    assert np.all(after >= np.minimum(before, 0.09) - NOISE)


@pytest.mark.parametrize(
    ("name", "values", "wrong"),
    [
        ("meshopt:along", np.zeros(16), "must have 3 numbers"),
        ("meshopt:within", np.zeros((16, 2)), "must have 3 numbers"),
        ("meshopt:limit", np.zeros((16, 3)), "must have 4 numbers"),
        ("meshopt:along", np.full((16, 3), np.nan), "not finite at point 0"),
    ],
)
def test_arrays_of_another_shape_are_named(name, values, wrong):
    grid = tri_grid(3)
    grid.point_data[name] = values
    with pytest.raises(BadMeshError, match=wrong):
        run(grid)
