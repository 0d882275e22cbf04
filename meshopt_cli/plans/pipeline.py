"""Passes in order and in rounds, until there is nothing more to gain (18.5).

`Sequence` runs passes one after the other, `Chain` stages; `Repeat` runs one in rounds and keeps
the best mesh it saw. The mesh that comes out is never worse than the one that went in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

from ..kernels.shape.angles import ANGLE_Q
from ..passes import SILENT, UNLIMITED, Budget, Observer, OutOfTimeError, Pass, Tally
from ..passes.check import Check
from ..work.workspace import Standing, Workspace

NOTHING_TO_GAIN = "nothing to gain"
NO_CHANGE = "no change"
GAIN_BELOW = "gain below"
TARGET_REACHED = "target quality"
ROUNDS_DONE = "rounds"
TIME_IS_UP = "time limit"
TANGLED = "tangled"

# A run that gains less than this part of the quality hands its input back untouched, so that
# a mesh once optimized stays as it is: another order of visits may gain as much.
LEAST_GAIN = 0.02
DONE = "done"

# Angles may cost some of the worst Q as long as it stays within so many times the target.
NEAR_TARGET = 1.1
# By so much a q must be better than the least that is left, where the angles come first.
MARGIN = 1.01
# Where the worst Q stays beyond so many times `ANGLE_Q`, no angle counts.
MOST_LENIENT = 2


@dataclass(frozen=True)
class Stop:
    """When rounds end.

    Attributes
    ----------
    rounds : int
        At most so many rounds.
    gain : float
        End when a round lowers neither the worst Q, nor the mean Q, nor the mean Q of the
        worst hundredth of the cells by this part of it.
    target_quality : float
        End when the worst Q is at most this; 1 never ends.
    """

    rounds: int = 10
    gain: float = 1e-3
    target_quality: float = 1.0


@dataclass(frozen=True)
class Line:
    """What a pass did in a round, and how the mesh stood after it."""

    round: int
    tally: Tally
    standing: Standing


@dataclass
class Outcome:
    """The mesh of a run, what every pass did, and why it ended."""

    work: Workspace
    observer: Observer = SILENT
    budget: Budget = UNLIMITED
    lines: list[Line] = field(default_factory=list)
    stopped: str = DONE


# What is made of a pass.
Change = Callable[[Pass], Pass]


class Stage(Protocol):
    """A part of a pipeline: changes `outcome.work` and adds to its lines."""

    def run(self, outcome: Outcome, round: int = 0) -> None: ...

    def passes(self) -> Iterator[Pass]: ...

    def mapped(self, change: Change) -> Stage:
        """The same stage with other passes in the place of its own."""


@dataclass(frozen=True)
class Sequence:
    """Passes, one after the other, once."""

    steps: tuple[Pass, ...]

    def passes(self) -> Iterator[Pass]:
        yield from self.steps

    def mapped(self, change: Change) -> Sequence:
        return Sequence(tuple(change(step) for step in self.steps))

    def run(self, outcome: Outcome, round: int = 0) -> None:
        for step in self.steps:
            tally = step.run(outcome.work, outcome.observer, outcome.budget)
            outcome.lines.append(Line(round, tally, outcome.work.judged()))


@dataclass(frozen=True)
class Chain:
    """Stages, one after the other."""

    stages: tuple[Stage, ...]

    def passes(self) -> Iterator[Pass]:
        for stage in self.stages:
            yield from stage.passes()

    def mapped(self, change: Change) -> Chain:
        return Chain(tuple(stage.mapped(change) for stage in self.stages))

    def run(self, outcome: Outcome, round: int = 0) -> None:
        for stage in self.stages:
            stage.run(outcome, round)


@dataclass(frozen=True)
class Repeat:
    """A stage in rounds, until a criterion is met; it ends on the best mesh it saw."""

    body: Stage
    stop: Stop

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def mapped(self, change: Change) -> Repeat:
        return replace(self, body=self.body.mapped(change))

    def run(self, outcome: Outcome, round: int = 0) -> None:
        guard = Guard(outcome)
        outcome.stopped = self._first_reason(guard.best)
        after = guard.best
        while not outcome.stopped:
            round += 1
            before = after
            n_lines = len(outcome.lines)
            try:
                self.body.run(outcome, round)
            finally:
                after = guard.note()
            changed = any(line.tally.applied for line in outcome.lines[n_lines:])
            reason = self._reason(round, changed, before, after)
            # Rounds of rounds are a matter of the preset: why the last of them ended tells more.
            outcome.stopped = (outcome.stopped or reason) if reason == ROUNDS_DONE else reason
        guard.restore()

    def _first_reason(self, standing: Standing) -> str:
        return TARGET_REACHED if self._is_target(standing) else ""

    def _reason(self, round: int, changed: bool, before: Standing, after: Standing) -> str:
        """Why the rounds end here; empty while they go on."""
        if not changed:
            return NO_CHANGE
        if self._is_target(after):
            return TARGET_REACHED
        if gain(before, after) < self.stop.gain:
            return GAIN_BELOW
        return ROUNDS_DONE if round >= self.stop.rounds else ""

    def _is_target(self, standing: Standing) -> bool:
        return self.stop.target_quality > 1.0 and standing.worst * self.stop.target_quality >= 1.0


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

    def mapped(self, change: Change) -> WithAngles:
        return replace(self, body=self.body.mapped(change))

    def run(self, outcome: Outcome, round: int = 0) -> None:
        judge, target = outcome.work.judge, outcome.work.target
        least = min(outcome.work.standing().worst, 1.0 / max(ANGLE_Q, NEAR_TARGET * target))
        lenience = 1.0
        if self.lenient:
            if ANGLE_Q * least * MOST_LENIENT < 1.0:
                return
            lenience = max(1.0, int(100.0 / (ANGLE_Q * MARGIN * least)) / 100.0)
        start = outcome.work.copy()
        outcome.work.judge_by(judge._replace(lenience=lenience))
        outcome.work.target = target / lenience
        try:
            self.body.run(outcome, round)
        finally:
            outcome.work.judge_by(judge)
            outcome.work.visits = dict(start.visits)  # what changed here has a later clock
            outcome.work.target = target
            if outcome.work.standing().worst < least:
                outcome.work = start


class Guard:
    """Remembers the best state of a run, so that it can be gone back to."""

    def __init__(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self.best = outcome.work.standing()
        self._kept = outcome.work.copy()

    def note(self) -> Standing:
        """Keep the present state unless it is worse than the best; returns how good it is."""
        now = self._outcome.work.standing()
        if not self.best.is_better_than(now):
            self.best = now
            del self._kept  # never both of them at once
            self._kept = self._outcome.work.copy()
        return now

    def restore(self) -> None:
        """Go back to the best state if the present one is worse."""
        if self.best.is_better_than(self._outcome.work.standing()):
            self._outcome.work = self._kept


def gain(before: Standing, after: Standing) -> float:
    """The largest of what the worst Q, the mean Q and its tail lost, each as a part of itself."""
    if after.worst <= 0.0 or before.worst <= 0.0:
        return float("inf") if after.worst > before.worst else 0.0
    return max(
        1.0 - before.worst / after.worst,
        1.0 - after.mean / before.mean,
        1.0 - after.tail / before.tail,
    )


@dataclass(frozen=True)
class Pipeline:
    """A named list of stages.

    Attributes
    ----------
    time_limit : float
        Seconds from the start of the run.
    """

    name: str
    stages: tuple[Stage, ...]
    time_limit: float = float("inf")

    def passes(self) -> Iterator[Pass]:
        for stage in self.stages:
            yield from stage.passes()

    @property
    def mends_tangles(self) -> bool:
        """Whether it may be given a mesh with inverted cells."""
        return any(step.mends_tangles for step in self.passes())

    def mapped(self, change: Change) -> Pipeline:
        """The same pipeline with other passes in the place of its own."""
        return replace(self, stages=tuple(stage.mapped(change) for stage in self.stages))

    def run(self, work: Workspace, observer: Observer | None = None) -> Outcome:
        """Optimize a mesh in place of a copy of it.

        Returns
        -------
        outcome : Outcome
            Its mesh is never worse than `work` was: worst Q first, then mean Q.

        Raises
        ------
        InvariantError
            An operator broke the mesh.
        """
        outcome = Outcome(work, observer or SILENT, Budget.of(self.time_limit))
        untouched, before = work.copy(), work.standing()
        try:
            for stage in self.stages:
                stage.run(outcome)
                if outcome.work.standing().worst <= 0.0:
                    break  # nothing but untangling helps, and it comes first
        except OutOfTimeError:
            outcome.stopped = TIME_IS_UP
        after = outcome.work.standing()
        reason = TANGLED if after.worst <= 0.0 else outcome.stopped
        if before.is_better_than(after) or gain(before, after) < LEAST_GAIN:
            outcome.work = untouched
            reason = TANGLED if before.worst <= 0.0 else NOTHING_TO_GAIN
        if outcome.stopped != TIME_IS_UP:
            outcome.stopped = reason
        Check(inverted="allowed").run(outcome.work)
        return outcome
