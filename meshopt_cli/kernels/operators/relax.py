"""Degree relaxation (18.4.2): swaps that bring the degrees of the vertices nearer to the best.

The sum of the squared differences between degree and target must fall, and the worst q of
the patch may not fall below a floor.
"""

from __future__ import annotations

import numpy as np

from ...cells import TET_EDGES
from ...compiled.decorators import entry, kernel
from ..cavity import has_room
from ..types import APPLIED, MAX_SHELL, NOT_BETTER, Scratch, SimplexMesh
from .flip import apply_flip, simulate_flip
from .ring import collect_triangles
from .swap import NOT_VISITED, Swapping, apply_swap, simulate_edge_removal, simulate_face_swap


@kernel
def raise_degree(degree: np.ndarray, target: np.ndarray, vertex: int, by: int) -> float:
    """Change a degree by one; returns by how much its squared difference rises."""
    before = degree[vertex] - target[vertex]
    degree[vertex] += by
    after = degree[vertex] - target[vertex]
    return after * after - before * before


@kernel
def change_ring(
    degree: np.ndarray, target: np.ndarray, a: int, b: int, n: int, by: int, scratch: Scratch
) -> float:
    """Change the degrees as the planned removal of the edge a b does (by = 1), or back (-1)."""
    rise = raise_degree(degree, target, a, -by) + raise_degree(degree, target, b, -by)
    ring = scratch.ring
    for t in range(collect_triangles(n, scratch)):
        i = scratch.facets[t, 0]
        j = scratch.facets[t, 2]
        # The side i j of a triangle is a new edge, but for the side that closes the polygon.
        if j - i < n - 1:
            rise += raise_degree(degree, target, ring[i], by)
            rise += raise_degree(degree, target, ring[j], by)
    return rise


@kernel
def relax_edge(
    mesh: SimplexMesh,
    cell: int,
    edge: int,
    how: Swapping,
    degree: np.ndarray,
    target: np.ndarray,
    scratch: Scratch,
) -> int:
    """Remove an edge of a tet when the degrees gain by it; returns the verdict."""
    plan = simulate_edge_removal(mesh, 8 * cell + edge, how.rule, how.floor, scratch)
    if plan.verdict != APPLIED:
        return plan.verdict
    a = mesh.cells[cell, TET_EDGES[edge, 0]]
    b = mesh.cells[cell, TET_EDGES[edge, 1]]
    if change_ring(degree, target, a, b, plan.n_old, 1, scratch) >= 0:
        change_ring(degree, target, a, b, plan.n_old, -1, scratch)
        return NOT_BETTER
    apply_swap(mesh, plan, scratch)
    return APPLIED


@kernel
def relax_face(
    mesh: SimplexMesh,
    cell: int,
    local: int,
    how: Swapping,
    degree: np.ndarray,
    target: np.ndarray,
    scratch: Scratch,
) -> int:
    """Put an edge in place of a face of a tet when the degrees gain by it."""
    plan = simulate_face_swap(mesh, 4 * cell + local, how.rule, how.floor, scratch)
    if plan.verdict != APPLIED:
        return plan.verdict
    beyond = mesh.neighbours[cell, local]
    d = mesh.cells[cell, local]
    e = mesh.cells[beyond >> 2, beyond & 3]
    rise = raise_degree(degree, target, d, 1) + raise_degree(degree, target, e, 1)
    if rise >= 0:
        degree[d] -= 1
        degree[e] -= 1
        return NOT_BETTER
    apply_swap(mesh, plan, scratch)
    return APPLIED


@kernel
def relax_flip(
    mesh: SimplexMesh,
    cell: int,
    local: int,
    how: Swapping,
    degree: np.ndarray,
    target: np.ndarray,
    scratch: Scratch,
) -> int:
    """Flip an edge of a triangle when the degrees gain by it."""
    plan = simulate_flip(mesh, 4 * cell + local, how.rule, how.floor)
    if plan.verdict != APPLIED:
        return plan.verdict
    a = mesh.cells[cell, (local + 1) % 3]
    b = mesh.cells[cell, (local + 2) % 3]
    c = mesh.cells[cell, local]
    d = mesh.cells[plan.other >> 2, plan.other & 3]
    rise = raise_degree(degree, target, a, -1) + raise_degree(degree, target, b, -1)
    rise += raise_degree(degree, target, c, 1) + raise_degree(degree, target, d, 1)
    if rise >= 0:
        degree[a] += 1
        degree[b] += 1
        degree[c] -= 1
        degree[d] -= 1
        return NOT_BETTER
    apply_flip(mesh, plan, scratch)
    return APPLIED


@entry(
    group="relax",
    example=lambda work: (
        work.mesh, work.order, Swapping(0, 0.0, False, 0), work.vertex_values, work.vertex_values,
        work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_relax(
    mesh: SimplexMesh,
    order: np.ndarray,
    how: Swapping,
    degree: np.ndarray,
    target: np.ndarray,
    scratch: Scratch,
    counts: np.ndarray,
) -> int:
    """Try the swaps of each cell in turn; see `swap.sweep_swap`.

    Parameters
    ----------
    how : swap.Swapping
    degree, target : (np,) float64
        Degree of each vertex, kept up to date, and what it should be.
    """
    tets = mesh.cells.shape[1] == 4
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        if not has_room(mesh, MAX_SHELL):
            return i
        for handle in range(10 if tets else 3):
            if not tets:
                verdict = relax_flip(mesh, cell, handle, how, degree, target, scratch)
            elif handle < 6:
                verdict = relax_edge(mesh, cell, handle, how, degree, target, scratch)
            else:
                verdict = relax_face(mesh, cell, handle - 6, how, degree, target, scratch)
            if verdict == NOT_VISITED:
                continue
            counts[verdict] += 1
            if verdict == APPLIED:
                break
    return order.shape[0]
