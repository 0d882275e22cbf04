"""Proof that a working mesh is whole: what every operator must leave true."""

from __future__ import annotations

from ..compiled.decorators import entry
from .gather.ball import local_index
from .types import N_CELLS, SimplexMesh

WHOLE, NOT_POSITIVE, NOT_MUTUAL, NOT_SHARED, NOT_IN_BALL = range(5)


@entry(group="basic", example=lambda work: (work.mesh, 0.0))
def audit(mesh: SimplexMesh, least: float) -> tuple[int, int]:
    """Look for the first living cell that breaks a promise.

    Parameters
    ----------
    least : float
        What the q of every cell must exceed.

    Returns
    -------
    fault : int
        WHOLE; NOT_POSITIVE: q is not above `least`; NOT_MUTUAL: a neighbour does not lead back
        or is dead; NOT_SHARED: two neighbours do not have the same facet; NOT_IN_BALL: the cell
        noted for a vertex does not have it.
    cell : int
        The cell at fault, -1 without.
    """
    width = mesh.cells.shape[1]
    for cell in range(mesh.state[N_CELLS]):
        if not mesh.alive[cell]:
            continue
        if not mesh.quality[cell] > least:
            return NOT_POSITIVE, cell
        for k in range(width):
            noted = mesh.vertex_cell[mesh.cells[cell, k]]
            if noted < 0 or not mesh.alive[noted]:
                return NOT_IN_BALL, cell
            if local_index(mesh.cells, noted, mesh.cells[cell, k]) < 0:
                return NOT_IN_BALL, cell
            beyond = mesh.neighbours[cell, k]
            if beyond < 0:
                continue
            other = beyond >> 2
            if not mesh.alive[other] or mesh.neighbours[other, beyond & 3] != 4 * cell + k:
                return NOT_MUTUAL, cell
            for j in range(width):
                if j != k and local_index(mesh.cells, other, mesh.cells[cell, j]) < 0:
                    return NOT_SHARED, cell
    return WHOLE, -1
