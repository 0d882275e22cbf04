"""Named pipelines.

All of them relocate before they change the connectivity: where that is good already, nothing
beats relocation alone, and where it is not, little is lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .errors import ConfigError
from .kernels.measures import ANGLE_Q
from .passes import PASSES, Pass
from .passes.check import Check
from .passes.collapse import Collapse
from .passes.mend import Mend
from .passes.smooth import Smooth
from .passes.split import Split
from .passes.swap import Swap
from .passes.untangle import Untangle
from .pipeline import Repeat, Sequence, Stage, Stop, WithAngles

DEFAULT_PRESET = "standard"


@dataclass(frozen=True)
class Preset:
    """A pipeline by name; `build` makes it anew, for stop criteria and a dimension."""

    name: str
    summary: str
    stop: Stop
    build: Callable[[Stop, int], tuple[Stage, ...]]


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    """The stages between two checks, of which the first leaves inverted cells to be untangled."""
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


# Relocation alone goes on while it gains this part of the quality.
_SETTLED = Stop(rounds=15, gain=0.08)

import os
_POLISHED = Stop(rounds=10, gain=float(os.environ.get('PGAIN','.03')))

# Worst Q of the places that are worth a visit: a regular triangulation of the plane is all 1, one
# of space is not, so that in space there is nothing to win at Q = 1.5.
_SWAP = {2: 1.2, 3: 1.8}
_SMOOTH = {2: 1.1, 3: 1.6}
# What `best` goes on for, and how many vertices it may have for it, over those of the input.
_GROWTH = 2.0
_BAR = {2: 1.5, 3: ANGLE_Q}
_SPLIT = {2: 1.8, 3: 2.0}


def _settle() -> Repeat:
    """Relocation alone, for as long as it pays."""
    return Repeat(Sequence((Smooth(sweeps=2),)), _SETTLED)


def _rounds(stop: Stop, swap_below: float, smooth_below: float, split_below: float) -> list[Repeat]:
    """Swap, relocate and lift the worst balls; remove vertices, and add some, where that fails.

    New vertices come last, so that there are few of them.
    """

    def steps(change: Pass) -> Sequence:
        swap = Swap(below=swap_below, pick="best")
        smooth = Smooth(below=smooth_below, sweeps=2)
        return Sequence(
            (swap, smooth, change, Smooth(method="optimize", below=swap_below, sweeps=1))
        )

    return [Repeat(steps(Collapse()), stop), Repeat(steps(Split(below=split_below)), stop)]


def _polish(worst: float) -> Repeat:
    """A better mean, where no cell is worse than `worst` for it."""
    floor = 1.0 / worst
    return Repeat(
        Sequence(
            (
                Collapse(accept="mean", floor=floor, below=worst, min_vertices=0.6),
                Swap(accept="mean", floor=floor, below=float(os.environ.get("PSW","1.5"))),
                Smooth(accept="mean", floor=floor, sweeps=2),
            )
        ),
        _POLISHED,
    )


def _fast(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    swap = Swap(below=_SWAP[dimension], pick="best")
    smooth = Smooth(below=_SMOOTH[dimension], sweeps=2)
    return _audited(Sequence((Smooth(),)), Repeat(Sequence((swap, smooth)), stop))


def _standard(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    swap, smooth = _SWAP[dimension], _SMOOTH[dimension]
    import os
    a,b=_rounds(stop, swap, smooth, _SPLIT[dimension])
    if os.environ.get('MID'): return _audited(_settle(), a, _polish(2.0), b, _polish(2.0))
    return _audited(
        _settle(), *_rounds(stop, swap, smooth, _SPLIT[dimension]), _polish(2.0)
    )


def _best(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    """As standard, then the worst cells one by one until they are as good as `_BAR`."""
    swap, smooth = _SWAP[dimension], _SMOOTH[dimension]
    bar = _BAR[dimension]
    usual = (_settle(), *_rounds(stop, swap, smooth, _SPLIT[dimension]))
    settle = Smooth(below=smooth, sweeps=2)
    ways = (
        Mend(below=bar, max_vertices=_GROWTH, urgent=float(os.environ.get("U1","1.5"))),
        Mend(below=bar, max_vertices=_GROWTH, rings=3, urgent=float(os.environ.get("U2","1.5"))),
        Mend(below=bar, max_vertices=_GROWTH, rings=1, harm=0.3, steps=10, urgent=float(os.environ.get("U3","1.5"))),
    )
    mend: tuple[Stage, ...] = tuple(Repeat(Sequence((way, settle)), stop) for way in ways)
    mend=(*mend, *([_polish(bar)] if os.environ.get('BP') else []))
    if dimension == 3:
        mend = (WithAngles(mend),)
    return _audited(*usual, *([_polish(2.0)] if os.environ.get('BP') else []), *mend)


PRESETS: dict[str, Preset] = {
    p.name: p
    for p in (
        Preset("fast", "relocation, then a few rounds of swap and smooth", Stop(3, 2e-2), _fast),
        Preset(
            "standard",
            "relocation, then rounds of swap, smooth, collapse, split and optimizing smooth",
            Stop(10, 1e-2),
            _standard,
        ),
        Preset(
            "best",
            "as standard, then the worst cells one by one, with vertices where they help",
            Stop(10, 1e-2),
            _best,
        ),
    )
}


def preset_named(name: str) -> Preset:
    """The preset of this name.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    if name not in PRESETS:
        raise ConfigError(f"no preset {name!r}: choose one of {', '.join(PRESETS)}")
    return PRESETS[name]


def pass_named(name: str) -> type[Pass]:
    """The pass of this name.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    if name not in PASSES:
        raise ConfigError(f"no pass {name!r}: choose one of {', '.join(PASSES)}")
    return PASSES[name]
