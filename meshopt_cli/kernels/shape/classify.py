"""The types of triangles (Exercise 18.5) and tetrahedra (18.6), by short edges and obtuse angles.

A triangle that is nearly flat has a short edge, or a large angle if it has none.

A bad tet is nearly flat. If it has no short edge, the number of its large dihedral angles tells
how its vertices lie near a plane; if it has, how many short edges there are, and where, tells how
they lie near a line.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from ...cells import TET_EDGES
from ...compiled.decorators import entry, kernel
from ..vectors import at, dot, norm, square_distance
from .angles import tet_normals

SHORT = 0.3  # an edge shorter than this part of the longest is short
LARGE = math.cos(math.radians(115.0))  # an angle with less than this cosine is large


class TetType(IntEnum):
    """Shapes of tetrahedra."""

    REGULAR = 0  # no short edge and no large angle: good, or nearly so
    SPADE = 1  # one large angle: a vertex lies near an edge
    SLIVER = 2  # two large angles, at opposite edges, which cross
    CAP = 3  # three large angles, around a face: a vertex lies near the middle of that face
    WEDGE = 4  # one short edge
    SPINDLE = 5  # two short edges, opposite each other
    SPEAR = 6  # two or more short edges that meet: three vertices lie near each other, or in a row
    NEEDLE = 7  # three short edges around a face, and the fourth vertex far away


class TriangleType(IntEnum):
    """Shapes of triangles."""

    REGULAR = 0  # no short edge and no large angle: good, or nearly so
    NEEDLE = 1  # a short edge: two vertices lie near each other
    CAP = 2  # a large angle: a vertex lies near the edge across


TYPES: dict[int, type[IntEnum]] = {2: TriangleType, 3: TetType}  # by dimension
THIN, BLUNT = int(TriangleType.NEEDLE), int(TriangleType.CAP)
REGULAR, SPADE, SLIVER, CAP, WEDGE, SPINDLE, SPEAR, NEEDLE = (int(t) for t in TetType)


@kernel
def count_short(points: np.ndarray, cell_vertices: np.ndarray) -> tuple[int, bool, bool]:
    """Number of short edges, whether two of them are opposite, and a face of three of them.

    Parameters
    ----------
    cell_vertices : (4,) int64

    Returns
    -------
    n : int
    opposite : bool
    face : bool
    """
    longest = 0.0
    for e in range(6):
        a = at(points, cell_vertices[TET_EDGES[e, 0]])
        b = at(points, cell_vertices[TET_EDGES[e, 1]])
        longest = max(longest, square_distance(a, b))
    limit = SHORT * SHORT * longest
    n = 0
    opposite = False
    for e in range(6):
        a = at(points, cell_vertices[TET_EDGES[e, 0]])
        b = at(points, cell_vertices[TET_EDGES[e, 1]])
        if square_distance(a, b) < limit:
            n += 1
            c = at(points, cell_vertices[TET_EDGES[e, 2]])
            d = at(points, cell_vertices[TET_EDGES[e, 3]])
            opposite = opposite or square_distance(c, d) < limit
    # Three short edges are a face when the vertex opposite is far from all the others.
    face = False
    for k in range(4):
        far = 0
        for j in range(4):
            if j != k:
                a = at(points, cell_vertices[k])
                far += square_distance(a, at(points, cell_vertices[j])) >= limit
        face = face or (n == 3 and far == 3)
    return n, opposite, face


@kernel
def count_large(points: np.ndarray, cell_vertices: np.ndarray) -> int:
    """Number of large dihedral angles."""
    n0, n1, n2, n3 = tet_normals(
        at(points, cell_vertices[0]),
        at(points, cell_vertices[1]),
        at(points, cell_vertices[2]),
        at(points, cell_vertices[3]),
    )
    normals = (n0, n1, n2, n3)
    n = 0
    for i in range(4):
        for j in range(i):
            # Inward normals: the angle is pi less than that between them.
            cosine = -dot(normals[i], normals[j])
            n += cosine < LARGE * norm(normals[i]) * norm(normals[j])
    return n


@kernel
def tet_type(points: np.ndarray, cell_vertices: np.ndarray) -> int:
    """The type of a tet, one of `TetType`."""
    n, opposite, face = count_short(points, cell_vertices)
    if n > 0:
        if face:
            return NEEDLE
        if n == 1:
            return WEDGE
        return SPINDLE if opposite and n == 2 else SPEAR
    large = count_large(points, cell_vertices)
    if large == 0:
        return REGULAR
    if large == 1:
        return SPADE
    return SLIVER if large == 2 else CAP


@kernel
def triangle_type(points: np.ndarray, cell_vertices: np.ndarray) -> int:
    """The type of a triangle, one of `TriangleType`."""
    a = at(points, cell_vertices[0])
    b = at(points, cell_vertices[1])
    c = at(points, cell_vertices[2])
    squares = (square_distance(b, c), square_distance(c, a), square_distance(a, b))
    shortest = min(squares)
    longest = max(squares)
    if shortest < SHORT * SHORT * longest:
        return THIN
    # The greatest angle is opposite the longest edge.
    others = squares[0] + squares[1] + squares[2] - longest
    product = squares[0] * squares[1] * squares[2] / longest if longest > 0.0 else 0.0
    return BLUNT if others - longest < 2.0 * LARGE * math.sqrt(product) else REGULAR


@kernel
def cell_type(points: np.ndarray, cell_vertices: np.ndarray) -> int:
    """The type of a tet, or of a triangle as its nearest kin: WEDGE by a short edge, else SPADE."""
    if cell_vertices.shape[0] == 4:
        return tet_type(points, cell_vertices)
    return WEDGE if triangle_type(points, cell_vertices) == THIN else SPADE


@entry(group="basic", example=lambda work: (work.mesh.points, work.mesh.cells, work.counts))
def classify_cells(points: np.ndarray, cells: np.ndarray, out: np.ndarray) -> None:
    """The type of each cell, a number of `TriangleType` or `TetType`, written to `out`.

    Parameters
    ----------
    cells : (n, 3) or (n, 4) int64
    out : (n,) int64
    """
    for i in range(cells.shape[0]):
        if cells.shape[1] == 4:
            out[i] = tet_type(points, cells[i])
        else:
            out[i] = triangle_type(points, cells[i])
