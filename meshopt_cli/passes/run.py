"""One run of a pass: who watches it, how long it may take, and what it did."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..blocks.turns import Reach, sweep_in_blocks
from ..kernels.types import N_VERDICTS, Verdict
from ..progress.observer import CancelledError, Observer, OutOfTimeError
from ..work.session import Workspace
from ..work.visits import chunks

if TYPE_CHECKING:  # seldom met, and their kernels take their time to load
    from ..work.cells import CellWork
    from ..work.face_work import FaceWork

Array = np.ndarray
Work: TypeAlias = "Workspace | CellWork"


def faces_of(work: Work) -> FaceWork:
    """A working mesh of faces of a plane as what it is; `works_on` lets no other pass."""
    from ..work.face_work import FaceWork

    assert isinstance(work, FaceWork)
    return work


@dataclass(frozen=True)
class Budget:
    """Until when work may go on, and by how many.

    Attributes
    ----------
    deadline : float
        By `time.monotonic`; without end by default.
    threads : int or None
        How many may work at once on a large mesh, see `blocks.crew.n_threads`. What they make of
        it is the same for any number.
    """

    deadline: float = math.inf
    threads: int | None = 1

    @classmethod
    def of(cls, seconds: float, threads: int | None = 1) -> Budget:
        """The budget that ends so many seconds from now."""
        return cls(time.monotonic() + seconds, threads)

    def check(self) -> None:
        """Ask for more time.

        Raises
        ------
        OutOfTimeError
            There is none left.
        """
        if self.is_spent:
            raise OutOfTimeError

    @property
    def is_spent(self) -> bool:
        """Whether there is no time left."""
        return time.monotonic() >= self.deadline


UNLIMITED = Budget()


@dataclass
class Tally:
    """What one run of a pass did.

    Attributes
    ----------
    kinds : dict of str to dict of str to int
        Of meshes of any cells: how many vertices were "moved" by the family of cells at them, and
        how many pairs of faces were "swapped" and "collapsed" by theirs.
    """

    name: str
    counts: Array = field(default_factory=lambda: np.zeros(N_VERDICTS, dtype=np.int64))
    seconds: float = 0.0
    kinds: dict[str, dict[str, int]] = field(default_factory=dict)

    def note(self, what: str, kinds: dict[str, int]) -> None:
        """Count what was done to cells of some kinds; those of which nothing was are left out."""
        counts = self.kinds.get(what, {})
        for kind, n in kinds.items():
            if n:
                counts[kind] = counts.get(kind, 0) + n
        if counts:
            self.kinds[what] = counts

    @property
    def visited(self) -> int:
        """Number of attempts."""
        return int(self.counts.sum())

    @property
    def applied(self) -> int:
        return int(self.counts[Verdict.APPLIED])

    @property
    def refused(self) -> dict[str, int]:
        """Number of refusals by verdict, those that occurred."""
        return {
            v.name.lower().replace("_", "-"): int(self.counts[v])
            for v in Verdict
            if v != Verdict.APPLIED and self.counts[v]
        }


@dataclass(frozen=True)
class Run:
    """A pass at work on a mesh."""

    tally: Tally
    observer: Observer
    budget: Budget

    @property
    def is_over(self) -> bool:
        """Whether there is no time left, or nobody who wants more."""
        return self.observer.is_cancelled or self.budget.is_spent

    def check(self) -> None:
        """Ask whether to go on.

        Raises
        ------
        CancelledError, OutOfTimeError
        """
        if self.observer.is_cancelled:
            raise CancelledError
        self.budget.check()

    def visit(
        self,
        work: Work,
        order: Array,
        sweep: Callable[..., int],
        *how: Any,
        reach: Reach | None = None,
    ) -> None:
        """Sweep over entities in chunks, and make room for cells where it is short of it.

        Parameters
        ----------
        order : (n,) or (n, 2) int64
        sweep : callable
            A kernel: takes the mesh, a part of the order, `how`, the working space and the
            counts, and returns the place in that part where it stopped for want of room.
        reach : Reach, optional
            What it touches of the mesh, so that it may go on in blocks of a large one at once.

        Raises
        ------
        CancelledError, OutOfTimeError
        """
        self.observer.started(self.tally.name, len(order))
        self.check()
        order = sweep_in_blocks(
            work, order, sweep, how, reach, self.tally.counts, self.budget.threads, self._advanced
        )
        for chunk in chunks(order):
            done = 0
            while True:
                done += sweep(work.mesh, chunk[done:], *how, work.scratch, self.tally.counts)
                if done == len(chunk):
                    break
                assert isinstance(work, Workspace)  # nothing else runs short of room
                work.grow()
            self._advanced(len(chunk))
        work.renew()

    def _advanced(self, n: int) -> None:
        """Tell that so many more were visited, and ask whether to go on."""
        self.observer.advanced(n)
        self.check()
