"""The arrays of the kernels: built from the cells of a mesh, and larger ones when they are full."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..boundary.patches import Patches
from ..constraints.model import Constraints
from ..handles import OUTER, PATCH
from ..kernels.judge import measure_cells
from ..kernels.types import (
    CLOCK,
    EDITION,
    J_ALIVE,
    MAX_BALL,
    MAX_CREATED,
    MAX_KEPT,
    MAX_SHELL,
    N_CELLS,
    N_FREE,
    N_POINTS,
    AnyMesh,
    Journal,
    Judge,
    Scratch,
    SimplexMesh,
)
from ..mesh import adjacency
from ..mesh.cast import Simplices
from .visits import living_cells

Array = np.ndarray

# Swaps of tets may raise the number of cells: this much room is made, and more when it is full.
# How much there is, is a matter of speed alone: sweeps go on where they ran out of it.
ROOM = 1.15
SPARE = 64


def capacity_for(n_cells: int) -> int:
    """Rows for so many cells and some more."""
    return int(ROOM * n_cells) + SPARE


def inverse(order: Array) -> Array:
    """Where each row went."""
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return number


def simplex_mesh(
    source: Simplices,
    judge: Judge,
    origin: Array,
    in_order: bool,
    patches: Patches | None,
    metric: Array | None = None,
    constraints: Constraints | None = None,
) -> SimplexMesh:
    """The cells of a mesh as the kernels see them.

    Parameters
    ----------
    origin : (np,) int64
        The point of the source that each row is.
    in_order : bool
        Whether the cells keep their rows, rather than stand by their first vertex.
    patches : Patches, optional
        What may move on the boundary; nothing without it.
    metric : (np, 6) float64, optional
        Of each point of the source: see `kernels.metric`.
    constraints : Constraints, optional
        What vertices were told.
    """
    number = inverse(origin)
    cells, beyond, region = _ordered_cells(source, number, in_order, patches)
    n_cells, n_points = len(cells), len(origin)
    capacity = capacity_for(n_cells)
    vertex_cell = _first_cells(cells, n_points)
    points = source.points[origin]
    if metric is not None:
        points = np.concatenate([points, metric[origin]], axis=1)
    quality = np.zeros(capacity)
    measure_cells(judge, points, cells, quality[:n_cells])
    fixed = _fixed(source, origin, number)
    fixed, guide, limits = guides(fixed, origin, patches, constraints)
    return SimplexMesh(
        points=points,
        cells=_extended(cells, capacity, 0),
        neighbours=_extended(beyond, capacity, OUTER),
        vertex_cell=vertex_cell,
        quality=quality,
        region=_extended(region, capacity, 0),
        alive=_extended(np.ones(n_cells, dtype=bool), capacity, False),
        fixed=fixed,
        guide=guide,
        limits=limits,
        required=_required(source, number, patches),
        vertex_clock=(vertex_cell >= 0).astype(np.int64),
        free=np.zeros(capacity, dtype=np.int64),
        state=np.array([n_cells, 0, 1, n_points, 0], dtype=np.int64),
        judge=judge,
        slides=patches is not None,
        single=source.single,
    )


def guides(
    fixed: Array, origin: Array, patches: Patches | None, constraints: Constraints | None
) -> tuple[Array, Array, Array]:
    """Which vertices stay, what those move along that do so all the same, and their half-spaces.

    Parameters
    ----------
    fixed : (np,) bool
        Vertices that stay whatever else they are told.
    """
    sliding = None if patches is None else patches.guide[origin]
    if constraints is not None:
        told = constraints.of_rows(origin)
        return fixed | told.told, told.guides(fixed, sliding), told.limits
    guide = np.zeros((0 if sliding is None else len(fixed), 6))
    if sliding is not None:
        guide[:, :4] = sliding
    return fixed, guide, np.zeros((0, 4))


def _ordered_cells(
    source: Simplices, number: Array, in_order: bool, patches: Patches | None
) -> tuple[Array, Array, Array]:
    """Cells, what lies beyond their facets, and their regions, in the order of the work."""
    cells = number[source.cells]
    order = np.argsort(np.zeros(len(cells)) if in_order else cells.min(axis=1), kind="stable")
    beyond = source.neighbours
    if patches is not None and patches.splits is not None:
        borders = np.where(patches.splits, PATCH - patches.patch, OUTER)
        beyond = beyond.copy()
        beyond[beyond == OUTER] = borders  # those of `source.outer`, which are in this order
    beyond = beyond[order]
    beyond = np.where(beyond < 0, beyond, 4 * inverse(order)[beyond >> 2] + (beyond & 3))
    return cells[order], beyond, source.region[order]


def _first_cells(cells: Array, n_points: int) -> Array:
    """The first cell of the ball of each point, -1 where no cell uses it."""
    n_cells, width = cells.shape
    first = np.full(n_points, -1, dtype=np.int64)
    # Written from the last cell to the first: the first cell of each ball stays.
    first[cells[::-1].ravel()] = np.repeat(np.arange(n_cells)[::-1], width)
    return first


def _fixed(source: Simplices, origin: Array, number: Array) -> Array:
    """Which vertices neither move nor vanish: those of the boundary, and the declared ones."""
    fixed = source.fixed[origin]
    fixed[number[source.skin]] = True
    fixed[number[source.edges]] = True
    return fixed


def _required(source: Simplices, number: Array, patches: Patches | None) -> Array:
    """Sorted keys of the edges that must stay."""
    edges = source.edges
    if patches is not None:
        whole = patches.whole
        edges = whole if whole is not None else np.concatenate([edges, patches.ridges])
    return adjacency.distinct(adjacency.row_keys(number[edges], len(number)))


def with_room_for_cells(mesh: SimplexMesh) -> SimplexMesh:
    """The mesh in larger arrays of the cells."""
    capacity = capacity_for(len(mesh.cells))
    per_cell = ("cells", "neighbours", "quality", "region", "alive", "free")
    larger: dict[str, Any] = {n: _extended(getattr(mesh, n), capacity, 0) for n in per_cell}
    return mesh._replace(**larger)


def with_rows_for_points(mesh: SimplexMesh, n_points: int) -> SimplexMesh:
    """The mesh in arrays of the vertices with so many rows, which are more than now."""
    old = len(mesh.points)
    fills = {"points": 0.0, "vertex_cell": -1, "fixed": True, "vertex_clock": 0}
    if len(mesh.guide):
        fills["guide"] = 0.0
    larger: dict[str, Any] = {
        name: _extended(getattr(mesh, name), n_points, fill) for name, fill in fills.items()
    }
    # The keys of required edges count in rows.
    keys = mesh.required // old * n_points + mesh.required % old
    return mesh._replace(**larger, required=keys)


def with_triangles(
    mesh: SimplexMesh, points: Array, cells: Array, region: Array, facets: Array, n_kept: int
) -> SimplexMesh:
    """A mesh of the plane in arrays of other triangles; see `Workspace.put`.

    Parameters
    ----------
    n_kept : int
        The first vertices, which are those of `mesh`: fixed where they were.
    """
    n_cells, n_points = len(cells), len(points)
    capacity = capacity_for(n_cells)
    beyond = adjacency.neighbours(cells, region, n_points, facets)
    fixed = np.zeros(n_points, dtype=bool)
    fixed[:n_kept] = mesh.fixed[:n_kept]
    fixed[adjacency.boundary_facets(cells, beyond)] = True
    guide = np.zeros((n_points if len(mesh.guide) else 0, 6))
    guide[:n_kept] = mesh.guide[:n_kept]
    quality = np.zeros(capacity)
    measure_cells(mesh.judge, points, cells, quality[:n_cells])
    state = mesh.state.copy()
    state[[N_CELLS, N_FREE, N_POINTS]] = n_cells, 0, n_points
    state[EDITION] += 1
    n_rows = len(mesh.points)  # rows never become fewer: visits are remembered by them
    mesh = mesh._replace(
        points=points,
        cells=_extended(cells, capacity, 0),
        neighbours=_extended(beyond, capacity, OUTER),
        vertex_cell=_first_cells(cells, n_points),
        quality=quality,
        region=_extended(region, capacity, 0),
        alive=_extended(np.ones(n_cells, dtype=bool), capacity, False),
        fixed=fixed,
        guide=guide,
        vertex_clock=np.full(n_points, state[CLOCK]),
        free=np.zeros(capacity, dtype=np.int64),
        state=state,
    )
    return with_rows_for_points(mesh, n_rows) if n_rows > n_points else mesh


def copied(mesh: SimplexMesh) -> SimplexMesh:
    """The mesh in arrays of its own."""
    arrays: dict[str, Any] = {
        name: value.copy()
        for name, value in mesh._asdict().items()
        if isinstance(value, np.ndarray)
    }
    return mesh._replace(**arrays)


def _extended(array: Array, capacity: int, fill: float) -> Array:
    result = np.full((capacity, *array.shape[1:]), fill, dtype=array.dtype)
    result[: len(array)] = array
    return result


def new_scratch(mesh: AnyMesh) -> Scratch:
    """Working space for a mesh with arrays of that size."""
    capacity, n_points = len(mesh.cells), len(mesh.points)
    return Scratch(
        ball=np.zeros(MAX_BALL, dtype=np.int64),
        other=np.zeros(MAX_BALL, dtype=np.int64),
        shell=np.zeros(MAX_SHELL, dtype=np.int64),
        ring=np.zeros(MAX_SHELL, dtype=np.int64),
        table=np.zeros((MAX_SHELL, MAX_SHELL)),
        split=np.zeros((MAX_SHELL, MAX_SHELL), dtype=np.int64),
        cavity=np.zeros(MAX_BALL, dtype=np.int64),
        created=np.zeros((MAX_CREATED, 4), dtype=np.int64),
        facets=np.zeros((4 * MAX_CREATED, 4), dtype=np.int64),
        values=np.zeros(MAX_BALL),
        gradients=np.zeros((MAX_BALL, 3)),
        # Rows a power of two apart would share a few lines of the cache.
        star=np.zeros((19, MAX_BALL + 8)),
        cell_mark=np.zeros(capacity, dtype=np.int64),
        vertex_mark=np.zeros(n_points, dtype=np.int64),
        stamp=np.zeros(1, dtype=np.int64),
        journal=Journal(
            cells=np.zeros((MAX_KEPT, J_ALIVE + 1), dtype=np.int64),
            quality=np.zeros(MAX_KEPT),
            vertices=np.zeros((4 * MAX_KEPT, 3), dtype=np.int64),
            points=np.zeros((4 * MAX_KEPT, 3)),
            cell_mark=np.zeros(capacity, dtype=np.int64),
            vertex_mark=np.zeros(n_points, dtype=np.int64),
            state=np.zeros(9, dtype=np.int64),
        ),
    )


def simplices_of(
    mesh: SimplexMesh, source: Simplices, numbers: Array, facets: Array, resamples: bool = False
) -> tuple[Simplices, Array]:
    """The mesh as it is now, without the vertices that vanished.

    Parameters
    ----------
    numbers : (np,) int64
        The point of the source that each row was.
    facets : (n, d) int64
        The declared facets, by rows.
    resamples : bool
        Whether edges of the boundary may have been split.

    Returns
    -------
    simplices : Simplices
    origin : (np',) int64
        The point of the source that each point was, -1 for a new one. Points that no cell used
        stay.
    """
    n_before = len(source.points)
    unused = np.ones(len(mesh.points), dtype=bool)
    unused[n_before:] = False
    unused[inverse(numbers)[source.cells]] = False
    rows = np.flatnonzero(unused | (mesh.vertex_cell >= 0))
    # The points of the input in their order, then the new ones.
    origin = np.full(len(rows), -1)
    origin[rows < n_before] = numbers[rows[rows < n_before]]
    order = np.argsort(np.where(origin < 0, n_before, origin), kind="stable")
    rows, origin = rows[order], origin[order]
    number = np.full(len(mesh.points), -1)
    number[rows] = np.arange(len(rows))
    # Cells in order of region, then of their first vertex: stable, and near in memory.
    living = living_cells(mesh)
    cells, region = number[np.take(mesh.cells, living, axis=0)], mesh.region[living]
    least = np.minimum.reduce([*cells.T])
    order = adjacency.ascending(region * len(rows) + least)
    cells, region = np.take(cells, order, axis=0), region[order]
    patch = None
    if resamples:
        beyond = mesh.neighbours[living][order]
        beyond = beyond[(beyond == OUTER) | (beyond <= PATCH)]
        patch = np.where(beyond <= PATCH, PATCH - beyond, -1)
    number_of = number[inverse(numbers)]
    worked = replace(
        source,
        points=mesh.points[rows, :3],
        cells=cells,
        region=region,
        fixed=source.fixed[origin] & (origin >= 0),
        facets=number[facets],
        edges=number_of[source.edges],
        patch=patch,
    )
    return worked, origin
