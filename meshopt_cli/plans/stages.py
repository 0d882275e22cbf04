"""Parts of a pipeline: passes in order, stages in order, and rounds.

`Sequence` runs passes one after the other, `Chain` stages; `Repeat` runs a stage in rounds and
mostly ends on the best mesh it saw.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

from ..passes import UNLIMITED, Budget, Pass, Tally, Work
from ..passes.smooth import is_settled
from ..progress.observer import SILENT, Observer
from ..work.standing import Standing
from .guard import Guard
from .stop import DONE, ROUNDS_DONE, Stop

log = logging.getLogger("meshopt")


@dataclass(frozen=True)
class Line:
    """What a pass did in a round, and how the mesh stood after it."""

    round: int
    tally: Tally
    standing: Standing


@dataclass
class Outcome:
    """The mesh of a run, what every pass did, which were left out, and why it ended.

    `is_untouched` tells that nothing of the mesh is other than it was.
    """

    work: Work
    observer: Observer = SILENT
    budget: Budget = UNLIMITED
    lines: list[Line] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)  # passes that are not for such a mesh
    stopped: str = DONE
    is_untouched: bool = False


class Stage(Protocol):
    """A part of a pipeline: changes `outcome.work` and adds to its lines."""

    def run(self, outcome: Outcome, round: int = 0) -> None: ...

    def passes(self) -> Iterator[Pass]: ...


@dataclass(frozen=True)
class Sequence:
    """Passes, one after the other, once."""

    steps: tuple[Pass, ...]

    def passes(self) -> Iterator[Pass]:
        yield from self.steps

    def run(self, outcome: Outcome, round: int = 0) -> None:
        for step in self.steps:
            if outcome.work.kind not in step.works_on:
                if step.name not in outcome.left_out:
                    outcome.left_out.append(step.name)
                continue
            tally = step.run(outcome.work, outcome.observer, outcome.budget)
            standing = outcome.work.judged()
            log.debug(
                "round %d: %s: %d of %d in %.3f s, worst q %.4g, mean Q %.4g", round, tally.name,
                tally.applied, tally.visited, tally.seconds, standing.worst, standing.mean,
            )  # fmt: skip
            outcome.lines.append(Line(round, tally, standing))
            outcome.observer.stood(standing, round)


@dataclass(frozen=True)
class Chain:
    """Stages, one after the other."""

    stages: tuple[Stage, ...]

    def passes(self) -> Iterator[Pass]:
        for stage in self.stages:
            yield from stage.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        for stage in self.stages:
            stage.run(outcome, round)


@dataclass(frozen=True)
class UpTo:
    """A stage for meshes of so many cells at most: larger ones go without."""

    most_cells: int
    body: Stage

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        if outcome.work.n_cells <= self.most_cells:
            self.body.run(outcome, round)


@dataclass(frozen=True)
class Repeat:
    """A stage in rounds, until a criterion is met.

    Attributes
    ----------
    guarded : bool
        Whether it ends on the best mesh it saw, rather than on the last: for a stage that does
        harm which others after it make good. Cut short, it ends on the best in any case.
    """

    body: Stage
    stop: Stop
    guarded: bool = True

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        guard = Guard(outcome.work)
        outcome.stopped = self.stop.at_first(guard.best)
        after = guard.best
        is_whole = False
        try:
            while not outcome.stopped:
                round += 1
                before = after
                guard.keep(outcome.work)
                n_lines = len(outcome.lines)
                try:
                    self.body.run(outcome, round)
                finally:
                    after = guard.note(outcome.work)
                changed = any(line.tally.applied for line in outcome.lines[n_lines:])
                reason = self.stop.reason(round, changed, before, after)
                # Rounds of rounds are a matter of the preset: why the last of them ended tells
                # more.
                outcome.stopped = (outcome.stopped or reason) if reason == ROUNDS_DONE else reason
            is_whole = True
        finally:
            if self.guarded or not is_whole:
                outcome.work = guard.better_of(outcome.work)


@dataclass(frozen=True)
class Unsettled:
    """A stage that is left out where untangling just moved all vertices at once."""

    body: Stage

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        if not is_settled(outcome.work):
            self.body.run(outcome, round)


@dataclass(frozen=True)
class Trial:
    """Other cells and what is made of them; what was there comes back unless nothing got worse.

    Attributes
    ----------
    change, after : Stage
        The second runs only where the first leaves other cells.
    """

    change: Stage
    after: Stage

    def passes(self) -> Iterator[Pass]:
        yield from self.change.passes()
        yield from self.after.passes()

    def run(self, outcome: Outcome, round: int = 0) -> None:
        kept, stopped = outcome.work.copy(), outcome.stopped
        before, keeps = kept.standing(), False
        try:
            self.change.run(outcome, round)
            if outcome.work.mesh.cells is kept.mesh.cells:
                return
            self.after.run(outcome, round)
            now = outcome.work.standing()
            keeps = now.is_better_than(before) and now.mean <= before.mean
        finally:
            if not keeps:
                outcome.work, outcome.stopped = kept, stopped
