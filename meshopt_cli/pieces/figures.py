"""The figures of a mesh from those of its pieces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..quality.summary import Summary
from ..quality.worst import N_WORST, WorstCell


@dataclass(frozen=True)
class Figures:
    """What of a `Summary` adds up: of one piece, or of several.

    Attributes
    ----------
    total : float
        The sum of the Q of the cells that are valid.
    worst_cells : tuple
        Each a `WorstCell`.
    """

    measure: str
    dimension: int
    family: str
    n_cells: int
    n_points: int
    counts: tuple[int, ...]
    n_invalid: int
    worst: float
    total: float
    best: float
    angle_min: float
    angle_max: float
    types: dict[str, int]
    worst_by_measure: dict[str, float]
    worst_cells: tuple[WorstCell, ...]

    @property
    def mean(self) -> float:
        n = self.n_cells - self.n_invalid
        return self.total / n if n else math.inf

    def summary(self, target: float) -> Summary:
        """The figures as those of a mesh, but for what needs the whole at once.

        Parameters
        ----------
        target : float
            What its boundary allows.
        """
        return Summary(
            self.measure, self.dimension, self.family, self.n_cells, self.n_points, self.counts,
            self.n_invalid, self.worst, self.mean, self.best, target, self.angle_min,
            self.angle_max, self.types, self.worst_by_measure, worst_cells=self.worst_cells,
        )  # fmt: skip


def figures_of(summary: Summary, piece: int) -> Figures:
    """The figures of a piece, whose worst cells are named by its number."""
    worst = tuple(
        replace(one, cell=f"piece {piece}, {one.cell or f'cell {one.number}'}")
        for one in summary.worst_cells
    )
    total = summary.mean * (summary.n_cells - summary.n_invalid) if summary.n_cells else 0.0
    return Figures(
        summary.measure, summary.dimension, summary.family, summary.n_cells, summary.n_points,
        summary.counts, summary.n_invalid, summary.worst, total, summary.best, summary.angle_min,
        summary.angle_max, summary.types, summary.worst_by_measure, worst,
    )  # fmt: skip


def together(figures: Sequence[Figures], n_shared: int) -> Figures:
    """The figures of all pieces; so many of their points are there again in another."""
    first = figures[0]
    types: dict[str, int] = {}
    for one in figures:
        for name, n in one.types.items():
            types[name] = types.get(name, 0) + n
    worst = sorted((cell for one in figures for cell in one.worst_cells), key=lambda c: -c.quality)
    return replace(
        first,
        n_cells=sum(one.n_cells for one in figures),
        n_points=sum(one.n_points for one in figures) - n_shared,
        counts=tuple(map(sum, zip(*(one.counts for one in figures), strict=True))),
        n_invalid=sum(one.n_invalid for one in figures),
        worst=max(one.worst for one in figures),
        total=math.fsum(one.total for one in figures),
        best=min(one.best for one in figures),
        angle_min=min(one.angle_min for one in figures),
        angle_max=max(one.angle_max for one in figures),
        types=types,
        worst_by_measure={
            name: max(one.worst_by_measure[name] for one in figures)
            for name in first.worst_by_measure
        },
        worst_cells=tuple(worst[:N_WORST]),
    )


def to_json(figures: Figures) -> dict[str, Any]:
    from dataclasses import asdict

    return asdict(figures)


def from_json(value: dict[str, Any]) -> Figures:
    worst = tuple(
        WorstCell(**(one | {"where": tuple(one["where"])})) for one in value["worst_cells"]
    )
    return Figures(**(value | {"counts": tuple(value["counts"]), "worst_cells": worst}))
