"""One turn of a sweep over the blocks of a mesh: what each block has, and what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any

import numpy as np

from ..work.session import Workspace
from ..work.storage import new_scratch
from .crew import Share, n_threads, work_on
from .cut import Balls, Shells
from .partition import N_TURNS, is_large, partition_of

Array = np.ndarray


class Reach(Enum):
    """What a sweep reads and changes at each entity that it visits: how the mesh is shared out."""

    BALLS = Balls
    SHELLS = Shells


def sweep_in_blocks(
    work: object,
    order: Array,
    sweep: Callable[..., int],
    how: tuple[Any, ...],
    reach: Reach | None,
    counts: Array,
    threads: int | None,
    advanced: Callable[[int], None],
) -> Array:
    """Sweep over what lies inside of blocks; returns the rest of the order.

    Parameters
    ----------
    reach : Reach, optional
        Without it there are no blocks for the sweep.
    counts : (N_VERDICTS,) int64
        As in sweeps.
    threads : int or None
        See `crew.n_threads`.
    advanced : function of a number
        Called as so many more were visited. The mesh is whole again when an exception that it
        raises comes out of here.
    """
    if reach is None or not is_large(work):
        return order
    assert isinstance(work, Workspace)
    for turn in range(N_TURNS):
        if len(order) < reach.value.least_part * work.n_cells:
            break
        partition = partition_of(work)
        parts = reach.value(work, partition.labels[turn], partition.n_blocks, order)
        try:
            spaces = [new_scratch(work.mesh) for _ in range(n_threads(threads) - 1)]
            work_on(parts.shares, sweep, how, [work.scratch, *spaces], advanced)
        finally:
            parts.close()
            counts += sum(share.counts for share in parts.shares)
        order = _left(order, parts.shares)
    return order


def _left(order: Array, shares: Sequence[Share]) -> Array:
    """What of an order no share visited."""
    is_left = np.ones(len(order), dtype=bool)
    for share in shares:
        is_left[share.places[: share.done]] = False
    return order[is_left]
