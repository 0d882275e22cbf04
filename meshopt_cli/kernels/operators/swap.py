"""Swaps of tetrahedra (18.4.2): a face for an edge, and an edge for the best triangulation.

The edge swap goes over all triangulations of the polygon around the edge (18.27) by the
dynamic programme of Klincsek (1980), which finds the same optimum in O(n^3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...cells import TET_EDGES, TET_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import FLAT, MEAN, is_accepted, mean_falls, threshold
from ..cavity import has_room, replace_cells
from ..gather.shell import (
    SHELL_ELSEWHERE,
    SHELL_OPEN,
    SHELL_OVERFLOW,
    gather_open_shell,
    gather_shell,
    is_required,
)
from ..shape.simplex import tet_quality
from ..types import APPLIED, FIXED, FULL, INVALID, NOT_BETTER, TOO_LARGE
from ..vectors import at

# The shell is looked at from another of its tets: no attempt, and no verdict.
NOT_VISITED = -1


class Swap(NamedTuple):
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
def put(created, i, a, b, c, d):
    created[i, 0] = a
    created[i, 1] = b
    created[i, 2] = c
    created[i, 3] = d


@kernel
def simulate_face_swap(mesh, handle, rule, floor, scratch):
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
    pa = at(mesh.points, a)
    pb = at(mesh.points, b)
    pc = at(mesh.points, c)
    pd = at(mesh.points, d)
    pe = at(mesh.points, e)
    worst = tet_quality(mesh.measure, pe, pa, pb, pd)
    if worst > stop:
        worst = min(worst, tet_quality(mesh.measure, pe, pb, pc, pd))
    if worst > stop:
        worst = min(worst, tet_quality(mesh.measure, pe, pc, pa, pd))
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


@kernel
def triangulate_ring(mesh, a, b, n, stop, scratch):
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
    pa = at(mesh.points, a)
    pb = at(mesh.points, b)
    for i in range(n - 1):
        table[i, i + 1] = 2.0
    for width in range(2, n):
        for i in range(n - width):
            j = i + width
            pi = at(mesh.points, ring[i])
            pj = at(mesh.points, ring[j])
            best = stop
            best_k = -1
            for k in range(i + 1, j):
                worst = min(table[i, k], table[k, j])
                if worst <= best:
                    continue
                pk = at(mesh.points, ring[k])
                worst = min(worst, tet_quality(mesh.measure, pi, pk, pj, pb))
                if worst <= best:
                    continue
                worst = min(worst, tet_quality(mesh.measure, pi, pj, pk, pa))
                if worst > best:
                    best = worst
                    best_k = k
            table[i, j] = best
            split[i, j] = best_k
    return table[0, n - 1]


@kernel
def collect_ring(a, b, n, scratch):
    """Write the tets of the best triangulation to `scratch.created`; returns how many."""
    ring = scratch.ring
    # The parts still to be taken apart wait in `facets`.
    stack = scratch.facets
    stack[0, 0] = 0
    stack[0, 1] = n - 1
    waiting = 1
    n_new = 0
    while waiting > 0:
        waiting -= 1
        i = stack[waiting, 0]
        j = stack[waiting, 1]
        if j - i < 2:
            continue
        k = scratch.split[i, j]
        put(scratch.created, n_new, ring[i], ring[k], ring[j], b)
        put(scratch.created, n_new + 1, ring[i], ring[j], ring[k], a)
        n_new += 2
        stack[waiting, 0] = i
        stack[waiting, 1] = k
        stack[waiting + 1, 0] = k
        stack[waiting + 1, 1] = j
        waiting += 2
    return n_new


@kernel
def simulate_edge_removal(mesh, handle, rule, floor, scratch):
    """Remove an edge: replace its closed shell by the best triangulation of its polygon.

    Parameters
    ----------
    handle : int
        `8 * tet + edge`, the tet being the worst of the shell.
    """
    cell = handle >> 3
    edge = handle & 7
    a = mesh.cells[cell, TET_EDGES[edge, 0]]
    b = mesh.cells[cell, TET_EDGES[edge, 1]]
    c = mesh.cells[cell, TET_EDGES[edge, 2]]
    d = mesh.cells[cell, TET_EDGES[edge, 3]]
    n = gather_shell(mesh, cell, a, b, c, d, scratch)
    if n == SHELL_OVERFLOW:
        return SwapPlan(TOO_LARGE, 0, 0, 0.0)
    if n == SHELL_ELSEWHERE:
        return SwapPlan(NOT_VISITED, 0, 0, 0.0)
    if n < 3 or is_required(mesh, a, b):
        return SwapPlan(FIXED, max(n, 0), 0, 0.0)
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
def simulate_open_swap(mesh, handle, rule, floor, scratch):
    """Remove the faces inside an open shell; its edge and its two outer faces stay.

    One tet is left at the edge, between those faces; the rest becomes the best triangulation
    of the polygon around it. With two tets this is the swap of the face between them. Where the
    outer faces lie in a plane and the boundary slides, no tet is left, and the edge goes.
    """
    cell = handle >> 3
    edge = handle & 7
    a = mesh.cells[cell, TET_EDGES[edge, 0]]
    b = mesh.cells[cell, TET_EDGES[edge, 1]]
    c = mesh.cells[cell, TET_EDGES[edge, 2]]
    d = mesh.cells[cell, TET_EDGES[edge, 3]]
    n = gather_open_shell(mesh, cell, a, b, c, d, scratch)
    if n == SHELL_OVERFLOW:
        return SwapPlan(TOO_LARGE, 0, 0, 0.0)
    if n == SHELL_ELSEWHERE:
        return SwapPlan(NOT_VISITED, 0, 0, 0.0)
    before = mesh.quality[cell]
    stop = threshold(rule, floor, before)
    ring = scratch.ring
    points = mesh.points
    worst = tet_quality(
        mesh.measure, at(points, a), at(points, b), at(points, ring[0]), at(points, ring[n])
    )
    flat = mesh.slides and n > 1 and abs(worst) < FLAT and not is_required(mesh, a, b)
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
def simulate_edge_swap(mesh, handle, rule, floor, scratch):
    """Remove an edge inside, or the faces at an edge of the boundary or of an interface."""
    plan = simulate_edge_removal(mesh, handle, rule, floor, scratch)
    if plan.verdict == FIXED and plan.n_old == SHELL_OPEN:
        return simulate_open_swap(mesh, handle, rule, floor, scratch)
    return plan


@kernel
def apply_swap(mesh, plan, scratch):
    """Carry out a simulated face or edge swap."""
    replace_cells(mesh, scratch.shell, plan.n_old, plan.n_new, scratch)


@inlined
def is_unchanged(mesh, cell, handle, since):
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
def best_swap(mesh, cell, how, scratch, counts):
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
def lowers_mean(mesh, plan, scratch):
    """Whether the mean Q of the tets of a swap falls."""
    before = 0.0
    after = 0.0
    for i in range(plan.n_old):
        before += 1.0 / mesh.quality[scratch.shell[i]]
    for i in range(plan.n_new):
        after += 1.0 / tet_quality(
            mesh.measure,
            at(mesh.points, scratch.created[i, 0]),
            at(mesh.points, scratch.created[i, 1]),
            at(mesh.points, scratch.created[i, 2]),
            at(mesh.points, scratch.created[i, 3]),
        )
    return mean_falls(before / plan.n_old, after / plan.n_new)


@kernel
def simulate_swap(mesh, cell, handle, how, scratch):
    """Simulate the swap of an edge 0..5 or of a face 6..9 of a tet."""
    if handle < 6:
        plan = simulate_edge_swap(mesh, 8 * cell + handle, how.rule, how.floor, scratch)
    else:
        plan = simulate_face_swap(mesh, 4 * cell + handle - 6, how.rule, how.floor, scratch)
    if plan.verdict == APPLIED and how.rule == MEAN and not lowers_mean(mesh, plan, scratch):
        return SwapPlan(NOT_BETTER, plan.n_old, plan.n_new, plan.worst)
    return plan


@entry
def sweep_swap(mesh, order, how, scratch, counts):
    """Try, for each tet in turn, its six edges, then its four faces.

    Parameters
    ----------
    order : (n,) int64
        Tets to visit; those that died meanwhile are passed over.
    counts : (N_VERDICTS,) int64
        Raised by one for each attempt, at its verdict.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        handle = best_swap(mesh, cell, how, scratch, counts)
        if handle >= 0:
            plan = simulate_swap(mesh, cell, handle, how, scratch)
            apply_swap(mesh, plan, scratch)
            counts[APPLIED] += 1
