"""mend: composite operations on the worst tetrahedra, by their type (18.5, Exercise 18.6)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.classify import TetType
from ..kernels.mend import Mending, Remedy, sweep_mend
from ..kernels.types import N_POINTS
from ..workspace import Workspace
from .base import Observer, Operator, Tally, option

# For each type, what to try in what order: the cheap and the likely first.
REMEDIES: dict[TetType, tuple[Remedy, ...]] = {
    TetType.REGULAR: (Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.SPADE: (Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.SLIVER: (Remedy.REMOVE_EDGE, Remedy.RELOCATE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.CAP: (Remedy.REMOVE_FACES, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.WEDGE: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.SPINDLE: (Remedy.COLLAPSE, Remedy.REMOVE_EDGE, Remedy.RELOCATE, Remedy.INSERT),
    TetType.SPEAR: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.NEEDLE: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.INSERT, Remedy.REMOVE_EDGE),
}


def remedy_table() -> np.ndarray:
    """`REMEDIES` as the kernel takes it."""
    table = np.zeros((len(TetType), max(map(len, REMEDIES.values()))), dtype=np.int64)
    for kind, remedies in REMEDIES.items():
        table[kind, : len(remedies)] = remedies
    return table


@dataclass
class Mend(Operator):
    """Change, improve what is around, and undo it where it does not pay."""

    name: ClassVar[str] = "mend"
    summary: ClassVar[str] = "composite operations on the worst tetrahedra, by type (18.5)"

    dimensions: ClassVar[tuple[int, ...]] = (3,)

    below: float = option(2.0, "visit only cells whose Q is above this", least=1.0)
    accept: str = option("strict", "the worst Q of what changed must fall", choices=("strict",))
    max_vertices: float = option(1.5, "most vertices, over those of the input", least=1.0, most=4.0)
    harm: float = option(
        0.3, "what the first change may leave of the quality of the cell", least=0.0, most=1.0
    )
    least_gain: float = option(
        0.01, "least gain of the worst quality of what changed, as a part of it", least=0.0
    )

    def sweep(self, work: Workspace, tally: Tally, observer: Observer) -> None:
        cells, quality = work.changed_cells(self.since(work, "cavities"), self.limit)
        if not len(cells):
            return
        # Room for a vertex an attempt, and never for less than the input had.
        most = int(self.max_vertices * work.n_input_points) + 1
        work.reserve_points(min(most, int(work.mesh.state[N_POINTS]) + len(cells)))
        how = Mending(self.limit, self.harm, self.least_gain, min(most, len(work.mesh.points)))
        order = self.ordered(work, cells, quality)
        table = remedy_table()

        def kernel(chunk):
            sweep_mend(work.mesh, chunk, table, how, work.scratch, tally.counts)

        self.visit(work, order, kernel, tally, observer)
