"""Several threads at work on shares of a sweep."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..cores import n_cores
from ..kernels.types import N_VERDICTS, Scratch, SimplexMesh

Array = np.ndarray

# Entities that a thread visits between two times that progress is told and interrupts act.
CHUNK = 4_000


def n_threads(wanted: int | None) -> int:
    """How many threads work at once: so many, or as many as this process may use processors.

    A process of several that share them, as those of `jobs.pool` do, has one.
    """
    if wanted is not None:
        return wanted
    processes = sys.modules.get("multiprocessing.process")
    if processes is not None and processes.parent_process() is not None:
        return 1
    return n_cores()


@dataclass
class Share:
    """The part of a sweep that one block has.

    Attributes
    ----------
    mesh : SimplexMesh
        As this block sees it.
    order : (n,) int64
        What is visited.
    places : (n,) int64
        Where in the order of the sweep that is.
    done : int
        How much of it was visited.
    is_full : bool
        Whether it ran out of room for cells.
    """

    mesh: SimplexMesh
    order: Array
    places: Array
    done: int = 0
    is_full: bool = False
    counts: Array = field(default_factory=lambda: np.zeros(N_VERDICTS, dtype=np.int64))

    @property
    def is_over(self) -> bool:
        return self.is_full or self.done == len(self.order)

    def step(self, sweep: Callable[..., int], how: tuple[Any, ...], scratch: Scratch) -> int:
        """Visit some more; returns how many."""
        chunk = self.order[self.done : self.done + CHUNK]
        n = sweep(self.mesh, chunk, *how, scratch, self.counts)
        self.done += n
        self.is_full = n < len(chunk)
        return n


def work_on(
    shares: Sequence[Share],
    sweep: Callable[..., int],
    how: tuple[Any, ...],
    scratches: Sequence[Scratch],
    advanced: Callable[[int], None],
) -> None:
    """Sweep over shares, in as many threads as there are working spaces.

    What comes of a share does not depend on which thread has it, nor when.

    Parameters
    ----------
    advanced : function of a number
        Called by this thread as so many more were visited. Where it raises an exception the
        threads end what they are at.
    """
    # The longest first, so that no thread is left with one at the end.
    waiting = sorted((s for s in shares if not s.is_over), key=lambda s: len(s.order))
    if len(scratches) == 1 or len(waiting) < 2:
        while waiting:
            share = waiting.pop()
            while not share.is_over:
                advanced(share.step(sweep, how, scratches[0]))
        return
    from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

    with ThreadPoolExecutor(min(len(scratches), len(waiting)), "block") as pool:
        running: dict[Future[int], tuple[Share, Scratch]] = {}

        def go_on(share: Share | None, scratch: Scratch) -> None:
            if share is None or share.is_over:
                share = waiting.pop() if waiting else None
            if share is not None:
                running[pool.submit(share.step, sweep, how, scratch)] = share, scratch

        for scratch in scratches:
            go_on(None, scratch)
        while running:
            n = 0
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                share, scratch = running.pop(future)
                n += future.result()
                go_on(share, scratch)
            advanced(n)
