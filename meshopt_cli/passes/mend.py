"""mend: composite operations on the worst cells, by their type (18.5, Exercise 18.6)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.operators.mend import WAYS, Mending, Remedy, sweep_mend
from ..kernels.search.target import facet_bounds
from ..kernels.shape.classify import TetType
from ..work.refusals import Refusals, no_refusals
from ..work.session import Workspace
from .base import Operator, Pass, bad_enough, option, urgency, urgent_q
from .run import Run

Array = np.ndarray

LEAST_VISITS = 64  # whatever part of the cells of a small mesh that is
MOST_WAYS = max(map(max, WAYS))  # of any remedy

# For each type, what to try in what order: the cheap and the likely first.
REMEDIES: dict[TetType, tuple[Remedy, ...]] = {
    TetType.REGULAR: (Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.SPADE: (Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.SLIVER: (Remedy.REMOVE_EDGE, Remedy.RELOCATE, Remedy.REMOVE_FACES, Remedy.INSERT),
    TetType.CAP: (Remedy.REMOVE_FACES, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.WEDGE: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.SPINDLE: (Remedy.COLLAPSE, Remedy.REMOVE_EDGE, Remedy.RELOCATE, Remedy.INSERT),
    TetType.SPEAR: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.REMOVE_EDGE, Remedy.INSERT),
    TetType.NEEDLE: (Remedy.COLLAPSE, Remedy.RELOCATE, Remedy.INSERT, Remedy.REMOVE_EDGE),
}


def remedy_table() -> np.ndarray:
    """`REMEDIES` as the kernel takes it."""
    table = np.zeros((len(TetType), max(map(len, REMEDIES.values()))), dtype=np.int64)
    for kind, remedies in REMEDIES.items():
        table[kind, : len(remedies)] = remedies
    return table


def worst_first(work: Workspace, cells: Array) -> Array:
    """The cells by their q, ties by number."""
    return cells[np.argsort(work.quality(cells), kind="stable")]


@dataclass(frozen=True)
class Remedial(Pass):
    """What passes share that try remedies on bad cells and undo what does not pay."""

    max_vertices: float = option(1.5, "most vertices, over those of the input", least=1.0, most=4.0)
    least_gain: float = option(
        0.01, "least gain of the worst quality of what changed, as a part of it",
        least=0.0, most=1e3,
    )  # fmt: skip
    trials: int = option(
        4, "ways of a remedy that are carried out, the best first", least=1, most=MOST_WAYS
    )
    steps: int = option(
        5, "improvements of what is around, after the first change", least=0, most=100
    )

    def arranged(self, work: Workspace, cells: Array) -> Array:
        """The cells in the order of the visits: the worst first."""
        return worst_first(work, cells)

    def mend(
        self,
        work: Workspace,
        cells: Array,
        limit: float,
        least_kept: float,
        urgent: float,
        run: Run,
    ) -> None:
        """Visit those cells around which something changed since they were visited last.

        Parameters
        ----------
        limit : float
            The q below which a cell is visited.
        least_kept : float
            What the first change may leave of the q of a cell, as a part of it.
        urgent : float
            Where what changes is better than this q, its mean Q must fall, too.
        """
        max_points = work.room_for_vertices(self.max_vertices, len(cells))
        cells = work.not_seen((self, "cells"), cells)
        if not len(cells):
            return
        how = Mending(
            limit, least_kept, self.least_gain, max_points, self.trials, self.steps, urgent
        )
        order = self.arranged(work, cells)
        run.visit(work, order, sweep_mend, remedy_table(), how)


@dataclass(frozen=True)
class Mend(Remedial, Operator):
    """Change, improve what is around, and undo it where it does not pay."""

    name: ClassVar[str] = "mend"
    summary: ClassVar[str] = "composite operations on the worst cells, by their type (18.5)"
    kernels: ClassVar[tuple[str, ...]] = ("mend",)

    worse_than: float = bad_enough(2.0, "cells whose Q is above")
    accept: str = option("strict", "the worst Q of what changed must fall", choices=("strict",))
    least_kept: float = option(
        0.8, "what the first change may leave of the quality of the cell", least=0.0, most=1.0
    )
    max_rings: int = option(
        0, "where cells stay bad, mend up to so many rings of cells around them, and try again",
        least=0, most=4,
    )  # fmt: skip
    max_cells: int = option(
        64, "rings are mended around so many of the worst cells at most", least=1, most=1_000_000
    )
    near_target: float = option(
        1.1, "no rings around cells whose Q is below so many times the target",
        least=1.0, most=1e3,
    )  # fmt: skip
    near_bound: float = option(
        1.1, "no cell whose Q is below so many times what its boundary facets allow",
        least=1.0, most=1e3,
    )  # fmt: skip
    max_share: float = option(
        1.0, "visit so many of the worst at most, as a part of all cells", least=0.0, most=1.0
    )
    urgent_factor: float = urgency()
    rings_worse_than: float = bad_enough(1.6, "cells of these rings whose Q is above")

    def sweep(self, work: Workspace, run: Run) -> None:
        def mend(cells: Array, limit: float) -> None:
            urgent = urgent_q(work, self.urgent_factor)
            refused: Refusals = work.visits.get((self, "refused"), no_refusals(work.mesh))
            alike = refused.are_alike(work.mesh, cells) & (work.quality(cells) > urgent)
            cells = self._with_room(work, cells[~alike])
            before = Refusals.of(work.mesh, cells)
            self.mend(work, cells, limit, self.least_kept, urgent, run)
            left = before.chosen(before.are_unchanged(work.mesh))
            work.visits[(self, "refused")] = refused.joined(left)

        bad = worst_first(work, work.worse_cells(self.limit))
        mend(bad[: max(LEAST_VISITS, int(self.max_share * work.n_cells))], self.limit)
        # What is nearly as good as the boundary allows is worth no more than that.
        limit = 1.0 / max(self.worse_than, self.near_target * work.bounds.target)
        around = 1.0 / self.rings_worse_than
        for n_rings in range(1, self.max_rings + 1):
            bad = work.worse_cells(limit)
            if not len(bad):
                return
            bad = worst_first(work, bad)[: self.max_cells]
            near = work.rings_around(bad, n_rings)
            mend(near[work.quality(near) < around], around)
            mend(work.worse_cells(limit), limit)

    def _with_room(self, work: Workspace, cells: Array) -> Array:
        """The cells whose boundary facets allow more; over an edge any triangle can be regular."""
        if work.dimension == 2:
            return cells
        allowed = np.empty(len(cells))
        facet_bounds(work.mesh, cells, allowed)
        return cells[self.near_bound * work.quality(cells) < allowed]
