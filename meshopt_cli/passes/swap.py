"""swap: other cells between the same vertices (18.4.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..kernels.operators.flip import sweep_flip
from ..kernels.operators.swap import Swapping, sweep_swap
from ..work.session import Workspace
from .base import Operator, option
from .run import Run


@dataclass(frozen=True)
class Swap(Operator):
    """Flip edges of triangles; swap faces and edges of tetrahedra."""

    name: ClassVar[str] = "swap"
    summary: ClassVar[str] = "flips edges in the plane, swaps faces and edges in space (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("swap",)

    pick: str = option(
        "first", "which of the accepted swaps of a cell is applied", choices=("first", "best")
    )

    def sweep(self, work: Workspace, run: Run) -> None:
        since = work.since((self, "shells"))
        how = Swapping(self.rule, self.least(work), self.pick == "best", since)
        sweep = sweep_swap if work.dimension == 3 else sweep_flip
        cells, quality = work.changed_cells(since, self.limit)
        order = self.ordered(work, cells, quality)
        run.visit(work, order, sweep, how)
