"""untangle: make inverted and flat cells positive, the boundary as it is (18.5)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels.accept import FLAT, STRICT
from ..kernels.operators import relocate
from ..work.kinds import CELLS, FACES, SIMPLICES
from ..work.session import Workspace
from .base import option
from .mend import Remedial
from .run import Run, Work
from .smooth import smooth_all


@dataclass(frozen=True)
class Untangle(Remedial):
    """Move, swap and insert around inverted cells; without any, there is nothing to do.

    Where some stay inverted, all vertices move at once.
    """

    name: ClassVar[str] = "untangle"
    summary: ClassVar[str] = "mends inverted and flat cells inside the mesh"
    # Those of `mend` take long, and few meshes are tangled: they are compiled when one is.
    kernels: ClassVar[tuple[str, ...]] = ("relocation",)
    mends_tangles: ClassVar[bool] = True
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES, CELLS)

    rounds: int = option(20, "rounds of relocation and of composite operations", least=1, most=1000)

    def sweep(self, work: Work, run: Run) -> None:
        for _ in range(self.rounds):
            bad = work.worse_cells(FLAT)
            if not len(bad):
                return
            applied = run.tally.applied
            self._relocate(work, bad, run)
            if isinstance(work, Workspace):
                self.mend(work, work.worse_cells(FLAT), FLAT, 0.0, math.inf, run)
            if run.tally.applied == applied:
                break
        if len(work.worse_cells(FLAT)):
            smooth_all(work, run)

    def _relocate(self, work: Work, bad: np.ndarray, run: Run) -> None:
        """Move the free vertices of the bad cells, and those of the ring around them.

        The mean of its neighbours is often inside the ball of a vertex far outside of it,
        where uphill is a long way.
        """
        self._move(work, relocate.LAPLACE, bad, run)
        self._move(work, relocate.OPTIMIZE, bad, run)
        self._move(work, relocate.OPTIMIZE, work.rings_around(bad, 1), run)

    def _move(self, work: Work, method: int, cells: np.ndarray, run: Run) -> None:
        how = relocate.Relocation(method, relocate.UNIFORM, 1.0, STRICT, 0.0, np.inf)
        order = work.movable(cells)
        work.next_sweep()
        run.visit(work, order, work.relocation, how, reach=Reach.BALLS)
