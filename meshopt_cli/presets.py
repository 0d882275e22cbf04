"""Named pipelines.

All of them relocate before they change the connectivity: where that is good already, nothing
beats relocation alone, and where it is not, little is lost. Remark 18.15 would have the degrees
relaxed early: `best` tries that way too, and keeps the better mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .errors import ConfigError
from .passes import PASSES, Pass
from .passes.check import Check
from .passes.collapse import Collapse
from .passes.relax import Relax
from .passes.smooth import Smooth
from .passes.swap import Swap
from .pipeline import Either, Repeat, Sequence, Stage, Stop

DEFAULT_PRESET = "standard"


@dataclass(frozen=True)
class Preset:
    """A pipeline by name; `build` makes it anew, with the stop criteria that were asked for."""

    name: str
    summary: str
    stop: Stop
    build: Callable[[Stop], tuple[Stage, ...]]


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    """The stages between two checks."""
    return (Sequence((Check(),)), *stages, Sequence((Check(),)))


# Relocation alone goes on while it gains this part of the quality.
_SETTLED = Stop(rounds=10, gain=0.05)


def _settle() -> Repeat:
    """Relocation alone, for as long as it pays."""
    return Repeat(Sequence((Smooth(),)), _SETTLED)


def _rounds(stop: Stop, below: float = 1.6) -> Repeat:
    """Swap, relocate, remove what neither mends, and lift the worst balls."""
    steps = (
        Swap(below=below, pick="best"),
        Smooth(below=below, sweeps=2),
        Collapse(),
        Smooth(method="optimize", below=1.125 * below, sweeps=1),
    )
    return Repeat(Sequence(steps), stop)


def _fast(stop: Stop) -> tuple[Stage, ...]:
    steps = (Swap(below=1.6, pick="best"), Smooth(below=1.6, sweeps=2))
    return _audited(Sequence((Smooth(),)), Repeat(Sequence(steps), stop))


def _standard(stop: Stop) -> tuple[Stage, ...]:
    return _audited(_settle(), _rounds(stop))


def _best(stop: Stop) -> tuple[Stage, ...]:
    relocate_first = (_settle(), _rounds(stop, 1.4))
    swap_first = (Sequence((Swap(), Relax())), _settle(), _rounds(stop, 1.4))
    return _audited(Either((relocate_first, swap_first)))


PRESETS: dict[str, Preset] = {
    p.name: p
    for p in (
        Preset("fast", "relocation, then a few rounds of swap and smooth", Stop(3, 2e-2), _fast),
        Preset(
            "standard",
            "relocation, then rounds of swap, smooth, collapse and optimizing smooth",
            Stop(10, 5e-3),
            _standard,
        ),
        Preset(
            "best",
            "as standard, to the end, from relocated and from relaxed degrees; keeps the better",
            Stop(30, 1e-3),
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
