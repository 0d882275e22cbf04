"""Pipelines for meshes of any cells: relocation, and other faces where they lie in a plane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..passes import Pass
from ..passes.check import Check
from ..passes.collapse import Collapse
from ..passes.relax import Relax
from ..passes.smooth import GLOBAL, Smooth, is_settled
from ..passes.swap import Swap
from ..passes.untangle import Untangle
from .stages import Chain, Change, Outcome, Repeat, Sequence, Stage, UpTo
from .stop import Stop

# What a better mean may cost: nothing of the worst cell of all, and some of others.
_MEAN = Smooth(method="descent", accept="mean", least_quality=0.0, sweeps=2, order="index")
_LIFT = Smooth(method="optimize", sweeps=2)
_ALL = Smooth(method=GLOBAL)
# Of a mixed mesh of 52 cells the least scaled Jacobian is 0.75 with it and 0.65 without; where all
# vertices moved at once few cells are left to swap, and none of a grid.
_SWAP = Swap(worse_than=1.2)

# Up to so many faces other ones are tried in standard: it takes up to three times as long.
_SMALL = 20_000
# Of 13 meshes six get better for other faces, the least scaled Jacobian of a sheared grid from 0.66
# to 0.72; the worst Q and the mean Q of none rise.
_RELAX = Relax(max_growth=1.5)
_COLLAPSE = Collapse(worse_than=1.2)


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


def fast(stop: Stop) -> tuple[Stage, ...]:
    """Shapes evened out, and the worst cells lifted a few times."""
    return _audited(Sequence((Smooth(), _LIFT, _MEAN)), Repeat(Sequence((_LIFT, _MEAN)), stop))


def standard(stop: Stop) -> tuple[Stage, ...]:
    """All vertices at once, then turns of lifting the worst cells and of a better mean."""
    turns = Chain(tuple(_turn(stop, near) for near in (2.0, 1.5, 1.1)))
    return _audited(
        Unsettled(Sequence((_ALL,))), Sequence((_SWAP,)), turns, UpTo(_SMALL, _other_ways(turns))
    )


def best(stop: Stop) -> tuple[Stage, ...]:
    """The same, for as long as it pays: on a sheared grid 0.66 instead of 0.53."""
    turn = Chain((_turn(stop, 1.5), _turn(stop, 1.1), Sequence((_ALL,))))
    everywhere = Repeat(Sequence((_ALL, _SWAP)), stop)
    usual = Chain((_turn(stop, 2.0), Repeat(turn, stop), _turn(stop, 1.1)))
    return _audited(everywhere, usual, _other_ways(Chain((everywhere, usual))))


def _other_ways(turns: Stage) -> Stage:
    """The same once more between other faces of a plane, where that is better."""
    return Trial(Sequence((_RELAX, _COLLAPSE, _SWAP)), Chain((Sequence((_ALL,)), turns)))


@dataclass(frozen=True)
class Unsettled:
    """A stage that is left out where untangling just moved all vertices at once."""

    body: Stage

    def passes(self) -> Iterator[Pass]:
        yield from self.body.passes()

    def mapped(self, change: Change) -> Unsettled:
        return Unsettled(self.body.mapped(change))

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

    def mapped(self, change: Change) -> Trial:
        return Trial(self.change.mapped(change), self.after.mapped(change))

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


def _turn(stop: Stop, near: float) -> Stage:
    """The worst cells up to some Q over the worst, and then the mean."""
    lift = Smooth(method="optimize", sweeps=3, near_worst=near)
    return Chain((Repeat(Sequence((lift,)), stop), Repeat(Sequence((_MEAN,)), stop)))
