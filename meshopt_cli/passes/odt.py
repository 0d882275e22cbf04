"""odt: relocation and swaps toward an optimal Delaunay triangulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels import accept as rules
from ..kernels.operators.flip import sweep_delaunay
from ..kernels.operators.odt import Pull, sizes_at, smooth_values, sweep_pull
from ..kernels.operators.swap import Swapping, sweep_swap
from ..work.session import Workspace
from .base import Operator, bad_enough, option
from .run import Run

Array = np.ndarray

# How often the sizes are smoothed. In the plane 5 and 20 cost up to 0.002 of the mean and 3 % of
# Q_T on graded meshes, 30 and no smoothing more.
N_SMOOTHINGS = 10
TINY = np.finfo(float).tiny  # stands for sizes too small to have a logarithm
EVER = -1  # before the clock of the first sweep


def densities(work: Workspace) -> Array:
    """The density that keeps the sizes of the cells as they are, (np,) float64."""
    sizes, totals, weights = np.zeros((3, len(work.mesh.points)))
    sizes_at(work.mesh, sizes, totals, weights)
    # By a power of two: a mesh and its double have the same densities.
    _, unit = np.frexp(np.max(sizes))
    logs = np.log(np.maximum(np.ldexp(sizes, -unit), TINY))
    for _ in range(N_SMOOTHINGS):
        smooth_values(work.mesh, logs, totals, weights)
    power = 1.0 + 1.0 / work.dimension
    with np.errstate(over="ignore"):  # a vertex that has no density worth the name stays
        return np.exp(-power * (logs - np.mean(logs[work.mesh.vertex_cell >= 0])))


@dataclass(frozen=True)
class Odt(Operator):
    """Move vertices to the mean of the circumcentres around them, and swap, in turns."""

    name: ClassVar[str] = "odt"
    summary: ClassVar[str] = (
        "moves vertices to the circumcentres around them, with flips to Delaunay in the plane and "
        "swaps for the mean Q in space; sizes stay (optimal Delaunay triangulation)"
    )
    kernels: ClassVar[tuple[str, ...]] = ("odt", "swap")

    swap_worse_than: float = bad_enough(1.0, "cells with swaps whose Q is above")
    accept: str = option(
        "floor", "as in smooth; here quality may fall for what is around", choices=("floor",
        "strict"),
    )  # fmt: skip
    least_quality: float = option(
        0.3, "least quality 1/Q of a patch; one that is worse may not get worse still",
        least=0.0, most=1.0,
    )  # fmt: skip
    order: str = option("index", "order of the visits", choices=("index", "worst-first", "random"))
    relaxation: float = option(
        1.9, "part of the way to the mean of the circumcentres to go at first", least=0.0, most=2.0
    )
    sweeps: int = option(
        15, "relocations of all vertices, with swaps after each", least=1, most=1000
    )

    def sweep(self, work: Workspace, run: Run) -> None:
        density = densities(work)
        how = Pull(self.relaxation, self.rule, self.least_quality)
        vertices, worst = work.changed_vertices(EVER, self.limit)
        for _ in range(self.sweeps):
            work.next_sweep()
            order = self.ordered(work, vertices, worst)
            run.visit(work, order, sweep_pull, how, density, reach=Reach.BALLS)
            self._swap(work, run)

    def _swap(self, work: Workspace, run: Run) -> None:
        in_plane = work.dimension == 2
        rule = self.rule if in_plane else rules.MEAN
        how = Swapping(rule, self.least_quality, pick_best=False, since=EVER)
        limit = min(self.limit, 1.0 / self.swap_worse_than)
        order = self.ordered(work, *work.changed_cells(EVER, limit))
        sweep = sweep_delaunay if in_plane else sweep_swap
        run.visit(work, order, sweep, how, reach=Reach.SHELLS)
