"""Composite operations on the worst cells: a first change, then what it makes possible (18.5).

A swap, a collapse or a new vertex often pays only once the vertices around it have moved. So
the first change may do harm, within a limit; vertices and faces around it are then improved one
by one, the worst cell first; and all of it is undone unless the worst q of what changed has risen.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TRI_EDGES
from ...compiled.decorators import entry, kernel
from ..accept import FLOOR, STRICT, gained
from ..cavity import has_room
from ..journal import (
    close_journal,
    has_lower_mean,
    has_pages,
    open_journal,
    roll_back,
    worst_after,
    worst_before,
)
from ..shape.classify import cell_type
from ..types import (
    APPLIED,
    FULL,
    MAX_CREATED,
    MAX_SHELL,
    N_POINTS,
    NOT_BETTER,
    NOT_LEGAL,
    Scratch,
    SimplexMesh,
)
from ..vectors import rounded
from .climb import apply_relocation, simulate_climb
from .collapse import MAX_GROWTH, Collapsing, apply_collapse, simulate_collapse
from .face_removal import simulate_face_removal
from .flip import apply_flip, simulate_flip
from .insert import Insertion, apply_insertion, grow_cavity, is_legal_cavity, starting_point
from .swap import apply_swap, simulate_edge_swap


class Remedy(IntEnum):
    """What may be done to a bad cell at first."""

    NONE = 0
    RELOCATE = 1  # each of its vertices
    REMOVE_EDGE = 2  # each of its edges: the edge swap, in the plane the flip
    REMOVE_FACES = 3  # each of its faces, and those around it; none in the plane
    COLLAPSE = 4  # each of its edges, onto either end
    INSERT = 5  # a vertex, in a cavity around it


RELOCATE, REMOVE_EDGE, REMOVE_FACES, COLLAPSE, INSERT = (int(r) for r in list(Remedy)[1:])
# Number of first changes of each remedy, for triangles and for tets.
WAYS = ((0, 1, 3, 0, 6, 4), (0, 1, 6, 4, 12, 7))


class Mending(NamedTuple):
    """How to mend."""

    below: float  # cells with less q than this
    least_kept: float  # what the first change may leave of the worst q
    gain: float  # least gain of the worst q, as a part of it
    max_points: int  # rows of the vertex arrays that may be used
    trials: int  # ways of a remedy that are carried out
    steps: int  # improvements after the first change
    urgent: float  # where what changes is better than this q, its mean Q must fall, too


@kernel
def climb_vertex(mesh: SimplexMesh, vertex: int, scratch: Scratch) -> bool:
    """Move a vertex to where its ball is best; whether it moved."""
    plan = simulate_climb(mesh, vertex, math.inf, scratch)
    if plan.verdict == APPLIED:
        apply_relocation(mesh, vertex, plan, scratch)
    return plan.verdict == APPLIED


@kernel
def climb_cell(mesh: SimplexMesh, cell: int, scratch: Scratch) -> bool:
    """Move the free vertices of a cell; whether any moved."""
    moved = False
    for k in range(mesh.cells.shape[1]):
        vertex = mesh.cells[cell, k]
        if climb_vertex(mesh, vertex, scratch):
            moved = True
    return moved


@kernel
def swap_edge(
    mesh: SimplexMesh, cell: int, edge: int, rule: int, floor: float, do: bool, scratch: Scratch
) -> tuple[int, float]:
    """Simulate the removal of an edge of a cell, and apply it if `do` and it is accepted.

    Returns
    -------
    verdict : int
    worst : float
        Worst q of the new cells.
    """
    if mesh.cells.shape[1] == 3:
        flip = simulate_flip(mesh, 4 * cell + edge, rule, floor)
        if do and flip.verdict == APPLIED:
            apply_flip(mesh, flip, scratch)
        return flip.verdict, min(flip.q_one, flip.q_other)
    plan = simulate_edge_swap(mesh, 8 * cell + edge, rule, floor, scratch)
    if do and plan.verdict == APPLIED:
        apply_swap(mesh, plan, scratch)
    return plan.verdict, plan.worst


@kernel
def swap_faces(
    mesh: SimplexMesh, cell: int, local: int, rule: int, floor: float, do: bool, scratch: Scratch
) -> tuple[int, float]:
    """The same for a face of a tet and those around it."""
    plan = simulate_face_removal(mesh, 4 * cell + local, rule, floor, scratch)
    if do and plan.verdict == APPLIED:
        apply_swap(mesh, plan, scratch)
    return plan.verdict, plan.worst


@kernel
def swap_cell(mesh: SimplexMesh, cell: int, scratch: Scratch) -> bool:
    """Apply the first swap of a cell that is accepted; whether there was one."""
    tets = mesh.cells.shape[1] == 4
    for edge in range(6 if tets else 3):
        if swap_edge(mesh, cell, edge, STRICT, 0.0, True, scratch)[0] == APPLIED:
            return True
    for local in range(4 if tets else 0):
        if swap_faces(mesh, cell, local, STRICT, 0.0, True, scratch)[0] == APPLIED:
            return True
    return False


@kernel
def change(
    mesh: SimplexMesh,
    cell: int,
    remedy: int,
    way: int,
    how: Mending,
    do: bool,
    scratch: Scratch,
) -> tuple[int, float]:
    """What one way of a remedy makes of a cell at once; with `do` it is done.

    Returns
    -------
    verdict : int
    worst : float
        Worst q right after it.
    """
    floor = how.least_kept * max(mesh.quality[cell], 0.0)
    if remedy == REMOVE_EDGE:
        return swap_edge(mesh, cell, way, FLOOR, floor, do, scratch)
    if remedy == REMOVE_FACES:
        return swap_faces(mesh, cell, way, FLOOR, floor, do, scratch)
    if remedy == COLLAPSE:
        return collapse_edge(mesh, cell, way, floor, do, scratch)
    return insert_vertex(mesh, cell, way, floor, how.max_points, do, scratch)


@kernel
def collapse_edge(
    mesh: SimplexMesh, cell: int, way: int, floor: float, do: bool, scratch: Scratch
) -> tuple[int, float]:
    """Put one end of an edge on the other: the ways go over the edges, both ends of each."""
    table = TET_EDGES if mesh.cells.shape[1] == 4 else TRI_EDGES
    vertex = mesh.cells[cell, table[way >> 1, way & 1]]
    onto = mesh.cells[cell, table[way >> 1, 1 - (way & 1)]]
    plan = simulate_collapse(
        mesh, vertex, onto, Collapsing(FLOOR, floor, MAX_GROWTH, False), scratch
    )
    if do and plan.verdict == APPLIED:
        apply_collapse(mesh, plan, scratch)
    return plan.verdict, plan.worst


@kernel
def insert_vertex(
    mesh: SimplexMesh,
    cell: int,
    way: int,
    floor: float,
    max_points: int,
    do: bool,
    scratch: Scratch,
) -> tuple[int, float]:
    """Star a cavity from a new vertex, and let it climb: the ways are where it starts."""
    if mesh.state[N_POINTS] >= max_points:
        return NOT_BETTER, 0.0
    start = rounded(mesh, starting_point(mesh, cell, way))
    n_cells, n_facets, worst, _ = grow_cavity(mesh, cell, start, scratch)
    if worst <= floor or n_facets > scratch.created.shape[0]:
        return NOT_BETTER, worst
    if not is_legal_cavity(mesh, n_cells, n_facets, scratch):
        return NOT_LEGAL, worst
    if not has_room(mesh, n_facets):
        return FULL, worst
    if do:
        insertion = Insertion(APPLIED, n_cells, n_facets, start, worst)
        climb_vertex(mesh, apply_insertion(mesh, insertion, scratch), scratch)
    return APPLIED, worst


@kernel
def improve(mesh: SimplexMesh, goal: float, n_steps: int, scratch: Scratch) -> float:
    """Improve what changed since the journal was opened, the worst cell first.

    Returns
    -------
    worst : float
        The worst q of what changed, once it is above the goal or nothing helps.
    """
    cell, worst = worst_after(mesh, scratch)
    for _ in range(n_steps):
        if cell < 0 or worst > goal or not has_pages(scratch):
            break
        if not climb_cell(mesh, cell, scratch) and not swap_cell(mesh, cell, scratch):
            break
        before = worst
        cell, worst = worst_after(mesh, scratch)
        if worst < gained(before):
            break
    return worst


@kernel
def pays(mesh: SimplexMesh, goal: float, how: Mending, scratch: Scratch) -> bool:
    """Improve on what was done since the journal was opened, and undo it all if it is no gain."""
    after = improve(mesh, goal, how.steps, scratch)
    before = worst_before(mesh, scratch)
    if after > before + how.gain * abs(before) and (
        before <= how.urgent or has_lower_mean(mesh, scratch)
    ):
        close_journal(scratch)
        return True
    roll_back(mesh, scratch)
    return False


@kernel
def try_remedy(mesh: SimplexMesh, cell: int, remedy: int, how: Mending, scratch: Scratch) -> int:
    """Try the most promising ways of one remedy until one pays.

    Returns
    -------
    verdict : int
        APPLIED, or NOT_BETTER with the mesh as it was.
    """
    goal = mesh.quality[cell] + how.gain * abs(mesh.quality[cell])
    if remedy == RELOCATE:
        open_journal(mesh, scratch)
        moved = climb_cell(mesh, cell, scratch)
        return APPLIED if pays(mesh, goal, how, scratch) and moved else NOT_BETTER
    last = math.inf
    for _ in range(how.trials):
        best = -1
        best_worst = -math.inf
        for way in range(WAYS[mesh.cells.shape[1] - 3][remedy]):
            verdict, worst = change(mesh, cell, remedy, way, how, False, scratch)
            if verdict == APPLIED and best_worst < worst < last:
                best = way
                best_worst = worst
        if best < 0:
            break
        last = best_worst
        open_journal(mesh, scratch)
        change(mesh, cell, remedy, best, how, True, scratch)
        if pays(mesh, goal, how, scratch):
            return APPLIED
    return NOT_BETTER


@kernel
def mend_cell(
    mesh: SimplexMesh, cell: int, remedies: np.ndarray, how: Mending, scratch: Scratch
) -> int:
    """Try the remedies for the type of a cell, in their order; returns the verdict."""
    kind = cell_type(mesh.points, mesh.cells[cell])
    for i in range(remedies.shape[1]):
        if remedies[kind, i] == 0:
            break
        verdict = try_remedy(mesh, cell, remedies[kind, i], how, scratch)
        if verdict != NOT_BETTER:
            return verdict
    return NOT_BETTER


@entry(
    group="mend",
    example=lambda work: (
        work.mesh, work.order, work.facets, Mending(0.0, 0.0, 0.0, 0, 0, 0, 0.0),
        work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_mend(
    mesh: SimplexMesh,
    order: np.ndarray,
    remedies: np.ndarray,
    how: Mending,
    scratch: Scratch,
    counts: np.ndarray,
) -> int:
    """Try to mend each cell in turn; see `swap.sweep_swap`.

    Parameters
    ----------
    order : (n,) int64
        Cells to visit; those that died or became better meanwhile are passed over.
    remedies : (n_types, n) int64
        For each type the remedies in their order, filled up with zeros.
    how : Mending
    counts : (N_VERDICTS,) int64
    """
    # A first change, and a swap at each step.
    most = MAX_CREATED + how.steps * MAX_SHELL
    for i in range(order.shape[0]):
        cell = order[i]
        if mesh.alive[cell] and mesh.quality[cell] < how.below:
            if not has_room(mesh, most):
                return i
            counts[mend_cell(mesh, cell, remedies, how, scratch)] += 1
    return order.shape[0]
