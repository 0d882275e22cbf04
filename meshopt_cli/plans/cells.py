"""Pipelines for meshes of any cells, whose connectivity stays: relocation, and nothing else."""

from __future__ import annotations

from ..passes.check import Check
from ..passes.smooth import GLOBAL, Smooth
from ..passes.untangle import Untangle
from .stages import Chain, Repeat, Sequence, Stage
from .stop import Stop

# What a better mean may cost: nothing of the worst cell of all, and some of others.
_MEAN = Smooth(method="descent", accept="mean", least_quality=0.0, sweeps=2, order="index")
_LIFT = Smooth(method="optimize", sweeps=2)
_ALL = Smooth(method=GLOBAL)


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


def fast(stop: Stop) -> tuple[Stage, ...]:
    """Shapes evened out, and the worst cells lifted a few times."""
    return _audited(Sequence((Smooth(), _LIFT, _MEAN)), Repeat(Sequence((_LIFT, _MEAN)), stop))


def standard(stop: Stop) -> tuple[Stage, ...]:
    """All vertices at once, then turns of lifting the worst cells and of a better mean."""
    return _audited(Sequence((_ALL,)), _turn(stop, 2.0), _turn(stop, 1.5), _turn(stop, 1.1))


def best(stop: Stop) -> tuple[Stage, ...]:
    """The same, for as long as it pays."""
    turn = Chain((_turn(stop, 1.5), _turn(stop, 1.1), Sequence((_ALL,))))
    return _audited(Sequence((_ALL,)), _turn(stop, 2.0), Repeat(turn, stop), _turn(stop, 1.1))


def _turn(stop: Stop, near: float) -> Stage:
    lift = Smooth(method="optimize", sweeps=3, near_worst=near)
    return Chain((Repeat(Sequence((lift,)), stop), Repeat(Sequence((_MEAN,)), stop)))
