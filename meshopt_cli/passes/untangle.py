"""untangle: make inverted and flat cells positive, the boundary as it is (18.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels import relocate
from ..kernels.accept import FLAT, STRICT
from ..workspace import Workspace
from .base import Observer, Tally, option
from .mend import Mend


@dataclass
class Untangle(Mend):
    """Move, swap and insert around inverted cells; without any, there is nothing to do."""

    name: ClassVar[str] = "untangle"
    summary: ClassVar[str] = "mends inverted and flat cells inside the mesh"
    # Those of `mend` take long, and few meshes are tangled: they are compiled when one is.
    kernels: ClassVar[tuple[str, ...]] = ("relocation",)

    below: float = option(1.0, "not used: only cells without a volume are visited", least=1.0)
    harm: float = option(
        0.0, "what the first change may leave of the quality of the cell", least=0.0, most=1.0
    )
    rounds: int = option(20, "rounds of relocation and of composite operations", least=1)

    @property
    def limit(self) -> float:
        return FLAT

    def sweep(self, work: Workspace, tally: Tally, observer: Observer) -> None:
        for _ in range(self.rounds):
            bad = work.worse_cells(self.limit)
            if not len(bad):
                return
            applied = tally.applied
            self._relocate(work, bad, tally, observer)
            self._mend(work, work.worse_cells(self.limit), self.limit, tally, observer)
            if tally.applied == applied:
                return

    def _relocate(self, work: Workspace, bad: np.ndarray, tally: Tally, observer: Observer) -> None:
        """Move the free vertices of the bad cells, and those of the ring around them.

        The mean of its neighbours is often inside the ball of a vertex far outside of it,
        where uphill is a long way.
        """
        self._move(work, relocate.LAPLACE, bad, tally, observer)
        self._move(work, relocate.OPTIMIZE, bad, tally, observer)
        self._move(work, relocate.OPTIMIZE, work.rings_around(bad, 1), tally, observer)

    def _move(
        self, work: Workspace, method: int, cells: np.ndarray, tally: Tally, observer: Observer
    ) -> None:
        how = relocate.Relocation(method, relocate.UNIFORM, 1.0, STRICT, 0.0, np.inf)
        vertices = np.unique(work.mesh.cells[cells])
        order = vertices[~work.mesh.fixed[vertices]]

        def kernel(chunk):
            relocate.sweep_relocation(work.mesh, chunk, how, work.scratch, tally.counts)

        work.next_sweep()
        self.visit(work, order, kernel, tally, observer)
