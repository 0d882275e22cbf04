"""Splitting of over-constrained entities (Definitions 18.8, 18.9).

A cell, an internal edge or an internal face that has all its vertices on the boundary leaves a
solver no unknown inside, and the optimizer no vertex to move. A new vertex in it is the remedy.
"""

from __future__ import annotations

import math

from ...cells import TET_EDGES, TET_FACETS, TRI_FACETS
from ...compiled.decorators import entry, kernel
from ..cavity import has_room
from ..gather.shell import is_required
from ..types import APPLIED, FIXED, FULL, INVALID, MAX_SHELL, N_POINTS, NOT_BETTER, TOO_LARGE
from ..vectors import FREE, Vec, at
from .insert import Insertion, apply_insertion, enclose
from .relocate import climb, rounded

NOTHING = -1  # no constrained entity there


@kernel
def around_edge(mesh, cell, edge, scratch):
    """Put the tets around an internal edge into the cavity; returns how many, 0 on the boundary."""
    first = cell
    c = mesh.cells[cell, TET_EDGES[edge, 2]]
    d = mesh.cells[cell, TET_EDGES[edge, 3]]
    n = 0
    while n < MAX_SHELL:
        scratch.cavity[n] = cell
        n += 1
        local = 0
        for k in range(4):
            if mesh.cells[cell, k] == c:
                local = k
        beyond = mesh.neighbours[cell, local]
        if beyond < 0:
            return 0
        cell = beyond >> 2
        if cell == first:
            return n
        c = d
        d = mesh.cells[cell, beyond & 3]
    return MAX_SHELL + 1


@kernel
def across_facet(mesh, cell, local, scratch):
    """Put the two cells at a facet into the cavity; returns how many, 0 on the boundary."""
    beyond = mesh.neighbours[cell, local]
    scratch.cavity[0] = cell
    scratch.cavity[1] = beyond >> 2
    return 2 if beyond >= 0 else 0


@kernel
def all_on(mesh, on_boundary, cell, omitted, other):
    """Whether all vertices of a cell but two are on the boundary; -1 omits none."""
    for k in range(mesh.cells.shape[1]):
        if k not in (omitted, other) and not on_boundary[mesh.cells[cell, k]]:
            return False
    return True


@kernel
def middle(mesh, cell, omitted, other):
    """Barycentre of the vertices of a cell but two."""
    x = 0.0
    y = 0.0
    z = 0.0
    n = 0
    for k in range(mesh.cells.shape[1]):
        if k not in (omitted, other):
            p = at(mesh.points, mesh.cells[cell, k])
            x += p.x
            y += p.y
            z += p.z
            n += 1
    return Vec(x / n, y / n, z / n)


@kernel
def simulate_constrained_split(mesh, cell, entity, on_boundary, keep, scratch):
    """Simulate a new vertex in one entity of a cell, if its vertices are all on the boundary.

    Parameters
    ----------
    entity : int
        In space an edge 0..5, a face 6..9, or the cell 10; in the plane an edge 6..8, or 10.
    on_boundary : (np,) bool
    keep : float
        Least part of the worst q of the cells that their replacements must have.

    Returns
    -------
    plan : insert.Insertion
        Its verdict is NOTHING where there is no such entity.
    """
    table = TET_FACETS if mesh.cells.shape[1] == 4 else TRI_FACETS
    omitted = -1
    other = -1
    n = 1
    scratch.cavity[0] = cell
    if entity < 6:
        omitted = TET_EDGES[entity, 2]
        other = TET_EDGES[entity, 3]
        a = mesh.cells[cell, TET_EDGES[entity, 0]]
        b = mesh.cells[cell, TET_EDGES[entity, 1]]
    elif entity < 10:
        omitted = entity - 6
        a = mesh.cells[cell, table[omitted, 0]]
        b = mesh.cells[cell, table[omitted, 1]]
    nowhere = at(mesh.points, mesh.cells[cell, 0])
    if not all_on(mesh, on_boundary, cell, omitted, other):
        return Insertion(NOTHING, 0, 0, nowhere, 0.0)
    if entity < 6:
        n = around_edge(mesh, cell, entity, scratch)
    elif entity < 10:
        n = across_facet(mesh, cell, omitted, scratch)
    if n == 0:
        return Insertion(NOTHING, 0, 0, nowhere, 0.0)
    if n > MAX_SHELL:
        return Insertion(TOO_LARGE, 0, 0, nowhere, 0.0)
    if (entity < 6 or (mesh.cells.shape[1] == 3 and entity < 10)) and is_required(mesh, a, b):
        return Insertion(FIXED, 0, 0, nowhere, 0.0)
    before = math.inf
    for i in range(n):
        before = min(before, mesh.quality[scratch.cavity[i]])
    n_facets = enclose(mesh, n, scratch)
    p = rounded(mesh, middle(mesh, cell, omitted, other))
    p, worst = climb(mesh, scratch.ball, n_facets, p, FREE, scratch)
    if worst <= 0.0:
        return Insertion(INVALID, n, n_facets, p, worst)
    if worst < keep * before:
        return Insertion(NOT_BETTER, n, n_facets, p, worst)
    if not has_room(mesh, n_facets):
        return Insertion(FULL, n, n_facets, p, worst)
    return Insertion(APPLIED, n, n_facets, p, worst)


@entry
def sweep_constrained(mesh, order, on_boundary, keep, max_points, scratch, counts):
    """Try to split the over-constrained entities of each cell in turn, edges first.

    Parameters
    ----------
    max_points : int
        Rows of the point arrays that may be used.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        for entity in range(0 if mesh.cells.shape[1] == 4 else 6, 11):
            if not mesh.alive[cell] or mesh.state[N_POINTS] >= max_points:
                break
            if entity - 6 == mesh.cells.shape[1]:
                continue  # a triangle has no fourth edge
            plan = simulate_constrained_split(mesh, cell, entity, on_boundary, keep, scratch)
            if plan.verdict == NOTHING:
                continue
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                vertex = apply_insertion(mesh, plan, scratch)
                on_boundary[vertex] = False
                break
