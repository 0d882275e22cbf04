"""Splitting of over-constrained entities (Definitions 18.8, 18.9).

A cell, an internal edge or an internal face that has all its vertices on the boundary leaves a
solver no unknown inside, and the optimizer no vertex to move. A new vertex in it is the remedy.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_EDGES, TRI_FACETS
from ...compiled.decorators import entry, kernel
from ..cavity import has_room
from ..gather.shell import is_required, next_around
from ..guide import FREE
from ..types import (
    APPLIED,
    FIXED,
    FULL,
    INVALID,
    MAX_CREATED,
    MAX_SHELL,
    N_POINTS,
    NOT_BETTER,
    TOO_LARGE,
    Scratch,
    SimplexMesh,
)
from ..vectors import ZERO, Vec, at, rounded
from .climb import climb
from .insert import Insertion, apply_insertion, enclose

NOTHING = -1  # no constrained entity there


class Place(NamedTuple):
    """Where a new vertex may start, with the cells that go in `scratch.cavity`."""

    verdict: int  # APPLIED where it may
    n_cells: int
    position: Vec


NOWHERE = Place(NOTHING, 0, ZERO)


@kernel
def around_edge(mesh: SimplexMesh, cell: int, edge: int, scratch: Scratch) -> int:
    """Put the tets around an internal edge into the cavity; returns how many, 0 on the boundary."""
    first = cell
    c = mesh.cells[cell, TET_EDGES[edge, 2]]
    d = mesh.cells[cell, TET_EDGES[edge, 3]]
    n = 0
    while n < MAX_SHELL:
        scratch.cavity[n] = cell
        n += 1
        cell, c, d = next_around(mesh, cell, c, d)
        if cell < 0:
            return 0
        if cell == first:
            return n
    return MAX_SHELL + 1


@kernel
def all_on(mesh: SimplexMesh, on_boundary: np.ndarray, cell: int, omitted: int, other: int) -> bool:
    """Whether all vertices of a cell but two are on the boundary; -1 omits none."""
    for k in range(mesh.cells.shape[1]):
        if k not in (omitted, other) and not on_boundary[mesh.cells[cell, k]]:
            return False
    return True


@kernel
def middle(mesh: SimplexMesh, cell: int, omitted: int, other: int) -> Vec:
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
def around_constrained_edge(
    mesh: SimplexMesh, cell: int, edge: int, on_boundary: np.ndarray, scratch: Scratch
) -> Place:
    """A new vertex in an internal edge of a tet: its shell goes."""
    c = TET_EDGES[edge, 2]
    d = TET_EDGES[edge, 3]
    if not all_on(mesh, on_boundary, cell, c, d):
        return NOWHERE
    n = around_edge(mesh, cell, edge, scratch)
    if n == 0:
        return NOWHERE
    if n > MAX_SHELL:
        return Place(TOO_LARGE, 0, ZERO)
    a = mesh.cells[cell, TET_EDGES[edge, 0]]
    b = mesh.cells[cell, TET_EDGES[edge, 1]]
    if is_required(mesh, a, b):
        return Place(FIXED, 0, ZERO)
    return Place(APPLIED, n, middle(mesh, cell, c, d))


@kernel
def across_constrained_facet(
    mesh: SimplexMesh, cell: int, local: int, on_boundary: np.ndarray, scratch: Scratch
) -> Place:
    """A new vertex in an internal facet, an edge in the plane: both its cells go."""
    beyond = mesh.neighbours[cell, local]
    if beyond < 0 or not all_on(mesh, on_boundary, cell, local, -1):
        return NOWHERE
    if mesh.cells.shape[1] == 3 and is_required(
        mesh, mesh.cells[cell, TRI_FACETS[local, 0]], mesh.cells[cell, TRI_FACETS[local, 1]]
    ):
        return Place(FIXED, 0, ZERO)
    scratch.cavity[0] = cell
    scratch.cavity[1] = beyond >> 2
    return Place(APPLIED, 2, middle(mesh, cell, local, -1))


@kernel
def inside_constrained_cell(
    mesh: SimplexMesh, cell: int, on_boundary: np.ndarray, scratch: Scratch
) -> Place:
    """A new vertex inside a cell."""
    if not all_on(mesh, on_boundary, cell, -1, -1):
        return NOWHERE
    scratch.cavity[0] = cell
    return Place(APPLIED, 1, middle(mesh, cell, -1, -1))


@kernel
def place_in_entity(
    mesh: SimplexMesh, cell: int, entity: int, on_boundary: np.ndarray, scratch: Scratch
) -> Place:
    """Where a new vertex may start in an entity of a cell; see `simulate_constrained_split`."""
    width = mesh.cells.shape[1]
    n_edges = 6 if width == 4 else 0
    if entity < n_edges:
        return around_constrained_edge(mesh, cell, entity, on_boundary, scratch)
    if entity < n_edges + width:
        return across_constrained_facet(mesh, cell, entity - n_edges, on_boundary, scratch)
    return inside_constrained_cell(mesh, cell, on_boundary, scratch)


@kernel
def simulate_constrained_split(
    mesh: SimplexMesh,
    cell: int,
    entity: int,
    on_boundary: np.ndarray,
    keep: float,
    least: float,
    scratch: Scratch,
) -> Insertion:
    """Simulate a new vertex in one entity of a cell, if its vertices are all on the boundary.

    Parameters
    ----------
    entity : int
        The edges of a tet come first, then facets, then the cell.
    on_boundary : (np,) bool
    keep : float
        Least part of the worst q of the cells that their replacements must have.
    least : float
        And the q that none of these may be below, unless one of the cells was.

    Returns
    -------
    plan : insert.Insertion
        Its verdict is NOTHING where there is no such entity.
    """
    verdict, n, start = place_in_entity(mesh, cell, entity, on_boundary, scratch)
    if verdict != APPLIED:
        return Insertion(verdict, 0, 0, start, 0.0)
    before = math.inf
    for i in range(n):
        before = min(before, mesh.quality[scratch.cavity[i]])
    n_facets = enclose(mesh, n, scratch)
    p, worst = climb(mesh, scratch.ball, n_facets, rounded(mesh, start), FREE, scratch)
    if worst <= 0.0:
        return Insertion(INVALID, n, n_facets, p, worst)
    if worst < max(keep * before, min(before, least)):
        return Insertion(NOT_BETTER, n, n_facets, p, worst)
    if not has_room(mesh, n_facets):
        return Insertion(FULL, n, n_facets, p, worst)
    return Insertion(APPLIED, n, n_facets, p, worst)


@entry(
    group="constrained",
    example=lambda work: (
        work.mesh, work.order, work.mesh.fixed, 0.0, 0.0, 0, work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_constrained(
    mesh: SimplexMesh,
    order: np.ndarray,
    on_boundary: np.ndarray,
    keep: float,
    least: float,
    max_points: int,
    scratch: Scratch,
    counts: np.ndarray,
) -> int:
    """Try to split the over-constrained entities of each cell, edges first; see `swap.sweep_swap`.

    Parameters
    ----------
    max_points : int
        Rows of the point arrays that may be used.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if not has_room(mesh, MAX_CREATED):
            return i
        for entity in range(11 if mesh.cells.shape[1] == 4 else 4):
            if not mesh.alive[cell] or mesh.state[N_POINTS] >= max_points:
                break
            plan = simulate_constrained_split(mesh, cell, entity, on_boundary, keep, least, scratch)
            if plan.verdict == NOTHING:
                continue
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                vertex = apply_insertion(mesh, plan, scratch)
                on_boundary[vertex] = False
                break
    return order.shape[0]
