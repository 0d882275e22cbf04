"""A pipeline: stages in order, on a mesh that never comes out worse than it went in (18.5)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from ..cells import FAMILIES
from ..errors import ConfigError
from ..kernels.types import EDITION
from ..passes import Budget, Pass, Work
from ..passes.check import Check
from ..passes.confine import Confine
from ..passes.repair import Repair
from ..progress.observer import SILENT, CancelledError, Observer, StoppedError
from ..quality.measures import Measure
from .stages import Outcome, Sequence, Stage
from .stop import CANCELLED, NOTHING_TO_GAIN, TANGLED, TIME_IS_UP, gain

# A run that gains less than this part of the quality hands its input back untouched, so that
# a mesh once optimized stays as it is: another order of visits may gain as much. Of 48 second runs
# 30 would change their mesh at 0, five at 0.025, one at 0.04.
LEAST_GAIN = 0.04


@dataclass(frozen=True)
class Pipeline:
    """A named list of stages.

    Attributes
    ----------
    time_limit : float
        Seconds from the start of the run.
    threads : int or None
        How many work at once on a large mesh, with the same result for any number; None: as many
        as this process may use processors.
    repairs : tuple of Repair
        What is to be mended of a mesh before it is worked on; `run` has no part in it.
    measures : tuple of Measure
        What steers stages of it, besides the measure of the run.
    least_gain : float
        See `LEAST_GAIN`.
    """

    name: str
    stages: tuple[Stage, ...]
    time_limit: float = float("inf")
    repairs: tuple[Repair, ...] = ()
    measures: tuple[Measure, ...] = ()
    threads: int | None = None
    least_gain: float = LEAST_GAIN

    def require_measures(self, measure: Measure, families: Iterable[str]) -> None:
        """Refuse cells of families that the measure of a run, or of a stage, is not for.

        Raises
        ------
        ConfigError
        """
        for one in (measure, *self.measures):
            lacking = [FAMILIES[family].plural for family in families if family not in one.ways]
            if lacking:
                raise ConfigError(f"measure {one.name} cannot steer {' and '.join(lacking)}")

    def passes(self) -> Iterator[Pass]:
        yield from self.repairs
        for stage in self.stages:
            yield from stage.passes()

    @property
    def needs_metric(self) -> bool:
        """Whether some pass of it fits edges to a metric."""
        return any(step.needs_metric for step in self.passes())

    @property
    def mends_tangles(self) -> bool:
        """Whether it may be given a mesh with inverted cells."""
        return any(step.mends_tangles for step in self.passes())

    def confined(self) -> Pipeline:
        """The same pipeline for a mesh whose vertices were told where to stay."""
        confine = Sequence((Confine(),))
        return replace(self, stages=(confine, *self.stages, confine))

    def run(self, work: Work, observer: Observer = SILENT) -> Outcome:
        """Optimize a mesh in place of a copy of it.

        Returns
        -------
        outcome : Outcome
            Its mesh is never worse than `work` was: worst Q first, then what passes count that
            have an aim of their own, then mean Q.

        Raises
        ------
        InvariantError
            An operator broke the mesh.
        """
        steps = tuple(dict.fromkeys(self.passes()))
        work.aim_at(tuple(step.left for step in steps), self.needs_metric)
        outcome = Outcome(work, observer, Budget.of(self.time_limit, self.threads))
        untouched, before = work.copy(), work.standing()
        edition = int(work.mesh.state[EDITION])
        outcome.observer.stood(before)
        del work  # held by the outcome, until that goes back to a copy
        try:
            is_mended = not self.mends_tangles
            for stage in self.stages:
                stage.run(outcome)
                is_mended |= any(step.mends_tangles for step in stage.passes())
                if is_mended and outcome.work.standing().worst <= 0.0:
                    break  # nothing but untangling helps
        except StoppedError as why:
            outcome.stopped = CANCELLED if isinstance(why, CancelledError) else TIME_IS_UP
        after = outcome.work.standing()
        if before.is_better_than(after) or gain(before, after) < self.least_gain:
            outcome.work = untouched
            if outcome.stopped not in (TIME_IS_UP, CANCELLED):
                outcome.stopped = NOTHING_TO_GAIN
        if outcome.work.standing().worst <= 0.0:
            outcome.stopped = TANGLED
        Check(inverted="allowed").run(outcome.work)
        outcome.is_untouched = int(outcome.work.mesh.state[EDITION]) == edition
        return outcome
