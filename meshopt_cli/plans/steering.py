"""Stages that another measure than that of the run steers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..passes import Pass
from ..quality.measures import Measure
from .stages import Outcome, Stage


@dataclass(frozen=True)
class ByMeasure:
    """A stage in which cells are as good as another measure says; the run is judged by its own.

    What the boundary allows by that measure is not known.
    """

    measure: Measure
    body: Stage

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        judge, bounds, seen = outcome.work.mesh.judge, outcome.work.bounds, outcome.work.visits
        outcome.work.judge_by(judge._replace(code=self.measure.judge.code))
        outcome.work.bounds = replace(bounds, target=1.0)
        try:
            self.body.run(outcome, round)
        finally:
            outcome.work.judge_by(judge)
            outcome.work.visits = dict(seen)  # what changed here has a later clock
            outcome.work.bounds = bounds
