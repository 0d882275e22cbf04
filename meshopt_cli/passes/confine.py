"""confine: vertices go where they were told to stay (topologically driven, 18.4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels.accept import FLOOR, STRICT
from ..kernels.operators import relocate
from ..work.kinds import CELLS, FACES, SIMPLICES
from .base import Pass, option
from .run import Run, Work


@dataclass(frozen=True)
class Confine(Pass):
    """Move vertices into the half-spaces that they were told to stay in, or toward them."""

    name: ClassVar[str] = "confine"
    summary: ClassVar[str] = (
        "moves vertices to where they were told to stay, such as off a plane, while no cell comes "
        "to be worse than the worst (18.4.1); without such vertices there is nothing to do"
    )
    kernels: ClassVar[tuple[str, ...]] = ("relocation",)
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES, CELLS)

    least_quality: float = option(
        0.0, "least quality 1/Q that cells may come to have; never below that of the worst",
        least=0.0, most=1.0,
    )  # fmt: skip
    sweeps: int = option(
        10, "sweeps over these vertices, and of smoothing around them, in one run, fewer when "
        "nothing moves", least=1, most=1000,
    )  # fmt: skip

    def left(self, work: Work) -> int:
        """Number of vertices that are where they were told not to be."""
        return len(work.outside())

    def sweep(self, work: Work, run: Run) -> None:
        for _ in range(self.sweeps):
            vertices = work.outside()
            applied = run.tally.applied
            if not len(vertices):
                return
            work.next_sweep()
            floor = max(self.least_quality, work.worst_of_all)
            how = relocate.Relocation(relocate.LIMITS, relocate.UNIFORM, 1.0, FLOOR, floor, np.inf)
            run.visit(work, vertices, work.relocation, how, reach=Reach.BALLS)
            if not self.left(work):
                return
            # What is around makes way where it is better for it.
            around = work.movable(work.rings_around(work.cells_at(vertices), 1))
            how = how._replace(method=relocate.OPTIMIZE, rule=STRICT)
            run.visit(work, around, work.relocation, how, reach=Reach.BALLS)
            if run.tally.applied == applied:
                return
