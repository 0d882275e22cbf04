"""Insertion of a vertex into a cavity around a bad cell (18.4, "to add a vertex").

The cavity grows from the bad cell across the facet that would make the worst new cell, for as
long as that may help; the hole is starred from the new vertex, which climbs to where the star is
best. What is applied is the best stage seen, or nothing. A split of an edge, a face or a cell is
the case where the cavity is its shell, its two cells, or the cell alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TET_FACETS, TRI_EDGES, TRI_FACETS
from ...compiled.decorators import entry, kernel
from ..accept import UNCHANGED, lowers_mean, with_cell, without
from ..cavity import has_room, replace_cells
from ..gather.ball import next_stamp
from ..gather.shell import is_required
from ..guide import FREE
from ..journal import keep_vertex
from ..judge import q_with
from ..metric import set_mean
from ..types import (
    APPLIED,
    FULL,
    INVALID,
    MAX_CREATED,
    N_POINTS,
    NOT_BETTER,
    NOT_LEGAL,
    TOO_LARGE,
    Scratch,
    SimplexMesh,
)
from ..vectors import Vec, at, rounded, set_point, toward
from .climb import climb

MAX_CAVITY = 40  # cells
PATIENCE = 10  # cells that may join without gain
N_REFINEMENTS = 2  # rounds of growing the cavity and moving the vertex


class Splitting(NamedTuple):
    """Which insertions are wanted."""

    max_points: int  # rows of the vertex arrays that may be used
    gain: float  # least gain of the worst q of a cavity, as a part of it
    urgent: float  # where a cavity is no worse than this q, its mean Q must fall, too
    first_gain: float  # and the first cavity of a cell must have this part of its q to be refined


class Insertion(NamedTuple):
    """A simulated insertion.

    The cells of the cavity are in `scratch.cavity`, and the handles of its facets, each in
    the cell inside, in `scratch.ball`.
    """

    verdict: int
    n_cells: int
    n_facets: int
    position: Vec
    worst: float


@kernel
def centre(mesh: SimplexMesh, cell: int) -> Vec:
    """Barycentre of a cell."""
    x = 0.0
    y = 0.0
    z = 0.0
    width = mesh.cells.shape[1]
    for k in range(width):
        p = at(mesh.points, mesh.cells[cell, k])
        x += p.x / width
        y += p.y / width
        z += p.z / width
    return Vec(x, y, z)


@kernel
def grow_cavity(
    mesh: SimplexMesh, cell: int, p: Vec, scratch: Scratch
) -> tuple[int, int, float, float]:
    """Find the cavity around a cell whose star from p has the best worst q.

    Returns
    -------
    n_cells, n_facets : int
        Of the best cavity, left in `scratch.cavity` and `scratch.ball`.
    worst : float
        Worst q of its star.
    before : float
        Worst q of its cells.
    """
    width = mesh.cells.shape[1]
    cavity = scratch.cavity
    facets = scratch.ball
    values = scratch.values
    stamp = next_stamp(scratch)
    cavity[0] = cell
    scratch.cell_mark[cell] = stamp
    n_cells = 1
    n_facets = 0
    for k in range(width):
        facets[n_facets] = 4 * cell + k
        values[n_facets] = q_with(mesh, facets[n_facets], p)
        n_facets += 1
    before = mesh.quality[cell]
    best_n = 0
    best_worst = -math.inf
    best_before = before
    while True:
        worst = math.inf
        weakest = -1
        for i in range(n_facets):
            if values[i] < worst:
                worst = values[i]
                weakest = i
        if worst > best_worst:
            best_n = n_cells
            best_worst = worst
            best_before = before
        beyond = mesh.neighbours[facets[weakest] >> 2, facets[weakest] & 3]
        if beyond < 0 or n_cells == MAX_CAVITY or n_cells > best_n + PATIENCE:
            break
        # The neighbour joins: facets it shares with the cavity vanish, the others are new.
        added = beyond >> 2
        scratch.cell_mark[added] = stamp
        cavity[n_cells] = added
        n_cells += 1
        before = min(before, mesh.quality[added])
        n_facets = close_facets(mesh, added, facets, values, n_facets, p, stamp, scratch)
    # Take the later cells out again.
    return best_n, enclose(mesh, best_n, scratch), best_worst, best_before


@kernel
def enclose(mesh: SimplexMesh, n_cells: int, scratch: Scratch) -> int:
    """Collect the facets of the first cells of `scratch.cavity`; returns how many there are."""
    cavity = scratch.cavity
    n_facets = 0
    stamp = next_stamp(scratch)
    for i in range(n_cells):
        scratch.cell_mark[cavity[i]] = stamp
    for i in range(n_cells):
        for k in range(mesh.cells.shape[1]):
            beyond = mesh.neighbours[cavity[i], k]
            if beyond < 0 or scratch.cell_mark[beyond >> 2] != stamp:
                scratch.ball[n_facets] = 4 * cavity[i] + k
                n_facets += 1
    return n_facets


@kernel
def close_facets(
    mesh: SimplexMesh,
    added: int,
    facets: np.ndarray,
    values: np.ndarray,
    n_facets: int,
    p: Vec,
    stamp: int,
    scratch: Scratch,
) -> int:
    """Update the facets of a cavity for a cell that joined it; returns how many there are."""
    for k in range(mesh.cells.shape[1]):
        beyond = mesh.neighbours[added, k]
        if beyond >= 0 and scratch.cell_mark[beyond >> 2] == stamp:
            for i in range(n_facets):
                if facets[i] == beyond:
                    n_facets -= 1
                    facets[i] = facets[n_facets]
                    values[i] = values[n_facets]
                    break
        else:
            facets[n_facets] = 4 * added + k
            values[n_facets] = q_with(mesh, facets[n_facets], p)
            n_facets += 1
    return n_facets


@kernel
def is_legal_cavity(mesh: SimplexMesh, n_cells: int, n_facets: int, scratch: Scratch) -> bool:
    """Whether a star of the cavity keeps all vertices and all edges that must stay."""
    width = mesh.cells.shape[1]
    stamp = next_stamp(scratch)
    for i in range(n_facets):
        cell = scratch.ball[i] >> 2
        for k in range(width):
            if k != scratch.ball[i] & 3:
                scratch.vertex_mark[mesh.cells[cell, k]] = stamp
    for i in range(n_cells):
        for k in range(width):
            if scratch.vertex_mark[mesh.cells[scratch.cavity[i], k]] != stamp:
                return False
    if mesh.required.shape[0] > 0:
        table = TET_EDGES if width == 4 else TRI_EDGES
        for i in range(n_cells):
            for e in range(table.shape[0]):
                a = mesh.cells[scratch.cavity[i], table[e, 0]]
                b = mesh.cells[scratch.cavity[i], table[e, 1]]
                if is_required(mesh, a, b):
                    return False
    return True


@kernel
def has_lower_mean(
    mesh: SimplexMesh, n_cells: int, n_facets: int, p: Vec, scratch: Scratch
) -> bool:
    """Whether the mean Q of the star of a cavity from p is below that of its cells."""
    sums = UNCHANGED
    for i in range(n_cells):
        sums = without(sums, mesh.quality[scratch.cavity[i]])
    for i in range(n_facets):
        sums = with_cell(sums, q_with(mesh, scratch.ball[i], p))
    return lowers_mean(sums)


@kernel
def refine_insertion(
    mesh: SimplexMesh, cell: int, start: Vec, how: Splitting, scratch: Scratch
) -> Insertion:
    """Let the cavity grow and the new vertex move in turn, from one starting point."""
    p = rounded(mesh, start)
    n_cells, n_facets, worst, before = grow_cavity(mesh, cell, p, scratch)
    for _ in range(N_REFINEMENTS):
        if worst <= 0.0:
            break
        p, climbed = climb(mesh, scratch.ball, n_facets, p, FREE, scratch)
        n_cells, n_facets, worst, before = grow_cavity(mesh, cell, p, scratch)
        if worst < climbed:
            break
    if worst <= 0.0:
        return Insertion(INVALID, n_cells, n_facets, p, worst)
    if worst <= before + how.gain * abs(before) or (
        before > how.urgent and not has_lower_mean(mesh, n_cells, n_facets, p, scratch)
    ):
        return Insertion(NOT_BETTER, n_cells, n_facets, p, worst)
    if not is_legal_cavity(mesh, n_cells, n_facets, scratch):
        return Insertion(NOT_LEGAL, n_cells, n_facets, p, worst)
    if n_facets > scratch.created.shape[0]:
        return Insertion(TOO_LARGE, n_cells, n_facets, p, worst)
    if not has_room(mesh, n_facets):
        return Insertion(FULL, n_cells, n_facets, p, worst)
    return Insertion(APPLIED, n_cells, n_facets, p, worst)


@kernel
def starting_point(mesh: SimplexMesh, cell: int, which: int) -> Vec:
    """Where a new vertex for a bad cell may start: its centre, or the middle of an edge."""
    if which == 0:
        return centre(mesh, cell)
    tets = mesh.cells.shape[1] == 4
    a = mesh.cells[cell, TET_EDGES[which - 1, 0] if tets else TRI_EDGES[which - 1, 0]]
    b = mesh.cells[cell, TET_EDGES[which - 1, 1] if tets else TRI_EDGES[which - 1, 1]]
    # A little towards the centre: an edge of the boundary must not be touched.
    middle = toward(at(mesh.points, a), at(mesh.points, b), 0.5)
    return toward(middle, centre(mesh, cell), 0.2)


@kernel
def simulate_insertion(mesh: SimplexMesh, cell: int, how: Splitting, scratch: Scratch) -> Insertion:
    """Simulate the insertion of a vertex that mends a cell.

    The starting points are compared by their first cavities; the two best are refined, and
    the first that pays is taken.
    """
    first = -1
    second = -1
    first_worst = -math.inf
    second_worst = -math.inf
    for which in range(7 if mesh.cells.shape[1] == 4 else 4):
        p = rounded(mesh, starting_point(mesh, cell, which))
        _, _, worst, _ = grow_cavity(mesh, cell, p, scratch)
        if worst > first_worst:
            second = first
            second_worst = first_worst
            first = which
            first_worst = worst
        elif worst > second_worst:
            second = which
            second_worst = worst
    q = mesh.quality[cell]
    if q > how.urgent and first_worst < how.first_gain * q:
        return Insertion(NOT_BETTER, 0, 0, centre(mesh, cell), first_worst)
    plan = refine_insertion(mesh, cell, starting_point(mesh, cell, first), how, scratch)
    if plan.verdict == APPLIED or second < 0:
        return plan
    return refine_insertion(mesh, cell, starting_point(mesh, cell, second), how, scratch)


@kernel
def apply_insertion(mesh: SimplexMesh, plan: Insertion, scratch: Scratch) -> int:
    """Carry out a simulated insertion; returns the new vertex."""
    width = mesh.cells.shape[1]
    vertex = mesh.state[N_POINTS]
    mesh.state[N_POINTS] += 1
    keep_vertex(mesh, vertex, scratch)
    set_point(mesh.points, vertex, plan.position)
    if mesh.points.shape[1] > 3:
        set_mean(mesh.points, vertex, mesh.cells, scratch.cavity[0])
    mesh.fixed[vertex] = False
    for i in range(plan.n_facets):
        cell = scratch.ball[i] >> 2
        local = scratch.ball[i] & 3
        for k in range(width - 1):
            corner = TET_FACETS[local, k] if width == 4 else TRI_FACETS[local, k]
            scratch.created[i, k] = mesh.cells[cell, corner]
        scratch.created[i, width - 1] = vertex
    replace_cells(mesh, scratch.cavity, plan.n_cells, plan.n_facets, scratch)
    return vertex


@entry(
    group="split",
    example=lambda work: (
        work.mesh, work.order, Splitting(0, 0.0, 0.0, 0.0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_split(
    mesh: SimplexMesh, order: np.ndarray, how: Splitting, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try to mend each cell in turn by a new vertex; see `swap.sweep_swap`.

    Parameters
    ----------
    how : Splitting
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        if mesh.state[N_POINTS] >= how.max_points:
            break
        if not has_room(mesh, MAX_CREATED):
            return i
        plan = simulate_insertion(mesh, cell, how, scratch)
        counts[plan.verdict] += 1
        if plan.verdict == APPLIED:
            apply_insertion(mesh, plan, scratch)
    return order.shape[0]
