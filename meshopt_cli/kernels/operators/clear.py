"""Composite operations against obtuse triangles (18.4.3), where moves and flips do not help.

A flip, a split of a vertex in two, a collapse or a new vertex comes first, whatever harm it does;
what changed is eased by moves and flips, in rounds; and all of it is undone unless fewer triangles
lack anything then, or they lack much less.

The split of a vertex is what the boundary needs most: between an edge of the boundary and the next,
it brings one triangle more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TRI_EDGES
from ...compiled.decorators import entry, kernel
from ..accept import FLAT, VALID
from ..cavity import has_room
from ..gather.ball import local_index
from ..journal import changed, close_journal, has_pages, open_journal, roll_back
from ..judge import q_with
from ..shape.lack import NONE, Lack, Wants, added, extremes
from ..types import (
    APPLIED,
    J_ALIVE,
    J_CELLS,
    J_CORNERS,
    J_ROW,
    J_STAMP,
    J_VERTICES,
    MAX_CREATED,
    N_POINTS,
    NOT_BETTER,
    Scratch,
    SimplexMesh,
)
from ..vectors import Vec, at, rounded
from .collapse import Collapsing, apply_collapse, simulate_collapse
from .flip import apply_flip, simulate_flip
from .insert import (
    Insertion,
    apply_insertion,
    enclose,
    grow_cavity,
    is_legal_cavity,
    starting_point,
)
from .nonobtuse import ease, extremes_of, lack_of_cell

# The ways to begin at a triangle: a flip of each edge; a collapse of each edge onto each of its
# ends; a split of each vertex, toward each of the two others, with each number of triangles of
# FANS; a vertex in a cavity, from each of `starting_point`. With splits before collapses badly
# connected meshes get 8 % more triangles instead of 7 % less, and half more is left on one of six.
FANS = (2, 3, 4)
COLLAPSES = 3
SPLITS = COLLAPSES + 6
INSERTIONS = SPLITS + 6 * len(FANS)
N_WAYS = INSERTIONS + 4
MOST_CHANGED = 100  # cells that are eased around a first change, but for the last ones
LEAST_PROGRESS = 0.05  # of a round of easing, as a part of what is lacking; less ends it
COUNTS = 10.0  # what an obtuse or sharp triangle counts there, beside the cost
# More triangles that lack anything than before, after a round: it ends there, as it does once there
# are fewer. Without that it takes twice the time, for nothing.
HOPELESS = 2
LEAST_SAVED = 0.2  # part of the cost that must be saved where numbers stay the same


class Clearing(NamedTuple):
    """How triangles are cleared of obtuse angles."""

    wants: Wants
    max_points: int  # rows of the vertex arrays that may be used
    spare: int  # vertices that may vanish
    steps: int  # rounds of easing after a first change


# What changed ---------------------------------------------------------------------------------


@kernel
def point_before(mesh: SimplexMesh, vertex: int, scratch: Scratch) -> Vec:
    """Where a vertex was when the journal was opened."""
    journal = scratch.journal
    if journal.vertex_mark[vertex] == journal.state[J_STAMP]:
        for i in range(journal.state[J_VERTICES]):
            if journal.vertices[i, 0] == vertex:
                return at(journal.points, i)
    return at(mesh.points, vertex)


@kernel
def lack_before(mesh: SimplexMesh, wants: Wants, scratch: Scratch) -> tuple[Lack, float]:
    """What the cells lacked that changed since the journal was opened, and their least angle."""
    journal = scratch.journal
    lack = NONE
    least = math.inf
    for i in range(journal.state[J_CELLS]):
        if journal.cells[i, J_ALIVE] == 1 and changed(mesh, scratch, i):
            a = point_before(mesh, journal.cells[i, J_CORNERS], scratch)
            b = point_before(mesh, journal.cells[i, J_CORNERS + 1], scratch)
            c = point_before(mesh, journal.cells[i, J_CORNERS + 2], scratch)
            angles = extremes(a, b, c)
            lack = added(lack, angles, wants)
            least = min(least, angles.least)
    return lack, least


@kernel
def lack_after(mesh: SimplexMesh, wants: Wants, scratch: Scratch) -> tuple[Lack, float, float]:
    """What the cells lack now that changed, the sine of their least angle, and their worst q."""
    journal = scratch.journal
    lack = NONE
    least = math.inf
    worst = math.inf
    for i in range(journal.state[J_CELLS]):
        cell = journal.cells[i, J_ROW]
        if mesh.alive[cell] and changed(mesh, scratch, i):
            c = mesh.cells
            angles = extremes_of(mesh, c[cell, 0], c[cell, 1], c[cell, 2])
            lack = added(lack, angles, wants)
            least = min(least, angles.least)
            worst = min(worst, mesh.quality[cell])
    return lack, least, worst


@kernel
def pays(mesh: SimplexMesh, how: Clearing, scratch: Scratch) -> bool:
    """Close the journal if what was done since it was opened is a gain, else undo it."""
    after, least, worst = lack_after(mesh, how.wants, scratch)
    before, least_before = lack_before(mesh, how.wants, scratch)
    is_gain = (
        after.n_obtuse + after.n_sharp < before.n_obtuse + before.n_sharp
        or after.cost < (1.0 - LEAST_SAVED) * before.cost
    )
    if (
        is_gain
        and after.n_obtuse <= before.n_obtuse
        and after.n_sharp <= before.n_sharp
        and least >= min(how.wants.least, least_before)
        and worst >= how.wants.q
    ):
        close_journal(scratch)
        return True
    roll_back(mesh, scratch)
    return False


# The ways -------------------------------------------------------------------------------------


@kernel
def flip_edge(mesh: SimplexMesh, cell: int, local: int, scratch: Scratch) -> bool:
    """Flip an edge of a triangle; whether it could be."""
    plan = simulate_flip(mesh, 4 * cell + local, VALID, 0.0)
    if plan.verdict == APPLIED:
        apply_flip(mesh, plan, scratch)
    return plan.verdict == APPLIED


@kernel
def split_vertex(
    mesh: SimplexMesh, cell: int, local: int, behind: int, n: int, scratch: Scratch
) -> bool:
    """Give n triangles in a row around a vertex to a new one beside it; whether it could be.

    Parameters
    ----------
    local : int
        The vertex, in the first of these triangles.
    behind : int
        The vertex there where the row begins: it gets an edge, as does the one where it ends.
    """
    cavity = scratch.cavity
    vertex = mesh.cells[cell, local]
    here = cell
    x = 0.0
    y = 0.0
    for i in range(n):
        cavity[i] = here
        start = mesh.cells[here, behind]
        end = mesh.cells[here, 3 - local - behind]
        x += 0.5 * (mesh.points[start, 0] + mesh.points[end, 0]) / n
        y += 0.5 * (mesh.points[start, 1] + mesh.points[end, 1]) / n
        if i < n - 1:
            beyond = mesh.neighbours[here, behind]
            if beyond < 0 or beyond >> 2 == cell:
                return False
            here = beyond >> 2
            local = local_index(mesh.cells, here, vertex)
            behind = local_index(mesh.cells, here, end)
    p = at(mesh.points, vertex)
    position = rounded(mesh, Vec(0.5 * (p.x + x), 0.5 * (p.y + y), p.z))
    n_facets = enclose(mesh, n, scratch)
    worst = math.inf
    for i in range(n_facets):
        worst = min(worst, q_with(mesh, scratch.ball[i], position))
    if worst <= FLAT or not is_legal_cavity(mesh, n, n_facets, scratch):
        return False
    apply_insertion(mesh, Insertion(APPLIED, n, n_facets, position, worst), scratch)
    return True


@kernel
def collapse_edge(mesh: SimplexMesh, vertex: int, onto: int, scratch: Scratch) -> bool:
    """Put a vertex on another one; whether it could be."""
    how = Collapsing(VALID, 0.0, math.inf, False)
    plan = simulate_collapse(mesh, vertex, onto, how, scratch)
    if plan.verdict == APPLIED:
        apply_collapse(mesh, plan, scratch)
    return plan.verdict == APPLIED


@kernel
def insert_vertex(mesh: SimplexMesh, cell: int, which: int, scratch: Scratch) -> bool:
    """Star a cavity around a triangle from a new vertex; whether it could be."""
    start = rounded(mesh, starting_point(mesh, cell, which))
    n_cells, n_facets, worst, _ = grow_cavity(mesh, cell, start, scratch)
    if (
        worst <= FLAT
        or n_facets > MAX_CREATED
        or not is_legal_cavity(mesh, n_cells, n_facets, scratch)
    ):
        return False
    apply_insertion(mesh, Insertion(APPLIED, n_cells, n_facets, start, worst), scratch)
    return True


@kernel
def begin(
    mesh: SimplexMesh, cell: int, way: int, how: Clearing, n_gone: int, scratch: Scratch
) -> bool:
    """Carry out the first change of one of the ways at a triangle; whether it could be."""
    if way < COLLAPSES:
        return flip_edge(mesh, cell, way, scratch)
    if way < SPLITS:
        if n_gone >= how.spare:
            return False
        edge = (way - COLLAPSES) >> 1
        end = (way - COLLAPSES) & 1
        vertex = mesh.cells[cell, TRI_EDGES[edge, end]]
        return collapse_edge(mesh, vertex, mesh.cells[cell, TRI_EDGES[edge, 1 - end]], scratch)
    if mesh.state[N_POINTS] >= how.max_points:
        return False
    if way >= INSERTIONS:
        return insert_vertex(mesh, cell, way - INSERTIONS, scratch)
    way -= SPLITS
    local = way // (2 * len(FANS))
    behind = (local + 1 + way % 2) % 3
    return split_vertex(mesh, cell, local, behind, FANS[way // 2 % len(FANS)], scratch)


@kernel
def ease_around(mesh: SimplexMesh, how: Clearing, scratch: Scratch) -> None:
    """Ease what changed since the journal was opened, until that is a gain, or hopeless."""
    journal = scratch.journal
    last = math.inf
    for _ in range(how.steps):
        for i in range(journal.state[J_CELLS]):
            if journal.state[J_CELLS] > MOST_CHANGED or not has_pages(scratch):
                return
            cell = journal.cells[i, J_ROW]
            if mesh.alive[cell] and lack_of_cell(mesh, cell, how.wants).cost > 0.0:
                ease(mesh, cell, how.wants, scratch)
        lack, _, _ = lack_after(mesh, how.wants, scratch)
        before, _ = lack_before(mesh, how.wants, scratch)
        more = lack.n_obtuse + lack.n_sharp - before.n_obtuse - before.n_sharp
        left = COUNTS * (lack.n_obtuse + lack.n_sharp) + lack.cost
        if more > HOPELESS or more < 0 or left > (1.0 - LEAST_PROGRESS) * last:
            return
        last = left


@kernel
def clear_at(mesh: SimplexMesh, cell: int, how: Clearing, n_gone: int, scratch: Scratch) -> int:
    """Try the ways at a triangle until one pays; returns that one, or -1."""
    for way in range(N_WAYS):
        open_journal(mesh, scratch)
        if not begin(mesh, cell, way, how, n_gone, scratch):
            close_journal(scratch)
            continue
        ease_around(mesh, how, scratch)
        if pays(mesh, how, scratch):
            return way
    return -1


@kernel
def clear(mesh: SimplexMesh, cell: int, how: Clearing, n_gone: int, scratch: Scratch) -> int:
    """Try the ways at a triangle, and at its neighbours, until one pays; that one, or -1.

    Without the neighbours half more is left where the boundary is poor.

    Parameters
    ----------
    n_gone : int
        Vertices that have vanished, of those that may.
    """
    way = clear_at(mesh, cell, how, n_gone, scratch)
    for local in range(3):
        if way >= 0:
            break
        beyond = mesh.neighbours[cell, local]
        if beyond >= 0:
            way = clear_at(mesh, beyond >> 2, how, n_gone, scratch)
    return way


@entry(
    group="nonobtuse",
    example=lambda work: (
        work.mesh, work.order, Clearing(Wants(0.0, 0.0, 0.0), 0, 0, 0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_clear(
    mesh: SimplexMesh, order: np.ndarray, how: Clearing, scratch: Scratch, counts: np.ndarray
) -> int:
    """Clear each triangle in turn that is obtuse or sharp; see `swap.sweep_swap`."""
    n_gone = 0
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        lack = lack_of_cell(mesh, cell, how.wants)
        if lack.n_obtuse + lack.n_sharp == 0:
            continue
        if not has_room(mesh, MAX_CREATED):
            return i
        way = clear(mesh, cell, how, n_gone, scratch)
        n_gone += 1 if COLLAPSES <= way < SPLITS else 0
        counts[APPLIED if way >= 0 else NOT_BETTER] += 1
    return order.shape[0]
