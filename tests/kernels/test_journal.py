"""The journal of composite operations: it never runs out of rows."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.compiled.decorators import entry
from meshopt_cli.kernels import journal
from meshopt_cli.kernels.operators import mend
from meshopt_cli.kernels.types import J_CELLS, MAX_BALL, MAX_CREATED, MAX_KEPT
from support.edits import shaken
from support.invariants import workspace
from support.meshes import tet_grid, tri_grid


@entry
def has_pages(scratch):
    """`journal.has_pages` for Python."""
    return journal.has_pages(scratch)


@entry
def climbed(mesh, cell, scratch):
    """How many rows the journal holds after all vertices of a cell climbed."""
    journal.open_journal(mesh, scratch)
    mend.climb_cell(mesh, cell, scratch)
    return scratch.journal.state[J_CELLS]


def test_an_improvement_finds_room_where_it_is_said_to():
    """One improvement moves the vertices of a cell, or swaps; before it, rows are asked for."""
    most = max(4 * MAX_BALL, 3 * MAX_CREATED)
    assert most <= journal.MARGIN < MAX_KEPT
    work = workspace(tri_grid(2))
    for kept in range(0, MAX_KEPT + 1, 7):
        work.scratch.journal.state[J_CELLS] = kept
        assert not has_pages(work.scratch) or kept + most <= MAX_KEPT


@pytest.mark.parametrize("grid", [tri_grid(6), tet_grid(4)], ids=["triangles", "tets"])
def test_climbing_keeps_the_balls_of_a_cell(grid):
    """What one improvement keeps are the balls of the vertices of one cell, and nothing else."""
    patch = shaken(grid, 0.12)
    for cell in range(0, len(patch.blocks[0].cells), 5):
        work = workspace(patch)
        corners = work.mesh.cells[cell]
        around = np.isin(work.mesh.cells[work.living()], corners).any(axis=1)
        assert climbed(work.mesh, cell, work.scratch) <= around.sum()
