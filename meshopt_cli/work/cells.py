"""The working state of an optimization of any cells: points move; see `face_work` for the plane."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any, Self

import numpy as np

from ..cells import FAMILIES, SIMPLICES, stretch_of
from ..constraints.model import Constraints
from ..errors import InvariantError
from ..kernels.operators.place import measure_rows, sweep_places
from ..kernels.types import CLOCK, CORNERS, EDITION, FACES, CellMesh, Judge
from ..mesh.adjacency import distinct
from ..mesh.any_cells import AnyCells
from ..mesh.facets import CellSet
from . import storage, visits
from .bounds import Bounds
from .foldover import relocate_all
from .kinds import CELLS
from .standing import Standing, standing_of

Array = np.ndarray

# A stored q that differs by more from the measured one is stale, and no rounding.
STALE = 1e-9


class CellWork:
    """The working state; what it has in common with `Workspace` passes may use of both.

    Attributes
    ----------
    source : AnyCells
        What it was made from.
    mesh : CellMesh
    scratch, judge, bounds, came_tangled, visits
        As `Workspace` has them; the judge is one of simplices, and measures rows.
    """

    kind = CELLS  # tells it from `Workspace`
    relocation = staticmethod(sweep_places)

    def __init__(
        self, source: AnyCells, judge: Judge, constraints: Constraints | None = None
    ) -> None:
        self.source = source
        self.judge = _formed(judge, source.dimension)
        self.mesh = mesh_of(source, self.judge, constraints)
        self.scratch = storage.new_scratch(self.mesh)
        # Rows of a cell follow each other.
        owner = self.mesh.owner
        self._first = np.flatnonzero(np.diff(owner, prepend=-1))
        self.visits: dict[Hashable, Any] = {}
        self._standings: dict[tuple[int, Judge], Standing] = {}
        measure_rows(self.mesh, self.scratch, self.mesh.quality)
        used = np.diff(self.mesh.ball_start) > 0
        self.n_vertices = int(np.count_nonzero(used))
        self.bounds = Bounds(1.0, self.n_vertices, len(source.points))
        self.came_tangled = self.standing().worst <= 0.0

    @property
    def dimension(self) -> int:
        return self.source.dimension

    @property
    def clock(self) -> int:
        """Number of the current sweep."""
        return int(self.mesh.state[CLOCK])

    @property
    def places(self) -> Array:
        """Where the vertices are, (np, 3); a copy."""
        return self.mesh.points.copy()

    def renew(self) -> None:
        """Nothing here depends on where vertices are, but for what is measured at once."""

    @property
    def n_cells(self) -> int:
        return len(self._first)

    # How good it is ------------------------------------------------------------------

    def cell_quality(self) -> Array:
        """q of each cell, that of its worst row, (nc,) float64."""
        return np.minimum.reduceat(self.mesh.quality, self._first)

    def standing(self) -> Standing:
        """How good the mesh is, by the judge that steers."""
        return self._standing_by(self.mesh.judge)

    def judged(self) -> Standing:
        """How good the mesh is, by the judge of the run."""
        return self._standing_by(self.judge)

    def _standing_by(self, judge: Judge) -> Standing:
        edition = int(self.mesh.state[EDITION])
        if (edition, judge) not in self._standings:
            if judge != self.mesh.judge:
                quality = np.empty(len(self.mesh.quality))
                measure_rows(self.mesh._replace(judge=judge), self.scratch, quality)
                found = standing_of(np.minimum.reduceat(quality, self._first))
            else:
                found = standing_of(self.cell_quality())
            others = {key: at for key, at in self._standings.items() if key[0] == edition}
            self._standings = {**others, (edition, judge): found}
        return self._standings[edition, judge]

    @property
    def worst_of_all(self) -> float:
        """q of the worst cell."""
        return self.standing().worst

    def judge_by(self, judge: Judge) -> None:
        """Let another judge steer; what was good enough may not be for it."""
        self.visits = {}
        self._standings = {}
        self.mesh = self.mesh._replace(judge=_formed(judge, self.dimension))
        measure_rows(self.mesh, self.scratch, self.mesh.quality)

    def aim_at(self, aims: tuple[Callable[[Any], int], ...], fits: bool = False) -> None:
        """Passes that have an aim of their own are for simplices: nothing is left to do."""

    def require_fresh(self) -> None:
        """Find out whether the stored q are those of the points.

        Raises
        ------
        InvariantError
        """
        quality = np.empty(len(self.mesh.quality))
        measure_rows(self.mesh, self.scratch, quality)
        stale = np.flatnonzero(np.abs(quality - self.mesh.quality) > STALE)
        if len(stale):
            cell = int(self.mesh.owner[stale[0]])
            raise InvariantError(f"cell {cell} of the working mesh has a stale quality")

    # What to visit -------------------------------------------------------------------

    def next_sweep(self) -> int:
        """Start a sweep; returns the clock of the one before."""
        since = self.clock
        self.mesh.state[CLOCK] += 1
        return since

    def since(self, visitor: Hashable) -> int:
        """Clock of the last sweep of a visitor, 0 at the first; starts the next one."""
        last = self.visits.get(visitor, 0)
        self.visits[visitor] = self.next_sweep()
        return last

    def changed_vertices(self, since: int, least: float) -> tuple[Array, Array]:
        """Vertices free to move around which something changed after a sweep, with less q than
        `least`; and the worst q around each."""
        worst = self.vertex_quality()
        free = visits.are_movable(self.mesh)
        wanted = (self.mesh.vertex_clock > since) & free & (worst < least)
        vertices = np.flatnonzero(wanted)
        return vertices, worst[vertices]

    def vertex_quality(self) -> Array:
        """Worst q of the rows at each vertex, (np,); infinite where there are none."""
        mesh = self.mesh
        worst = np.full(len(mesh.points), np.inf)
        used = np.flatnonzero(np.diff(mesh.ball_start))
        if len(used):
            q = mesh.quality[mesh.ball >> 2]
            worst[used] = np.minimum.reduceat(q, mesh.ball_start[used])
        return worst

    def worse_cells(self, least: float) -> Array:
        """Cells with less q than `least`."""
        return np.flatnonzero(self.cell_quality() < least)

    def movable(self, cells: Array) -> Array:
        """Vertices of some cells that may move, ascending."""
        return np.flatnonzero(self._vertices_of(cells) & visits.are_movable(self.mesh))

    def outside(self) -> Array:
        """See `visits.vertices_outside`."""
        return visits.vertices_outside(self.mesh)

    def rings_around(self, cells: Array, n_rings: int) -> Array:
        """Cells at most so many rings away from some cells."""
        for _ in range(n_rings):
            cells = self.cells_at(np.flatnonzero(self._vertices_of(cells)))
        return cells

    def cells_at(self, vertices: Array) -> Array:
        """Cells with one of some vertices."""
        near = np.zeros(len(self.mesh.points), dtype=bool)
        near[vertices] = True
        rows = near[self.mesh.cells].any(axis=1)
        rows |= (self.mesh.fourth >= 0) & near[self.mesh.fourth]
        return distinct(self.mesh.owner[rows])

    def _vertices_of(self, cells: Array) -> Array:
        mask = np.zeros(self.n_cells, dtype=bool)
        mask[cells] = True
        rows = mask[self.mesh.owner]
        vertices = np.zeros(len(self.mesh.points), dtype=bool)
        vertices[self.mesh.cells[rows]] = True
        fourth = self.mesh.fourth[rows]
        vertices[fourth[fourth >= 0]] = True
        return vertices

    # Keeping -------------------------------------------------------------------------

    def copy(self) -> Self:
        """An independent copy; the working space is shared."""
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        names = ("points", "quality", "vertex_clock", "state")
        twin.mesh = self.mesh._replace(**{n: getattr(self.mesh, n).copy() for n in names})
        twin.visits = dict(self.visits)
        return twin

    def move(self, points: Array) -> None:
        """Put all vertices where they are to be, (np, 3)."""
        self.mesh.state[CLOCK] += 1
        changed = np.any(points != self.mesh.points, axis=1)
        self.mesh.points[:] = points
        self.mesh.vertex_clock[changed] = self.clock
        self.mesh.state[EDITION] += 1
        measure_rows(self.mesh, self.scratch, self.mesh.quality)

    def smoothed(self, is_over: Callable[[], bool]) -> Array:
        """Where all vertices at once go so that no cell is folded over, (np, 3); see `foldover`."""
        rows, kinds, owner = self.mesh.cells, self.mesh.shape, self.mesh.owner
        shapes = _REFERENCES[self.dimension]
        if self.dimension == 2:
            rows, kinds, owner = _corners_of_faces(self.mesh)
        mesh = self.mesh
        found, _ = relocate_all(
            mesh.points, rows, shapes, kinds, mesh.fixed, owner, is_over=is_over
        )
        return found

    def moved_from(self, points: Array) -> dict[str, int]:
        """How many vertices are no more where they were, by the family of cells at them."""
        moved = np.any(points != self.mesh.points, axis=1)
        if not moved.any():
            return {}
        at: dict[str, Array] = {}
        for group in self.result().cell_sets:
            mask = at.setdefault(group.family, np.zeros(len(points), dtype=bool))
            mask[group.cells] = True
        return {family: int(np.count_nonzero(mask & moved)) for family, mask in at.items()}

    def result(self) -> AnyCells:
        """The cells as they are now."""
        return replace(self.source, points=self.mesh.points.copy())


def _formed(judge: Judge, dimension: int) -> Judge:
    return judge._replace(form=FACES if dimension == 2 else CORNERS)


def mesh_of(source: AnyCells, judge: Judge, constraints: Constraints | None = None) -> CellMesh:
    """The arrays of the kernels; the q of the rows are still to be measured."""
    rows_of = np.arange(len(source.points))
    fixed, guide, limits = storage.guides(source.fixed.copy(), rows_of, None, constraints)
    judge = _formed(judge, source.dimension)
    d = source.dimension
    parts = [_faces(group) if d == 2 else _corners(group) for group in source.cell_sets]
    rows, fourth, owner, kinds = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(owner, kind="stable")
    rows, fourth, owner, kinds = rows[order], fourth[order], owner[order], kinds[order]
    _, owner = np.unique(owner, return_inverse=True)
    start, ball = balls_of(rows, fourth, len(source.points))
    return CellMesh(
        points=source.points.copy(),
        cells=np.ascontiguousarray(rows),
        fourth=fourth,
        owner=owner.astype(np.int64),
        shape=kinds,
        stretch=STRETCHES,
        ball_start=start,
        ball=ball,
        quality=np.zeros(len(rows)),
        fixed=fixed,
        guide=guide,
        limits=limits,
        vertex_clock=np.ones(len(source.points), dtype=np.int64),
        state=np.array([0, 0, 1, 0, 0], dtype=np.int64),
        judge=judge,
        single=source.single,
    )


def _faces(group: CellSet) -> tuple[Array, Array, Array, Array]:
    n, width = group.cells.shape
    fourth = group.cells[:, 3] if width == 4 else np.full(n, -1)
    return group.cells[:, :3], fourth.astype(np.int64), group.numbers, np.zeros(n, np.int64)


def _corners(group: CellSet) -> tuple[Array, Array, Array, Array]:
    corners = FAMILIES[group.family].corners
    n, k = len(group.cells), len(corners)
    first = KINDS[group.family]
    rows = np.take(group.cells, corners, axis=1).reshape(-1, 4)
    kinds = np.tile(np.arange(first, first + k), n)
    return rows, np.full(n * k, -1), np.repeat(group.numbers, k), kinds


def _stretches() -> tuple[dict[str, int], Array]:
    """The number of the first corner of each solid, that of a tetrahedron 0; and how each corner
    is stretched, with a fourth row: how high its vertex is over its three neighbours, as a part of
    the root of twice their area, and 1 over its scaled Jacobian."""
    numbers: dict[str, int] = {}
    found: list[Array] = []
    solids = [name for name, row in FAMILIES.items() if row.dimension == 3]
    for name in (SIMPLICES[3], *(name for name in solids if name != SIMPLICES[3])):
        numbers[name] = len(found)
        for corner in FAMILIES[name].corners:
            place = FAMILIES[name].reference[corner]
            across = np.cross(place[2] - place[1], place[3] - place[1])
            size = np.linalg.norm(across)
            height = abs(across @ (place[0] - place[1])) / size / np.sqrt(size)
            jacobian = np.linalg.det(place[1:] - place[0])  # edges of length 1
            found.append(np.vstack([stretch_of(name, corner), [height, 1.0 / jacobian, 0.0]]))
    return numbers, np.array(found)


KINDS, STRETCHES = _stretches()


def _references(dimension: int) -> Array:
    """The inverse of the edges of each ideal corner, by the numbers that rows have; in the plane
    those of a triangle and of a quad."""
    names = list(KINDS) if dimension == 3 else ["triangle", "quad"]
    corners = [FAMILIES[name].reference[corner] for name in names
               for corner in FAMILIES[name].corners[: None if dimension == 3 else 1]]  # fmt: skip
    edges = np.array([(place[1:] - place[0])[:, :dimension].T for place in corners])
    return np.linalg.inv(edges)


_REFERENCES = {dimension: _references(dimension) for dimension in (2, 3)}


def _corners_of_faces(mesh: CellMesh) -> tuple[Array, Array, Array]:
    """The triangles at the corners of the faces of the plane, what they are to be, and whose."""
    quad = np.flatnonzero(mesh.fourth >= 0)
    others = np.flatnonzero(mesh.fourth < 0)
    around = np.column_stack([mesh.cells[quad], mesh.fourth[quad]])
    corners = np.take(around, FAMILIES["quad"].corners, axis=1).reshape(-1, 3)
    return (
        np.concatenate([mesh.cells[others], corners]),
        np.repeat([0, 1], [len(others), len(corners)]),
        np.concatenate([mesh.owner[others], np.repeat(mesh.owner[quad], 4)]),
    )


def balls_of(rows: Array, fourth: Array, n_points: int) -> tuple[Array, Array]:
    """Where the handles of each vertex begin, and all handles."""
    n, width = rows.shape
    vertices = rows.ravel()
    handles = (4 * np.arange(n)[:, None] + np.arange(width)).ravel()
    quads = np.flatnonzero(fourth >= 0)
    vertices = np.concatenate([vertices, fourth[quads]])
    handles = np.concatenate([handles, 4 * quads + 3])
    order = np.argsort(vertices, kind="stable")
    start = np.zeros(n_points + 1, dtype=np.int64)
    np.cumsum(np.bincount(vertices, minlength=n_points), out=start[1:])
    return start, handles[order]
