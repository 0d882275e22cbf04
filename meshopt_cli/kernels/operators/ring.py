"""The polygon around an edge: its best triangulation, by the worst tet at either end of the edge.

It goes over all triangulations (18.27) by the dynamic programme of Klincsek (1980), which finds
the same optimum in O(n^3).
"""

from __future__ import annotations

import numpy as np

from ...compiled.decorators import inlined, kernel
from ..judge import q_of_tet
from ..types import Scratch, SimplexMesh


@inlined
def put(created: np.ndarray, i: int, a: int, b: int, c: int, d: int) -> None:
    """Write a tet into a row of `scratch.created`."""
    created[i, 0] = a
    created[i, 1] = b
    created[i, 2] = c
    created[i, 3] = d


@kernel
def triangulate_ring(
    mesh: SimplexMesh, a: int, b: int, n: int, stop: float, scratch: Scratch
) -> float:
    """Best triangulation of the polygon `scratch.ring` joined with both ends of an edge.

    `scratch.table[i, j]` becomes the worst q over the part of the polygon from i to j, and
    `scratch.split[i, j]` the vertex of its triangle at the side i j. Parts that cannot be
    better than `stop` count as that bad.

    Returns
    -------
    worst : float
        The worst q of the best triangulation, or at most `stop`.
    """
    ring = scratch.ring
    table = scratch.table
    split = scratch.split
    for i in range(n - 1):
        table[i, i + 1] = 2.0
    for width in range(2, n):
        for i in range(n - width):
            j = i + width
            best = stop
            best_k = -1
            for k in range(i + 1, j):
                worst = min(table[i, k], table[k, j])
                if worst <= best:
                    continue
                worst = min(worst, q_of_tet(mesh, ring[i], ring[k], ring[j], b))
                if worst <= best:
                    continue
                worst = min(worst, q_of_tet(mesh, ring[i], ring[j], ring[k], a))
                if worst > best:
                    best = worst
                    best_k = k
            table[i, j] = best
            split[i, j] = best_k
    return table[0, n - 1]


@kernel
def collect_triangles(n: int, scratch: Scratch) -> int:
    """Write the triangles of the best triangulation of a polygon into `scratch.facets`.

    Returns
    -------
    n : int
        How many: places i < k < j in the ring, in the first three columns.
    """
    triangles = scratch.facets
    # The parts of the polygon that are still to be taken apart, as pairs of places.
    stack = scratch.other
    stack[0] = 0
    stack[1] = n - 1
    waiting = 1
    n_triangles = 0
    while waiting > 0:
        waiting -= 1
        i = stack[2 * waiting]
        j = stack[2 * waiting + 1]
        if j - i < 2:
            continue
        k = scratch.split[i, j]
        triangles[n_triangles, 0] = i
        triangles[n_triangles, 1] = k
        triangles[n_triangles, 2] = j
        n_triangles += 1
        stack[2 * waiting] = i
        stack[2 * waiting + 1] = k
        stack[2 * waiting + 2] = k
        stack[2 * waiting + 3] = j
        waiting += 2
    return n_triangles


@kernel
def collect_ring(a: int, b: int, n: int, scratch: Scratch) -> int:
    """Write the tets of the best triangulation to `scratch.created`; returns how many."""
    ring = scratch.ring
    n_triangles = collect_triangles(n, scratch)
    for t in range(n_triangles):
        i = ring[scratch.facets[t, 0]]
        k = ring[scratch.facets[t, 1]]
        j = ring[scratch.facets[t, 2]]
        put(scratch.created, 2 * t, i, k, j, b)
        put(scratch.created, 2 * t + 1, i, j, k, a)
    return 2 * n_triangles
