"""Collapses and degrees of triangles and quads of a plane (18.4.2)."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.mesh.any_cells import cast_any, with_cells
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes.collapse import Collapse
from meshopt_cli.passes.relax import Relax
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import check
from meshopt_cli.work.face_work import FaceWork
from support.meshes import mesh, quad_grid

JUDGE = MEASURES["scaled-jacobian"].judge


def run_on(one, *passes):
    """The mesh that comes of some passes, its working state, and how many changes there were."""
    part = cast_any(one)
    work = FaceWork(part, JUDGE)
    applied = [step.run(work).applied for step in passes]
    work.require_fresh()
    return with_cells(one, part, work.result()), work, sum(applied)


def split_quad():
    """Four squares with a thin quad between the upper two and the lower: two vertices for one."""
    side = np.array([0.0, 1.0, 2.0])
    points = [[x, y] for y in side for x in side]
    points[4] = [1.0, 1.1]
    points.append([1.0, 0.9])
    quads = [[0, 1, 9, 3], [1, 2, 5, 9], [3, 4, 7, 6], [4, 5, 8, 7], [3, 9, 5, 4]]
    return mesh(np.array(points), quad=quads)


def crowded(seed, halves=0.4):
    """A shaken grid of quads and triangles, some vertices of which are two with a quad between."""
    grid = quad_grid(7)
    quads, points = grid.blocks[0].cells.copy(), grid.points.copy()
    rng = np.random.default_rng(seed)
    place = np.round(points * 7)
    chosen = np.flatnonzero(np.all((place % 3 == 2) & (place < 7), axis=1))
    middle = points[quads].mean(axis=1)
    thin, new = [], []
    for v in chosen.tolist():
        above = (quads == v) & (middle[:, 1] > points[v, 1])[:, None]
        left, right = (int(np.argmin(np.abs(points - points[v] - [x / 7, 0]).sum(axis=1)))
                       for x in (-1, 1))  # fmt: skip
        quads[above] = len(points) + len(new)
        thin.append([left, v, right, len(points) + len(new)])
        new.append(points[v] + [0.0, 0.03])
        points[v, 1] -= 0.03
    points = np.concatenate([points, new])
    inside = np.all((points > 0) & (points < 1), axis=1)
    points[inside] += rng.uniform(-0.01, 0.01, (inside.sum(), 2))
    halved = rng.random(len(quads)) < halves
    cut = quads[halved]
    triangles = np.concatenate([cut[:, [0, 1, 2]], cut[:, [0, 2, 3]]])
    blocks = [Block("triangle", triangles), Block("quad", np.concatenate([quads[~halved], thin]))]
    return Mesh(points, [block for block in blocks if len(block.cells)])


def area(one):
    total = 0.0
    for block in one.blocks:
        p = one.points[block.cells]
        q = np.roll(p, -1, axis=1)
        total += float((p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]).sum()) / 2
    return total


def test_a_quad_goes_where_two_of_its_corners_meet():
    one = split_quad()
    assert check(one).is_valid
    result, work, applied = run_on(one, Collapse(worse_than=1.0))
    assert applied == 1
    assert len(result.blocks[0].cells) == 4
    assert len(result.points) == 9
    assert work.standing().worst > 0.9
    assert check(result).is_valid
    assert area(result) == pytest.approx(4.0)


def test_rows_and_points_that_are_left_keep_what_they_had():
    one = split_quad()
    one.blocks[0].data["number"] = np.arange(5.0)
    one.point_data["x"] = one.points[:, 0].copy()
    one.blocks.append(Block("line", np.array([[0, 1], [1, 2]])))
    result, _, _ = run_on(one, Collapse(worse_than=1.0))
    assert result.blocks[0].data["number"].tolist() == [0, 1, 2, 3]
    assert len(result.point_data["x"]) == 9
    assert np.array_equal(result.points[result.blocks[1].cells], one.points[[[0, 1], [1, 2]]])


def test_two_triangles_go_with_their_edge():
    angles = 2 * np.pi * np.arange(6) / 6
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.concatenate([ring, [[0.05, 0.0], [-0.05, 0.0]], [[2.0, 0.9], [2.0, 0.0]]])
    one = mesh(
        points,
        triangle=[[0, 1, 6], [1, 7, 6], [1, 2, 7], [2, 3, 7], [3, 4, 7], [4, 6, 7], [4, 5, 6],
                  [5, 0, 6]],
        quad=[[0, 9, 8, 1]],
    )  # fmt: skip
    assert check(one).is_valid
    result, _, applied = run_on(one, Collapse(worse_than=1.0))
    assert applied >= 1
    assert check(result).is_valid
    assert [len(block.cells) for block in result.blocks] == [6, 1]
    assert area(result) == pytest.approx(area(one))


def test_a_triangle_takes_the_place_that_a_quad_is_left_with():
    """A short edge between a triangle and a quad."""
    points = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1.0, 0.96], [1.0, 1.04]], dtype=float)
    one = mesh(points, triangle=[[0, 4, 5], [0, 5, 3], [0, 1, 4], [2, 3, 5]], quad=[[4, 1, 2, 5]])
    assert check(one).is_valid
    result, _, applied = run_on(one, Collapse(worse_than=1.0))
    assert applied == 1
    assert {block.type: len(block.cells) for block in result.blocks if len(block.cells)} == {
        "triangle": 4
    }
    assert check(result).is_valid
    assert area(result) == pytest.approx(4.0)


def test_what_is_held_stays():
    one = split_quad()
    in_two = replace(one, blocks=[replace(one.blocks[0], data={"part": np.array([1, 1, 2, 2, 1])})])
    both = replace(one, blocks=[*one.blocks, Block("vertex", np.array([[4], [9]]))])
    kept = replace(one, blocks=[replace(one.blocks[0], data={"medit:required": np.arange(5) > 3})])
    for other in (both, kept):
        result, _, applied = run_on(other, Collapse(worse_than=1.0), Relax())
        assert applied == 0
        assert np.array_equal(result.points, one.points)
    result, _, _ = run_on(in_two, Collapse(worse_than=1.0))
    held = cast_any(in_two).fixed
    there = {tuple(p) for p in result.points.tolist()}
    assert {tuple(p) for p in one.points[held].tolist()} <= there


def test_vertices_enough_are_left():
    _, _, applied = run_on(split_quad(), Collapse(worse_than=1.0, min_vertices=1.0))
    assert applied == 0
    _, _, applied = run_on(split_quad(), Collapse(worse_than=1.0, max_growth=0.4))
    assert applied == 0


@pytest.mark.parametrize("accept", ["strict", "ratio", "floor", "mean"])
@pytest.mark.parametrize("seed", range(3))
def test_a_mesh_stays_one_and_gets_no_worse(accept, seed):
    one = crowded(seed)
    assert check(one).is_valid
    part = cast_any(one)
    before = FaceWork(part, JUDGE).standing()
    step = Collapse(worse_than=1.0, accept=accept, least_quality=0.2, min_vertices=0.5)
    result, work, applied = run_on(one, step, step, step)
    assert applied > 0
    assert check(result).is_valid
    assert area(result) == pytest.approx(1.0)
    assert len(result.points) == work.n_vertices >= 0.5 * len(one.points)
    fixed = one.points[part.fixed].tolist()
    assert {tuple(p) for p in fixed} <= {tuple(p) for p in result.points.tolist()}
    if accept == "strict":
        assert work.standing().worst >= before.worst


def off(work):
    degree, target = work.degrees()
    used = np.diff(work.mesh.ball_start) > 0
    return float(((degree - target)[used] ** 2).sum())


@pytest.mark.parametrize("halves", [0.0, 0.4])
@pytest.mark.parametrize("seed", range(3))
def test_degrees_come_nearer_to_their_target(halves, seed):
    one = crowded(seed, halves)
    before = FaceWork(cast_any(one), JUDGE)
    result, work, applied = run_on(one, Relax(), Relax())
    assert applied > 0
    assert off(work) < off(before)
    assert check(result).is_valid
    assert area(result) == pytest.approx(1.0)
    assert work.standing().worst >= min(before.standing().worst, Relax().least_quality)


def test_degrees_are_those_of_edges():
    work = FaceWork(cast_any(quad_grid(3)), JUDGE)
    degree, target = work.degrees()
    assert np.array_equal(degree, target)
    assert sorted(degree.tolist()) == [2.0] * 4 + [3.0] * 8 + [4.0] * 4


def test_an_ideal_grid_stays():
    _, _, applied = run_on(quad_grid(4), Collapse(), Relax())
    assert applied == 0


@pytest.mark.parametrize("seed", range(3))
def test_what_is_collapsed_is_counted_by_its_kind(seed):
    one = crowded(seed)
    work = FaceWork(cast_any(one), JUDGE)
    before = work.n_cells
    tally = Collapse(worse_than=1.0, accept="floor", least_quality=0.2, min_vertices=0.5).run(work)
    found = tally.kinds["collapsed"]
    assert sum(found.values()) == tally.applied > 0
    assert set(found) <= {"quad", "triangle-quad", "triangle-triangle"}
    # Of a pair of triangles both go; of a triangle and a quad the latter.
    assert before - work.n_cells == tally.applied + found.get("triangle-triangle", 0)
