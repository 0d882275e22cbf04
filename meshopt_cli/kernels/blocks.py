"""Blocks of a mesh: which cells and vertices each has for itself."""

from __future__ import annotations

import numpy as np

from ..compiled.decorators import entry, inlined
from ..handles import RIM
from .cavity import link
from .types import N_CELLS, SimplexMesh

# What `find_homes` gives to vertices that no block has for itself.
NO_CELLS = -2
ON_RIM = -1


@inlined
def owner_of(mesh: SimplexMesh, cell: int, label: np.ndarray) -> int:
    """The block of a cell: the least of its vertices' labels.

    So the rim between two blocks is one layer of vertices, on the side of the greater label.
    """
    owner = label[mesh.cells[cell, 0]]
    for k in range(1, mesh.cells.shape[1]):
        owner = min(owner, label[mesh.cells[cell, k]])
    return owner


@entry(group="blocks", example=lambda work: (work.mesh, work.order, work.order, work.order))
def find_homes(mesh: SimplexMesh, label: np.ndarray, owner: np.ndarray, home: np.ndarray) -> None:
    """The block of each cell, and the one that has all cells at a vertex, for each vertex.

    Parameters
    ----------
    label : (np,) int64
        From 0 on; any will do.
    owner : (capacity,) int64
        Receives the block of each living cell.
    home : (np,) int64
        Receives that of each vertex; ON_RIM where several blocks have such cells, NO_CELLS where
        there are none.
    """
    home[:] = NO_CELLS
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            owner[cell] = owner_of(mesh, cell, label)
            for k in range(mesh.cells.shape[1]):
                v = mesh.cells[cell, k]
                if home[v] == NO_CELLS:
                    home[v] = owner[cell]
                elif home[v] != owner[cell]:
                    home[v] = ON_RIM


@entry(group="blocks", example=lambda work: (work.mesh, *(work.order,) * 4))
def find_blocks(
    mesh: SimplexMesh, order: np.ndarray, owner: np.ndarray, home: np.ndarray, block: np.ndarray
) -> None:
    """The blocks of some cells, alive or not, that have no edge on a rim.

    Parameters
    ----------
    order : (n,) int64
        The cells.
    owner, home : (capacity,) and (np,) int64
        See `find_homes`.
    block : (n,) int64
        Receives them; -1 for other cells.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        block[i] = -1
        if mesh.alive[cell]:
            n = 0
            for k in range(mesh.cells.shape[1]):
                n += home[mesh.cells[cell, k]] == ON_RIM
            if n < 2:
                block[i] = owner[cell]


@entry(group="blocks", example=lambda work: (work.mesh, work.order))
def cut_rims(mesh: SimplexMesh, owner: np.ndarray) -> int:
    """Let the mesh end between blocks, at borders of `handles.RIM`; `sew_rims` undoes it.

    Parameters
    ----------
    owner : (capacity,) int64
        The block of each living cell.

    Returns
    -------
    n : int
        Number of facets between blocks.
    """
    n = 0
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            for k in range(mesh.cells.shape[1]):
                beyond = mesh.neighbours[cell, k]
                if beyond >= 0 and owner[beyond >> 2] != owner[cell]:
                    mesh.neighbours[cell, k] = RIM - n
                    mesh.neighbours[beyond >> 2, beyond & 3] = RIM - n
                    n += 1
    return n


@entry(group="blocks", example=lambda work: (work.mesh, work.order, work.order))
def sew_rims(mesh: SimplexMesh, home: np.ndarray, waiting: np.ndarray) -> None:
    """Make the facets at each border of `handles.RIM` neighbours again.

    Of the balls of vertices on rims, which several blocks have cells of, the first cell is the one
    with the least row.

    Parameters
    ----------
    home : (np,) int64
        Of the vertices before the blocks were worked on: see `find_homes`.
    waiting : (n,) int64
        Working space, -1 for each facet between blocks.
    """
    for vertex in range(home.shape[0]):
        if home[vertex] == ON_RIM:
            mesh.vertex_cell[vertex] = -1
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            for k in range(mesh.cells.shape[1]):
                v = mesh.cells[cell, k]
                if home[v] == ON_RIM and mesh.vertex_cell[v] < 0:
                    mesh.vertex_cell[v] = cell
                beyond = mesh.neighbours[cell, k]
                if beyond <= RIM:
                    if waiting[RIM - beyond] < 0:
                        waiting[RIM - beyond] = 4 * cell + k
                    else:
                        link(mesh, 4 * cell + k, waiting[RIM - beyond])
