"""The one door to the quality of a cell: operators ask here, and know no formula.

A cell is given by the numbers of its vertices, by a handle and a new place of its vertex, or by
the edges at one of its vertices. So whatever else a quality may depend on, as a metric at the
vertices or a reference shape, enters here and nowhere else.
"""

from __future__ import annotations

import numpy as np

from ..cells import TET_FACETS, TRI_FACETS
from ..compiled.decorators import entry, inlined, kernel
from .metric import NO_TENSOR, Upper, map_of_row, mapped, plus, root
from .shape.simplex import tet_quality, tri_quality
from .types import MAPPED, Judge, SimplexMesh
from .vectors import ZERO, Vec, at, minus


@inlined
def q_of_tet(mesh: SimplexMesh, a: int, b: int, c: int, d: int) -> float:
    """q of a tetrahedron between vertices of the mesh."""
    p = mesh.points
    if mesh.judge.form == MAPPED:
        return tet_in_metric(mesh.judge, p, a, b, c, d)
    return tet_quality(mesh.judge, at(p, a), at(p, b), at(p, c), at(p, d))


@inlined
def q_of_triangle(mesh: SimplexMesh, a: int, b: int, c: int) -> float:
    """q of a triangle between vertices of the mesh."""
    if mesh.judge.form == MAPPED:
        return tri_in_metric(mesh.judge, mesh.points, a, b, c)
    return tri_quality(mesh.judge, at(mesh.points, a), at(mesh.points, b), at(mesh.points, c))


@inlined
def q_of_row(mesh: SimplexMesh, rows: np.ndarray, i: int) -> float:
    """q of the cell whose vertices are row i of an array."""
    if mesh.cells.shape[1] == 4:
        return q_of_tet(mesh, rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3])
    return q_of_triangle(mesh, rows[i, 0], rows[i, 1], rows[i, 2])


@inlined
def q_with(mesh: SimplexMesh, handle: int, p: Vec) -> float:
    """q of a cell with its vertex `handle & 3` put at p, where it has the metric that it had."""
    cell = handle >> 2
    local = handle & 3
    if mesh.judge.form == MAPPED:
        return moved_in_metric(mesh, cell, local, p)
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


@kernel
def q_mapped(judge: Judge, width: int, t: Upper, e1: Vec, e2: Vec, e3: Vec) -> float:
    """q of a cell in a metric, whose map takes it to the usual space; see `q_of_edges`."""
    return q_of_edges(judge, width, mapped(t, e1), mapped(t, e2), mapped(t, e3))


@kernel
def tet_in_metric(judge: Judge, points: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """q of a tetrahedron, each of whose vertices has a metric."""
    m = plus(plus(NO_TENSOR, points, a, 0.25), points, b, 0.25)
    t = root(plus(plus(m, points, c, 0.25), points, d, 0.25))
    p = at(points, d)
    return q_mapped(
        judge, 4, t, minus(at(points, a), p), minus(at(points, b), p), minus(at(points, c), p)
    )


@kernel
def tri_in_metric(judge: Judge, points: np.ndarray, a: int, b: int, c: int) -> float:
    """q of a triangle of the plane, each of whose vertices has a metric."""
    third = 1.0 / 3.0
    t = root(plus(plus(plus(NO_TENSOR, points, a, third), points, b, third), points, c, third))
    p = at(points, c)
    return q_mapped(judge, 3, t, minus(at(points, a), p), minus(at(points, b), p), ZERO)


@kernel
def moved_in_metric(mesh: SimplexMesh, cell: int, local: int, p: Vec) -> float:
    """q of a cell in the metric of its vertices with one of these put at p."""
    t = map_of_row(mesh.points, mesh.cells, cell)
    if mesh.cells.shape[1] == 4:
        return q_mapped(
            mesh.judge, 4, t,
            minus(at(mesh.points, mesh.cells[cell, TET_FACETS[local, 0]]), p),
            minus(at(mesh.points, mesh.cells[cell, TET_FACETS[local, 1]]), p),
            minus(at(mesh.points, mesh.cells[cell, TET_FACETS[local, 2]]), p),
        )  # fmt: skip
    return q_mapped(
        mesh.judge, 3, t,
        minus(at(mesh.points, mesh.cells[cell, TRI_FACETS[local, 0]]), p),
        minus(at(mesh.points, mesh.cells[cell, TRI_FACETS[local, 1]]), p),
        ZERO,
    )  # fmt: skip


@entry(
    group="basic",
    example=lambda work: (work.mesh.judge, work.mesh.points, work.mesh.cells, work.mesh.quality),
)
def measure_cells(judge: Judge, points: np.ndarray, cells: np.ndarray, out: np.ndarray) -> None:
    """q of each cell of an (n, 3) or (n, 4) array, written to `out`.

    Parameters
    ----------
    points : (np, 3) or (np, 9) float64
        As `SimplexMesh.points` are.
    """
    for i in range(cells.shape[0]):
        a = cells[i, 0]
        b = cells[i, 1]
        c = cells[i, 2]
        if cells.shape[1] == 4:
            d = cells[i, 3]
            if judge.form == MAPPED:
                out[i] = tet_in_metric(judge, points, a, b, c, d)
            else:
                out[i] = tet_quality(
                    judge, at(points, a), at(points, b), at(points, c), at(points, d)
                )
        elif judge.form == MAPPED:
            out[i] = tri_in_metric(judge, points, a, b, c)
        else:
            out[i] = tri_quality(judge, at(points, a), at(points, b), at(points, c))
