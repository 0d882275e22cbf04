"""The one door to the quality of a cell: operators ask here, and know no formula.

A cell is given by the numbers of its vertices, by a handle and a new place of its vertex, or by
the edges at one of its vertices. So whatever else a quality may depend on, as a metric at the
vertices or a reference shape, enters here and nowhere else.
"""

from __future__ import annotations

import numpy as np

from ..cells import TET_FACETS, TRI_FACETS
from ..compiled.decorators import inlined, kernel
from .shape.simplex import tet_quality, tri_quality
from .types import Judge, SimplexMesh
from .vectors import ZERO, Vec, at


@inlined
def q_of_tet(mesh: SimplexMesh, a: int, b: int, c: int, d: int) -> float:
    """q of a tetrahedron between vertices of the mesh."""
    p = mesh.points
    return tet_quality(mesh.judge, at(p, a), at(p, b), at(p, c), at(p, d))


@inlined
def q_of_triangle(mesh: SimplexMesh, a: int, b: int, c: int) -> float:
    """q of a triangle between vertices of the mesh."""
    return tri_quality(mesh.judge, at(mesh.points, a), at(mesh.points, b), at(mesh.points, c))


@inlined
def q_of_row(mesh: SimplexMesh, rows: np.ndarray, i: int) -> float:
    """q of the cell whose vertices are row i of an array."""
    if mesh.cells.shape[1] == 4:
        return q_of_tet(mesh, rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])
    return q_of_triangle(mesh, rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def q_with(mesh: SimplexMesh, handle: int, p: Vec) -> float:
    """q of a cell with its vertex `handle & 3` put at p."""
    cell = handle >> 2
    local = handle & 3
    if mesh.cells.shape[1] == 4:
        return tet_quality(
            mesh.judge,
            at(mesh.points, mesh.cells[cell, TET_FACETS[local, 0]]),
            at(mesh.points, mesh.cells[cell, TET_FACETS[local, 1]]),
            at(mesh.points, mesh.cells[cell, TET_FACETS[local, 2]]),
            p,
        )
    return tri_quality(
        mesh.judge,
        at(mesh.points, mesh.cells[cell, TRI_FACETS[local, 0]]),
        at(mesh.points, mesh.cells[cell, TRI_FACETS[local, 1]]),
        p,
    )


@kernel
def q_of_edges(judge: Judge, width: int, e1: Vec, e2: Vec, e3: Vec) -> float:
    """q of a cell from the edges that lead from one of its vertices to the others.

    Parameters
    ----------
    width : int
        Vertices of the cell: 4, or 3 for a triangle, which has no `e3`.
    e1, e2, e3 : Vec
        Such that the cell (e1, e2, e3, 0) is positive where the cell is.
    """
    if width == 4:
        return tet_quality(judge, e1, e2, e3, ZERO)
    return tri_quality(judge, e1, e2, ZERO)
