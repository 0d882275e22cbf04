"""A journal of what operators change, so that several of them in a row can be undone.

While it is open, every operator calls `keep` for a cell before it changes anything of that cell:
its vertices, its neighbours or the place of a vertex. A composite operation opens it, applies
operators, compares the worst q of what changed before and after, and closes it or rolls back.
"""

from __future__ import annotations

import math

from ..compiled.decorators import kernel
from .accept import UNCHANGED, lowers_mean, with_cell, without
from .types import (
    EDITION,
    J_ACTIVE,
    J_ALIVE,
    J_BEYOND,
    J_CELLS,
    J_CORNERS,
    J_MESH,
    J_REGION,
    J_ROW,
    J_STAMP,
    J_VERTICES,
    MAX_BALL,
    MAX_CREATED,
    MAX_KEPT,
    N_CELLS,
    N_FREE,
    N_POINTS,
    Scratch,
    SimplexMesh,
)

# Cells that are kept at most between two times that `has_pages` is asked: the balls of all vertices
# of a cell, or what one operator replaces, makes and touches.
MARGIN = 4 * MAX_BALL + 3 * MAX_CREATED


@kernel
def open_journal(mesh: SimplexMesh, scratch: Scratch) -> None:
    """Start to remember."""
    journal = scratch.journal
    journal.state[J_ACTIVE] = 1
    journal.state[J_STAMP] += 1
    journal.state[J_CELLS] = 0
    journal.state[J_VERTICES] = 0
    for k in range(mesh.state.shape[0]):
        journal.state[J_MESH + k] = mesh.state[k]


@kernel
def close_journal(scratch: Scratch) -> None:
    """Stop remembering: what was done stays."""
    scratch.journal.state[J_ACTIVE] = 0


@kernel
def has_pages(scratch: Scratch) -> bool:
    """Whether the journal can take one more improvement."""
    return scratch.journal.state[J_CELLS] + MARGIN < MAX_KEPT


@kernel
def keep_vertex(mesh: SimplexMesh, vertex: int, scratch: Scratch) -> None:
    """Remember a vertex before its first change."""
    journal = scratch.journal
    if journal.state[J_ACTIVE] == 0 or journal.vertex_mark[vertex] == journal.state[J_STAMP]:
        return
    journal.vertex_mark[vertex] = journal.state[J_STAMP]
    i = journal.state[J_VERTICES]
    journal.state[J_VERTICES] += 1
    journal.vertices[i, 0] = vertex
    journal.vertices[i, 1] = mesh.vertex_cell[vertex]
    journal.vertices[i, 2] = mesh.vertex_clock[vertex]
    for k in range(3):
        journal.points[i, k] = mesh.points[vertex, k]


@kernel
def keep(mesh: SimplexMesh, cell: int, scratch: Scratch) -> None:
    """Remember a row of the cells, alive or not, and its vertices before their first change."""
    journal = scratch.journal
    if journal.state[J_ACTIVE] == 0 or journal.cell_mark[cell] == journal.state[J_STAMP]:
        return
    journal.cell_mark[cell] = journal.state[J_STAMP]
    i = journal.state[J_CELLS]
    journal.state[J_CELLS] += 1
    journal.quality[i] = mesh.quality[cell]
    journal.cells[i, J_ROW] = cell
    journal.cells[i, J_REGION] = mesh.region[cell]
    journal.cells[i, J_ALIVE] = mesh.alive[cell]
    for k in range(mesh.cells.shape[1]):
        journal.cells[i, J_CORNERS + k] = mesh.cells[cell, k]
        journal.cells[i, J_BEYOND + k] = mesh.neighbours[cell, k]
        keep_vertex(mesh, mesh.cells[cell, k], scratch)


@kernel
def roll_back(mesh: SimplexMesh, scratch: Scratch) -> None:
    """Undo all changes since the journal was opened, and close it."""
    journal = scratch.journal
    for i in range(journal.state[J_CELLS]):
        cell = journal.cells[i, J_ROW]
        mesh.quality[cell] = journal.quality[i]
        mesh.alive[cell] = journal.cells[i, J_ALIVE] == 1
        mesh.region[cell] = journal.cells[i, J_REGION]
        for k in range(mesh.cells.shape[1]):
            mesh.cells[cell, k] = journal.cells[i, J_CORNERS + k]
            mesh.neighbours[cell, k] = journal.cells[i, J_BEYOND + k]
    for i in range(journal.state[J_VERTICES]):
        vertex = journal.vertices[i, 0]
        mesh.vertex_cell[vertex] = journal.vertices[i, 1]
        mesh.vertex_clock[vertex] = journal.vertices[i, 2]
        for k in range(3):
            mesh.points[vertex, k] = journal.points[i, k]
    for k in (N_CELLS, N_FREE, N_POINTS, EDITION):
        mesh.state[k] = journal.state[J_MESH + k]
    # The rows that were taken off the stack of dead cells go back there.
    top = mesh.state[N_FREE]
    for i in range(journal.state[J_CELLS]):
        row = journal.cells[i, J_ROW]
        if journal.cells[i, J_ALIVE] == 0 and row < mesh.state[N_CELLS]:
            top -= 1
            mesh.free[top] = row
    close_journal(scratch)


@kernel
def changed(mesh: SimplexMesh, scratch: Scratch, i: int) -> bool:
    """Whether the i-th kept cell is another one now, or gone."""
    journal = scratch.journal
    cell = journal.cells[i, J_ROW]
    if mesh.alive[cell] != (journal.cells[i, J_ALIVE] == 1):
        return True
    return mesh.alive[cell] and mesh.quality[cell] != journal.quality[i]


@kernel
def worst_before(mesh: SimplexMesh, scratch: Scratch) -> float:
    """Worst q that the changed cells had when the journal was opened."""
    journal = scratch.journal
    worst = math.inf
    for i in range(journal.state[J_CELLS]):
        if journal.cells[i, J_ALIVE] == 1 and changed(mesh, scratch, i):
            worst = min(worst, journal.quality[i])
    return worst


@kernel
def worst_after(mesh: SimplexMesh, scratch: Scratch) -> tuple[int, float]:
    """The worst cell that changed since the journal was opened, and its q; -1 if there is none."""
    journal = scratch.journal
    worst = math.inf
    weakest = -1
    for i in range(journal.state[J_CELLS]):
        cell = journal.cells[i, J_ROW]
        if mesh.alive[cell] and mesh.quality[cell] < worst and changed(mesh, scratch, i):
            worst = mesh.quality[cell]
            weakest = cell
    return weakest, worst


@kernel
def has_lower_mean(mesh: SimplexMesh, scratch: Scratch) -> bool:
    """Whether the mean Q of what changed since the journal was opened has fallen."""
    journal = scratch.journal
    sums = UNCHANGED
    for i in range(journal.state[J_CELLS]):
        if changed(mesh, scratch, i):
            if journal.cells[i, J_ALIVE] == 1:
                sums = without(sums, journal.quality[i])
            if mesh.alive[journal.cells[i, J_ROW]]:
                sums = with_cell(sums, mesh.quality[journal.cells[i, J_ROW]])
    return lowers_mean(sums)
