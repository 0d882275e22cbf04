"""The figures of a mesh: the rows of Table 18.3, and a few more."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..cells import SIMPLICES
from ..kernels.shape.angles import angle_range
from ..kernels.shape.classify import TYPES, classify_cells
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Array
from ..mesh.sizes import unfolded
from .census import Census, census
from .measures import MEASURES, Measure, as_degradation, cell_quality
from .room import Room, room
from .target import target
from .worst import WorstCell, in_space, worst_cells

# Upper ends of the ranks of Table 18.3; the last one has none.
RANKS = (1.0, 2.0, 3.0, 10.0, math.inf)


@dataclass(frozen=True)
class Summary:
    """The figures of one mesh, as Table 18.3 has them and a few more.

    Q of a flat or inverted cell is infinite; such cells count in `n_invalid` and in the last
    rank, and are left out of the mean.
    """

    measure: str
    dimension: int
    family: str  # of the cells; empty where there are several
    n_cells: int
    n_points: int
    counts: tuple[int, ...]  # cells in each rank
    n_invalid: int
    worst: float
    mean: float
    best: float
    target: float  # not a number where none is defined
    angle_min: float  # degrees; dihedral angles in 3-D
    angle_max: float
    types: dict[str, int] = field(default_factory=dict)  # cells of each type (18.2.3)
    worst_by_measure: dict[str, float] = field(default_factory=dict)
    forced: tuple[float, float] | None = None  # see `forced_angles`; None where not asked for
    room: Room | None = None  # of tetrahedra
    census: Census | None = None  # of the whole mesh
    parts: tuple[Summary, ...] = ()  # one a family, where there are several
    worst_cells: tuple[WorstCell, ...] = ()  # the very worst first

    @property
    def equation(self) -> str:
        """Where the chapter defines the measure for these cells."""
        families = [part.family for part in self.parts] or [self.family]
        ways = MEASURES[self.measure].ways
        return ", ".join(dict.fromkeys(ways[family].source for family in families))

    @property
    def percent(self) -> tuple[float, ...]:
        return tuple(100.0 * c / max(self.n_cells, 1) for c in self.counts)


def histogram(degradation: Array) -> tuple[int, ...]:
    """Number of cells in each rank of Table 18.3; the upper end belongs to a rank."""
    inner = np.array(RANKS[1:-1])
    rank = np.searchsorted(inner, degradation, side="left")
    return tuple(int(n) for n in np.bincount(rank, minlength=len(inner) + 1))


def summarize(
    simplices: Simplices,
    measure: Measure,
    others: tuple[Measure, ...] = (),
    best_target: float | None = None,
) -> Summary:
    """All figures of a mesh of triangles or tetrahedra.

    Parameters
    ----------
    measure : Measure
        One that kernels find for such cells.
    simplices : Simplices
        Triangles that lie in no common plane (`frame` is None) are each measured in their own,
        where none is inverted.
    others : tuple of Measure
        Such measures whose worst Q is wanted as well.
    best_target : float, optional
        The target, when it is known already: it belongs to the boundary, which stays.
    """
    points, cells = simplices.points, simplices.cells
    n_points = count_vertices(cells, len(points))
    if simplices.dimension == 2 and simplices.frame is None:
        points, cells = unfolded(points, cells)
    family = SIMPLICES[simplices.dimension]
    q = cell_quality(points, cells, measure)
    degradation = as_degradation(q)
    least, greatest = angle_range(points, cells)
    return Summary(
        measure=measure.name,
        dimension=simplices.dimension,
        family=family,
        n_points=n_points,
        **figures(degradation),
        target=target(simplices, measure) if best_target is None else best_target,
        angle_min=math.degrees(least),
        angle_max=math.degrees(greatest),
        worst_by_measure={
            m.name: float(as_degradation(cell_quality(points, cells, m)).max(initial=1.0))
            for m in others
        },
        types=types_of(points, cells),
        room=room(simplices, measure, q),
        census=census(simplices),
        worst_cells=worst_cells(degradation, points, cells, family, partial(in_space, simplices)),
    )


def figures(degradation: Array) -> dict[str, Any]:
    """What a summary tells of the Q of its cells, (n,): infinite where they have none."""
    valid = degradation[np.isfinite(degradation)]
    return {
        "n_cells": len(degradation),
        "counts": histogram(degradation),
        "n_invalid": len(degradation) - len(valid),
        "worst": float(degradation.max(initial=1.0)),
        "mean": float(valid.mean()) if len(valid) else math.inf,
        "best": float(degradation.min(initial=math.inf)),
    }


def count_vertices(cells: Array, n_points: int) -> int:
    """Number of vertices of some cells."""
    return int(np.count_nonzero(adjacency.is_used(cells, n_points)))


def types_of(points: Array, cells: Array) -> dict[str, int]:
    """How many triangles or tetrahedra there are of each type, by its name (18.2.3)."""
    types = TYPES[cells.shape[1] - 1]
    counts = np.bincount(classified(points, cells), minlength=len(types))
    return {kind.name.lower(): int(counts[kind]) for kind in types}


def classified(points: Array, cells: Array) -> Array:
    """The type of each triangle or tetrahedron, (n,) int64, a number of those in `TYPES`."""
    types = np.empty(len(cells), dtype=np.int64)
    classify_cells(points, cells, types)
    return types
