"""A mesh in the form the kernels work on, with its clock and its working space."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..boundary.patches import Patches
from ..handles import OUTER
from ..kernels.gather.ball import vertex_quality
from ..kernels.shape.simplex import measure_cells
from ..kernels.types import (
    CLOCK,
    J_ALIVE,
    MAX_BALL,
    MAX_CREATED,
    MAX_KEPT,
    MAX_SHELL,
    N_CELLS,
    N_FREE,
    N_POINTS,
    Journal,
    Judge,
    Scratch,
    SimplexMesh,
)
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.order import hilbert

Array = np.ndarray

# Swaps of tets may raise the number of cells: this much room is made, and more when it is full.
# How much there is, is a matter of speed alone: sweeps go on where they ran out of it.
ROOM = 1.15
SPARE = 64


@dataclass(frozen=True)
class Standing:
    """How good a mesh is: the worst q decides, then the mean Q.

    `tail` is the mean Q of the worst hundredth of the cells: it shows progress that neither
    the worst cell nor the mean of all does.
    """

    worst: float
    mean: float
    tail: float

    def is_better_than(self, other: Standing) -> bool:
        """Whether this is a real gain, rounding noise left aside."""
        if abs(self.worst - other.worst) > 1e-9:
            return self.worst > other.worst
        return self.mean < other.mean - 1e-9


class Workspace:
    """The working state of an optimization.

    Attributes
    ----------
    mesh : SimplexMesh
        Arrays of the kernels. They may be replaced by larger ones: ask for them anew.
    scratch : Scratch
    judge : Judge
        By what the mesh is judged; a stage may let another one steer.
    visits : dict
        When entities were visited last, by who visited them: clocks, whole or for each vertex.
        Its values are replaced and never written into, so that a copy may share them.

    Parameters
    ----------
    target : float
        Q of the best cell that the worst facet of the boundary allows; 1 when that is not known.
    patches : Patches, optional
        What may move on the boundary; nothing without it.
    in_order : bool
        Whether vertices and cells keep the rows they have in the source, rather than
        stand near each other in memory where they are near in space.
    """

    def __init__(
        self,
        source: Simplices,
        judge: Judge,
        target: float = 1.0,
        in_order: bool = False,
        patches: Patches | None = None,
    ) -> None:
        self._source = source
        self.judge = judge
        self.target = target
        n_points = len(source.points)
        n_cells, width = source.cells.shape
        capacity = int(ROOM * n_cells) + SPARE
        # Row i of the work is point `_origin[i]` of the source.
        self._origin = np.arange(n_points) if in_order else hilbert(source.points)
        number = _inverse(self._origin)
        cells = number[source.cells]
        cell_order = np.argsort(np.zeros(n_cells) if in_order else cells.min(axis=1), kind="stable")
        cells = cells[cell_order]
        beyond = source.neighbours[cell_order]
        beyond = np.where(beyond < 0, beyond, 4 * _inverse(cell_order)[beyond >> 2] + (beyond & 3))
        points = source.points[self._origin]
        fixed = source.fixed[self._origin]
        fixed[number[source.skin]] = True
        fixed[number[source.edges]] = True
        guide = np.zeros((n_points, 4)) if patches is None else patches.guide[self._origin]
        edges = source.edges if patches is None else np.concatenate([source.edges, patches.ridges])
        required = np.unique(adjacency.row_keys(number[edges], n_points))
        vertex_cell = np.full(n_points, -1, dtype=np.int64)
        # Written from the last cell to the first: the first cell of each ball stays.
        vertex_cell[cells[::-1].ravel()] = np.repeat(np.arange(n_cells)[::-1], width)
        quality = np.zeros(capacity)
        measure_cells(judge, points, cells, quality[:n_cells])
        self.mesh = SimplexMesh(
            points=points,
            cells=_extended(cells, capacity, 0),
            neighbours=_extended(beyond, capacity, OUTER),
            vertex_cell=vertex_cell,
            quality=quality,
            region=_extended(source.region[cell_order], capacity, 0),
            alive=_extended(np.ones(n_cells, dtype=bool), capacity, False),
            fixed=fixed,
            guide=guide,
            required=required,
            vertex_clock=(vertex_cell >= 0).astype(np.int64),
            free=np.zeros(capacity, dtype=np.int64),
            state=np.array([n_cells, 0, 1, n_points], dtype=np.int64),
            judge=judge,
            slides=patches is not None,
            single=source.single,
        )
        self.scratch = _new_scratch(capacity, n_points)
        self.visits: dict[Hashable, Any] = {}

    # What is there -------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        return self.mesh.cells.shape[1] - 1

    @property
    def n_cells(self) -> int:
        """Number of living cells."""
        return int(self.mesh.state[N_CELLS] - self.mesh.state[N_FREE])

    @property
    def n_input_points(self) -> int:
        """Number of points the mesh came with."""
        return len(self._source.points)

    @property
    def n_input_vertices(self) -> int:
        """Number of points that cells of the input used."""
        used = adjacency.is_used(self._source.cells, self.n_input_points)
        return int(np.count_nonzero(used))

    @property
    def n_vertices(self) -> int:
        """Number of points that cells use now."""
        return int(np.count_nonzero(self.mesh.vertex_cell >= 0))

    def living(self) -> Array:
        """Rows of the living cells, ascending."""
        return np.flatnonzero(self.mesh.alive[: self.mesh.state[N_CELLS]])

    def standing(self) -> Standing:
        """How good the mesh is by the measure that steers."""
        return _standing_of(self.mesh.quality[self.living()])

    def judged(self) -> Standing:
        """How good the mesh is by the measure that it is judged by."""
        if self.mesh.judge == self.judge:
            return self.standing()
        return _standing_of(self._measured(self.judge))

    def _measured(self, judge: Judge) -> Array:
        """q of the living cells as another judge sees it."""
        cells = self.mesh.cells[self.living()]
        quality = np.empty(len(cells))
        measure_cells(judge, self.mesh.points, cells, quality)
        return quality

    def judge_by(self, judge: Judge) -> None:
        """Let another judge steer; what was good enough may not be for it.

        So everything is visited again, unless `visits` are put back.
        """
        self.visits = {}
        self.mesh.quality[self.living()] = self._measured(judge)
        self.mesh = self.mesh._replace(judge=judge)

    # What to visit -------------------------------------------------------------------

    def next_sweep(self) -> int:
        """Start a sweep; returns the clock of the one before, for `changed_*`."""
        since = int(self.mesh.state[CLOCK])
        self.mesh.state[CLOCK] += 1
        return since

    def since(self, visitor: Hashable) -> int:
        """Clock of the last sweep of a visitor, 0 at the first; starts the next one."""
        last = self.visits.get(visitor, 0)
        self.visits[visitor] = self.next_sweep()
        return last

    def not_seen(self, visitor: Hashable, cells: Array) -> Array:
        """Cells with an edge around which anything changed since a visitor saw it; it does now."""
        seen = np.full(len(self.mesh.points), -1)
        before = self.visits.get(visitor, seen[:0])
        seen[: len(before)] = before
        corners = self.mesh.cells[cells]
        changed = self.mesh.vertex_clock[corners] > seen[corners]
        cells = cells[np.count_nonzero(changed, axis=1) >= 2]
        seen[self.mesh.cells[cells]] = self.next_sweep()
        self.visits[visitor] = seen
        return cells

    def changed_vertices(self, since: int, below: float) -> tuple[Array, Array]:
        """Vertices free to move whose ball changed after sweep `since` and is worse than `below`.

        Returns
        -------
        vertices : (n,) int64
        worst : (n,) float64
            Worst q of the ball of each.
        """
        worst = np.empty(len(self.mesh.points))
        vertex_quality(self.mesh, worst)
        free = ~self.mesh.fixed | (self.mesh.guide[:, 0] > 0)
        wanted = (self.mesh.vertex_clock > since) & free & (worst < below)
        vertices = np.flatnonzero(wanted)
        return vertices, worst[vertices]

    def changed_cells(self, since: int, below: float) -> tuple[Array, Array]:
        """Cells worse than `below` with an edge around which anything changed after `since`.

        Returns
        -------
        cells : (n,) int64
        quality : (n,) float64
        """
        n = int(self.mesh.state[N_CELLS])
        rows = np.flatnonzero(self.mesh.alive[:n] & (self.mesh.quality[:n] < below))
        changed = self.mesh.vertex_clock > since
        rows = rows[np.count_nonzero(changed[self.mesh.cells[rows]], axis=1) >= 2]
        return rows, self.mesh.quality[rows]

    def worse_cells(self, below: float) -> Array:
        """Living cells with less q than `below`."""
        living = self.living()
        return living[self.mesh.quality[living] < below]

    def rings_around(self, cells: Array, n_rings: int) -> Array:
        """Cells at most so many rings away from some cells: the first share a vertex with them."""
        living = self.living()
        near = np.zeros(len(self.mesh.points), dtype=bool)
        rows = cells
        for _ in range(n_rings):
            near[self.mesh.cells[rows].ravel()] = True
            rows = living[near[self.mesh.cells[living]].any(axis=1)]
        return rows

    # Keeping and growing -------------------------------------------------------------

    def copy(self) -> Workspace:
        """An independent copy; the working space is shared, for it means nothing between calls."""
        twin = object.__new__(Workspace)
        twin._source, twin._origin = self._source, self._origin
        twin.judge, twin.target = self.judge, self.target
        arrays: dict[str, Any] = {
            k: v.copy() for k, v in self.mesh._asdict().items() if isinstance(v, np.ndarray)
        }
        twin.mesh = self.mesh._replace(**arrays)
        twin.scratch = self.scratch
        twin.visits = dict(self.visits)
        return twin

    def grow(self) -> None:
        """Make room for more cells."""
        capacity = int(ROOM * len(self.mesh.cells)) + SPARE
        per_cell = ("cells", "neighbours", "quality", "region", "alive", "free")
        larger: dict[str, Any] = {
            name: _extended(getattr(self.mesh, name), capacity, 0) for name in per_cell
        }
        self.mesh = self.mesh._replace(**larger)
        self.scratch = _new_scratch(capacity, len(self.mesh.points))

    def reserve_points(self, n_points: int) -> None:
        """Make room for vertices up to this number of rows."""
        old = len(self.mesh.points)
        if n_points <= old:
            return
        fills = {"points": 0.0, "vertex_cell": -1, "fixed": True, "vertex_clock": 0, "guide": 0.0}
        larger: dict[str, Any] = {
            n: _extended(getattr(self.mesh, n), n_points, v) for n, v in fills.items()
        }
        # The keys of required edges count in rows.
        keys = self.mesh.required // old * n_points + self.mesh.required % old
        self.mesh = self.mesh._replace(**larger, required=keys)
        self.scratch = _new_scratch(len(self.mesh.cells), n_points)

    def make_room(self, ratio: float, n_attempts: int) -> int:
        """Make room for a new vertex an attempt, within a ratio of the points of the input.

        Returns
        -------
        room : int
            Rows of the vertex arrays that may be used.
        """
        # Never less than the input had.
        most = int(ratio * self.n_input_points) + 1
        self.reserve_points(min(most, int(self.mesh.state[N_POINTS]) + n_attempts))
        return min(most, len(self.mesh.points))

    def result(self) -> tuple[Simplices, Array]:
        """The mesh as it is now, without the vertices that vanished.

        Returns
        -------
        simplices : Simplices
        origin : (np',) int64
            The point of the input that each point was, -1 for a new one. Points that no cell
            used stay.
        """
        n_before = len(self._source.points)
        unused = np.ones(len(self.mesh.points), dtype=bool)
        unused[n_before:] = False
        unused[_inverse(self._origin)[self._source.cells]] = False
        rows = np.flatnonzero(unused | (self.mesh.vertex_cell >= 0))
        # The points of the input in their order, then the new ones.
        origin = np.full(len(rows), -1)
        origin[rows < n_before] = self._origin[rows[rows < n_before]]
        order = np.argsort(np.where(origin < 0, n_before, origin), kind="stable")
        rows, origin = rows[order], origin[order]
        number = np.full(len(self.mesh.points), -1)
        number[rows] = np.arange(len(rows))
        # Cells in order of region, then of their first vertex: stable, and near in memory.
        living = self.living()
        cells, region = number[self.mesh.cells[living]], self.mesh.region[living]
        order = np.lexsort((cells.min(axis=1), region))
        cells, region = cells[order], region[order]
        number_of = number[_inverse(self._origin)]
        worked = replace(
            self._source,
            points=self.mesh.points[rows],
            cells=cells,
            region=region,
            fixed=self._source.fixed[origin] & (origin >= 0),
            facets=number_of[self._source.facets],
            edges=number_of[self._source.edges],
        )
        return worked, origin

    def chunks(self, order: Array, size: int = 20_000) -> Iterator[Array]:
        """The order in pieces, between which progress is shown and interrupts act."""
        for start in range(0, len(order), size):
            yield order[start : start + size]


def _standing_of(q: Array) -> Standing:
    worst = float(q.min())
    if worst <= 0.0:
        return Standing(worst, math.inf, math.inf)
    n_tail = max(len(q) // 100, min(len(q), 10))
    tail = np.partition(q, n_tail - 1)[:n_tail]
    return Standing(worst, float(np.mean(1.0 / q)), float(np.mean(1.0 / tail)))


def _inverse(order: Array) -> Array:
    """Where each row went."""
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    return number


def _extended(array: Array, capacity: int, fill: float) -> Array:
    result = np.full((capacity, *array.shape[1:]), fill, dtype=array.dtype)
    result[: len(array)] = array
    return result


def _new_scratch(capacity: int, n_points: int) -> Scratch:
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
        star=np.zeros((12, MAX_BALL + 8)),
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
            state=np.zeros(8, dtype=np.int64),
        ),
    )
