"""split: new vertices where nothing else mends a cell (18.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..cells import SIMPLICES
from ..kernels.operators.constrained import sweep_constrained
from ..kernels.operators.insert import Splitting, sweep_split
from ..mesh import adjacency
from ..mesh.constrained import between_bound, constrained_edges, constrained_facets
from ..mesh.facets import CellSet
from ..work.session import Workspace
from .base import Operator, bad_enough, option, urgency, urgent_q
from .run import Run

# Once there are so many times the vertices, the order of the visits is stale: what was refused
# among the worst cells may have become possible, and comes before what is left.
STALE = 1.15


@dataclass(frozen=True)
class Split(Operator):
    """Insert vertices into cavities around bad cells."""

    name: ClassVar[str] = "split"
    summary: ClassVar[str] = "adds vertices where nothing else mends a cell (18.4)"
    kernels: ClassVar[tuple[str, ...]] = ("split", "constrained")

    worse_than: float = bad_enough(3.0, "cells whose Q is above")
    accept: str = option("strict", "the worst Q of the cavity must fall", choices=("strict",))
    max_vertices: float = option(1.5, "most vertices, over those of the input", least=1.0, most=4.0)
    least_gain: float = option(
        0.1, "least gain of the worst quality of a cavity, as a part of it",
        least=0.0, most=1e3,
    )  # fmt: skip
    urgent_factor: float = urgency()
    first_gain: float = option(
        0.0, "away from those urgent cells, move the new vertex only where the first cavity is at "
        "least so many times as good as the cell", least=0.0, most=1e3,
    )  # fmt: skip
    constrained: float = option(
        0.0, "also split cells, and internal edges and faces, that have all their vertices on the "
        "boundary, as long as this part of the quality is left; 0: do not",
        least=0.0, most=1.0,
    )  # fmt: skip

    worst: str = option(
        "kept", "whether the worst Q of the mesh may rise for that (free): a run goes back then, "
        "unless other passes lower it again", choices=("kept", "free"),
    )  # fmt: skip

    def needed_kernels(self) -> tuple[str, ...]:
        return self.kernels if self.constrained else self.kernels[:1]

    def left(self, work: Workspace) -> int:
        """Number of entities that have all their vertices on the boundary, where they are split."""
        return over_constrained(work) if self.constrained else 0

    def sweep(self, work: Workspace, run: Run) -> None:
        if self.constrained:
            self._split_constrained(work, run)
        since = work.since((self, "cavities"))
        while self._split(work, since, run):
            pass

    def _split(self, work: Workspace, since: int, run: Run) -> bool:
        """Visit the cells, those that changed after a sweep; whether they are to be listed anew."""
        cells, quality = work.changed_cells(since, self.limit)
        if not len(cells):
            return False
        most = work.room_for_vertices(self.max_vertices, len(cells))
        max_points = min(most, int(STALE * work.n_points) + 1)
        order = self.ordered(work, cells, quality)
        urgent = urgent_q(work, self.urgent_factor)
        how = Splitting(max_points, self.least_gain, urgent, self.first_gain)
        run.visit(work, order, sweep_split, how)
        return max_points < most and work.n_points >= max_points

    def _split_constrained(self, work: Workspace, run: Run) -> None:
        """Give every over-constrained entity a vertex inside (Definitions 18.8, 18.9)."""
        applied = -1
        while run.tally.applied > applied:
            applied = run.tally.applied
            # The cells around a new vertex may be constrained at another of their edges.
            cells = work.living()
            max_points = work.room_for_vertices(self.max_vertices, len(cells))
            on_boundary = work.facets_at() > 0
            # An internal edge needs two vertices there; every other entity has such edges.
            cells = cells[np.count_nonzero(on_boundary[work.corners(cells)], axis=1) >= 2]
            order = self.ordered(work, cells, work.quality(cells))
            work.next_sweep()
            least = work.worst_of_all if self.worst == "kept" else 0.0
            how = on_boundary, self.constrained, least, max_points
            run.visit(work, order, sweep_constrained, *how)


def over_constrained(work: Workspace) -> int:
    """How many cells, and edges and faces inside, have all their vertices on the boundary."""
    rows = work.living()
    cells, beyond = work.corners(rows), work.mesh.neighbours[rows]
    n_points, family = len(work.mesh.points), SIMPLICES[work.dimension]
    on_boundary = work.facets_at() > 0
    keys, _ = between_bound([CellSet(family, cells, rows)], on_boundary)
    n = len(constrained_edges(keys, [adjacency.facets_at(cells, beyond < 0)], n_points))
    n += int(np.count_nonzero(on_boundary[cells].all(axis=1)))
    if work.dimension == 3:
        inner = adjacency.facets_at(cells, beyond >= 0)  # each from both its cells
        n += int(np.count_nonzero(constrained_facets(inner, on_boundary))) // 2
    return n
