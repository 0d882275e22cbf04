"""Replace the cells of a cavity by others that fill it, with their neighbours."""

from __future__ import annotations

import numpy as np

from ..cells import TET_FACETS, TRI_FACETS
from ..compiled.decorators import kernel
from ..handles import OUTER
from .gather.ball import next_stamp, touch
from .journal import keep
from .judge import q_with
from .types import N_CELLS, N_FREE, Scratch, SimplexMesh
from .vectors import at

UNMATCHED = -(2**63)  # neither a handle nor a border


@kernel
def has_room(mesh: SimplexMesh, n_more: int) -> bool:
    """Whether so many more cells fit the arrays.

    A sweep asks for as many as an operator can make before it visits an entity: so what becomes
    of it does not depend on how much room there happens to be.
    """
    return mesh.state[N_FREE] + mesh.cells.shape[0] - mesh.state[N_CELLS] >= n_more


@kernel
def new_cell(mesh: SimplexMesh, scratch: Scratch) -> int:
    """A row for a new cell: the last one that died, or the next one never used."""
    if mesh.state[N_FREE] > 0:
        mesh.state[N_FREE] -= 1
        cell = mesh.free[mesh.state[N_FREE]]
    else:
        cell = mesh.state[N_CELLS]
        mesh.state[N_CELLS] += 1
    keep(mesh, cell, scratch)
    mesh.alive[cell] = True
    return cell


@kernel
def kill_cell(mesh: SimplexMesh, cell: int) -> None:
    """Put the row of a cell on the stack of those that are free."""
    mesh.alive[cell] = False
    mesh.free[mesh.state[N_FREE]] = cell
    mesh.state[N_FREE] += 1


@kernel
def link(mesh: SimplexMesh, one: int, other: int) -> None:
    """Make two facets, given by their handles, each other's neighbour; one may be a border."""
    if one >= 0:
        mesh.neighbours[one >> 2, one & 3] = other
    if other >= 0:
        mesh.neighbours[other >> 2, other & 3] = one


@kernel
def match_facet(facets: np.ndarray, n: int, a: int, b: int, c: int, handle: int) -> tuple[int, int]:
    """Find the waiting facet with these vertices, or let this one wait.

    Returns
    -------
    other : int
        Handle of the match, which is taken off the list; UNMATCHED when there is none.
    n : int
        Number of waiting facets after the call.
    """
    low = min(a, b, c)
    high = max(a, b, c)
    middle = a + b + c - low - high
    for i in range(n):
        if facets[i, 0] == low and facets[i, 1] == middle and facets[i, 2] == high:
            other = facets[i, 3]
            n -= 1
            for k in range(4):
                facets[i, k] = facets[n, k]
            return other, n
    facets[n, 0] = low
    facets[n, 1] = middle
    facets[n, 2] = high
    facets[n, 3] = handle
    return UNMATCHED, n + 1


@kernel
def match_cell_facet(
    mesh: SimplexMesh, cell: int, k: int, handle: int, n: int, scratch: Scratch
) -> tuple[int, int]:
    """`match_facet` for facet k of a cell; an edge of a triangle has no third vertex."""
    if mesh.cells.shape[1] == 4:
        a = mesh.cells[cell, TET_FACETS[k, 0]]
        b = mesh.cells[cell, TET_FACETS[k, 1]]
        c = mesh.cells[cell, TET_FACETS[k, 2]]
    else:
        a = mesh.cells[cell, TRI_FACETS[k, 0]]
        b = mesh.cells[cell, TRI_FACETS[k, 1]]
        c = -1
    return match_facet(scratch.facets, n, a, b, c, handle)


@kernel
def replace_cells(
    mesh: SimplexMesh, old: np.ndarray, n_old: int, n_new: int, scratch: Scratch
) -> None:
    """Put the first `n_new` rows of `scratch.created` in place of the cells `old`.

    Both sets must fill the same polyhedron, and `has_room` must hold for the difference. Where
    facets of a border become others, each has the border of the one it has most in common with.
    """
    width = mesh.cells.shape[1]
    stamp = next_stamp(scratch)
    region = mesh.region[old[0]]
    for i in range(n_old):
        keep(mesh, old[i], scratch)
        scratch.cell_mark[old[i]] = stamp
    # The facets of the cavity wait, each with what lies beyond it, for the cell that fills it.
    n = 0
    for i in range(n_old):
        for k in range(width):
            beyond = mesh.neighbours[old[i], k]
            if beyond < 0 or scratch.cell_mark[beyond >> 2] != stamp:
                if beyond >= 0:
                    keep(mesh, beyond >> 2, scratch)
                _, n = match_cell_facet(mesh, old[i], k, beyond, n, scratch)
    # The first of the old rows is used again first.
    for i in range(n_old):
        kill_cell(mesh, old[n_old - 1 - i])
    for i in range(n_new):
        cell = new_cell(mesh, scratch)
        mesh.region[cell] = region
        for k in range(width):
            mesh.neighbours[cell, k] = OUTER  # until a facet that waits matches
            mesh.cells[cell, k] = scratch.created[i, k]
            mesh.vertex_cell[scratch.created[i, k]] = cell
        for k in range(width):
            other, n = match_cell_facet(mesh, cell, k, 4 * cell + k, n, scratch)
            if other != UNMATCHED:
                link(mesh, 4 * cell + k, other)
        last = mesh.cells[cell, width - 1]
        mesh.quality[cell] = q_with(mesh, 4 * cell + width - 1, at(mesh.points, last))
        touch(mesh, cell)
    for i in range(n):  # what still waits is on a border, and either new or gone
        handle = scratch.facets[i, 3]
        if handle >= 0:
            mesh.neighbours[handle >> 2, handle & 3] = border_like(scratch.facets, n, i)


@kernel
def border_like(facets: np.ndarray, n: int, i: int) -> int:
    """The border beyond that of some facets which has most vertices in common with one of them."""
    best = OUTER
    most = 0
    for j in range(n):
        if facets[j, 3] < 0:
            common = 0
            for k in range(3):
                for m in range(3):
                    common += facets[i, k] == facets[j, m]
            if common > most:
                most = common
                best = facets[j, 3]
    return best
