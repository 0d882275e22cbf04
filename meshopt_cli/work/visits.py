"""What to visit: entities that are bad, and around which something changed."""

from __future__ import annotations

import numpy as np

from ..constraints.model import noise_of, slacks
from ..kernels.gather.ball import vertex_quality
from ..kernels.types import N_CELLS, CellMesh, SimplexMesh
from ..mesh.adjacency import distinct

Array = np.ndarray


def living_cells(mesh: SimplexMesh) -> Array:
    """Rows of the living cells, ascending."""
    return np.flatnonzero(mesh.alive[: mesh.state[N_CELLS]])


def are_movable(mesh: SimplexMesh | CellMesh) -> Array:
    """Which vertices may move, (np,) bool: those that are not fixed, or only guided."""
    return ~mesh.fixed | (mesh.guide[:, 0] > 0) if len(mesh.guide) else ~mesh.fixed


def vertices_outside(mesh: SimplexMesh | CellMesh) -> Array:
    """Vertices out of half-spaces that they are to stay in, by more than rounding, ascending."""
    if not len(mesh.limits):
        return np.empty(0, np.int64)
    vertices, slack = slacks(mesh.points, mesh.guide, mesh.limits)
    return distinct(vertices[slack < -2.0 * noise_of(mesh.points, mesh.single)])


def changed_vertices(mesh: SimplexMesh, since: int, least: float) -> tuple[Array, Array]:
    """Vertices free to move whose ball changed after sweep `since` and has less q than `least`.

    Returns
    -------
    vertices : (n,) int64
    worst : (n,) float64
        Worst q of the ball of each.
    """
    worst = np.empty(len(mesh.points))
    vertex_quality(mesh, worst)
    free = are_movable(mesh)
    wanted = (mesh.vertex_clock > since) & free & (worst < least)
    vertices = np.flatnonzero(wanted)
    return vertices, worst[vertices]


def changed_cells(mesh: SimplexMesh, since: int, least: float) -> tuple[Array, Array]:
    """Cells with less q than `least` and an edge around which anything changed after `since`.

    Returns
    -------
    cells : (n,) int64
    quality : (n,) float64
    """
    n = int(mesh.state[N_CELLS])
    rows = np.flatnonzero(mesh.alive[:n] & (mesh.quality[:n] < least))
    rows = cells_changed_since(mesh, rows, since)
    return rows, mesh.quality[rows]


def cells_changed_since(mesh: SimplexMesh, cells: Array, since: int | Array) -> Array:
    """Those of some cells with an edge around which anything changed after a clock.

    Parameters
    ----------
    since : int or (np,) int64
        The clock, or one for each vertex.
    """
    changed = mesh.vertex_clock > since
    if changed.all():
        return cells
    return cells[np.count_nonzero(changed[mesh.cells[cells]], axis=1) >= 2]


def rings_around(mesh: SimplexMesh, cells: Array, n_rings: int) -> Array:
    """Cells at most so many rings away from some cells: the first share a vertex with them."""
    for _ in range(n_rings):
        cells = cells_at(mesh, mesh.cells[cells].ravel())
    return cells


def cells_at(mesh: SimplexMesh, vertices: Array) -> Array:
    """Living cells with one of some vertices, ascending."""
    near = np.zeros(len(mesh.points), dtype=bool)
    near[vertices] = True
    living = living_cells(mesh)
    return living[near[mesh.cells[living]].any(axis=1)]


def chunks(order: Array, size: int = 20_000) -> list[Array]:
    """The order in pieces, between which progress is shown and interrupts act."""
    return [order[start : start + size] for start in range(0, len(order), size)]
