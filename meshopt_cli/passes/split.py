"""split: new vertices where nothing else mends a cell (18.4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..kernels.split import sweep_split
from ..kernels.types import N_POINTS
from ..workspace import Workspace
from .base import Observer, Operator, Tally, option


@dataclass
class Split(Operator):
    """Insert vertices into cavities around bad cells."""

    name: ClassVar[str] = "split"
    summary: ClassVar[str] = "adds vertices where nothing else mends a cell (18.4)"

    below: float = option(3.0, "visit only cells whose Q is above this", least=1.0)
    accept: str = option("strict", "the worst Q of the cavity must fall", choices=("strict",))
    max_vertices: float = option(1.5, "most vertices, over those of the input", least=1.0, most=4.0)
    least_gain: float = option(
        0.1, "least gain of the worst quality of a cavity, as a part of it", least=0.0
    )

    def sweep(self, work: Workspace, tally: Tally, observer: Observer) -> None:
        cells, quality = work.changed_cells(self.since(work, "cavities"), self.limit)
        if not len(cells):
            return
        # Room for a vertex an attempt, and never for less than the input had.
        most = int(self.max_vertices * work.n_input_points) + 1
        work.reserve_points(min(most, int(work.mesh.state[N_POINTS]) + len(cells)))
        room = min(most, len(work.mesh.points))
        order = self.ordered(work, cells, quality)

        def kernel(chunk):
            sweep_split(work.mesh, chunk, room, self.least_gain, work.scratch, tally.counts)

        self.visit(work, order, kernel, tally, observer)
