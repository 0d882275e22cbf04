"""Relocation downhill on the sum of the Q² of a ball."""

import numpy as np
import pytest

from meshopt_cli.kernels import accept
from meshopt_cli.kernels.types import APPLIED, CLOCK
from support.operators import RELOCATIONS, in_use, measured, shaken_workspace

DESCENT = RELOCATIONS["descent"]


def squares(work, cells):
    return float(np.sum(measured(work, cells) ** -2.0))


@pytest.mark.parametrize("measure", ["aspect-ratio", "volume-length"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_sum_falls(dimension, measure):
    """Wherever a vertex moves, and more than half of those of a shaken grid do."""
    work = shaken_workspace(dimension, 6, measure)
    moved = 0
    handles = list(DESCENT.handles(work))
    for handle in handles:
        plan = DESCENT.simulate(work, handle, accept.VALID, 0.0)
        if plan.verdict != APPLIED:
            continue
        twin = work.copy()
        twin.mesh.state[CLOCK] += 1
        DESCENT.apply(twin, handle, DESCENT.simulate(twin, handle, accept.VALID, 0.0))
        old, new = in_use(work), in_use(twin)
        changed = [row for row in old if new[row] != old[row]]
        assert squares(twin, changed) < squares(work, changed)
        moved += 1
    movable = np.count_nonzero(~work.mesh.fixed[: work.n_input_points])
    assert moved > 0.5 * movable


@pytest.mark.parametrize("dimension", [2, 3])
def test_at_rest_it_stays(dimension):
    """A vertex goes down to where it would not go on from."""
    work = shaken_workspace(dimension, 7)
    handle = next(
        h
        for h in DESCENT.handles(work)
        if DESCENT.simulate(work, h, accept.VALID, 0.0).verdict == APPLIED
    )
    for _ in range(50):
        plan = DESCENT.simulate(work, handle, accept.VALID, 0.0)
        if plan.verdict != APPLIED:
            break
        DESCENT.apply(work, handle, plan)
    assert plan.verdict != APPLIED
