"""Edges of the boundary: the cells around them, and what they lie on."""

from __future__ import annotations

from ...cells import TET_EDGES, TET_FACETS
from ...compiled.decorators import inlined, kernel
from ...handles import OUTER, PATCH
from ..guide import LINE, PLANE
from ..types import MAX_SHELL, Scratch, SimplexMesh
from ..vectors import at, cross, minus, norm
from .ball import local_index
from .shell import next_around

INSIDE = 0  # in the place of a border, where cells are all around an edge


@inlined
def is_outer(beyond: int) -> bool:
    """Whether the mesh ends where this stands in the place of a neighbour."""
    return beyond == OUTER or beyond <= PATCH


@kernel
def around_any_edge(
    mesh: SimplexMesh, cell: int, edge: int, scratch: Scratch
) -> tuple[int, int, int]:
    """Put the cells around an edge into the cavity, where it is inside or may be split.

    Returns
    -------
    n : int
        How many: 0 where the edge is on a border that stays, MAX_SHELL + 1 where they are more
        than fit.
    one, other : int
        The borders on either side, INSIDE without.
    """
    if mesh.cells.shape[1] == 3:
        beyond = mesh.neighbours[cell, edge]
        scratch.cavity[0] = cell
        if beyond >= 0:
            scratch.cavity[1] = beyond >> 2
            return 2, INSIDE, INSIDE
        return (1 if beyond <= PATCH else 0), beyond, beyond
    first = cell
    c = mesh.cells[first, TET_EDGES[edge, 2]]
    d = mesh.cells[first, TET_EDGES[edge, 3]]
    back_c = d
    back_d = c
    n = 0
    one = INSIDE
    while n < MAX_SHELL:
        scratch.cavity[n] = cell
        n += 1
        cell, c, d = next_around(mesh, cell, c, d)
        if cell == first:
            return n, INSIDE, INSIDE
        if cell < 0:
            if cell > PATCH:
                return 0, cell, cell
            if one != INSIDE:
                return n, one, cell
            # Back to where it began, and the other way.
            one = cell
            cell, c, d = next_around(mesh, first, back_c, back_d)
            if cell < 0:
                return (n if cell <= PATCH else 0), one, cell
    return MAX_SHELL + 1, one, one


@kernel
def borders_at(
    mesh: SimplexMesh, vertex: int, onto: int, n: int, scratch: Scratch
) -> tuple[int, int]:
    """The borders on either side of an edge, INSIDE where it is not on the boundary.

    Parameters
    ----------
    n : int
        Cells of the ball of `vertex`, in `scratch.ball`.
    """
    one = INSIDE
    other = INSIDE
    for i in range(n):
        cell = scratch.ball[i] >> 2
        there = local_index(mesh.cells, cell, onto)
        if there < 0:
            continue
        for k in range(mesh.cells.shape[1]):
            beyond = mesh.neighbours[cell, k]
            if k not in (there, scratch.ball[i] & 3) and beyond < 0:
                if one == INSIDE:
                    one = beyond
                other = beyond
    return one, other


@kernel
def may_slide_onto(mesh: SimplexMesh, vertex: int, onto: int, n: int, scratch: Scratch) -> bool:
    """Whether a vertex of the boundary that may move comes to another within its plane or ridge.

    Parameters
    ----------
    n : int
        Cells of the ball of `vertex`, in `scratch.ball`.
    """
    one, other = borders_at(mesh, vertex, onto, n, scratch)
    if one > PATCH or other > PATCH:
        return False
    for i in range(n):  # a cell between them, flat but for the tolerance, would leave a gap
        cell = scratch.ball[i] >> 2
        there = local_index(mesh.cells, cell, onto)
        if there >= 0 and mesh.neighbours[cell, there] < 0:
            return False
    if mesh.cells.shape[1] == 3:
        return True
    return (one == other) == (mesh.guide[vertex, 0] == PLANE)


@kernel
def set_guide_between(
    mesh: SimplexMesh, vertex: int, a: int, b: int, one: int, other: int, n: int, scratch: Scratch
) -> None:
    """Say where a new vertex on an edge of the boundary may move: as that end which does so there.

    Parameters
    ----------
    n : int
        Cells around the edge, in `scratch.cavity`, one of which has a border `one`.
    """
    kind = LINE if mesh.cells.shape[1] == 3 or one != other else PLANE
    mesh.fixed[vertex] = True
    mesh.guide[vertex, 0] = kind
    end = a if mesh.guide[a, 0] == kind else b
    if mesh.guide[end, 0] == kind:
        for k in range(1, 4):
            mesh.guide[vertex, k] = mesh.guide[end, k]
        return
    p = at(mesh.points, a)
    v = minus(at(mesh.points, b), p)
    if kind == PLANE:
        third = third_of_facet(mesh, a, b, one, n, scratch)
        v = cross(v, minus(at(mesh.points, third), p))
    size = norm(v)
    mesh.guide[vertex, 1] = v.x / size
    mesh.guide[vertex, 2] = v.y / size
    mesh.guide[vertex, 3] = v.z / size


@kernel
def third_of_facet(mesh: SimplexMesh, a: int, b: int, border: int, n: int, scratch: Scratch) -> int:
    """The third vertex of a facet at an edge that has a border beyond; see `set_guide_between`."""
    for i in range(n):
        cell = scratch.cavity[i]
        for k in range(4):
            if mesh.neighbours[cell, k] == border and mesh.cells[cell, k] not in (a, b):
                for j in range(3):
                    v = mesh.cells[cell, TET_FACETS[k, j]]
                    if v not in (a, b):
                        return v
    return -1
