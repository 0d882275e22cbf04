"""swap: other cells between the same vertices (18.4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels.accept import FLAT
from ..kernels.operators.flip import sweep_flip
from ..kernels.operators.swap import Swapping, sweep_swap
from ..kernels.types import Verdict
from ..work.kinds import FACES, SIMPLICES
from ..work.session import Workspace
from .apart import apart
from .base import Operator, option
from .run import Run, Work, faces_of

if TYPE_CHECKING:
    from ..work.face_work import FaceWork


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
            self._swap_faces(faces_of(work), run)
            return
        since = work.since((self, "shells"))
        how = Swapping(self.rule, self.least(work), self.pick == "best", since)
        sweep = sweep_swap if work.dimension == 3 else sweep_flip
        cells, quality = work.changed_cells(since, self.limit)
        order = self.ordered(work, cells, quality)
        run.visit(work, order, sweep, how, reach=Reach.SHELLS)

    def _swap_faces(self, work: FaceWork, run: Run) -> None:
        """Swap pairs of triangles and quads, the worst first, each face once."""
        from ..work.faces import best_of

        run.check()
        found, floor = best_of(work.swaps()), self.least(work)
        before, after = found.before.min(axis=1), found.after.min(axis=1)
        near = np.flatnonzero((before < self.limit) & (after > 0.0))
        near = self.ordered(work, near, before[near])
        means = (1.0 / found.before).sum(axis=1), (1.0 / np.maximum(found.after, FLAT)).sum(axis=1)
        good = [k for k in near.tolist()
                if self.takes(floor, before[k], after[k], (means[0][k], means[1][k]))]  # fmt: skip
        chosen = apart(good, lambda k: found.rows[k], work.n_cells)
        work.next_sweep()
        if len(chosen):
            work.put(found.rows[chosen].ravel(), found.faces[chosen].reshape(-1, 4))
        run.tally.note("swapped", found.kinds(chosen))
        run.tally.counts[Verdict.APPLIED] += len(chosen)
        run.tally.counts[Verdict.NOT_BETTER] += len(near) - len(chosen)
