"""fit: edges of length 1 in the metric: long ones are split, short ones collapsed (18.3)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from ..errors import ConfigError
from ..kernels.operators.edges import (
    Fitting,
    sweep_long_edges,
    sweep_short_edges,
)
from ..work.session import Workspace
from .base import Operator, bad_enough, option
from .run import Run

UNLIMITED_LACK = -1.0


@dataclass(frozen=True)
class Fit(Operator):
    """Split edges that are too long in the metric, and collapse those that are too short."""

    name: ClassVar[str] = "fit"
    summary: ClassVar[str] = (
        "splits and collapses edges that are not of length 1 in the metric (18.3)"
    )
    kernels: ClassVar[tuple[str, ...]] = ("fit",)
    needs_metric: ClassVar[bool] = True

    worse_than: float = bad_enough(1.0, "cells whose Q in the metric is above")
    accept: str = option(
        "floor",
        "what the worst Q of what changes may become: see other passes",
        choices=("strict", "ratio", "floor", "valid"),
    )
    least_quality: float = option(
        0.1, "least quality 1/Q, or part of the quality before, that `accept` allows",
        least=0.0, most=1.0,
    )  # fmt: skip
    longest: float = option(
        math.sqrt(2.0), "split edges that are longer, from 1 on; 0: none", least=0.0, most=1e6
    )
    shortest: float = option(
        math.sqrt(0.5), "collapse edges that are shorter, up to 1; 0: none", least=0.0, most=1.0
    )
    slack: float = option(
        1.0, "new edges of a split may have this part of `shortest`, and of a collapse `longest` "
        "over it", least=0.1, most=1.0,
    )  # fmt: skip
    gains: str = option(
        "no", "whether the efficiency index must rise with every change", choices=("no", "yes")
    )
    max_vertices: float = option(
        100.0, "most vertices, over those of the input", least=1.0, most=1e6
    )

    def validate(self) -> None:
        super().validate()
        if 0.0 < self.longest < 1.0:
            raise ConfigError(f"fit.longest: {self.longest:g} is out of range, must be 0 or from 1")

    def sweep(self, work: Workspace, run: Run) -> None:
        if not work.has_metric:  # who calls for a run without one was told so
            return
        if self.shortest:
            new = (self.longest or math.inf) / self.slack
            self._sweep(work, run, sweep_short_edges, self.shortest, new)
        if self.longest:
            self._sweep(work, run, sweep_long_edges, self.longest, self.shortest * self.slack)

    def _sweep(
        self, work: Workspace, run: Run, sweep: Callable[..., int], limit: float, new: float
    ) -> None:
        """Visit the cells with an edge beyond a limit; `new` is one for new edges."""
        is_long = sweep is sweep_long_edges
        shortest, longest, lack = work.lengths()
        lacking = float(lack[work.living()].mean()) if self.gains == "yes" else UNLIMITED_LACK
        least = self.limit if self.worse_than > 1.0 else math.inf
        cells, _ = work.changed_cells(work.since((self, is_long)), least)
        urgency = limit - longest[cells] if is_long else shortest[cells] - limit
        order = self.ordered(work, cells[urgency < 0.0], urgency[urgency < 0.0])
        most = work.room_for_vertices(self.max_vertices, len(order)) if is_long else 0
        how = Fitting(self.rule, self.least(work), limit, new, lacking, most)
        run.visit(work, order, sweep, how)
