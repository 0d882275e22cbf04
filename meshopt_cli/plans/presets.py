"""Named pipelines.

All of them relocate before they change the connectivity: where that is good already, nothing
beats relocation alone, and where it is not, little is lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..errors import ConfigError
from ..kernels.shape.angles import ANGLE_Q
from ..passes import Pass
from ..passes.check import Check
from ..passes.collapse import Collapse
from ..passes.mend import Mend
from ..passes.relax import Relax
from ..passes.smooth import Smooth
from ..passes.split import Split
from ..passes.swap import Swap
from ..passes.untangle import Untangle
from .angles import WithAngles
from .stages import Chain, Repeat, Sequence, Stage
from .stop import Stop

DEFAULT_PRESET = "standard"


@dataclass(frozen=True)
class Preset:
    """A pipeline by name; `build` makes it anew, for stop criteria and a dimension.

    Attributes
    ----------
    all_measures : bool
        Whether it is for more than one measure, so that a report tells the others too.
    """

    name: str
    summary: str
    stop: Stop
    build: Callable[[Stop, int], tuple[Stage, ...]]
    all_measures: bool = False


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    """The stages between two checks, of which the first leaves inverted cells to be untangled."""
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


# Relocation alone, and the mean alone, go on while they gain these parts of the quality.
_RELOCATION_STOP = Stop(rounds=15, gain=0.08)
_MEAN_STOP = Stop(rounds=10, gain=0.03)
# Rounds with new vertices and a better mean take turns, and once more where that gains this.
_TURNS_STOP = Stop(rounds=2, gain=0.01)

# Worst Q of the places that are worth a visit: a regular triangulation of the plane is all 1, one
# of space is not, so that in space there is nothing to win at Q = 1.5.
_SWAP = {2: 1.2, 3: 1.8}
_SMOOTH = {2: 1.1, 3: 1.6}
# What `best` goes on for, and how many vertices it may have for it, over those of the input.
_GROWTH = 2.0
_BAR = {2: 1.5, 3: ANGLE_Q}
_SPLIT = {2: 1.8, 3: 2.0}
_MEAN = {2: 1.5, 3: 2.0}


def _relocation_alone() -> Repeat:
    """Relocation alone, for as long as it pays."""
    return Repeat(Sequence((Smooth(sweeps=2, order="index"),)), _RELOCATION_STOP)


def _better_degrees() -> Sequence:
    """Degrees of triangles nearer to six, at some cost that the rounds after it make good.

    In the plane they are what keeps the mean from being better; in space this pays too seldom.
    """
    smooth = Smooth(method="laplace", accept="floor", least_quality=0.4, sweeps=1, order="index")
    return Sequence((smooth, Relax()) * 3)


def _rounds(stop: Stop, dimension: int) -> tuple[Repeat, Repeat]:
    """Swap, relocate and lift the worst balls; remove vertices, and add some, where that fails.

    New vertices come last, so that there are few of them.
    """
    # Shared: what the rounds without new vertices left as it was needs no second visit.
    swap = Swap(worse_than=_SWAP[dimension], pick="best")
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2, order="index")
    lift = Smooth(method="optimize", worse_than=_SWAP[dimension], sweeps=1)
    # Most of what is bad beside the boundary stays so: little time is spent on it.
    split = Split(worse_than=_SPLIT[dimension], first_gain=0.85)

    def steps(change: Pass) -> Sequence:
        return Sequence((swap, smooth, change, lift))

    # What the first rounds gain little by little, the others gain as well.
    sooner = replace(stop, gain=2.0 * stop.gain)
    return Repeat(steps(Collapse()), sooner), Repeat(steps(split), stop)


def _better_mean(stop: Stop, worst: float) -> Repeat:
    """A better mean, where no cell comes to be worse than `worst` for it.

    What lifts the worst cell of a ball costs the others some of theirs, to no avail where the
    boundary does not let that cell be good.
    """
    least = 1.0 / worst
    collapse = Collapse(accept="mean", least_quality=least, worse_than=worst, min_vertices=0.6)
    # No cell is more urgent than others: what is near in the mesh is near in memory.
    swap = Swap(accept="mean", least_quality=least, worse_than=1.5, order="index")
    smooth = Smooth(accept="mean", least_quality=least, sweeps=2, order="index")
    while_it_pays = replace(_MEAN_STOP, target_quality=stop.target_quality)
    return Repeat(Sequence((collapse, swap, smooth)), while_it_pays)


def _fast(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    swap = Swap(worse_than=_SWAP[dimension], pick="best")
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2)
    return _audited(Sequence((Smooth(),)), Repeat(Sequence((swap, smooth)), stop))


def _standard(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    return _audited(*_usual(stop, dimension))


def _usual(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    """Rounds without new vertices, then with some and a better mean, for what that allows again."""
    relocation = _relocation_alone()
    fewer, more = _rounds(stop, dimension)
    mean = _better_mean(stop, _MEAN[dimension])
    again = replace(_TURNS_STOP, target_quality=stop.target_quality)
    if dimension == 2:
        return (Repeat(Chain((relocation, _better_degrees(), fewer, more, mean)), again),)
    return (relocation, fewer, Repeat(Chain((more, mean)), again))


def _best(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    """As standard, then the worst cells one by one until they are as good as `_BAR`."""
    bar = _BAR[dimension]
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2)
    alone = Mend(worse_than=bar, max_vertices=_GROWTH)
    by_rings = replace(alone, max_rings=3)
    at_a_loss = replace(alone, max_rings=1, least_kept=0.3, trials=2, urgent_factor=1.1)

    def mended(*ways: Pass) -> Chain:
        """Rounds of each way to mend, with what relocation makes of it."""
        return Chain(tuple(Repeat(Sequence((way, smooth)), stop) for way in ways))

    # A better mean makes some of what was stuck loose.
    mend = Chain((mended(alone, by_rings, at_a_loss), _better_mean(stop, bar), mended(by_rings)))
    if dimension == 2:
        return _audited(*_usual(stop, dimension), mend)
    angles = WithAngles(mended(alone, at_a_loss), lenient=True)
    return _audited(*_usual(stop, dimension), WithAngles(mend), angles)


PRESETS: dict[str, Preset] = {
    p.name: p
    for p in (
        Preset("fast", "relocation, then a few rounds of swap and smooth", Stop(3, 2e-2), _fast),
        Preset(
            "standard",
            "relocation, then rounds of swap, smooth, collapse and split, then a better mean",
            Stop(10, 1e-2),
            _standard,
        ),
        Preset(
            "best",
            "as standard, then the worst cells one by one, with vertices where they help",
            Stop(10, 1e-2),
            _best,
            all_measures=True,
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
