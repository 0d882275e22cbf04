"""collapse: two vertices become one, with what is between them (18.4.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..kernels.accept import FLAT
from ..kernels.operators.collapse import MAX_GROWTH, Collapsing, sweep_collapse
from ..kernels.types import Verdict
from ..work.kinds import FACES, SIMPLICES
from ..work.session import Workspace
from .apart import apart
from .base import Operator, bad_enough, option
from .run import Run, Work, faces_of

if TYPE_CHECKING:
    from ..work.face_work import FaceWork
    from ..work.merges import Merge

Array = np.ndarray


@dataclass(frozen=True)
class Collapse(Operator):
    """Remove internal vertices where the cells around them gain by it."""

    name: ClassVar[str] = "collapse"
    summary: ClassVar[str] = "removes internal vertices where quality gains by it (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("collapse",)
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES)

    worse_than: float = bad_enough(3.0, "cells whose Q is above")
    placement: str = option(
        "any",
        "where the two ends meet (Figure 18.11): at one of them (ends), or also half way between",
        choices=("any", "ends"),
    )
    max_growth: float = option(
        MAX_GROWTH, "longest new edge, over the longest edge of the balls it replaces",
        least=0.0, most=1e3,
    )  # fmt: skip
    min_vertices: float = option(
        0.8, "fewest vertices, over those of the input", least=0.0, most=1.0
    )

    def sweep(self, work: Work, run: Run) -> None:
        if not isinstance(work, Workspace):
            self._merge_faces(faces_of(work), run)
            return
        how = Collapsing(self.rule, self.least(work), self.max_growth, self.placement == "any")
        cells, quality = work.changed_cells(work.since((self, "edges")), self.limit)
        order = self.ordered(work, cells, quality)
        most = run.tally.applied + self._spare(work)
        anyone = np.full(len(order), -1)
        run.visit(work, np.column_stack([order, anyone]), sweep_collapse, how, most)

    def _spare(self, work: Work) -> int:
        """How many vertices may go."""
        fewest = math.ceil(self.min_vertices * work.bounds.n_input_vertices)
        return max(0, work.n_vertices - fewest)

    def _merge_faces(self, work: FaceWork, run: Run) -> None:
        """Let vertices of faces that are bad become one with others, the worst first."""
        run.check()
        found, floor = work.merges(work.vertex_quality() < self.limit), self.least(work)
        near = np.flatnonzero(
            (found.before < self.limit) & ((found.meeting.part == 0.0) | (self.placement == "any"))
        )
        allowed = near[(found.after[near] > FLAT) & (found.growth[near] <= self.max_growth)]
        if self.order == "worst-first":  # the best of several places comes first
            allowed = allowed[np.argsort(-found.after[allowed], kind="stable")]
        allowed = self.ordered(work, allowed, found.before[allowed])
        good = [k for k in allowed.tolist()
                if self.takes(floor, found.before[k], found.after[k],
                              (found.mean_before[k], found.mean_after[k]))]  # fmt: skip
        chosen = apart(good, found.vertices, len(work.mesh.points))
        merge_faces(work, run, found, chosen[: self._spare(work)])
        counts = run.tally.counts
        counts[Verdict.INVALID] += np.count_nonzero(found.after[near] <= FLAT)
        is_long = (found.after[near] > FLAT) & (found.growth[near] > self.max_growth)
        counts[Verdict.TOO_LONG] += np.count_nonzero(is_long)
        counts[Verdict.NOT_BETTER] += len(allowed) - len(good)


def merge_faces(work: FaceWork, run: Run, found: Merge, chosen: Array) -> None:
    """Apply merges that have no vertex in common."""
    work.next_sweep()
    if len(chosen):
        work.merge(found, chosen)
    run.tally.note("collapsed", found.kinds(chosen))
    run.tally.counts[Verdict.APPLIED] += len(chosen)
