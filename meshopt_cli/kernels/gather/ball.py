"""The ball of a vertex: the cells that share it (Definition 18.5)."""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..types import CLOCK, EDITION, MAX_BALL, N_CELLS, AnyMesh, Scratch, SimplexMesh
from ..vectors import Vec, at, square_distance


@inlined
def local_index(cells: np.ndarray, cell: int, vertex: int) -> int:
    """Local number of a vertex in a cell, -1 when the cell does not have it."""
    for k in range(cells.shape[1]):
        if cells[cell, k] == vertex:
            return k
    return -1


@inlined
def next_stamp(scratch: Scratch) -> int:
    """Clear all marks of the working space at once."""
    scratch.stamp[0] += 1
    return scratch.stamp[0]


@kernel
def gather_ball(
    mesh: SimplexMesh, vertex: int, ball: np.ndarray, scratch: Scratch
) -> tuple[int, bool]:
    """Collect the handles of the cells around a vertex.

    Parameters
    ----------
    ball : (MAX_BALL,) int64
        Receives one handle `4 * cell + local number of the vertex` a cell.

    Returns
    -------
    n : int
        Number of cells; -1 when they do not fit, 0 for a vertex without cells.
    closed : bool
        Whether no facet at the vertex is on the boundary.
    """
    first = mesh.vertex_cell[vertex]
    if first < 0:
        return 0, False
    stamp = next_stamp(scratch)
    mark = scratch.cell_mark
    d1 = mesh.cells.shape[1]
    ball[0] = 4 * first + local_index(mesh.cells, first, vertex)
    mark[first] = stamp
    n = 1
    i = 0
    closed = True
    while i < n:
        cell = ball[i] >> 2
        local = ball[i] & 3
        i += 1
        for k in range(d1):
            if k == local:
                continue
            beyond = mesh.neighbours[cell, k]
            if beyond < 0:
                closed = False
                continue
            neighbour = beyond >> 2
            if mark[neighbour] == stamp:
                continue
            if n == MAX_BALL:
                return -1, closed
            mark[neighbour] = stamp
            ball[n] = 4 * neighbour + local_index(mesh.cells, neighbour, vertex)
            n += 1
    return n, closed


@inlined
def worst_of(mesh: AnyMesh, ball: np.ndarray, n: int) -> float:
    """Worst q of the cells of a ball, as stored."""
    worst = math.inf
    for i in range(n):
        worst = min(worst, mesh.quality[ball[i] >> 2])
    return worst


@inlined
def sum_of(mesh: AnyMesh, ball: np.ndarray, n: int) -> float:
    """Sum of the Q of the cells of a ball, as stored."""
    total = 0.0
    for i in range(n):
        total += 1.0 / mesh.quality[ball[i] >> 2]
    return total


@kernel
def longest_edge_at(mesh: SimplexMesh, ball: np.ndarray, n: int, p: Vec) -> float:
    """Length of the longest edge from p to the vertices of a ball other than its own."""
    longest = 0.0
    for i in range(n):
        cell = ball[i] >> 2
        for k in range(mesh.cells.shape[1]):
            if k != ball[i] & 3:
                q = at(mesh.points, mesh.cells[cell, k])
                longest = max(longest, square_distance(p, q))
    return math.sqrt(longest)


@inlined
def touch(mesh: SimplexMesh, cell: int) -> None:
    """Note that something around the vertices of a cell changed in the current sweep."""
    clock = mesh.state[CLOCK]
    for k in range(mesh.cells.shape[1]):
        mesh.vertex_clock[mesh.cells[cell, k]] = clock
    mesh.state[EDITION] += 1


@entry(group="basic", example=lambda work: (work.mesh, work.vertex_values))
def vertex_quality(mesh: SimplexMesh, out: np.ndarray) -> None:
    """Worst q of the ball of each vertex, written to `out` (np,); inf without cells."""
    out[:] = math.inf
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            for k in range(mesh.cells.shape[1]):
                v = mesh.cells[cell, k]
                out[v] = min(out[v], mesh.quality[cell])
