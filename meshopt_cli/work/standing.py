"""How good a mesh is, as one thing to compare."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

Array = np.ndarray

# Weight of the tail beside the mean: with 0.03 what makes bad cells better is given up.
TAIL = 0.1


@dataclass(frozen=True)
class Standing:
    """How good a mesh is: the worst q decides, then what is left to do, then the mean Q.

    Before all that, once no cell is flat or inverted, comes what edges lack of length 1.

    Attributes
    ----------
    tail : float
        Mean Q of the worst hundredth of the cells: it shows progress that neither the worst cell
        nor the mean of all does.
    left : int
        What passes that have another aim than quality leave to do: see `Workspace.aim_at`.
    lack : float
        1 - tau (18.12), the mean of it over the cells; 0 where no pass fits edges to a metric.
    """

    worst: float
    mean: float
    tail: float
    left: int = 0
    lack: float = 0.0

    def is_better_than(self, other: Standing) -> bool:
        """Whether this is a real gain, rounding noise left aside."""
        if min(self.worst, other.worst) > 0.0 and abs(self.lack - other.lack) > 1e-9:
            return self.lack < other.lack
        if abs(self.worst - other.worst) > 1e-9:
            return self.worst > other.worst
        if self.left != other.left:
            return self.left < other.left
        return self.mean < other.mean - 1e-9

    @property
    def cost(self) -> float:
        """What tells meshes apart that have hardly another worst q: their mean, and some tail."""
        return self.mean + TAIL * self.tail


def standing_of(q: Array, left: int = 0, lack: float = 0.0) -> Standing:
    """The standing of cells with these q, (n,) float64, what is left to do, and edges lack."""
    worst = float(q.min())
    if worst <= 0.0:
        return Standing(worst, math.inf, math.inf, left, lack)
    n_tail = max(len(q) // 100, min(len(q), 10))
    tail = np.partition(q, n_tail - 1)[:n_tail]
    with np.errstate(over="ignore"):
        return Standing(worst, float(np.mean(1.0 / q)), float(np.mean(1.0 / tail)), left, lack)
