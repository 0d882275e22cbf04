"""The pipeline for meshes that are driven by a metric (18.3): edges of length 1 first."""

from __future__ import annotations

from ..passes.check import Check
from ..passes.fit import Fit
from ..passes.smooth import Smooth
from ..passes.swap import Swap
from ..passes.untangle import Untangle
from .stages import Chain, Repeat, Sequence, Stage
from .stop import Stop

# Where edges are far from what they should be, six rounds bring most of them near.
_ROUGH = Stop(rounds=12, gain=0.02)


def adapt(stop: Stop, dimension: int) -> tuple[Stage, ...]:
    """As many vertices as the metric asks for, then changes that each bring edges nearer to 1."""
    swap = Swap(pick="best", worse_than=1.05 if dimension == 2 else 1.4)
    # What makes way for others may be bad for a while.
    smooth = Smooth(
        method="descent", accept="mean", least_quality=0.02, order="index", sweeps=4 - dimension
    )
    rough = Fit(least_quality=0.05, slack=0.8)
    fine = Fit(longest=1.3, shortest=0.8, slack=0.7, gains="yes", least_quality=0.2)
    return (
        Sequence((Check(inverted="allowed"), Untangle())),
        Chain((
            Repeat(Sequence((rough, swap, smooth, swap)), _ROUGH, guarded=False),
            Repeat(Sequence((fine, swap, smooth, swap, smooth)), stop),
        )),
        Sequence((Check(),)),
    )  # fmt: skip
