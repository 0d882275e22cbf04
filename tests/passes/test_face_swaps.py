"""Swaps of triangles and quads of a plane that share an edge (Figure 18.9)."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.mesh.any_cells import cast_any
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.passes.swap import Swap
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import check
from meshopt_cli.work.face_work import FaceWork
from meshopt_cli.work.faces import best_of
from support.meshes import mesh, quad_grid

JUDGE = MEASURES["scaled-jacobian"].judge
ANGLES = 2 * np.pi * np.arange(6) / 6
HEXAGON = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)


def swapped(one, **options):
    """What comes of one pass, and how many swaps there were."""
    work = FaceWork(cast_any(one), JUDGE)
    tally = Swap(**options).run(work)
    work.require_fresh()
    sets = {group.family: group.cells for group in work.result().cell_sets}
    return sets, tally.applied, work.standing()


def outlines(cells):
    """Faces by their corners, wherever they begin."""
    return {tuple(np.roll(row, -int(np.argmin(row))).tolist()) for row in cells}


@pytest.mark.parametrize("turn", [1, 2])
def test_two_quads_take_either_other_diagonal(turn):
    """An outline that is two squares side by side, divided across."""
    box = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]], dtype=float)
    good = [[0, 1, 4, 5], [1, 2, 3, 4]]
    bad = {1: [[1, 2, 5, 0], [2, 3, 4, 5]], 2: [[0, 1, 2, 3], [3, 4, 5, 0]]}[turn]
    points = box + 0.05 * HEXAGON  # so that no corner is flat
    sets, n, standing = swapped(mesh(points, quad=bad))
    assert n == 1
    assert outlines(sets["quad"]) == outlines(good)
    assert standing.worst > 0.8


def test_a_triangle_and_a_quad_change_their_places():
    """A house: a square with a roof, divided so that the triangle has two of its walls."""
    points = np.array([[0, 0], [1, 0], [1, 1], [0.5, 1.8], [0, 1]])
    one = mesh(points, triangle=[[0, 1, 2]], quad=[[0, 2, 3, 4]])
    sets, n, _ = swapped(one)
    assert n == 1
    assert outlines(sets["triangle"]) == {(2, 3, 4)}
    assert outlines(sets["quad"]) == {(0, 1, 2, 4)}


def test_two_triangles_among_quads_are_flipped():
    points = np.array([[0, 0], [2, -0.3], [4, 0], [2, 0.3], [6, 0], [6, 2], [4, 2]])
    one = mesh(points, triangle=[[0, 1, 2], [0, 2, 3]], quad=[[2, 4, 5, 6]])
    sets, n, _ = swapped(one)
    assert n == 1
    assert outlines(sets["triangle"]) == {(0, 1, 3), (1, 2, 3)}


def bad_pair():
    box = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]], dtype=float)
    return mesh(box + 0.05 * HEXAGON, quad=[[1, 2, 5, 0], [2, 3, 4, 5]])


def test_what_stays_is_not_swapped():
    one = bad_pair()
    assert swapped(one)[1] == 1
    in_two = replace(one, blocks=[replace(one.blocks[0], data={"part": np.array([1, 2])})])
    declared = replace(one, blocks=[*one.blocks, Block("line", np.array([[2, 5]]))])
    required = {"medit:required": np.array([1, 0])}
    kept = replace(one, blocks=[replace(one.blocks[0], data=required)])
    for other in (in_two, declared, kept):
        assert swapped(other)[1] == 0


@pytest.mark.parametrize("accept", ["strict", "ratio", "floor", "mean"])
@pytest.mark.parametrize("seed", range(3))
def test_a_mesh_stays_one_and_gets_no_worse(accept, seed):
    grid = quad_grid(6)
    quads = grid.blocks[0].cells
    rng = np.random.default_rng(seed)
    halved = rng.random(len(quads)) < 0.4
    halves = np.concatenate([quads[halved][:, [0, 1, 2]], quads[halved][:, [0, 2, 3]]])
    inside = np.all((grid.points > 0) & (grid.points < 1), axis=1)
    points = grid.points.copy()
    points[inside] += rng.uniform(-0.06, 0.06, (inside.sum(), 2))
    one = Mesh(points, [Block("triangle", halves), Block("quad", quads[~halved])])
    assert check(one).is_valid
    work = FaceWork(cast_any(one), JUDGE)
    before = work.standing()
    applied = 0
    for _ in range(5):
        applied += Swap(accept=accept, least_quality=0.2).run(work).applied
    assert applied > 0
    sets = [Block(group.family, group.cells) for group in work.result().cell_sets]
    assert [len(block.cells) for block in sets] == [len(block.cells) for block in one.blocks]
    assert check(Mesh(points, sets)).is_valid
    if accept == "strict":
        assert work.standing().worst >= before.worst
    if accept == "mean":
        assert work.standing().mean < before.mean


def test_edges_inside_are_looked_at_once_and_an_ideal_grid_stays():
    grid = quad_grid(4)
    work = FaceWork(cast_any(grid), JUDGE)
    found = best_of(work.swaps())
    assert len(found.rows) == 24  # edges inside
    assert Swap().run(work).applied == 0
