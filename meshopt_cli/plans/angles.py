"""Stages in which the dihedral angles of tetrahedra count beside their quality."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..kernels.shape.angles import ANGLE_Q
from ..passes import Pass
from .stages import Outcome, Stage

# Angles may cost some of the worst Q as long as it stays within so many times the target.
# With 1.05 one mesh of four ends 0.06 lower in the worst Q and 2 degrees lower in the least angle;
# with 1.2 two end up to 0.12 higher, for less than half a degree.
NEAR_TARGET = 1.1
# By so much a q must be better than the least that is left, where the angles come first. 1.005 and
# 1.02 move the worst Q of one mesh of four by 0.02 and no angle.
MARGIN = 1.01
# Where the worst Q stays beyond so many times `ANGLE_Q`, no angle counts. With 1 one mesh of four
# loses 2 degrees; 4 changes none.
MOST_LENIENT = 2


@dataclass(frozen=True)
class WithAngles:
    """A stage in which no tet counts as better than its dihedral angles: see `Judge`.

    Attributes
    ----------
    lenient : bool
        Whether a Q near what the boundary allows, or no worse than the worst, is good enough, so
        that the angles come first. Where that is bad, they are bad anyhow, and nothing is done.
    """

    body: Stage
    lenient: bool = False

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        judge, bounds = outcome.work.mesh.judge, outcome.work.bounds
        good_enough = 1.0 / max(ANGLE_Q, NEAR_TARGET * bounds.target)
        least = min(outcome.work.standing().worst, good_enough)
        lenience = 1.0
        if self.lenient:
            if ANGLE_Q * least * MOST_LENIENT < 1.0:
                return
            lenience = max(1.0, int(100.0 / (ANGLE_Q * MARGIN * least)) / 100.0)
        start = outcome.work.copy()
        outcome.work.judge_by(judge._replace(lenience=lenience))
        outcome.work.bounds = replace(bounds, target=bounds.target / lenience)
        try:
            self.body.run(outcome, round)
        finally:
            outcome.work.judge_by(judge)
            outcome.work.visits = dict(start.visits)  # what changed here has a later clock
            outcome.work.bounds = bounds
            if outcome.work.standing().worst < least:
                outcome.work = start
