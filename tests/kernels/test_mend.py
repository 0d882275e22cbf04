"""Composite operations: they pay or leave no trace; the types of bad cells and their remedies."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.kernels.operators.mend import Mending, Remedy, sweep_mend
from meshopt_cli.kernels.shape.classify import TetType, TriangleType, classify_cells
from meshopt_cli.kernels.types import APPLIED, N_VERDICTS, NOT_BETTER
from meshopt_cli.passes import PASSES
from meshopt_cli.passes.mend import REMEDIES, remedy_table
from meshopt_cli.progress.observer import Silent
from support import drivers
from support.edits import shaken
from support.invariants import assert_kept, assert_whole, snapshot, workspace
from support.meshes import tet_grid, tri_grid
from support.samples import sample

# Four vertices each: the shapes that Exercise 18.6 tells apart.
SHAPES = {
    TetType.REGULAR: [[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]],
    TetType.SPADE: [[0, 0, 0], [2, 0, 0], [1, 1.5, 0], [1, 0, 0.2]],
    TetType.SLIVER: [[1, 0, 0.05], [-1, 0, 0.05], [0, 1, -0.05], [0, -1, -0.05]],
    TetType.CAP: [[0, 0, 0], [2, 0, 0], [1, 1.7, 0], [1, 0.6, 0.1]],
    TetType.WEDGE: [[0, 0, 0], [0.1, 0, 0], [0, 1, 0], [0, 0.5, 0.9]],
    TetType.SPINDLE: [[0, 0, 0], [0.1, 0, 0], [0, 0, 1], [0, 0.1, 1]],
    TetType.SPEAR: [[0, 0, 0], [0.55, 0, 0], [1.1, 0.05, 0], [0.55, 0.1, 2]],
    TetType.NEEDLE: [[0, 0, 0], [0.1, 0, 0], [0.05, 0.09, 0], [0.05, 0.03, 2]],
}


@pytest.mark.parametrize("kind", TetType, ids=lambda kind: kind.name.lower())
def test_types(kind):
    """Each shape has its type, in whatever order its vertices are listed."""
    corners = np.array(SHAPES[kind], dtype=float)
    generator = np.random.default_rng(0)
    for _ in range(6):
        order = generator.permutation(4)
        assert drivers.type_of(corners, order) == kind


TRIANGLES = {
    TriangleType.REGULAR: [[0, 0, 0], [1, 0, 0], [0.4, 0.8, 0]],
    TriangleType.NEEDLE: [[0, 0, 0], [0.2, 0, 0], [0.1, 1, 0]],
    TriangleType.CAP: [[0, 0, 0], [1, 0, 0], [0.5, 0.2, 0]],
}


@pytest.mark.parametrize("shapes", [TRIANGLES, SHAPES], ids=["triangles", "tets"])
def test_types_are_told_apart(shapes):
    """Every cell has one, whatever its size and the order of its vertices."""
    corners = [np.array(shape, dtype=float) * 7.0**i for i, shape in enumerate(shapes.values())]
    cells = np.arange(sum(map(len, corners))).reshape(len(corners), -1)
    for order in itertools.permutations(range(cells.shape[1])):
        found = np.full(len(shapes), -1)
        classify_cells(np.concatenate(corners), np.ascontiguousarray(cells[:, order]), found)
        assert found.tolist() == [int(kind) for kind in shapes]


@given(st.lists(st.floats(-1, 1), min_size=12, max_size=12))
def test_every_cell_has_one_type(numbers):
    points = np.array(numbers).reshape(4, 3)
    for width, types in ((3, TriangleType), (4, TetType)):
        found = np.array([-1])
        classify_cells(points, np.arange(width)[None], found)
        assert types(found[0]) in types


def test_every_type_has_remedies():
    """A vertex is the last resort of all but the shapes that a collapse removes for good."""
    assert set(REMEDIES) == set(TetType)
    for remedies in REMEDIES.values():
        assert Remedy.INSERT in remedies
        assert len(set(remedies)) == len(remedies)


def badly_placed(dimension, seed):
    """A small grid whose inner vertices are badly placed, with room for more."""
    grid = tri_grid(5) if dimension == 2 else tet_grid(3)
    source = shaken(grid, 1.0, seed)
    work = workspace(source)
    work.reserve_points(2 * work.n_input_points)
    while len(work.mesh.cells) < 2 * work.n_cells + 512:
        work.grow()
    return work


def mended(mesh, cell, table, how, scratch):
    """The verdict of a sweep over one cell."""
    counts = np.zeros(N_VERDICTS, dtype=np.int64)
    sweep_mend(mesh, np.array([cell]), table, how, scratch, counts)
    (verdict,) = np.flatnonzero(counts)
    return verdict


def trace(work):
    """Every byte that means anything: not the rows of dead cells, nor of vertices to come."""
    return {n: a for n, a in snapshot(work).items() if n not in ("free", "fixed")}


@pytest.mark.parametrize("dimension", [2, 3])
def test_mended_or_as_it_was(dimension):
    """A cell is mended, and the worst q of what changed rises; or every byte is as before."""
    work = badly_placed(dimension, 5)
    verdicts = set()
    table = remedy_table()
    for least_kept in (0.9, 0.2):
        how = Mending(1.0, least_kept, 0.01, len(work.mesh.points), 2, 5, math.inf)
        for cell in range(len(work.living())):
            if not work.mesh.alive[cell]:
                continue
            before = trace(work)
            standing = work.standing()
            verdict = mended(work.mesh, cell, table, how, work.scratch)
            verdicts.add(verdict)
            if verdict == NOT_BETTER:
                assert trace(work) == before
            else:
                assert_whole(work)
                assert work.standing().worst >= standing.worst
    assert verdicts == {APPLIED, NOT_BETTER}


def test_nothing_changes_where_no_gain_is_enough():
    """Every change is undone when none may be kept: all bytes are those of the start."""
    work = badly_placed(3, 6)
    before = trace(work)
    how = Mending(1.0, 0.3, 1e9, len(work.mesh.points), 2, 5, math.inf)
    for cell in work.living():
        assert mended(work.mesh, cell, remedy_table(), how, work.scratch) == NOT_BETTER
    assert trace(work) == before


@pytest.mark.parametrize("rings", [1, 3])
def test_rings_help(rings):
    """Work on the cells around those that stay bad leaves fewer of these."""
    source = sample("raw_ball.mesh")
    alone, with_rings = workspace(source), workspace(source)
    for _ in range(3):
        PASSES["mend"](worse_than=1.84).run(alone, Silent())
        PASSES["mend"](worse_than=1.84, max_rings=rings).run(with_rings, Silent())
    assert_kept(source, with_rings)
    assert len(with_rings.worse_cells(1 / 1.84)) < len(alone.worse_cells(1 / 1.84))


def test_late_visits_cost_nothing():
    """Where nothing changed since the last visit, nothing is tried again."""
    work = workspace(sample("raw_ball.mesh"))
    step = PASSES["mend"](max_rings=2)
    while step.run(work, Silent()).applied:
        pass
    assert step.run(work, Silent()).visited == 0
