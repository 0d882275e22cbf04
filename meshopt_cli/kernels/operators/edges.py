"""Edges that are too long or too short in the metric: split, or collapsed (18.3.3, 18.4.2).

The efficiency index (18.12) tells what a change is worth: each edge lacks (1 - e)², e being its
length or 1 over it, whichever is less, and what the edges lack on average is to fall.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TRI_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import is_accepted, threshold
from ..cavity import has_room, replace_cells
from ..gather.ball import gather_ball, local_index, next_stamp, worst_of
from ..gather.rim import INSIDE, around_any_edge, may_slide_onto, set_guide_between
from ..gather.shell import is_required
from ..guide import LINE, PLANE
from ..journal import keep_vertex
from ..judge import q_of_row
from ..metric import length, set_between, square_in
from ..types import (
    APPLIED,
    FIXED,
    INVALID,
    MAX_CREATED,
    MAX_SHELL,
    N_CELLS,
    N_POINTS,
    NOT_BETTER,
    TOO_LARGE,
    TOO_LONG,
    Scratch,
    SimplexMesh,
)
from ..vectors import Vec, at, minus, rounded, set_point, toward
from .collapse import CollapsePlan, apply_collapse, refused, worst_collapsed

MAX_EDGES = 6


class Fitting(NamedTuple):
    """Which changes toward edges of length 1 are wanted."""

    rule: int
    floor: float
    limit: float  # edges that are longer are split, or shorter collapsed
    other: float  # new edges may not be shorter than this, or longer
    lack: float  # what the edges of the mesh lack on average, which must fall; negative: it may not
    max_points: int  # rows of the point arrays that may be used


class EdgeSplit(NamedTuple):
    """A simulated split. The old cells are in `scratch.cavity`, the new in `scratch.created`."""

    verdict: int
    n_old: int
    n_new: int
    position: Vec
    one: int  # borders on either side of an edge of the boundary, else INSIDE
    other: int


@inlined
def lack_of(size: float) -> float:
    """What an edge of this length lacks of one of length 1."""
    missing = 1.0 - min(size, 1.0 / size)
    return missing * missing


@inlined
def halfway(points: np.ndarray, a: int, b: int) -> float:
    """The part of the way from a to b at which the length from either end is the same."""
    e = minus(at(points, b), at(points, a))
    one = math.sqrt(square_in(points, a, e))
    other = math.sqrt(square_in(points, b, e))
    if abs(one - other) <= 1e-3 * one:
        return 0.5
    return math.log(2.0 * one / (one + other)) / math.log(one / other)


@inlined
def ends_of(mesh: SimplexMesh, cell: int, edge: int) -> tuple[int, int]:
    """The ends of an edge of a cell; in the plane of that across from a vertex."""
    if mesh.cells.shape[1] == 4:
        return mesh.cells[cell, TET_EDGES[edge, 0]], mesh.cells[cell, TET_EDGES[edge, 1]]
    return mesh.cells[cell, TRI_FACETS[edge, 0]], mesh.cells[cell, TRI_FACETS[edge, 1]]


@kernel
def simulate_edge_split(
    mesh: SimplexMesh, cell: int, edge: int, how: Fitting, scratch: Scratch
) -> EdgeSplit:
    """Simulate a new vertex half way, in the metric, on an edge that may be split.

    It is written to the next free row of the points, which nothing refers to yet.
    """
    a, b = ends_of(mesh, cell, edge)
    points = mesh.points
    n, one, other = around_any_edge(mesh, cell, edge, scratch)
    t = halfway(points, a, b)
    p = rounded(mesh, toward(at(points, a), at(points, b), t))
    if n == 0 or is_required(mesh, a, b):
        return EdgeSplit(FIXED, 0, 0, p, one, other)
    if n > MAX_SHELL:
        return EdgeSplit(TOO_LARGE, 0, 0, p, one, other)
    vertex = mesh.state[N_POINTS]
    set_point(points, vertex, p)
    set_between(points, vertex, a, b, t)
    width = mesh.cells.shape[1]
    before = math.inf
    for i in range(n):
        before = min(before, mesh.quality[scratch.cavity[i]])
    stop = threshold(how.rule, how.floor, before)
    worst = math.inf
    stamp = next_stamp(scratch)
    scratch.vertex_mark[a] = stamp
    scratch.vertex_mark[b] = stamp
    lack = -lack_of(length(points, a, b)) + lack_of(length(points, a, vertex))
    lack += lack_of(length(points, b, vertex))
    more = 1
    for i in range(n):
        old = scratch.cavity[i]
        for k in range(width):
            v = mesh.cells[old, k]
            scratch.created[2 * i, k] = vertex if v == a else v
            scratch.created[2 * i + 1, k] = vertex if v == b else v
            if scratch.vertex_mark[v] != stamp:
                scratch.vertex_mark[v] = stamp
                size = length(points, v, vertex)
                if size < how.other:
                    return EdgeSplit(TOO_LONG, n, 2 * n, p, one, other)
                lack += lack_of(size)
                more += 1
        worst = min(worst, q_of_row(mesh, scratch.created, 2 * i))
        worst = min(worst, q_of_row(mesh, scratch.created, 2 * i + 1))
        if worst <= stop:
            return EdgeSplit(INVALID if worst <= 0.0 else NOT_BETTER, n, 2 * n, p, one, other)
    if how.lack >= 0.0 and lack >= more * how.lack:
        return EdgeSplit(NOT_BETTER, n, 2 * n, p, one, other)
    return EdgeSplit(APPLIED, n, 2 * n, p, one, other)


@kernel
def apply_edge_split(mesh: SimplexMesh, plan: EdgeSplit, a: int, b: int, scratch: Scratch) -> int:
    """Carry out a simulated split of the edge from a to b; returns the new vertex."""
    vertex = mesh.state[N_POINTS]
    mesh.state[N_POINTS] += 1
    keep_vertex(mesh, vertex, scratch)
    mesh.fixed[vertex] = False
    if plan.one != INSIDE:
        set_guide_between(mesh, vertex, a, b, plan.one, plan.other, plan.n_old, scratch)
    replace_cells(mesh, scratch.cavity, plan.n_old, plan.n_new, scratch)
    return vertex


@kernel
def next_edge(
    mesh: SimplexMesh, cell: int, tried: int, limit: float, long: bool
) -> tuple[int, int]:
    """The longest edge of a cell above a limit, or the shortest below, of those not yet tried.

    Returns
    -------
    edge : int
        -1 when there is none.
    tried : int
        With the bit of that edge set.
    """
    found = -1
    best = limit
    for edge in range(6 if mesh.cells.shape[1] == 4 else 3):
        if tried >> edge & 1:
            continue
        a, b = ends_of(mesh, cell, edge)
        size = length(mesh.points, a, b)
        if (size > best) if long else (size < best):
            best = size
            found = edge
    return found, tried | (1 << found if found >= 0 else 0)


@entry(
    group="fit",
    example=lambda work: (
        work.mesh, work.order, Fitting(0, 0.0, 0.0, 0.0, 0.0, 0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_long_edges(
    mesh: SimplexMesh, order: np.ndarray, how: Fitting, scratch: Scratch, counts: np.ndarray
) -> int:
    """Split the edges of each cell that are too long, the longest first; see `swap.sweep_swap`."""
    for i in range(order.shape[0]):
        cell = order[i]
        if mesh.state[N_POINTS] >= how.max_points:
            break
        if not has_room(mesh, MAX_CREATED):
            return i
        tried = 0
        while mesh.alive[cell]:
            edge, tried = next_edge(mesh, cell, tried, how.limit, True)
            if edge < 0:
                break
            plan = simulate_edge_split(mesh, cell, edge, how, scratch)
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                a, b = ends_of(mesh, cell, edge)
                apply_edge_split(mesh, plan, a, b, scratch)
                break
    return order.shape[0]


@kernel
def simulate_short_collapse(
    mesh: SimplexMesh, vertex: int, onto: int, how: Fitting, scratch: Scratch
) -> CollapsePlan:
    """Put a vertex on another one, along the boundary where it slides there, as a rule allows."""
    slides = mesh.slides and mesh.guide[vertex, 0] in (LINE, PLANE)
    if mesh.fixed[vertex] and not slides:
        return refused(FIXED, vertex, onto)
    n, closed = gather_ball(mesh, vertex, scratch.ball, scratch)
    if n < 0:
        return refused(TOO_LARGE, vertex, onto)
    if not closed and not (slides and may_slide_onto(mesh, vertex, onto, n, scratch)):
        return refused(FIXED, vertex, onto)
    points = mesh.points
    p = at(points, onto)
    # What has an edge to `onto` already, within the ball, keeps it.
    stamp = next_stamp(scratch)
    scratch.vertex_mark[vertex] = stamp
    scratch.vertex_mark[onto] = stamp
    lack = -lack_of(length(points, vertex, onto))
    more = -1
    for i in range(n):
        cell = scratch.ball[i] >> 2
        if local_index(mesh.cells, cell, onto) >= 0:
            for k in range(mesh.cells.shape[1]):
                v = mesh.cells[cell, k]
                if scratch.vertex_mark[v] != stamp:
                    scratch.vertex_mark[v] = stamp
                    lack -= lack_of(length(points, vertex, v))
                    more -= 1
    for i in range(n):
        cell = scratch.ball[i] >> 2
        for k in range(mesh.cells.shape[1]):
            v = mesh.cells[cell, k]
            if scratch.vertex_mark[v] != stamp:
                scratch.vertex_mark[v] = stamp
                size = length(points, onto, v)
                if size > how.other and size > length(points, vertex, v):
                    return refused(TOO_LONG, vertex, onto)
                lack += lack_of(size) - lack_of(length(points, vertex, v))
    if how.lack >= 0.0 and lack >= more * how.lack:
        return refused(NOT_BETTER, vertex, onto)
    before = worst_of(mesh, scratch.ball, n)
    stop = threshold(how.rule, how.floor, before)
    worst = worst_collapsed(mesh, scratch.ball, n, onto, p, stop)
    if worst <= 0.0:
        return refused(INVALID, vertex, onto)
    if not is_accepted(how.rule, how.floor, before, worst):
        return refused(NOT_BETTER, vertex, onto)
    return CollapsePlan(APPLIED, vertex, onto, n, 0, p, worst)


@entry(
    group="fit",
    example=lambda work: (
        work.mesh, work.order, Fitting(0, 0.0, 0.0, 0.0, 0.0, 0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_short_edges(
    mesh: SimplexMesh, order: np.ndarray, how: Fitting, scratch: Scratch, counts: np.ndarray
) -> int:
    """Collapse the edges of each cell that are too short, the shortest first, onto either end.

    See `swap.sweep_swap`. It needs no room.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        tried = 0
        while mesh.alive[cell]:
            edge, tried = next_edge(mesh, cell, tried, how.limit, False)
            if edge < 0:
                break
            a, b = ends_of(mesh, cell, edge)
            plan = simulate_short_collapse(mesh, a, b, how, scratch)
            if plan.verdict != APPLIED:
                plan = simulate_short_collapse(mesh, b, a, how, scratch)
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                apply_collapse(mesh, plan, scratch)
                break
    return order.shape[0]


@entry(
    group="fit",
    example=lambda work: (work.mesh, work.vertex_values, work.vertex_values, work.vertex_values, 0),
)
def extreme_lengths(
    mesh: SimplexMesh, shortest: np.ndarray, longest: np.ndarray, lack: np.ndarray, since: int
) -> None:
    """The shortest and the longest edge of each cell, and what its edges lack on average, (n,).

    Parameters
    ----------
    since : int
        Of cells that did not change in this sweep, nor after it, the values are there.
    """
    n_edges = 6 if mesh.cells.shape[1] == 4 else 3
    for cell in range(mesh.state[N_CELLS]):
        changed = True
        for k in range(mesh.cells.shape[1]):
            changed = changed and mesh.vertex_clock[mesh.cells[cell, k]] >= since
        if mesh.alive[cell] and not changed:
            continue
        least = math.inf
        most = 0.0
        total = 0.0
        if mesh.alive[cell]:
            for edge in range(n_edges):
                a, b = ends_of(mesh, cell, edge)
                size = length(mesh.points, a, b)
                least = min(least, size)
                most = max(most, size)
                total += lack_of(size)
        shortest[cell] = least
        longest[cell] = most
        lack[cell] = total / n_edges
