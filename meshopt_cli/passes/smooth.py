"""smooth: relocation of the vertices inside their balls (18.4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels.operators import relocate
from ..kernels.types import EDITION, Verdict
from ..work.kinds import CELLS, FACES, SIMPLICES
from .base import MOST_Q, Operator, option
from .run import Run, Work

METHODS = {
    "laplace": relocate.LAPLACE,
    "weighted": relocate.WEIGHTED,
    "quality": relocate.QUALITY,
    "optimize": relocate.OPTIMIZE,
    "descent": relocate.DESCENT,
}
# How far vertices go back at a time, and how often. A tenth of the way takes others along, and
# comes to no end.
PULL, MOST_PULLS = 0.02, 60
GLOBAL = "global"  # a method that has all vertices move at once
WEIGHTS = {
    "uniform": relocate.UNIFORM,
    "worst": relocate.WORST,
    "quality": relocate.DEGRADATION,
    "quality2": relocate.DEGRADATION2,
}
# Footnote 5: close to one in the plane, smaller in space.
RELAXATION = {2: 0.9, 3: 0.7}


@dataclass(frozen=True)
class Smooth(Operator):
    """Move internal vertices inside their balls."""

    name: ClassVar[str] = "smooth"
    summary: ClassVar[str] = "moves internal vertices inside their balls (18.4.1)"
    kernels: ClassVar[tuple[str, ...]] = ("relocation",)
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES, CELLS)

    method: str = option(
        "quality",
        "where a vertex goes: mean of its neighbours (laplace, 18.19), weighted by their distance "
        "(weighted, 18.23), mean of the ideal points (quality, 18.24), uphill on the worst "
        "quality of the ball (optimize, Remark 18.12), or downhill on the sum of the Q² of the "
        "ball (descent), or all vertices at once where no cell is folded over and the worst is "
        "best (global)",
        choices=(*METHODS, GLOBAL),
    )
    weight: str = option("quality", "weights of the ideal points (18.24)", choices=tuple(WEIGHTS))
    relaxation: float = option(
        0.0, "part of the way to go at first (18.22); 0: 0.9 in the plane, 0.7 in space",
        least=0.0, most=1.0,
    )  # fmt: skip
    sweeps: int = option(
        3, "sweeps over the mesh in one run, fewer when nothing moves", least=1, most=1000
    )
    near_worst: float = option(
        0.0, "visit only where the worst Q is above that of the mesh over this; 0: everywhere",
        least=0.0, most=MOST_Q,
    )  # fmt: skip

    def needed_kernels(self) -> tuple[str, ...]:
        return (GLOBAL,) if self.method == GLOBAL else self.kernels

    def sweep(self, work: Work, run: Run) -> None:
        if self.method == GLOBAL:
            smooth_all(work, run)
            return
        for _ in range(self.sweeps):
            limit = self.limit
            if self.near_worst:
                limit = min(limit, self.near_worst * work.standing().worst)
            how = relocate.Relocation(
                METHODS[self.method],
                WEIGHTS[self.weight],
                self.relaxation or RELAXATION[work.dimension],
                self.rule,
                self.least(work),
                limit,
            )
            vertices, worst = work.changed_vertices(work.since((self, "balls")), limit)
            order = self.ordered(work, vertices, worst)
            applied = run.tally.applied
            run.visit(work, order, work.relocation, how, reach=Reach.BALLS)
            if run.tally.applied == applied:
                break


def smooth_all(work: Work, run: Run) -> None:
    """Move all vertices at once, if the mesh is better for it.

    Where cells come to be a little worse than the worst one was, their vertices go back until they
    are not.
    """
    run.check()
    points, before = work.places, work.standing()
    goal = work.smoothed(lambda: run.is_over)
    n_free = int(np.count_nonzero(~work.mesh.fixed))
    for _ in range(MOST_PULLS):
        work.move(goal.astype(np.float32).astype(np.float64) if work.mesh.single else goal)
        if work.standing().worst >= before.worst:
            break
        back = work.movable(work.worse_cells(before.worst))
        goal[back] += PULL * (points[back] - goal[back])
    if work.standing().is_better_than(before):
        run.tally.counts[Verdict.APPLIED] += n_free
    else:
        work.move(points)
        run.tally.counts[Verdict.NOT_BETTER] += n_free
    work.visits[GLOBAL] = int(work.mesh.state[EDITION])


def is_settled(work: Work) -> bool:
    """Whether nothing changed since all vertices moved at once."""
    return bool(work.visits.get(GLOBAL) == work.mesh.state[EDITION])
