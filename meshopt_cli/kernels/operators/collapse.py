"""Edge collapsing (18.4.2): an edge is replaced by one point, and a vertex vanishes.

The three placements of Figure 18.11: one end, the other end, or a point between them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TRI_EDGES
from ...compiled.decorators import entry, kernel
from ..accept import MEAN, UNCHANGED, is_accepted, lowers_mean, threshold, with_cell, without
from ..cavity import kill_cell, link
from ..gather.ball import (
    gather_ball,
    local_index,
    longest_edge_at,
    next_stamp,
    touch,
    worst_of,
)
from ..gather.rim import is_outer
from ..guide import PLANE
from ..journal import keep
from ..judge import q_with
from ..types import (
    APPLIED,
    CLOCK,
    FIXED,
    INVALID,
    NOT_BETTER,
    NOT_LEGAL,
    TOO_LARGE,
    TOO_LONG,
    Scratch,
    SimplexMesh,
)
from ..vectors import ZERO, Vec, at, rounded, set_point, toward

MAX_GROWTH = 1.5  # of the longest edge, where nothing else is said


class Collapsing(NamedTuple):
    """Which collapses are wanted."""

    rule: int
    floor: float
    max_growth: float  # longest new edge over the longest edge of the balls it replaces
    midpoint: bool  # whether the point between the ends is tried


class CollapsePlan(NamedTuple):
    """A simulated collapse: `vertex` vanishes into `onto`, which goes to `position`.

    The ball of `vertex` is in `scratch.ball`; that of `onto`, when it moves, in
    `scratch.other`.
    """

    verdict: int
    vertex: int
    onto: int
    n: int
    n_other: int  # 0 when `onto` stays where it is
    position: Vec
    worst: float


@kernel
def refused(verdict: int, vertex: int, onto: int) -> CollapsePlan:
    """The plan of a collapse that is not to be carried out."""
    return CollapsePlan(verdict, vertex, onto, 0, 0, ZERO, 0.0)


@kernel
def worst_collapsed(
    mesh: SimplexMesh, ball: np.ndarray, n: int, onto: int, p: Vec, stop: float
) -> float:
    """Worst q of the cells of a ball that do not have `onto`, with its vertex at p."""
    worst = math.inf
    for i in range(n):
        if local_index(mesh.cells, ball[i] >> 2, onto) < 0:
            worst = min(worst, q_with(mesh, ball[i], p))
            if worst <= stop:
                break
    return worst


@kernel
def has_lower_mean(
    mesh: SimplexMesh, n: int, n_other: int, vertex: int, onto: int, p: Vec, scratch: Scratch
) -> bool:
    """Whether the mean Q of the balls falls as both ends of an edge come to p."""
    sums = UNCHANGED
    for i in range(n):
        handle = scratch.ball[i]
        sums = without(sums, mesh.quality[handle >> 2])
        if local_index(mesh.cells, handle >> 2, onto) < 0:
            sums = with_cell(sums, q_with(mesh, handle, p))
    for i in range(n_other):
        handle = scratch.other[i]
        # Those with both ends are in the first ball, and vanish.
        if local_index(mesh.cells, handle >> 2, vertex) < 0:
            sums = without(sums, mesh.quality[handle >> 2])
            sums = with_cell(sums, q_with(mesh, handle, p))
    return lowers_mean(sums)


@kernel
def has_legal_link(
    mesh: SimplexMesh, vertex: int, onto: int, n: int, n_other: int, scratch: Scratch
) -> bool:
    """Whether the ends of an edge share no vertex but those of its shell.

    Otherwise two edges would fall together that have no cell between them.
    """
    ball_mark = next_stamp(scratch)
    for i in range(n):
        cell = scratch.ball[i] >> 2
        for k in range(mesh.cells.shape[1]):
            scratch.vertex_mark[mesh.cells[cell, k]] = ball_mark
    shell_mark = next_stamp(scratch)
    for i in range(n):
        cell = scratch.ball[i] >> 2
        if local_index(mesh.cells, cell, onto) >= 0:
            for k in range(mesh.cells.shape[1]):
                scratch.vertex_mark[mesh.cells[cell, k]] = shell_mark
    for i in range(n_other):
        cell = scratch.other[i] >> 2
        for k in range(mesh.cells.shape[1]):
            if scratch.vertex_mark[mesh.cells[cell, k]] == ball_mark:
                return False
    return True


@kernel
def joined_on_boundary(mesh: SimplexMesh, vertex: int, onto: int, n: int, scratch: Scratch) -> bool:
    """Whether the edge from a vertex of the boundary to another lies on the boundary."""
    for i in range(n):
        cell = scratch.ball[i] >> 2
        there = local_index(mesh.cells, cell, onto)
        if there >= 0:
            for k in range(mesh.cells.shape[1]):
                if k not in (there, scratch.ball[i] & 3) and is_outer(mesh.neighbours[cell, k]):
                    return True
    return False


@kernel
def simulate_collapse(
    mesh: SimplexMesh, vertex: int, onto: int, how: Collapsing, scratch: Scratch
) -> CollapsePlan:
    """Put an internal vertex on another vertex of its ball, or one of a plane on one of that."""
    in_plane = mesh.slides and mesh.guide[vertex, 0] == PLANE
    if mesh.fixed[vertex] and not in_plane:
        return refused(FIXED, vertex, onto)
    n, closed = gather_ball(mesh, vertex, scratch.ball, scratch)
    if n < 0:
        return refused(TOO_LARGE, vertex, onto)
    if not closed and not (in_plane and joined_on_boundary(mesh, vertex, onto, n, scratch)):
        return refused(FIXED, vertex, onto)
    before = worst_of(mesh, scratch.ball, n)
    stop = threshold(how.rule, how.floor, before)
    p = at(mesh.points, onto)
    worst = worst_collapsed(mesh, scratch.ball, n, onto, p, stop)
    if worst <= 0.0:
        return refused(INVALID, vertex, onto)
    if not is_accepted(how.rule, how.floor, before, worst) or (
        how.rule == MEAN and not has_lower_mean(mesh, n, 0, vertex, onto, p, scratch)
    ):
        return refused(NOT_BETTER, vertex, onto)
    longest = longest_edge_at(mesh, scratch.ball, n, at(mesh.points, vertex))
    if longest_edge_at(mesh, scratch.ball, n, p) > how.max_growth * longest:
        return refused(TOO_LONG, vertex, onto)
    return CollapsePlan(APPLIED, vertex, onto, n, 0, p, worst)


@kernel
def simulate_midpoint_collapse(
    mesh: SimplexMesh, vertex: int, onto: int, how: Collapsing, scratch: Scratch
) -> CollapsePlan:
    """Put both ends of an edge, neither of them fixed, on the point half way between."""
    if mesh.fixed[vertex] or mesh.fixed[onto]:
        return refused(FIXED, vertex, onto)
    n, closed = gather_ball(mesh, vertex, scratch.ball, scratch)
    n_other, closed_other = gather_ball(mesh, onto, scratch.other, scratch)
    if n < 0 or n_other < 0:
        return refused(TOO_LARGE, vertex, onto)
    if not (closed and closed_other):
        return refused(FIXED, vertex, onto)
    before = min(worst_of(mesh, scratch.ball, n), worst_of(mesh, scratch.other, n_other))
    stop = threshold(how.rule, how.floor, before)
    a = at(mesh.points, vertex)
    b = at(mesh.points, onto)
    p = rounded(mesh, toward(a, b, 0.5))
    worst = worst_collapsed(mesh, scratch.ball, n, onto, p, stop)
    if worst > stop:
        worst = min(worst, worst_collapsed(mesh, scratch.other, n_other, vertex, p, stop))
    if worst <= 0.0:
        return refused(INVALID, vertex, onto)
    if not is_accepted(how.rule, how.floor, before, worst) or (
        how.rule == MEAN and not has_lower_mean(mesh, n, n_other, vertex, onto, p, scratch)
    ):
        return refused(NOT_BETTER, vertex, onto)
    if not has_legal_link(mesh, vertex, onto, n, n_other, scratch):
        return refused(NOT_LEGAL, vertex, onto)
    longest = max(
        longest_edge_at(mesh, scratch.ball, n, a),
        longest_edge_at(mesh, scratch.other, n_other, b),
    )
    grown = max(
        longest_edge_at(mesh, scratch.ball, n, p),
        longest_edge_at(mesh, scratch.other, n_other, p),
    )
    if grown > how.max_growth * longest:
        return refused(TOO_LONG, vertex, onto)
    return CollapsePlan(APPLIED, vertex, onto, n, n_other, p, worst)


@kernel
def apply_collapse(mesh: SimplexMesh, plan: CollapsePlan, scratch: Scratch) -> None:
    """Carry out a simulated collapse."""
    d1 = mesh.cells.shape[1]
    for i in range(plan.n):
        keep(mesh, scratch.ball[i] >> 2, scratch)
    for i in range(plan.n_other):
        keep(mesh, scratch.other[i] >> 2, scratch)
    if plan.n_other > 0:
        set_point(mesh.points, plan.onto, plan.position)
    # The cells of the shell die: what lay beyond their facets at both ends meets.
    for i in range(plan.n):
        cell = scratch.ball[i] >> 2
        there = local_index(mesh.cells, cell, plan.onto)
        if there < 0:
            continue
        one = mesh.neighbours[cell, scratch.ball[i] & 3]
        other = mesh.neighbours[cell, there]
        if one >= 0:
            keep(mesh, one >> 2, scratch)
        if other >= 0:
            keep(mesh, other >> 2, scratch)
        link(mesh, one, other)
        for k in range(d1):
            mesh.vertex_clock[mesh.cells[cell, k]] = mesh.state[CLOCK]
            v = mesh.cells[cell, k]
            if v not in (plan.vertex, plan.onto):
                mesh.vertex_cell[v] = other >> 2
        kill_cell(mesh, cell)
    for i in range(plan.n):
        cell = scratch.ball[i] >> 2
        if mesh.alive[cell]:
            mesh.cells[cell, scratch.ball[i] & 3] = plan.onto
            mesh.vertex_cell[plan.onto] = cell
            mesh.quality[cell] = q_with(mesh, scratch.ball[i], plan.position)
            touch(mesh, cell)
    for i in range(plan.n_other):
        cell = scratch.other[i] >> 2
        if mesh.alive[cell]:
            mesh.vertex_cell[plan.onto] = cell
            mesh.quality[cell] = q_with(mesh, scratch.other[i], plan.position)
            touch(mesh, cell)
    mesh.vertex_cell[plan.vertex] = -1


@kernel
def collapse_cell(
    mesh: SimplexMesh, cell: int, victim: int, how: Collapsing, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try the edges of a cell in turn, each in its three placements.

    Parameters
    ----------
    victim : int
        The only vertex that may vanish; -1 for any.

    Returns
    -------
    vertex : int
        The vertex that vanished, or -1.
    """
    tets = mesh.cells.shape[1] == 4
    for edge in range(6 if tets else 3):
        a = mesh.cells[cell, TET_EDGES[edge, 0] if tets else TRI_EDGES[edge, 0]]
        b = mesh.cells[cell, TET_EDGES[edge, 1] if tets else TRI_EDGES[edge, 1]]
        if victim not in (-1, a, b):
            continue
        for placement in range(3 if how.midpoint else 2):
            if victim not in (-1, a if placement == 0 else b):
                continue
            if placement == 0:
                plan = simulate_collapse(mesh, a, b, how, scratch)
            elif placement == 1:
                plan = simulate_collapse(mesh, b, a, how, scratch)
            else:
                plan = simulate_midpoint_collapse(mesh, a, b, how, scratch)
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                apply_collapse(mesh, plan, scratch)
                return plan.vertex
    return -1


@entry(
    group="collapse",
    example=lambda work: (
        work.mesh, work.facets, Collapsing(0, 0.0, 0.0, False), 0,
        work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_collapse(
    mesh: SimplexMesh,
    order: np.ndarray,
    how: Collapsing,
    most: int,
    scratch: Scratch,
    counts: np.ndarray,
) -> int:
    """Try the edges of each cell in turn; see `swap.sweep_swap`. It needs no room.

    Parameters
    ----------
    order : (n, 2) int64
        Cells to visit, and for each the only vertex that may vanish there, -1 for any.
    most : int
        The sweep ends when so many are applied, those counted before it included.
    """
    for i in range(order.shape[0]):
        if counts[APPLIED] >= most:
            break
        if mesh.alive[order[i, 0]]:
            collapse_cell(mesh, order[i, 0], order[i, 1], how, scratch, counts)
    return order.shape[0]
