"""The figures of a mesh in a metric."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from ..mesh.model import Array
from ..quality.gates import FIGURES
from ..quality.measures import Measure
from ..quality.summary import figures
from .domain import Domain
from .field import Metric
from .lengths import UNIT, Lengths, edge_lengths, told_of
from .quality import metric_contents, metric_quality, optimal_shares, unit_content, unit_shares


@dataclass(frozen=True)
class Nearness:
    """How far cells are from what they should be: 0 for one that is just so, 1 for the farthest.

    Attributes
    ----------
    worst, mean : float
    share : float
        Part of the cells, of 1, that are off by no more than a factor of sqrt(2) in length.
    """

    worst: float
    mean: float
    share: float


@dataclass(frozen=True)
class MetricSummary:
    """What is told of a mesh in a metric.

    Attributes
    ----------
    kind : str
        "sizes" or "tensors".
    source : str
        Where the metric comes from.
    edges, inner : Lengths
        Of all edges, and of those with an end off the boundary.
    measure : str
        What Q is.
    n_cells : int
    counts : tuple of int
        Cells in each rank of Table 18.3, as Q in the metric ranks them.
    n_invalid : int
        Flat and inverted ones among them: their Q is infinite, and is left out of the mean.
    worst, mean, best : float
        Q in the metric.
    content : float
        Area or volume of the mesh in the metric.
    n_unit : float
        How many unit cells have this content: about as many cells the mesh should have.
    unit, optimal : Nearness
        To Definitions 18.3 and 18.4.
    """

    kind: str
    source: str
    edges: Lengths
    inner: Lengths
    measure: str
    n_cells: int
    counts: tuple[int, ...]
    n_invalid: int
    worst: float
    mean: float
    best: float
    content: float
    n_unit: float
    unit: Nearness
    optimal: Nearness


@dataclass(frozen=True)
class Judged:
    """Cells in a metric, one by one; each is by families.

    Attributes
    ----------
    quality : dict of str to (n,)
        Q in the metric, infinite for flat and inverted cells; only of families that have it.
    unit, optimal : dict of str to (n,)
        How far each cell is from a unit one and an optimal one, in [0, 1].
    summary : MetricSummary
    """

    quality: dict[str, Array]
    unit: dict[str, Array]
    optimal: dict[str, Array]
    summary: MetricSummary


def figures_of(summary: MetricSummary) -> dict[str, float]:
    """The figures that gates may be put on, by the keys of `FIGURES`."""
    return {name: attrgetter(figure.path)(summary) for name, figure in FIGURES.items()}


def judge(domain: Domain, turned: dict[str, Array], metric: Metric, measure: Measure) -> Judged:
    """Judge a mesh by a metric.

    Parameters
    ----------
    turned : dict of str to (n,) bool
        Which cells of each family have a negative content.
    metric : Metric
        As `field.fitted` makes it.
    measure : Measure
        A Q that some family has.
    """
    points, cells = domain.points, domain.cells
    lengths = edge_lengths(points, metric, domain.edges)
    quality = {
        f: np.where(turned[f], np.inf, metric_quality(points, c, f, metric, measure))
        for f, c in cells.items()
        if f in measure.ways
    }
    sizes = {f: metric_contents(points, c, f, metric) for f, c in cells.items()}
    unit = {f: 1.0 - near for f, near in unit_shares(domain, lengths).items()}
    optimal = {f: 1.0 - n for f, n in optimal_shares(domain, metric, lengths, sizes).items()}
    values = figures(np.concatenate(list(quality.values())))
    values["n_cells"] = sum(map(len, cells.values()))
    summary = MetricSummary(
        kind=metric.kind,
        source=metric.source,
        edges=told_of(lengths),
        inner=told_of(lengths[domain.is_inner]),
        measure=measure.name,
        **values,
        content=float(sum(s.sum() for s in sizes.values())),
        n_unit=float(sum(s.sum() / unit_content(f) for f, s in sizes.items())),
        unit=_nearness(unit),
        optimal=_nearness(optimal),
    )
    return Judged(quality, unit, optimal, summary)


def _nearness(off: dict[str, Array]) -> Nearness:
    every = np.concatenate(list(off.values()))
    share = np.mean(1.0 - every >= UNIT[0])
    return Nearness(float(every.max()), float(every.mean()), float(share))
