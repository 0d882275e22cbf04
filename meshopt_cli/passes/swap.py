"""swap: other cells between the same vertices (18.4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..kernels.accept import MEAN, is_accepted, mean_falls
from ..kernels.operators.flip import sweep_flip
from ..kernels.operators.swap import Swapping, sweep_swap
from ..kernels.types import Verdict
from ..work.kinds import FACES, SIMPLICES
from ..work.session import Workspace
from .base import Operator, option
from .run import Run, Work

if TYPE_CHECKING:
    from ..work.cells import CellWork


@dataclass(frozen=True)
class Swap(Operator):
    """Flip edges of triangles; swap faces and edges of tetrahedra."""

    name: ClassVar[str] = "swap"
    summary: ClassVar[str] = "flips edges in the plane, swaps faces and edges in space (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("swap",)
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES)

    pick: str = option(
        "first", "which of the accepted swaps of a cell is applied", choices=("first", "best")
    )

    def sweep(self, work: Work, run: Run) -> None:
        if not isinstance(work, Workspace):
            self._swap_faces(work, run)
            return
        since = work.since((self, "shells"))
        how = Swapping(self.rule, self.least(work), self.pick == "best", since)
        sweep = sweep_swap if work.dimension == 3 else sweep_flip
        cells, quality = work.changed_cells(since, self.limit)
        order = self.ordered(work, cells, quality)
        run.visit(work, order, sweep, how)

    def _swap_faces(self, work: CellWork, run: Run) -> None:
        """Swap pairs of triangles and quads, the worst first, each face once."""
        run.budget.check()
        found, floor = work.swaps(), self.least(work)
        before, after = found.before.min(axis=1), found.after.min(axis=1)
        near = np.flatnonzero((before < self.limit) & (after > 0.0))
        near = self.ordered(work, near, before[near])
        taken = np.zeros(work.n_cells, dtype=bool)
        chosen = []
        for k in near.tolist():
            good = is_accepted(self.rule, floor, before[k], after[k]) and (
                self.rule != MEAN
                or mean_falls((1.0 / found.before[k]).sum(), (1.0 / found.after[k]).sum())
            )
            if good and not taken[found.rows[k]].any():
                taken[found.rows[k]] = True
                chosen.append(k)
        work.next_sweep()
        if chosen:
            work.put(found.rows[chosen].ravel(), found.faces[chosen].reshape(-1, 4))
        run.tally.counts[Verdict.APPLIED] += len(chosen)
        run.tally.counts[Verdict.NOT_BETTER] += len(near) - len(chosen)
