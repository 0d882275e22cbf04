"""Named pipelines.

All of them relocate before they change the connectivity: where that is good already, nothing
beats relocation alone, and where it is not, little is lost.

What is said beside a number was measured on four meshes of tetrahedra and four of triangles, of
3,000 to 12,000 cells, with that number lower and higher and all else as it is; noise is 5 % of the
time. "Q_T" is the worst Q, "mean" the mean Q.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..errors import UnsupportedMeshError, chosen
from ..kernels.shape.angles import ANGLE_Q
from ..passes import Pass
from ..passes.check import Check
from ..passes.collapse import Collapse
from ..passes.mend import Mend
from ..passes.odt import Odt
from ..passes.relax import Relax
from ..passes.smooth import Smooth
from ..passes.split import Split
from ..passes.swap import Swap
from ..passes.untangle import Untangle
from ..work.kinds import SIMPLICES
from . import cells
from .adapt import adapt
from .angles import WithAngles
from .stages import Chain, Repeat, Sequence, Stage, UpTo
from .stop import Stop

DEFAULT_PRESET = "standard"
ADAPT = "adapt"  # the default where there is a metric

# In space 2 rounds take 13 % less time and cost 0.009 of the mean; 5 take 18 % more for nothing.
_FEW = {2: Stop(10, 1e-2), 3: Stop(3, 1e-2)}
_FIT = {2: Stop(10, 1e-2), 3: Stop(10, 1e-2)}
_FAST = {2: Stop(3, 2e-2), 3: Stop(3, 2e-2)}


@dataclass(frozen=True)
class Preset:
    """A pipeline by name; `build` makes it anew, for stop criteria and a dimension.

    Attributes
    ----------
    stops : dict of int to Stop
        The criteria for each dimension, where the user says nothing.
    cells : function of Stop, optional
        The same for meshes of any cells; without it, it is for simplices alone.
    all_measures : bool
        Whether it is for more than one measure, so that a report tells the others too.
    """

    name: str
    summary: str
    stops: dict[int, Stop]
    build: Callable[[Stop, int], tuple[Stage, ...]]
    cells: Callable[[Stop], tuple[Stage, ...]] | None
    all_measures: bool = False

    def stages(self, stop: Stop, dimension: int, kind: str) -> tuple[Stage, ...]:
        """Its stages for a kind of working mesh."""
        if kind == SIMPLICES:
            return self.build(stop, dimension)
        if self.cells is None:
            raise UnsupportedMeshError(
                f"the preset {self.name} is for meshes of triangles or of tetrahedra alone"
            )
        return self.cells(stop)


def _audited(*stages: Stage) -> tuple[Stage, ...]:
    """The stages between two checks, of which the first leaves inverted cells to be untangled."""
    return (Sequence((Check(inverted="allowed"), Untangle())), *stages, Sequence((Check(),)))


# Relocation alone, and the mean alone, go on while they gain these parts of the quality.
# Half and twice of the first is noise; half of the second takes 0.001 off the mean in space, twice
# adds that in the plane.
# What evens out shapes all over the mesh follows at once in the plane: 15 rounds take 8 % more
# time on 200,000 triangles for noise.
_RELOCATION_STOP = {2: Stop(rounds=1), 3: Stop(rounds=15, gain=0.08)}
_MEAN_STOP = Stop(rounds=10, gain=0.03)
# All of it once more in the plane, where it takes less time than to start the process. Without:
# 15 % less time, Q_T up to 1.5 % more on four of 25, 0.001 more mean.
_SMALL = 20_000

# What evens out shapes. In the plane 10 and 15 sweeps: noise; 25: 25 % more time for nothing; a
# relaxation of 1.8: 0.004 more mean, of 1.4: 0.02; least quality from 0.1 to 0.4: noise.
# In space, 2 sweeps and three turns: 10 % more time for 0.002 of the mean, 5 and one: 0.013 more of
# it; a relaxation of 1.6: 0.008 more mean; least quality 0.1: 0.002 less mean, angles 0.2 degrees
# less, 0.3: 0.007 more mean; swaps above 1.4: 4 % more time for 0.001 of it, above 1.8: 0.019 more.
_EVEN = {2: Odt(sweeps=12), 3: Odt(sweeps=3, swap_worse_than=1.6, least_quality=0.2)}

# Worst Q of the places that are worth a visit: a regular triangulation of the plane is all 1, one
# of space is not, so that in space there is nothing to win at Q = 1.5.
# 1.4 in the plane: 26 % less time, Q_T up to 0.04 more; in space 1.4 takes 28 % longer for nothing,
# 2.6 23 % less with Q_T 0.02 to 0.15 more on three of four.
_SWAP = {2: 1.2, 3: 1.8}
# 1.05 and 1.2 in the plane, 1.3 in space: noise; 2.2 in space: 11 % less time, 0.003 more mean.
_SMOOTH = {2: 1.1, 3: 1.6}
# In space 1.7 nearly triples the time and adds 16 % of the cells, for Q_T up to 0.18 less; 3.0
# leaves Q_T 0.2 to 0.9 more. In the plane 1.4 adds 4 % of the cells for 0.004 of the mean, and 2.6
# leaves Q_T 0.2 more on one of four.
_SPLIT = {2: 1.8, 3: 2.0}
# Gain that a new vertex must bring. In space 0.1 costs 0.008 of the mean, 0.2 on one of 28, and
# 0.02 gains 0.006 on average for up to 9 % more Q_T.
_SPLIT_GAIN = {2: 0.1, 3: 0.05}
# Worst Q that a better mean may cost in the plane. 2.0: Q_T 0.19 more on one of four.
_MEAN = 1.5
# What `best` goes on for: in the plane 1.25 takes 38 % longer for Q_T 0.08 and 0.16 less on two of
# four, 2.0 changes nothing but the mean, by 0.001.
_BAR = {2: 1.5, 3: ANGLE_Q}
# How many vertices it may have for it, over those of the input: never reached here, nor is 1.5.
_GROWTH = 2.0


def _relocation_alone(dimension: int) -> Repeat:
    """Relocation alone, for as long as it pays."""
    return Repeat(Sequence((Smooth(sweeps=2, order="index"),)), _RELOCATION_STOP[dimension])


def _once(rounds: Repeat) -> Repeat:
    """The first of some rounds."""
    return replace(rounds, stop=replace(rounds.stop, rounds=1))


def _better_degrees() -> Sequence:
    """Degrees of triangles nearer to six, at some cost that the rounds after it make good.

    In the plane they are what keeps the mean from being better; in space this pays too seldom.
    """
    # Down to 0.2: noise; to 0.8: 0.03 more mean.
    smooth = Smooth(method="laplace", accept="floor", least_quality=0.4, sweeps=1, order="index")
    return Sequence((smooth, Relax()))


def _rounds(stop: Stop, dimension: int) -> tuple[Repeat, Repeat]:
    """Swap, relocate and lift the worst balls; remove vertices, and add some, where that fails.

    New vertices come last, so that there are few of them.
    """
    # Shared: what the rounds without new vertices left as it was needs no second visit.
    swap = Swap(worse_than=_SWAP[dimension], pick="best")
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2, order="index")
    lift = Smooth(method="optimize", worse_than=_SWAP[dimension], sweeps=1)
    # Most of what is bad beside the boundary stays so: little time is spent on it. With 0.42 the
    # mean is 0.002 less in space; with 1.7 Q_T is 0.9 more on one of four, and 0.03 the mean.
    split = Split(worse_than=_SPLIT[dimension], least_gain=_SPLIT_GAIN[dimension], first_gain=0.85)

    def steps(change: Pass) -> Sequence:
        return Sequence((swap, smooth, change, lift))

    # What the first rounds gain little by little, the others gain as well. 4 times instead of 2:
    # 14 % less time and 0.003 more mean in space; once: noise.
    sooner = replace(stop, gain=2.0 * stop.gain)
    return Repeat(steps(Collapse()), sooner), Repeat(steps(split), stop)


def _better_mean(stop: Stop, worst: float) -> Repeat:
    """A better mean in the plane, where no cell comes to be worse than `worst` for it."""
    least = 1.0 / worst
    # Without collapses Q_T is up to 0.19 more, and 0.005 the mean; 0.3: no change.
    collapse = Collapse(accept="mean", least_quality=least, worse_than=worst, min_vertices=0.6)
    # No cell is more urgent than others: what is near in the mesh is near in memory.
    # Above 1.25: noise.
    swap = Swap(accept="mean", least_quality=least, worse_than=1.5, order="index")
    smooth = Smooth(accept="mean", least_quality=least, sweeps=2, order="index")
    while_it_pays = replace(_MEAN_STOP, target_quality=stop.target_quality)
    return Repeat(Sequence((collapse, swap, smooth)), while_it_pays)


def _better_mean_in_space(stop: Stop) -> Repeat:
    """A better mean in space, where bad cells may get worse for it.

    What lifts the worst cell of a ball costs the others some of theirs, to no avail where the
    boundary does not let that cell be good. A floor at what counts as bad would forbid nearly
    every change beside the boundary.
    """
    # 0.2: 0.016 more mean and 0.6 % less cells below Q = 2; 0.5: 0.08 more mean and 7 % less
    # of them where the boundary is poor, no change elsewhere; 0.05: no change.
    least = 0.1
    # Without collapses 0.01 more mean, 0.19 on one of 28; with 0.9 of the vertices kept, cells
    # below Q = 2 are up to 5 % less; worse than 1.5 takes a quarter longer.
    collapse = Collapse(accept="mean", least_quality=least, worse_than=2.0, min_vertices=0.6)
    # No cell is more urgent than others: what is near in the mesh is near in memory.
    # Above 1.3 and above 1.6: noise.
    swap = Swap(accept="mean", least_quality=least, worse_than=1.4, order="index")
    # To the mean of ideal points instead: 0.004 more mean, 0.05 on one of eleven.
    smooth = Smooth(method="descent", accept="mean", least_quality=least, sweeps=2, order="index")
    while_it_pays = replace(_MEAN_STOP, target_quality=stop.target_quality)
    # Swaps and relocations once between collapses: 12 % less time, up to 0.06 more mean; three
    # times: 2 % more time for 0.002 less.
    return Repeat(Sequence((swap, smooth, swap, smooth, collapse)), while_it_pays)


def _fast(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    swap = Swap(worse_than=_SWAP[dimension], pick="best")
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2)
    # In the plane for 7 % more time the mean is 0.14 less, and Q_T a third. In space it takes 10 %
    # more, and 1.5 % of the cells below Q = 2 where the boundary is poor.
    even = (_EVEN[2],) if dimension == 2 else ()
    return _audited(Sequence((Smooth(), *even)), Repeat(Sequence((swap, smooth)), stop))


def _standard(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    return _audited(*_usual(stop, dimension))


def _usual(stop: Stop, dimension: int, settled: float = 1.0) -> tuple[Stage, ...]:
    """Shapes evened out over the whole mesh, rounds for the worst cells, then a better mean.

    Parameters
    ----------
    settled : float
        Worst Q of a mesh in space whose shapes are not evened out: where relocation alone makes a
        shaken grid that good, that lowers the mean from 1.7 to 1.4, and raises the worst to 2.
    """
    relocation = _relocation_alone(dimension)
    fewer, more = _rounds(stop, dimension)
    even = Sequence((_EVEN[dimension],))
    one = replace(stop, rounds=1)
    if dimension == 2:
        mean = _better_mean(stop, _MEAN)
        turn = Repeat(Chain((relocation, even, _better_degrees(), fewer, more, mean)), one)
        return turn, UpTo(_SMALL, turn)

    def turn_with(*rounds: Repeat) -> Repeat:
        """What the evening out makes worse, the rounds after it make good."""
        until = replace(one, target_quality=max(one.target_quality, settled))
        return Repeat(Chain((even, *rounds)), until, guarded=False)

    # New vertices are evened out with the others, and bring more to even out. One turn: 6 % less
    # time, 0.013 more mean, and 0.3 % less cells below Q = 2; three: 10 % more time for 0.002 of
    # the mean.
    first = (_once(fewer), _once(more))
    turns = (turn_with(*first), turn_with(fewer, more))
    return relocation, *first, *turns, _better_mean_in_space(stop)


def _best(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    """As standard, then the worst cells one by one until they are as good as `_BAR`."""
    bar = _BAR[dimension]
    smooth = Smooth(worse_than=_SMOOTH[dimension], sweeps=2)
    alone = Mend(worse_than=bar, max_vertices=_GROWTH)
    # One ring: 10 % less time, Q_T 0.12 more on one of four; four: 5 % more time, 0.004 less mean.
    by_rings = replace(alone, max_rings=3)
    # 0.6 kept: Q_T 0.34 more on one of four, 0.15: no change; one trial: 0.05 more on one, four: no
    # change; a factor of 1: up to 0.23 more on two, 1.5: 0.001 more mean.
    # Of all cells: half more time on poor boundaries, for nothing; of 0.03 of them: 2 % less.
    at_a_loss = replace(
        alone, max_rings=1, least_kept=0.3, trials=2, urgent_factor=1.1, max_share=0.05
    )

    def mended(*ways: Pass) -> Chain:
        """Rounds of each way to mend, with what relocation makes of it."""
        return Chain(tuple(Repeat(Sequence((way, smooth)), stop) for way in ways))

    # A better mean makes some of what was stuck loose.
    mean = _better_mean(stop, bar) if dimension == 2 else _better_mean_in_space(stop)
    mend = Chain((mended(alone, by_rings, at_a_loss), mean, mended(by_rings)))
    if dimension == 2:
        return _audited(*_usual(stop, dimension), mend)
    angles = WithAngles(mended(alone, at_a_loss), lenient=True)
    usual = _usual(stop, dimension, settled=_SWAP[dimension])
    return _audited(*usual, WithAngles(mend), angles)


PRESETS: dict[str, Preset] = {
    p.name: p
    for p in (
        Preset(
            "fast",
            "relocation, in the plane all over the mesh, then a few rounds of swap and smooth",
            _FAST,
            _fast,
            cells.fast,
        ),
        Preset(
            "standard",
            "relocation, sizes and shapes evened out, rounds of swap, smooth, collapse and split, "
            "then a better mean",
            _FEW,
            _standard,
            cells.standard,
        ),
        Preset(
            "best",
            "as standard, then the worst cells one by one, with vertices where they help",
            _FEW,
            _best,
            cells.best,
            all_measures=True,
        ),
        Preset(
            ADAPT,
            "edges of length 1 in a metric, which --metric or --size gives, and good shapes in it",
            _FIT,
            adapt,
            None,
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
    return chosen(PRESETS, name, "preset")
