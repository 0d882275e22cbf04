"""Pipelines for meshes of any cells: relocation, and swaps where they lie in a plane."""

from __future__ import annotations

from ..passes.check import Check
from ..passes.smooth import GLOBAL, Smooth
from ..passes.swap import Swap
from ..passes.untangle import Untangle
from .stages import Chain, Repeat, Sequence, Stage
from .stop import Stop

# What a better mean may cost: nothing of the worst cell of all, and some of others.
_MEAN = Smooth(method="descent", accept="mean", least_quality=0.0, sweeps=2, order="index")
_LIFT = Smooth(method="optimize", sweeps=2)
_ALL = Smooth(method=GLOBAL)
# Of a mixed mesh of 52 cells the least scaled Jacobian is 0.75 with it and 0.65 without; where all
# vertices moved at once few cells are left to swap, and none of a grid.
_SWAP = Swap(worse_than=1.2)


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


def fast(stop: Stop) -> tuple[Stage, ...]:
    """Shapes evened out, and the worst cells lifted a few times."""
    return _audited(Sequence((Smooth(), _LIFT, _MEAN)), Repeat(Sequence((_LIFT, _MEAN)), stop))


def standard(stop: Stop) -> tuple[Stage, ...]:
    """All vertices at once, then turns of lifting the worst cells and of a better mean."""
    return _audited(Sequence((_ALL, _SWAP)), *(_turn(stop, near) for near in (2.0, 1.5, 1.1)))


def best(stop: Stop) -> tuple[Stage, ...]:
    """The same, for as long as it pays: on a sheared grid 0.66 instead of 0.53."""
    turn = Chain((_turn(stop, 1.5), _turn(stop, 1.1), Sequence((_ALL,))))
    everywhere = Repeat(Sequence((_ALL, _SWAP)), stop)
    return _audited(everywhere, _turn(stop, 2.0), Repeat(turn, stop), _turn(stop, 1.1))


def _turn(stop: Stop, near: float) -> Stage:
    """The worst cells up to some Q over the worst, and then the mean."""
    lift = Smooth(method="optimize", sweeps=3, near_worst=near)
    return Chain((Repeat(Sequence((lift,)), stop), Repeat(Sequence((_MEAN,)), stop)))
