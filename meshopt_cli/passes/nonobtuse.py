"""nonobtuse: triangles of the plane without obtuse angles, self-centered tets (18.4.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.operators.centre import not_centred, sweep_centre
from ..kernels.operators.clear import Clearing, sweep_clear
from ..kernels.operators.nonobtuse import lacking, sweep_ease
from ..kernels.shape.lack import Wants
from ..kernels.types import Verdict
from ..work.session import Workspace
from .base import Pass, option
from .run import Run

Array = np.ndarray

# How many degrees below 90 angles are led: at first, which evens out what is around obtuse ones,
# for this part of the sweeps; and then. Narrow all along: up to 0.04 more mean Q. Six degrees and
# then: twice as many are left on one mesh of six.
WIDE, NARROW = 10.0, 3.0
WIDE_SWEEPS = 0.25
CLEARINGS = (NARROW, 1.0, 8.0)  # the same, each time that what is left is cleared

LEAST_PART = 0.002  # of tets that lack something, that a sweep over them is to change

COARSE = 0.5  # part of the vertices that may move, below which there is little to move
MOST_IN_VAIN = 2


@dataclass(frozen=True)
class NonObtuse(Pass):
    """Move vertices and flip edges where angles are obtuse, and change more where that fails; in
    space move and swap where tetrahedra do not contain their circumcentre."""

    name: ClassVar[str] = "nonobtuse"
    splits_boundary: ClassVar[bool] = True
    takes_metric: ClassVar[bool] = False
    summary: ClassVar[str] = (
        "makes obtuse triangles of the plane acute or right, at the expense of the mean Q, not of "
        "the worst, with vertices on the boundary where --boundary split lets it; in space lets "
        "more tetrahedra contain their circumcentre (18.4.3)"
    )
    kernels: ClassVar[tuple[str, ...]] = ("nonobtuse", "steiner")

    sweeps: int = option(
        40, "sweeps of moves and flips in one run, fewer when nothing changes", least=1, most=1000
    )
    least_angle: float = option(
        25.0, "angle in degrees below which none comes to be, and from which smaller ones are "
        "lifted, too", least=0.0, most=45.0,
    )  # fmt: skip
    max_rings: int = option(
        3, "moves and flips reach so many rings of triangles around obtuse ones", least=0, most=10
    )
    steps: int = option(
        10, "rounds of moves and flips after a split of a vertex, a collapse, a new vertex or a "
        "flip that does harm, before it is judged", least=0, most=100,
    )  # fmt: skip
    max_vertices: float = option(1.2, "most vertices, over those of the input", least=1.0, most=4.0)
    min_vertices: float = option(
        0.8, "fewest vertices, over those of the input", least=0.0, most=1.0
    )

    max_steiner: float = option(
        4.0, "most vertices, over those of the input, where the boundary may be split",
        least=1.0, most=100.0,
    )  # fmt: skip

    least_quality: float = option(
        0.25, "in space, 1/Q below which no tetrahedron comes to be", least=0.0, most=1.0
    )

    def left(self, work: Workspace) -> int:
        """Number of obtuse triangles, or of tetrahedra that are not self-centered."""
        if work.dimension == 3:
            return not_centred(work.mesh, np.empty(0, np.int64))[0]
        n_obtuse, _ = lacking(work.mesh, self._wants(NARROW, 0.0), np.empty(0, np.int64))
        return n_obtuse

    def sweep(self, work: Workspace, run: Run) -> None:
        if work.dimension == 3:
            self._centre(work, run)
            return
        if work.splittable is not None and self._is_coarse(work):
            self._search(work, run)
            return
        n_wide = round(WIDE_SWEEPS * self.sweeps)
        self._ease(work, run, WIDE, n_wide)
        self._ease(work, run, NARROW, self.sweeps - n_wide)
        for margin in CLEARINGS:
            self._clear(work, run, margin)
        if work.splittable is not None:
            self._search(work, run)

    def _centre(self, work: Workspace, run: Run) -> None:
        """Move vertices and swap where tets are not self-centered, or nearly so."""
        least = max(self.least_quality, work.worst_of_all)
        for _ in range(self.sweeps):
            rows = np.empty(work.n_cells, dtype=np.int64)
            _, n = not_centred(work.mesh, rows)
            changed = work.not_seen((self, "space"), rows[:n])
            work.next_sweep()
            applied = run.tally.applied
            run.visit(work, changed, sweep_centre, least)
            if run.tally.applied - applied < LEAST_PART * n:
                return

    def _is_coarse(self, work: Workspace) -> bool:
        """Whether a mesh came with few vertices that may move: moves and flips do little there."""
        key = (self, "coarse")
        if key not in work.visits:
            there = work.mesh.vertex_cell >= 0
            n_free = np.count_nonzero(there & ~work.mesh.fixed)
            work.visits[key] = bool(n_free < COARSE * work.n_vertices)
        return bool(work.visits[key])

    def _search(self, work: Workspace, run: Run) -> None:
        """Look for Steiner points, on the boundary too, unless that was in vain twice."""
        from ..work.steiner import Search, goal_for, n_tries, net_for, put_back  # seldom needed

        n_in_vain = work.visits.get((self, "steiner"), 0)
        n_obtuse = self.left(work)
        if not n_obtuse or n_in_vain == MOST_IN_VAIN:
            return
        n_before = work.n_vertices
        most = max(int(self.max_steiner * work.bounds.n_input_points), n_before)
        goal = goal_for(work, self.least_angle, not self._is_coarse(work), most)
        net = net_for(work, most - n_before)

        def advanced(by: int) -> None:
            run.observer.advanced(by)
            run.check()

        run.observer.started(run.tally.name, n_tries(n_obtuse))
        run.check()
        search = Search(net, goal, advanced)
        try:
            search.run()
            if search.n_bad:
                work.visits[(self, "steiner")] = n_in_vain + 1
        finally:
            if search.kept and search.is_better:
                put_back(work, search.best)
                run.tally.counts[Verdict.APPLIED] += search.kept
            run.tally.counts[Verdict.NOT_BETTER] += search.tries - search.kept

    def _wants(self, margin: float, q: float) -> Wants:
        """What is wanted of triangles, with a margin in degrees."""
        least, margin = (math.sin(math.radians(angle)) for angle in (self.least_angle, margin))
        return Wants(least, margin, q)

    def _lacking(self, work: Workspace) -> Array:
        """Triangles that are obtuse, or have an angle below the least one."""
        rows = np.empty(work.n_cells, dtype=np.int64)
        _, n = lacking(work.mesh, self._wants(NARROW, 0.0), rows)
        return rows[:n]

    def _ease(self, work: Workspace, run: Run, margin: float, sweeps: int) -> None:
        """Move vertices and flip edges around the triangles that lack anything."""
        wants = self._wants(margin, work.worst_of_all)
        for _ in range(sweeps):
            cells = work.rings_around(self._lacking(work), self.max_rings)
            work.next_sweep()
            applied = run.tally.applied
            run.visit(work, cells, sweep_ease, wants)
            if run.tally.applied == applied:
                return

    def _clear(self, work: Workspace, run: Run, margin: float) -> None:
        """Change more at those that still do."""
        cells = work.not_seen((self, margin), self._lacking(work))
        max_points = work.room_for_vertices(self.max_vertices, len(cells))
        fewest = math.ceil(self.min_vertices * work.bounds.n_input_vertices)
        spare = max(0, work.n_vertices - fewest)
        how = Clearing(self._wants(margin, work.worst_of_all), max_points, spare, self.steps)
        run.visit(work, cells, sweep_clear, how)
