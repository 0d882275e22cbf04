"""The working state of an optimization: a mesh that passes change, and what belongs to it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, ClassVar

import numpy as np

from ..boundary.patches import Patches
from ..constraints.model import Constraints
from ..handles import OUTER, PATCH
from ..kernels.judge import measure_cells
from ..kernels.operators.relocate import sweep_relocation
from ..kernels.types import CLOCK, EDITION, MAPPED, N_CELLS, N_FREE, N_POINTS, Judge
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.order import hilbert
from . import storage, visits
from .background import Background, take_anew
from .bounds import Bounds
from .kinds import SIMPLICES
from .lengths import UNKNOWN, lengths_of
from .standing import Standing, standing_of
from .storage import inverse

Array = np.ndarray


class Workspace:
    """The working state of an optimization.

    Attributes
    ----------
    kind : str
        Tells it from `CellWork`.
    relocation : callable
        The kernel that relocates vertices.
    mesh : SimplexMesh
        Arrays of the kernels. They may be replaced by larger ones: ask for them anew.
    scratch : Scratch
    judge : Judge
        By what the mesh is judged; a stage may let another one steer.
    bounds : Bounds
        What passes hold the mesh against: itself, unless it is a part of another.
    came_tangled : bool
        Whether the mesh came with inverted or flat cells.
    visits : dict
        When entities were visited last, by who visited them: clocks, whole or for each vertex.
        Its values are replaced and never written into, so that a copy may share them.

    Parameters
    ----------
    target : float
        Q of the best cell that the worst facet of the boundary allows; 1 when that is not known.
    patches : Patches, optional
        What may move on the boundary; nothing without it.
    splittable : (n, 2) int64, optional
        Edges of the boundary that may be split; none without it.
    constraints : Constraints, optional
        What vertices were told.
    in_order : bool
        Whether vertices and cells keep the rows they have in the source, rather than
        stand near each other in memory where they are near in space.
    background : Background, optional
        The metric that edges have lengths in, and shapes where the form of the judge is MAPPED.
    """

    kind: ClassVar[str] = SIMPLICES
    relocation = staticmethod(sweep_relocation)

    def __init__(
        self,
        source: Simplices,
        judge: Judge,
        target: float = 1.0,
        in_order: bool = False,
        patches: Patches | None = None,
        splittable: Array | None = None,
        background: Background | None = None,
        constraints: Constraints | None = None,
    ) -> None:
        n_points = len(source.points)
        self._source = source
        # Row i of the work is point `_origin[i]` of the source.
        self._origin = np.arange(n_points) if in_order else hilbert(source.points)
        self._background = background
        self._resamples = patches is not None and patches.splits is not None
        metric = None if background is None else background.at_points
        self.mesh = storage.simplex_mesh(
            source, judge, self._origin, in_order, patches, metric, constraints
        )
        # Where the metric of each vertex was taken; replaced, never written into.
        self._taken = None if background is None else self.mesh.points[:, :3].copy()
        self.scratch = storage.new_scratch(self.mesh)
        number = inverse(self._origin)
        # Facets that the file declares, and edges that may be split, by rows; not written into.
        self.facets = number[source.facets]
        self.splittable = None if splittable is None else number[splittable]
        self.judge = judge
        self.bounds = Bounds(target, self.n_vertices, n_points)
        self.visits: dict[Hashable, Any] = {}
        self.n_input_cells = len(source.cells)
        self.partition: object = None  # see `blocks`; replaced, never written into
        # By the edition of the mesh and the judge; replaced, never written into.
        self._standings: dict[tuple[int, Judge], Standing] = {}
        self._aims: tuple[Callable[[Workspace], int], ...] = ()
        self._fits = False
        self._lengths = UNKNOWN
        self.came_tangled = self.standing().worst <= 0.0

    # What is there -------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        return self.mesh.cells.shape[1] - 1

    @property
    def clock(self) -> int:
        """Number of the current sweep."""
        return int(self.mesh.state[CLOCK])

    @property
    def n_cells(self) -> int:
        """Number of living cells."""
        return int(self.mesh.state[N_CELLS] - self.mesh.state[N_FREE])

    @property
    def n_vertices(self) -> int:
        """Number of points that cells use now."""
        return int(np.count_nonzero(self.mesh.vertex_cell >= 0))

    @property
    def n_points(self) -> int:
        """Rows of the vertex arrays in use, those of vertices that vanished included."""
        return int(self.mesh.state[N_POINTS])

    @property
    def n_input_points(self) -> int:
        """Number of points the mesh came with."""
        return len(self._source.points)

    @property
    def places(self) -> Array:
        """Where the vertices are, (np, 3); a copy."""
        return self.mesh.points[:, :3].copy()

    @property
    def has_metric(self) -> bool:
        """Whether a metric judges it."""
        return self._background is not None

    def living(self) -> Array:
        """Rows of the living cells, ascending."""
        return visits.living_cells(self.mesh)

    def corners(self, cells: Array) -> Array:
        """Vertices of some cells, (n, d + 1) int64."""
        return self.mesh.cells[cells]

    def quality(self, cells: Array) -> Array:
        """q of some cells, by the judge that steers, (n,) float64."""
        return self.mesh.quality[cells]

    def movable(self, cells: Array) -> Array:
        """Vertices of some cells that may move, ascending."""
        vertices = adjacency.distinct(self.mesh.cells[cells])
        return vertices[visits.are_movable(self.mesh)[vertices]]

    def outside(self) -> Array:
        """See `visits.vertices_outside`."""
        return visits.vertices_outside(self.mesh)

    def degrees(self) -> Array:
        """Number of edges at each vertex, (np,) int64."""
        cells = self.corners(self.living())
        if self.dimension == 3:
            return adjacency.degrees(cells, len(self.mesh.points))
        # Each triangle has two edges there, which it shares but where the mesh ends.
        n_cells = np.bincount(cells.ravel(), minlength=len(self.mesh.points))
        return n_cells + self.facets_at(outer=True) // 2

    def facets_at(self, outer: bool = False) -> Array:
        """Number of facets without a neighbour at each vertex, (np,) int64.

        Parameters
        ----------
        outer : bool
            Count those where the mesh ends only, not interfaces and declared facets.
        """
        rows = self.living()
        beyond = self.mesh.neighbours[rows]
        chosen = (beyond == OUTER) | (beyond <= PATCH) if outer else beyond < 0
        facets = adjacency.facets_at(self.mesh.cells[rows], chosen)
        return np.bincount(facets.ravel(), minlength=len(self.mesh.points))

    # How good it is ------------------------------------------------------------------

    def standing(self) -> Standing:
        """How good the mesh is, by the judge that steers."""
        return self._standing_by(self.mesh.judge)

    def judged(self) -> Standing:
        """How good the mesh is, by the judge of the run."""
        return self._standing_by(self.judge)

    def aim_at(self, aims: tuple[Callable[[Workspace], int], ...], fits: bool = False) -> None:
        """Let other aims than quality count: each tells how much there is left to do for it.

        Parameters
        ----------
        fits : bool
            Whether edges are to have length 1 in the metric, and this comes first.
        """
        self._aims = aims
        self._fits = fits and self.has_metric
        self._standings = {}

    def _standing_by(self, judge: Judge) -> Standing:
        """How good the mesh is as a judge sees it; looked for again where it has changed only."""
        edition = int(self.mesh.state[EDITION])
        if (edition, judge) not in self._standings:
            steers = judge == self.mesh.judge
            q = self.quality(self.living()) if steers else self._measured(judge)
            left = sum(aim(self) for aim in self._aims)
            others = {key: at for key, at in self._standings.items() if key[0] == edition}
            lack = float(self.lengths()[2, self.living()].mean()) if self._fits else 0.0
            self._standings = {**others, (edition, judge): standing_of(q, left, lack)}
        return self._standings[edition, judge]

    def lengths(self) -> Array:
        """Of each row of cells the shortest and the longest edge, and what they lack: (3, n).

        That is the mean of (1 - e)² of (18.12) over its edges.
        """
        self._lengths = lengths_of(self.mesh, self._lengths)
        return self._lengths.values

    @property
    def worst_of_all(self) -> float:
        """q of the worst cell: of the mesh, or of the whole that it is a part of."""
        return self.standing().worst if self.bounds.worst is None else self.bounds.worst

    def _measured(self, judge: Judge, cells: Array | None = None) -> Array:
        """q of some cells, all that live by default, as a judge sees them."""
        corners = self.corners(self.living() if cells is None else cells)
        quality = np.empty(len(corners))
        measure_cells(judge, self.mesh.points, corners, quality)
        return quality

    def judge_by(self, judge: Judge) -> None:
        """Let another judge steer; what was good enough may not be for it.

        So everything is visited again, unless `visits` are put back.
        """
        self.visits = {}
        self._standings = {}
        self.mesh.quality[self.living()] = self._measured(judge)
        self.mesh = self.mesh._replace(judge=judge)

    # What to visit -------------------------------------------------------------------

    def next_sweep(self) -> int:
        """Start a sweep; returns the clock of the one before, for `changed_*`."""
        since = self.clock
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
        cells = visits.cells_changed_since(self.mesh, cells, seen)
        seen[self.corners(cells)] = self.next_sweep()
        self.visits[visitor] = seen
        return cells

    def changed_vertices(self, since: int, least: float) -> tuple[Array, Array]:
        """See `visits.changed_vertices`."""
        return visits.changed_vertices(self.mesh, since, least)

    def changed_cells(self, since: int, least: float) -> tuple[Array, Array]:
        """See `visits.changed_cells`."""
        return visits.changed_cells(self.mesh, since, least)

    def worse_cells(self, least: float) -> Array:
        """Living cells with less q than `least`."""
        living = self.living()
        return living[self.quality(living) < least]

    def cells_at(self, vertices: Array) -> Array:
        """Living cells with one of some vertices."""
        return visits.cells_at(self.mesh, vertices)

    def rings_around(self, cells: Array, n_rings: int) -> Array:
        """See `visits.rings_around`."""
        return visits.rings_around(self.mesh, cells, n_rings)

    # Keeping and growing -------------------------------------------------------------

    def copy(self) -> Workspace:
        """An independent copy; the working space is shared, for it means nothing between calls."""
        twin = object.__new__(Workspace)
        twin.__dict__.update(self.__dict__)
        twin.mesh = storage.copied(self.mesh)
        twin.visits = dict(self.visits)
        return twin

    def smoothed(self, is_over: Callable[[], bool]) -> Array:
        """Where all vertices at once go so that no cell is folded over, (np, 3); see `foldover`."""
        from .foldover import relocate_simplices  # seldom needed

        cells = self.corners(self.living())
        return relocate_simplices(self.places, cells, self.mesh.fixed, is_over)

    def move(self, points: Array) -> None:
        """Put all vertices where they are to be, (np, 3)."""
        self.next_sweep()
        self._lengths = UNKNOWN
        places = self.mesh.points[:, :3]
        self.mesh.vertex_clock[np.any(points != places, axis=1)] = self.clock
        places[:] = points
        self.mesh.state[EDITION] += 1
        self.mesh.quality[self.living()] = self._measured(self.mesh.judge)

    def renew(self) -> None:
        """Take the metric of vertices that moved, or are new, from the background."""
        if self._background is None:
            return
        assert self._taken is not None
        moved = take_anew(self.mesh, self._background, self._taken)
        if not moved.any():
            return
        self._taken = self.places
        if self.mesh.judge.form != MAPPED:  # lengths alone go by it
            return
        cells = self.cells_at(np.flatnonzero(moved))
        self.mesh.quality[cells] = self._measured(self.mesh.judge, cells)
        self.mesh.state[EDITION] += 1

    def grow(self) -> None:
        """Make room for more cells."""
        self.mesh = storage.with_room_for_cells(self.mesh)
        self.scratch = storage.new_scratch(self.mesh)

    def put(
        self, points: Array, cells: Array, region: Array, facets: Array, splittable: Array
    ) -> None:
        """Take other triangles in the place of all, whose borders are those of these, or split.

        Parameters
        ----------
        points : (np, 3) float64
            Those of the input in their rows, then new ones.
        facets : (n, 2) int64
            What the declared facets are now.
        splittable : (n, 2) int64
            What the edges that may be split are now.
        """
        self.next_sweep()
        self.facets, self.splittable = facets, splittable
        self.mesh = storage.with_triangles(
            self.mesh, points, cells, region, facets, self.n_input_points
        )
        self.scratch = storage.new_scratch(self.mesh)

    def reserve_points(self, n_points: int) -> None:
        """Make room for vertices up to this number of rows."""
        if n_points > len(self.mesh.points):
            self.mesh = storage.with_rows_for_points(self.mesh, n_points)
            self.scratch = storage.new_scratch(self.mesh)

    def room_for_vertices(self, ratio: float, n_attempts: int) -> int:
        """Make room for a new vertex an attempt, within a ratio of the points of the input.

        So rows never run short during a sweep, which would leave entities out.

        Returns
        -------
        max_points : int
            Rows of the vertex arrays that may be used.
        """
        # Never less than the input had.
        most = int(ratio * self.bounds.n_input_points) + 1
        self.reserve_points(min(most, self.n_points + n_attempts))
        return min(most, len(self.mesh.points))

    def result(self) -> tuple[Simplices, Array]:
        """The mesh as it is now; see `storage.simplices_of`."""
        return storage.simplices_of(
            self.mesh, self._source, self._origin, self.facets, self._resamples
        )
