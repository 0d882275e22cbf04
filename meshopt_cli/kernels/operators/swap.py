"""Swaps of tetrahedra (18.4.2): a face for an edge, and an edge for the best triangulation.

The edge swap takes the best of all triangulations of the polygon around the edge: see `ring`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TET_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import (
    FLAT,
    MEAN,
    UNCHANGED,
    is_accepted,
    lowers_mean,
    threshold,
    with_cell,
    without,
)
from ..cavity import has_room, replace_cells
from ..gather.shell import (
    SHELL_OPEN,
    SHELL_OVERFLOW,
    gather_open_shell,
    gather_shell,
    is_required,
)
from ..judge import q_of_row, q_of_tet
from ..types import (
    APPLIED,
    FIXED,
    FULL,
    INVALID,
    MAX_SHELL,
    NOT_BETTER,
    TOO_LARGE,
    Scratch,
    SimplexMesh,
)
from .ring import collect_ring, put, triangulate_ring

# The shell is looked at from another of its tets: no attempt, and no verdict.
NOT_VISITED = -1


class Swapping(NamedTuple):
    """Which swaps are wanted."""

    rule: int
    floor: float
    pick_best: bool  # the best of all swaps of a cell, not the first accepted
    since: int  # only where something changed after this sweep


class SwapPlan(NamedTuple):
    """A simulated swap. The old tets are in `scratch.shell`, the new in `scratch.created`."""

    verdict: int
    n_old: int
    n_new: int
    worst: float  # q of the worst new tet


@kernel
def simulate_face_swap(
    mesh: SimplexMesh, handle: int, rule: int, floor: float, scratch: Scratch
) -> SwapPlan:
    """Replace the two tets at a face by three around the edge that joins their apexes."""
    cell = handle >> 2
    local = handle & 3
    beyond = mesh.neighbours[cell, local]
    if beyond < 0:
        return SwapPlan(FIXED, 0, 0, 0.0)
    other = beyond >> 2
    before = min(mesh.quality[cell], mesh.quality[other])
    stop = threshold(rule, floor, before)
    a = mesh.cells[cell, TET_FACETS[local, 0]]
    b = mesh.cells[cell, TET_FACETS[local, 1]]
    c = mesh.cells[cell, TET_FACETS[local, 2]]
    d = mesh.cells[cell, local]
    e = mesh.cells[other, beyond & 3]
    worst = q_of_tet(mesh, e, a, b, d)
    if worst > stop:
        worst = min(worst, q_of_tet(mesh, e, b, c, d))
    if worst > stop:
        worst = min(worst, q_of_tet(mesh, e, c, a, d))
    if worst <= 0.0:
        return SwapPlan(INVALID, 2, 3, worst)
    if not is_accepted(rule, floor, before, worst):
        return SwapPlan(NOT_BETTER, 2, 3, worst)
    if not has_room(mesh, 1):
        return SwapPlan(FULL, 2, 3, worst)
    scratch.shell[0] = cell
    scratch.shell[1] = other
    put(scratch.created, 0, e, a, b, d)
    put(scratch.created, 1, e, b, c, d)
    put(scratch.created, 2, e, c, a, d)
    return SwapPlan(APPLIED, 2, 3, worst)


@inlined
def around(mesh: SimplexMesh, handle: int) -> tuple[int, int, int, int, int]:
    """A tet and its vertices (a, b, c, d), of which a b is the edge of the handle."""
    cell = handle >> 3
    edge = handle & 7
    return (
        cell,
        mesh.cells[cell, TET_EDGES[edge, 0]],
        mesh.cells[cell, TET_EDGES[edge, 1]],
        mesh.cells[cell, TET_EDGES[edge, 2]],
        mesh.cells[cell, TET_EDGES[edge, 3]],
    )


@inlined
def not_gathered(n: int) -> SwapPlan:
    """The plan where a shell could not be gathered, from what is in place of its length."""
    return SwapPlan(TOO_LARGE if n == SHELL_OVERFLOW else NOT_VISITED, 0, 0, 0.0)


@kernel
def simulate_edge_removal(
    mesh: SimplexMesh, handle: int, rule: int, floor: float, scratch: Scratch
) -> SwapPlan:
    """Remove an edge: replace its closed shell by the best triangulation of its polygon.

    Parameters
    ----------
    handle : int
        `8 * tet + edge`, the tet being the worst of the shell.
    """
    cell, a, b, c, d = around(mesh, handle)
    n = gather_shell(mesh, cell, a, b, c, d, scratch)
    if n < 0:
        return not_gathered(n)
    if n < 3 or is_required(mesh, a, b):
        return SwapPlan(FIXED, n, 0, 0.0)
    before = mesh.quality[cell]
    stop = threshold(rule, floor, before)
    worst = triangulate_ring(mesh, a, b, n, stop, scratch)
    if worst <= 0.0:
        return SwapPlan(INVALID, n, 0, worst)
    if worst <= stop or not is_accepted(rule, floor, before, worst):
        return SwapPlan(NOT_BETTER, n, 0, worst)
    if not has_room(mesh, n - 4):
        return SwapPlan(FULL, n, 0, worst)
    return SwapPlan(APPLIED, n, collect_ring(a, b, n, scratch), worst)


@kernel
def simulate_open_swap(
    mesh: SimplexMesh, handle: int, rule: int, floor: float, scratch: Scratch
) -> SwapPlan:
    """Remove the faces inside an open shell; its edge and its two outer faces stay.

    One tet is left at the edge, between those faces; the rest becomes the best triangulation
    of the polygon around it. With two tets this is the swap of the face between them. Where the
    outer faces lie in a plane of the boundary that slides, no tet is left, and the edge goes. An
    interface has cells on its other side, which would keep the edge.
    """
    cell, a, b, c, d = around(mesh, handle)
    n, outer = gather_open_shell(mesh, cell, a, b, c, d, scratch)
    if n < 0:
        return not_gathered(n)
    before = mesh.quality[cell]
    stop = threshold(rule, floor, before)
    ring = scratch.ring
    worst = q_of_tet(mesh, a, b, ring[0], ring[n])
    flat = mesh.slides and outer and n > 1 and abs(worst) < FLAT and not is_required(mesh, a, b)
    if n < 3 and not flat:
        return SwapPlan(FIXED, 0, 0, 0.0)
    if flat:
        worst = triangulate_ring(mesh, a, b, n + 1, stop, scratch)
    elif worst > stop:
        worst = min(worst, triangulate_ring(mesh, a, b, n + 1, stop, scratch))
    if worst <= 0.0:
        return SwapPlan(INVALID, n, 0, worst)
    if worst <= stop or not is_accepted(rule, floor, before, worst):
        return SwapPlan(NOT_BETTER, n, 0, worst)
    if not has_room(mesh, n - 1):
        return SwapPlan(FULL, n, 0, worst)
    n_new = collect_ring(a, b, n + 1, scratch)
    if flat:
        return SwapPlan(APPLIED, n, n_new, worst)
    put(scratch.created, n_new, a, b, ring[0], ring[n])
    return SwapPlan(APPLIED, n, n_new + 1, worst)


@kernel
def simulate_edge_swap(
    mesh: SimplexMesh, handle: int, rule: int, floor: float, scratch: Scratch
) -> SwapPlan:
    """Remove an edge inside, or the faces at an edge of the boundary or of an interface."""
    plan = simulate_edge_removal(mesh, handle, rule, floor, scratch)
    if plan.verdict == FIXED and plan.n_old == SHELL_OPEN:
        return simulate_open_swap(mesh, handle, rule, floor, scratch)
    return plan


@kernel
def apply_swap(mesh: SimplexMesh, plan: SwapPlan, scratch: Scratch) -> None:
    """Carry out a simulated face or edge swap."""
    replace_cells(mesh, scratch.shell, plan.n_old, plan.n_new, scratch)


@inlined
def is_unchanged(mesh: SimplexMesh, cell: int, handle: int, since: int) -> bool:
    """Whether nothing changed around an edge 0..5 or at a face 6..9 of a tet after a sweep."""
    clock = mesh.vertex_clock
    if handle < 6:
        return (
            clock[mesh.cells[cell, TET_EDGES[handle, 0]]] <= since
            or clock[mesh.cells[cell, TET_EDGES[handle, 1]]] <= since
        )
    return (
        clock[mesh.cells[cell, TET_FACETS[handle - 6, 0]]] <= since
        or clock[mesh.cells[cell, TET_FACETS[handle - 6, 1]]] <= since
        or clock[mesh.cells[cell, TET_FACETS[handle - 6, 2]]] <= since
    )


@kernel
def best_swap(
    mesh: SimplexMesh, cell: int, how: Swapping, scratch: Scratch, counts: np.ndarray
) -> int:
    """Simulate the swaps of a tet's six edges and four faces.

    Returns
    -------
    handle : int
        Of the swap to apply: an edge 0..5 or 6 + a face 0..3; -1 when none is accepted. The
        first one, or with `how.pick_best` the one that leaves the best worst q.
    """
    best = -1
    best_worst = -math.inf
    for handle in range(10):
        if is_unchanged(mesh, cell, handle, how.since):
            continue
        plan = simulate_swap(mesh, cell, handle, how, scratch)
        if plan.verdict == NOT_VISITED:
            continue
        counts[plan.verdict] += plan.verdict != APPLIED
        if plan.verdict == APPLIED and plan.worst > best_worst:
            best = handle
            best_worst = plan.worst
            if not how.pick_best:
                break
    return best


@kernel
def has_lower_mean(mesh: SimplexMesh, plan: SwapPlan, scratch: Scratch) -> bool:
    """Whether the mean Q of the tets of a swap falls."""
    sums = UNCHANGED
    for i in range(plan.n_old):
        sums = without(sums, mesh.quality[scratch.shell[i]])
    for i in range(plan.n_new):
        sums = with_cell(sums, q_of_row(mesh, scratch.created, i))
    return lowers_mean(sums)


@kernel
def simulate_swap(
    mesh: SimplexMesh, cell: int, handle: int, how: Swapping, scratch: Scratch
) -> SwapPlan:
    """Simulate the swap of an edge 0..5 or of a face 6..9 of a tet."""
    if handle < 6:
        plan = simulate_edge_swap(mesh, 8 * cell + handle, how.rule, how.floor, scratch)
    else:
        plan = simulate_face_swap(mesh, 4 * cell + handle - 6, how.rule, how.floor, scratch)
    if plan.verdict == APPLIED and how.rule == MEAN and not has_lower_mean(mesh, plan, scratch):
        return SwapPlan(NOT_BETTER, plan.n_old, plan.n_new, plan.worst)
    return plan


@entry(
    group="swap",
    example=lambda work: (
        work.mesh,
        work.order,
        Swapping(0, 0.0, False, 0),
        work.scratch,
        work.counts,
    ),
)
def sweep_swap(
    mesh: SimplexMesh, order: np.ndarray, how: Swapping, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try, for each tet in turn, its six edges, then its four faces.

    Parameters
    ----------
    order : (n,) int64
        Tets to visit; those that died meanwhile are passed over.
    counts : (N_VERDICTS,) int64
        Raised by one for each attempt, at its verdict.

    Returns
    -------
    place : int
        Where in the order it stopped for want of room, before anything was done or counted
        there; the length of the order when it is done.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        if not has_room(mesh, MAX_SHELL):
            return i
        handle = best_swap(mesh, cell, how, scratch, counts)
        if handle >= 0:
            plan = simulate_swap(mesh, cell, handle, how, scratch)
            apply_swap(mesh, plan, scratch)
            counts[APPLIED] += 1
    return order.shape[0]
