"""Composite operations on the worst cells: a first change, then what it makes possible (18.5).

A swap, a collapse or a new vertex often pays only once the vertices around it have moved. So
the first change may do harm, within a limit; vertices and faces around it are then improved one
by one, the worst cell first; and all of it is undone unless the worst q of what changed has risen.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from ._jit import entry, kernel
from .accept import FLOOR, STRICT
from .cavity import has_room
from .classify import tet_type
from .collapse import Collapse, apply_collapse, simulate_collapse
from .face_removal import simulate_face_removal
from .journal import (
    close_journal,
    has_pages,
    open_journal,
    roll_back,
    worst_after,
    worst_before,
)
from .relocate import (
    DEGRADATION,
    OPTIMIZE,
    Relocation,
    apply_relocation,
    rounded,
    simulate_relocation,
)
from .shell_swap import (
    apply_swap,
    simulate_edge_swap,
)
from .split import Insertion, apply_insertion, grow_cavity, is_legal_cavity, starting_point
from .tables import TET_EDGES
from .types import APPLIED, FULL, N_POINTS, NOT_BETTER, NOT_LEGAL


class Remedy(IntEnum):
    """What may be done to a bad cell at first."""

    NONE = 0
    RELOCATE = 1  # each of its vertices
    REMOVE_EDGE = 2  # each of its edges: the edge swap
    REMOVE_FACES = 3  # each of its faces, and those around it
    COLLAPSE = 4  # each of its edges, onto either end
    INSERT = 5  # a vertex, in a cavity around it


RELOCATE, REMOVE_EDGE, REMOVE_FACES, COLLAPSE, INSERT = (int(r) for r in list(Remedy)[1:])
# Number of first changes of each remedy.
WAYS = (0, 1, 6, 4, 12, 7)

N_TRIALS = 2  # of the ways of a remedy
N_STEPS = 10  # improvements after the first change
MAX_GROWTH = 1.5  # of edges, by a collapse


class Mending(NamedTuple):
    """How to mend."""

    below: float  # cells with less q than this
    harm: float  # what the first change may leave of the worst q
    gain: float  # least gain of the worst q, as a part of it
    max_points: int  # rows of the vertex arrays that may be used


@kernel
def climb_vertex(mesh, vertex, scratch):
    """Move a vertex to where its ball is best; whether it moved."""
    how = Relocation(OPTIMIZE, DEGRADATION, 1.0, STRICT, 0.0, math.inf)
    plan = simulate_relocation(mesh, vertex, how, scratch)
    if plan.verdict == APPLIED:
        apply_relocation(mesh, vertex, plan, scratch)
    return plan.verdict == APPLIED


@kernel
def climb_cell(mesh, cell, scratch):
    """Move the free vertices of a cell; whether any moved."""
    moved = False
    for k in range(4):
        vertex = mesh.cells[cell, k]
        if not mesh.fixed[vertex] and climb_vertex(mesh, vertex, scratch):
            moved = True
    return moved


@kernel
def swap_cell(mesh, cell, scratch):
    """Apply the first swap of a cell that is accepted; whether there was one."""
    for edge in range(6):
        plan = simulate_edge_swap(mesh, 8 * cell + edge, STRICT, 0.0, scratch)
        if plan.verdict == APPLIED:
            apply_swap(mesh, plan, scratch)
            return True
    for local in range(4):
        plan = simulate_face_removal(mesh, 4 * cell + local, STRICT, 0.0, scratch)
        if plan.verdict == APPLIED:
            apply_swap(mesh, plan, scratch)
            return True
    return False


@kernel
def prospect(mesh, cell, remedy, way, how, scratch):
    """What one way of a remedy makes of a cell at once.

    Returns
    -------
    verdict : int
    worst : float
        Worst q right after it.
    """
    floor = how.harm * max(mesh.quality[cell], 0.0)
    if remedy == REMOVE_EDGE:
        plan = simulate_edge_swap(mesh, 8 * cell + way, FLOOR, floor, scratch)
        return plan.verdict, plan.worst
    if remedy == REMOVE_FACES:
        plan = simulate_face_removal(mesh, 4 * cell + way, FLOOR, floor, scratch)
        return plan.verdict, plan.worst
    if remedy == COLLAPSE:
        move = simulate_collapse(mesh, *ends(mesh, cell, way), loose(floor), scratch)
        return move.verdict, move.worst
    if mesh.state[N_POINTS] >= how.max_points:
        return NOT_BETTER, 0.0
    start = rounded(mesh, starting_point(mesh, cell, way))
    n_cells, n_facets, worst, _ = grow_cavity(mesh, cell, start, scratch)
    if worst <= floor or n_facets > scratch.created.shape[0]:
        return NOT_BETTER, worst
    if not is_legal_cavity(mesh, n_cells, n_facets, scratch):
        return NOT_LEGAL, worst
    return APPLIED if has_room(mesh, n_facets) else FULL, worst


@kernel
def carry_out(mesh, cell, remedy, way, how, scratch):
    """Apply one way of a remedy whose prospect was good."""
    floor = how.harm * max(mesh.quality[cell], 0.0)
    if remedy == REMOVE_EDGE:
        plan = simulate_edge_swap(mesh, 8 * cell + way, FLOOR, floor, scratch)
        apply_swap(mesh, plan, scratch)
    elif remedy == REMOVE_FACES:
        plan = simulate_face_removal(mesh, 4 * cell + way, FLOOR, floor, scratch)
        apply_swap(mesh, plan, scratch)
    elif remedy == COLLAPSE:
        move = simulate_collapse(mesh, *ends(mesh, cell, way), loose(floor), scratch)
        apply_collapse(mesh, move, scratch)
    else:
        start = rounded(mesh, starting_point(mesh, cell, way))
        n_cells, n_facets, worst, _ = grow_cavity(mesh, cell, start, scratch)
        insertion = Insertion(APPLIED, n_cells, n_facets, start, worst)
        climb_vertex(mesh, apply_insertion(mesh, insertion, scratch), scratch)


@kernel
def ends(mesh, cell, way):
    """The vertex that vanishes and the one it goes to, of the 12 collapses of a tet."""
    a = mesh.cells[cell, TET_EDGES[way >> 1, way & 1]]
    b = mesh.cells[cell, TET_EDGES[way >> 1, 1 - (way & 1)]]
    return a, b


@kernel
def loose(floor):
    """A collapse that may do harm."""
    return Collapse(FLOOR, floor, MAX_GROWTH, False)


@kernel
def improve(mesh, goal, scratch):
    """Improve what changed since the journal was opened, the worst cell first.

    Returns
    -------
    worst : float
        The worst q of what changed, once it is above the goal or nothing helps.
    """
    cell, worst = worst_after(mesh, scratch)
    for _ in range(N_STEPS):
        if cell < 0 or worst > goal or not has_pages(scratch):
            break
        if not climb_cell(mesh, cell, scratch) and not swap_cell(mesh, cell, scratch):
            break
        cell, worst = worst_after(mesh, scratch)
    return worst


@kernel
def pays(mesh, goal, how, scratch):
    """Improve on what was done since the journal was opened, and undo it all if it is no gain."""
    after = improve(mesh, goal, scratch)
    before = worst_before(mesh, scratch)
    if after > before + how.gain * abs(before):
        close_journal(scratch)
        return True
    roll_back(mesh, scratch)
    return False


@kernel
def try_remedy(mesh, cell, remedy, how, scratch):
    """Try the most promising ways of one remedy until one pays.

    Returns
    -------
    verdict : int
        APPLIED, FULL, or NOT_BETTER with the mesh as it was.
    """
    goal = mesh.quality[cell] + how.gain * abs(mesh.quality[cell])
    if remedy == RELOCATE:
        open_journal(mesh, scratch)
        moved = climb_cell(mesh, cell, scratch)
        return APPLIED if pays(mesh, goal, how, scratch) and moved else NOT_BETTER
    last = math.inf
    for _ in range(N_TRIALS):
        best = -1
        best_worst = -math.inf
        for way in range(WAYS[remedy]):
            verdict, worst = prospect(mesh, cell, remedy, way, how, scratch)
            if verdict == FULL:
                return FULL
            if verdict == APPLIED and best_worst < worst < last:
                best = way
                best_worst = worst
        if best < 0:
            break
        last = best_worst
        open_journal(mesh, scratch)
        carry_out(mesh, cell, remedy, best, how, scratch)
        if pays(mesh, goal, how, scratch):
            return APPLIED
    return NOT_BETTER


@kernel
def mend_cell(mesh, cell, remedies, how, scratch):
    """Try the remedies for the type of a cell, in their order; returns the verdict."""
    kind = tet_type(mesh.points, mesh.cells[cell])
    for i in range(remedies.shape[1]):
        if remedies[kind, i] == 0:
            break
        verdict = try_remedy(mesh, cell, remedies[kind, i], how, scratch)
        if verdict != NOT_BETTER:
            return verdict
    return NOT_BETTER


@entry
def sweep_mend(mesh, order, remedies, how, scratch, counts):
    """Try to mend each tet in turn.

    Parameters
    ----------
    order : (n,) int64
        Tets to visit; those that died or became better meanwhile are passed over.
    remedies : (n_types, n) int64
        For each type the remedies in their order, filled up with zeros.
    how : Mending
    counts : (N_VERDICTS,) int64
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if mesh.alive[cell] and mesh.quality[cell] < how.below:
            counts[mend_cell(mesh, cell, remedies, how, scratch)] += 1
