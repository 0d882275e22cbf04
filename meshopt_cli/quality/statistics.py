"""What measures say of all cells of a family: from where to where they go, and their mean."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..cores import n_cores
from ..errors import ConfigError, hint
from ..mesh.model import Array
from .measurable import Part
from .measures import DEGREES, QUALITIES, Measure

ALL = "all"  # names every measure that some cell of a mesh has
N_BINS = 30
WIDE = 100.0  # positive values that spread by more than this are put into bins by their logarithm
MOST_SPAN = 1e300  # of values that are put into bins, whose edges else may overflow


@dataclass(frozen=True)
class Histogram:
    """How many values are between each edge and the next, the last one included.

    Attributes
    ----------
    edges : tuple of float
        Ascending; two equal ones where all values are.
    counts : tuple of int
        One less.
    is_logarithmic : bool
        Whether the edges have the same ratios, not distances.
    """

    edges: tuple[float, ...]
    counts: tuple[int, ...]
    is_logarithmic: bool = False


@dataclass(frozen=True)
class Statistic:
    """A measure of the cells of one family.

    Attributes
    ----------
    measure, family : str
    unit : str
        A key of `measures.POWERS`.
    ideal : float or None
        The value of the ideal cell, where there is one.
    n_cells : int
    n_infinite : int
        Cells that have no finite value: flat or inverted. The rest is over the others.
    least, mean, greatest : float
        Not a number where no cell has a value.
    histogram : Histogram or None
        Of the finite values, where it was asked for and there are some.
    """

    measure: str
    family: str
    unit: str
    ideal: float | None
    n_cells: int
    n_infinite: int
    least: float
    mean: float
    greatest: float
    histogram: Histogram | None = None


def measures_named(names: Iterable[str]) -> tuple[Measure, ...]:
    """The measures of these names, of any kind; all there are where `ALL` is among them.

    Raises
    ------
    ConfigError
        There is no measure of a name.
    """
    from .verdict.table import every_measure  # seldom needed

    known, wanted = every_measure(), tuple(names)
    for name in wanted:
        if name != ALL and name not in known:
            raise ConfigError(f"no measure {name!r}{hint(name, known)}")
    if ALL in wanted:
        return tuple(known.whole().values())
    return tuple(known[name] for name in dict.fromkeys(wanted))


def table_measure(measures: Iterable[Measure], default: Measure) -> Measure:
    """By which of some measures cells are ranked in Table 18.3: the first that is a Q."""
    return next((m for m in measures if m.name in QUALITIES), default)


def statistics(
    part: Part, measures: Iterable[Measure], with_histograms: bool = False
) -> tuple[Statistic, ...]:
    """What measures say of the cells of a mesh, a family at a time where it has the measure."""
    asked = [(m, family) for m in measures for family in part.cells if family in m.ways]

    def told(one: tuple[Measure, str]) -> Statistic:
        return statistic(*one, values_of(part, *one), with_histograms)

    from concurrent.futures import ThreadPoolExecutor  # seldom needed

    with ThreadPoolExecutor(n_cores()) as pool:  # numpy lets several work at once
        return tuple(pool.map(told, asked))


def values_of(part: Part, measure: Measure, family: str) -> Array:
    """A measure of each cell of a family, (n,): infinite Q for those turned the wrong way."""
    values = measure.of(part.points, part.cells[family], family)
    if measure.is_quality:
        values[part.is_turned(family)] = math.inf
    return values


def statistic(
    measure: Measure, family: str, values: Array, with_histogram: bool = False
) -> Statistic:
    """What is told of the values of a measure, (n,)."""
    finite = values[np.isfinite(values)]
    some = (finite.min(), finite.mean(), finite.max()) if len(finite) else (math.nan,) * 3
    least, mean, greatest = (float(value) for value in some)
    found = histogram_of(finite, measure.unit) if with_histogram else None
    return Statistic(
        measure.name, family, measure.unit, measure.ideal,
        len(values), len(values) - len(finite), least, mean, greatest, found,
    )  # fmt: skip


def histogram_of(values: Array, unit: str) -> Histogram | None:
    """Finite values in bins, (n,); None for no values, or such as no bins can be made for."""
    if not len(values):
        return None
    least, greatest = float(values.min()), float(values.max())
    if greatest - least > MOST_SPAN:
        return None
    if least == greatest:
        return Histogram((least, greatest), (len(values),))
    is_logarithmic = False
    if unit == DEGREES and least >= 0.0 and greatest <= 360.0:
        # The same for all meshes, so that pictures can be compared.
        edges = np.linspace(0.0, 180.0, 37) if greatest <= 180.0 else np.linspace(0.0, 360.0, 37)
    else:
        is_logarithmic = least > 0.0 and greatest / WIDE > least
        edges = (np.geomspace if is_logarithmic else np.linspace)(least, greatest, N_BINS + 1)
        edges = np.unique(np.clip(edges, least, greatest))  # may be as near as numbers are
    counts, _ = np.histogram(values, edges)
    return Histogram(tuple(edges.tolist()), tuple(counts.tolist()), is_logarithmic)
