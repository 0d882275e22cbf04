"""smooth: relocation of the vertices inside their balls (18.4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..kernels.operators import relocate
from ..work.session import Workspace
from .base import Operator, option
from .run import Run

METHODS = {
    "laplace": relocate.LAPLACE,
    "weighted": relocate.WEIGHTED,
    "quality": relocate.QUALITY,
    "optimize": relocate.OPTIMIZE,
    "descent": relocate.DESCENT,
}
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

    method: str = option(
        "quality",
        "where a vertex goes: mean of its neighbours (laplace, 18.19), weighted by their distance "
        "(weighted, 18.23), mean of the ideal points (quality, 18.24), uphill on the worst "
        "quality of the ball (optimize, Remark 18.12), or downhill on the sum of the Q² of the "
        "ball (descent)",
        choices=tuple(METHODS),
    )
    weight: str = option("quality", "weights of the ideal points (18.24)", choices=tuple(WEIGHTS))
    relaxation: float = option(
        0.0, "part of the way to go at first (18.22); 0: 0.9 in the plane, 0.7 in space",
        least=0.0, most=1.0,
    )  # fmt: skip
    sweeps: int = option(
        3, "sweeps over the mesh in one run, fewer when nothing moves", least=1, most=1000
    )

    def sweep(self, work: Workspace, run: Run) -> None:
        how = relocate.Relocation(
            METHODS[self.method],
            WEIGHTS[self.weight],
            self.relaxation or RELAXATION[work.dimension],
            self.rule,
            self.least(work),
            self.limit,
        )
        for _ in range(self.sweeps):
            vertices, worst = work.changed_vertices(work.since((self, "balls")), self.limit)
            order = self.ordered(work, vertices, worst)
            applied = run.tally.applied
            run.visit(work, order, relocate.sweep_relocation, how)
            if run.tally.applied == applied:
                break
