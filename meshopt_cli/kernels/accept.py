"""When a simulated change is applied: the strategies of 18.5."""

from __future__ import annotations

from ._jit import kernel

STRICT, RATIO, VALID = range(3)

# A gain smaller than this is rounding noise: taking it would keep rounds going for ever.
GAIN = 1e-6


@kernel
def is_accepted(rule, floor, before, after):
    """Whether the worst q of a patch may go from `before` to `after`.

    Parameters
    ----------
    rule : int
        STRICT: the worst must rise. RATIO: it may not fall below `floor` times what it
        was. VALID: all cells must stay positive.
    """
    if rule == STRICT:
        return after > before + GAIN
    if rule == RATIO:
        return after > 0.0 and after >= floor * before
    return after > 0.0


@kernel
def threshold(rule, floor, before):
    """The worst q below which a simulation can stop at once."""
    if rule == STRICT:
        return before + GAIN
    if rule == RATIO:
        return max(0.0, floor * before)
    return 0.0
