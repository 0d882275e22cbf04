"""collapse: an edge becomes a point, and a vertex vanishes (18.4.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.operators.collapse import MAX_GROWTH, Collapsing, sweep_collapse
from ..work.session import Workspace
from .base import Operator, bad_enough, option
from .run import Run


@dataclass(frozen=True)
class Collapse(Operator):
    """Remove internal vertices where the cells around them gain by it."""

    name: ClassVar[str] = "collapse"
    summary: ClassVar[str] = "removes internal vertices where quality gains by it (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("collapse",)

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

    def sweep(self, work: Workspace, run: Run) -> None:
        how = Collapsing(self.rule, self.least(work), self.max_growth, self.placement == "any")
        cells, quality = work.changed_cells(work.since((self, "edges")), self.limit)
        order = self.ordered(work, cells, quality)

        fewest = math.ceil(self.min_vertices * work.bounds.n_input_vertices)
        spare = max(0, work.n_vertices - fewest)
        most = run.tally.applied + spare
        anyone = np.full(len(order), -1)
        run.visit(work, np.column_stack([order, anyone]), sweep_collapse, how, most)
