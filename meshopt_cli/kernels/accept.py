"""When a simulated change is applied: the strategies of 18.5."""

from __future__ import annotations

from typing import NamedTuple

from ..compiled.decorators import inlined

STRICT, RATIO, FLOOR, VALID, MEAN = range(5)

# Least gain of a change, as a part of the worst q: taking less would keep rounds going for ever.
GAIN = 5e-3
MEAN_GAIN = 1e-3  # the same of the mean Q of a patch

# A cell with less q than this is flat but for rounding: no rule lets one be made.
FLAT = 1e-8

# What a better mean may cost: a patch whose worst q is above GOOD keeps it there, any other keeps
# this part of it. GOOD = 0.55: 0.004 less mean and 0.35 % less cells below Q = 2 over 28 meshes,
# 1.7 % on one; 0.42: 0.007 less mean, 0.44 % less of them. KEPT from 0.4 to 0.75: no change.
GOOD = 0.5
KEPT = 0.6


@inlined
def gained(before: float) -> float:
    """The least worst q that counts as a gain over `before`."""
    return before + GAIN * abs(before)


@inlined
def threshold(rule: int, floor: float, before: float) -> float:
    """The worst q that a patch must exceed to be accepted.

    A simulation can stop at the first cell that does not.

    Parameters
    ----------
    rule : int
        STRICT: the worst q must rise. RATIO: it may not fall below `floor` times what it
        was. FLOOR: it may fall, but not below `floor`. VALID: all cells must stay positive.
        MEAN: it may fall to KEPT times what it was, but not below `floor`, nor below GOOD where
        it was above; and `mean_falls` must hold, which the simulation asks last.
    before : float
        Worst q of the patch as it is.
    """
    if rule == STRICT:
        return gained(before)
    if rule == RATIO:
        return max(FLAT, floor * before)
    if rule == FLOOR:
        return max(FLAT, min(before, floor))
    if rule == MEAN:
        good = max(GOOD, floor)
        least = good if before > good else max(floor, KEPT * before)
        return max(FLAT, min(before, least))
    return FLAT


@inlined
def is_accepted(rule: int, floor: float, before: float, after: float) -> bool:
    """Whether the worst q of a patch may go from `before` to `after`.

    The threshold itself is refused under every rule: a simulation stops there, and does not
    know the cells that it did not look at.
    """
    return after > threshold(rule, floor, before)


@inlined
def mean_falls(before: float, after: float) -> bool:
    """Whether `after` counts as a gain over `before`, both the mean Q of a patch."""
    return after < before - MEAN_GAIN * before


class Sums(NamedTuple):
    """Sums of Q over the cells that a change takes away, and over those that it makes."""

    before: float
    n_before: int
    after: float
    n_after: int


UNCHANGED = Sums(0.0, 0, 0.0, 0)


@inlined
def without(sums: Sums, q: float) -> Sums:
    """The sums, once a cell of quality q goes."""
    return Sums(sums.before + 1.0 / q, sums.n_before + 1, sums.after, sums.n_after)


@inlined
def with_cell(sums: Sums, q: float) -> Sums:
    """The sums, once a cell of quality q comes."""
    return Sums(sums.before, sums.n_before, sums.after + 1.0 / q, sums.n_after + 1)


@inlined
def lowers_mean(sums: Sums) -> bool:
    """Whether the mean Q of what changes falls."""
    return mean_falls(sums.before / sums.n_before, sums.after / sums.n_after)
