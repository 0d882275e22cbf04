"""The edges of many cells of any family, each once, with the cells around it.

Each edge of each cell is listed at its lower end, in segments one after the other: no sorting.
"""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import entry

N_KINDS = 8  # kinds of edges of cells
RIM = N_KINDS - 1  # the kind of an edge of the boundary, which is listed besides those of cells
LEAST = 8  # a count of cells is less than so many below its target


@entry(group="basic", example=lambda work: (work.mesh.cells, work.facets, work.order))
def count_ends(cells: np.ndarray, edges: np.ndarray, start: np.ndarray) -> None:
    """Count the edges of cells by their lower ends.

    Parameters
    ----------
    cells : (n, k) int64
    edges : (n_edges, 2) int64
        Local ends.
    start : (np + 2,) int64
        To `start[v + 2]`, the number of edges up from v is added.
    """
    for i in range(cells.shape[0]):
        for e in range(edges.shape[0]):
            start[min(cells[i, edges[e, 0]], cells[i, edges[e, 1]]) + 2] += 1


@entry(
    group="basic",
    example=lambda work: (work.mesh.cells, work.facets, work.order, work.order, work.order),
)
def list_ends(
    cells: np.ndarray, edges: np.ndarray, kinds: np.ndarray, start: np.ndarray, ends: np.ndarray
) -> None:
    """List the upper ends of the edges of cells, each with the kind of the edge.

    Parameters
    ----------
    kinds : (n_edges,) int64
        Below `N_KINDS`.
    start : (np + 2,) int64
        Sums of what `count_ends` gives. Once all edges are listed, those up from v are in
        `ends[start[v]:start[v + 1]]`.
    ends : (m,) int64
        `N_KINDS * vertex + kind`.
    """
    for i in range(cells.shape[0]):
        for e in range(edges.shape[0]):
            one = cells[i, edges[e, 0]]
            other = cells[i, edges[e, 1]]
            lower = min(one, other) + 1
            ends[start[lower]] = N_KINDS * max(one, other) + kinds[e]
            start[lower] += 1


@entry(
    group="basic",
    example=lambda work: (
        work.order, work.order, work.vertex_values, work.order, work.order, work.vertex_values,
        work.order, work.order, work.order,
    ),
)  # fmt: skip
def count_degrees(
    start: np.ndarray,
    ends: np.ndarray,
    angles: np.ndarray,
    place: np.ndarray,
    around: np.ndarray,
    claimed: np.ndarray,
    degree: np.ndarray,
    counts: np.ndarray,
    excess: np.ndarray,
) -> None:
    """Degrees of vertices, and how many cells there are around the edges inside.

    An edge should have as many cells as fit around it, or one more, by the angles that its cells
    claim: 5 or 6 tets, 4 hexahedra.

    Parameters
    ----------
    start, ends : (np + 2,) and (m,) int64
        See `list_ends`.
    angles : (N_KINDS,) float64
        What each kind claims of the 360 degrees around an edge. Edges without a claim are not
        counted, nor are those of the boundary.
    place : (np,) int64
        All -1; overwritten.
    around, claimed : (most,) int64 and float64
        As long as the longest segment of `ends`; overwritten.
    degree : (np,) int64
        The number of edges at each vertex is added.
    counts : (most + 1,) int64
        To item n, the number of edges with n cells is added.
    excess : (most + LEAST,) int64
        To item LEAST + n, the number of edges with n cells more than they should have.
    """
    for v in range(len(place)):
        first = start[v]
        n = 0
        for k in range(first, start[v + 1]):
            other = ends[k] // N_KINDS
            kind = ends[k] % N_KINDS
            if place[other] < first:
                place[other] = first + n
                around[n] = 0
                claimed[n] = 0.0
                n += 1
                degree[v] += 1
                degree[other] += 1
            edge = place[other] - first
            if kind == RIM:
                claimed[edge] = -math.inf
            else:
                around[edge] += 1
                claimed[edge] += angles[kind]
        for edge in range(n):
            if claimed[edge] > 0.0:
                wanted = 360.0 * around[edge] / claimed[edge]
                lack = math.floor(wanted) - around[edge]
                over = around[edge] - math.ceil(wanted)
                counts[around[edge]] += 1
                excess[LEAST + (over if over > 0 else -max(lack, 0))] += 1
