"""The table of measures: all that can be told of one cell, in a number.

Reports, limits, lists and `--measure` read it. What is measured by compiled code imports it when
it is measured, so that the table itself needs none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..errors import chosen
from ..mesh.model import Array
from ..mesh.sizes import chunks, unfolded
from . import formulas, quads

if TYPE_CHECKING:
    from ..kernels.types import Judge

LESS, MORE = "less", "more"

# Units, and the power of a length that each is; None for that of the dimension of the cells.
NUMBER, DEGREES, STERADIANS, LENGTH, CONTENT = "1", "deg", "sr", "length", "length^d"
POWERS = {NUMBER: 0, DEGREES: 0, STERADIANS: 0, LENGTH: 1, CONTENT: None}


@dataclass(frozen=True)
class Way:
    """How a measure is found for the cells of one family.

    Attributes
    ----------
    source : str
        Where the chapter defines it: "18.7", "Definition 18.1"; empty where it does not.
    kernel : str
        The name that its code has in `kernels.shape.simplex`, where it is compiled; it then gives
        1/Q (Remark 18.3), negative for an inverted cell.
    by : str
        For cells that are no simplices: a key of `parts.WAYS`, which says what of them is measured.
    function : function of points, cells and family, optional
        See `formulas`, where it is not.
    at_once : bool
        Whether it takes all cells at once, as where it compares them with each other.
    """

    source: str
    kernel: str = ""
    by: str = ""
    function: Callable[[Array, Array, str], Array] | None = None
    at_once: bool = False


@dataclass(frozen=True)
class Measure:
    """A row of `MEASURES`.

    Attributes
    ----------
    name : str
        As users type it.
    ways : dict of str to Way
        By the families of cells that have it.
    formula : str
        What it is, for people.
    unit : str
        A key of `POWERS`.
    better : str
        `LESS` or `MORE`.
    ideal : float or None
        Its value for the ideal cell of every family, where there is one.
    drives : bool
        Whether it tells all bad shapes from good ones, so that it can steer an optimization.
    """

    name: str
    ways: dict[str, Way]
    formula: str
    unit: str
    better: str
    ideal: float | None = None
    drives: bool = False

    @property
    def is_quality(self) -> bool:
        """Whether it is a Q: 1 for the ideal cell, greater as a cell degrades."""
        return (self.unit, self.ideal, self.better) == (NUMBER, 1.0, LESS)

    @property
    def is_compiled(self) -> bool:
        """Whether a kernel finds it for some family."""
        return any(way.kernel for way in self.ways.values())

    def is_direct(self, family: str) -> bool:
        """Whether a kernel finds it for the cells of a family as they are."""
        way = self.ways.get(family)
        return way is not None and bool(way.kernel) and not way.by

    @property
    def judge(self) -> Judge:
        """What the kernels judge by, where it alone counts; only if it is compiled."""
        from ..kernels.shape import simplex
        from ..kernels.types import Judge

        (name,) = {way.kernel for way in self.ways.values() if way.kernel}
        return Judge(getattr(simplex, name), 0.0)

    def power(self, dimension: int) -> int:
        """The power of a length that it is for cells of a dimension."""
        power = POWERS[self.unit]
        return dimension if power is None else power

    def of(self, points: Array, cells: Array, family: str) -> Array:
        """Its value for each of some cells, whichever their orientation, (n,) float64.

        Parameters
        ----------
        points : (np, 3) float64
        cells : (n, k) int64
            Corners.
        family : str
            A key of `ways`. Triangles are each measured in a plane of their own.
        """
        way = self.ways[family]
        if way.by:
            from . import parts

            worst = partial(parts.WAYS[way.by], self.judge)
            return as_degradation(_in_chunks(worst, points, cells, family))
        if way.function is None:
            if FAMILIES[family].dimension == 2:
                points, cells = unfolded(points, cells)
            return as_degradation(np.abs(cell_quality(points, cells, self)))
        if way.at_once:
            return way.function(points, cells, family)
        return _in_chunks(way.function, points, cells, family)


def _in_chunks(
    function: Callable[[Array, Array, str], Array], points: Array, cells: Array, family: str
) -> Array:
    found = [function(points, cells[rows], family) for rows in chunks(len(cells))]
    return np.concatenate([np.empty(0), *found])


_FACES = tuple(name for name, row in FAMILIES.items() if row.dimension == 2)
_SOLIDS = tuple(name for name, row in FAMILIES.items() if row.dimension == 3)
_SIMPLICES = SIMPLICES[2:]
_OTHERS = tuple(name for name in _FACES + _SOLIDS if name not in _SIMPLICES)
_WITH_QUADS = (
    "quad",
    *(name for name in _OTHERS if any(table.shape[1] == 4 for table in FAMILIES[name].facets)),
)


def _quality(
    name: str,
    kernel: str,
    sources: tuple[str, str],
    formula: str,
    drives: bool = True,
    others: dict[str, Way] | None = None,
) -> Measure:
    """A Q of triangles and tetrahedra that the kernels know, with its source for each."""
    ways = {family: Way(source, kernel) for family, source in zip(_SIMPLICES, sources, strict=True)}
    return Measure(name, ways | (others or {}), formula, NUMBER, LESS, 1.0, drives)


def _alike(
    families: Iterable[str], source: str, function: Callable[[Array, Array, str], Array]
) -> dict[str, Way]:
    """The same way for several families."""
    return {family: Way(source, function=function) for family in families}


def _by(part: str, families: Iterable[str], kernel: str, source: str = "18.2.4") -> dict[str, Way]:
    """The worst of some parts of cells that are no simplices."""
    return {family: Way(source, kernel, part) for family in families}


MEASURES: dict[str, Measure] = {
    m.name: m
    for m in (
        _quality("aspect-ratio", "ASPECT_RATIO", ("18.6", "18.7"),
                 "h_max / rho = h_max S / V; quads h_max h_s / S_min; else by the corners",
                 others=_alike(["quad"], "18.10", quads.aspect)
                 | _by("corners", _OTHERS[1:], "ASPECT_RATIO")),
        _quality("volume-length", "VOLUME_LENGTH", ("18.8", "18.9"), "h_s^3 / V",
                 others=_by("corners", _OTHERS, "VOLUME_LENGTH")),
        _quality("radius-ratio", "RADIUS_RATIO", ("18.2.2", "18.2.2"), "r / rho",
                 others=_by("corners", _OTHERS, "RADIUS_RATIO")),
        _quality("mean-edge", "MEAN_EDGE", ("18.2.2", "18.2.2"), "h_mean^3 / V",
                 others=_by("corners", _OTHERS, "MEAN_EDGE")),
        _quality("volume-area", "VOLUME_AREA", ("18.2.2", "18.2.2"), "(sum S_i^2)^3 / V^4",
                 others=_by("corners", _OTHERS, "VOLUME_AREA")),
        _quality("angle-min", "ANGLE_MIN", ("Exercise 18.3", "Definition 18.1"),
                 "regular angle / least angle"),
        _quality("angle-max", "ANGLE_MAX", ("Exercise 18.3", "Definition 18.1"),
                 "(pi - regular angle) / (pi - greatest angle)"),
        _quality("solid-angle-min", "SOLID_ANGLE_MIN", ("Exercise 18.3", "Definition 18.2"),
                 "regular solid angle / least solid angle"),
        _quality("scaled-jacobian", "SCALED_JACOBIAN", ("Knupp 2000", "Knupp 2000"),
                 "product of edges / det at the worst corner, next to the ideal one",
                 others=_alike(_OTHERS, "Knupp 2000", formulas.scaled_jacobian)),
        _quality("radius-edge", "RADIUS_EDGE", ("18.2.2", "18.2.2"), "r / h_min", drives=False),
        _quality("edge-ratio", "EDGE_RATIO", ("18.2.2", "18.2.2"), "h_max / h_min", drives=False,
                 others=_alike(_OTHERS, "18.2.2", formulas.edge_ratio)),
        Measure("worst-simplex", _alike(["quad"], "Remark 18.5", quads.worst_triangle)
                | _by("parts", _OTHERS[1:], "ASPECT_RATIO"),
                "worst simplex of all partitions, and worst face", NUMBER, LESS, 1.0),
        Measure("face-aspect", _by("faces", _SOLIDS, "ASPECT_RATIO"),
                "Q of the worst face", NUMBER, LESS, 1.0),
        Measure("robinson-aspect", _alike(["quad"], "Robinson 1987", quads.robinson_aspect),
                "max(e2 / f3, f3 / e2)", NUMBER, LESS, 1.0),
        Measure("robinson-skew", _alike(["quad"], "Robinson 1987", quads.robinson_skew),
                "e3 / f3", NUMBER, LESS, 0.0),
        Measure("robinson-taper-x", _alike(["quad"], "Robinson 1987", quads.robinson_taper_x),
                "f4 / f3", NUMBER, LESS, 0.0),
        Measure("robinson-taper-y", _alike(["quad"], "Robinson 1987", quads.robinson_taper_y),
                "e4 / e2", NUMBER, LESS, 0.0),
        Measure("smoothness", _alike(_WITH_QUADS, "18.11", quads.smoothness),
                "least (1 + n . n') / 2 over diagonals of quads", NUMBER, MORE, 1.0),
        Measure("torsion", _alike(_WITH_QUADS, "18.2.4", quads.torsion),
                "greatest fold of a quad along a diagonal", DEGREES, LESS, 0.0),
        Measure("radius-diameter", _alike(_SIMPLICES, "18.2.2", formulas.radius_diameter),
                "r / h_max", NUMBER, LESS),
        Measure("edge-share", _alike(_FACES + _SOLIDS, "18.2.2", formulas.edge_share),
                "h_min / h_max", NUMBER, MORE, 1.0),
        Measure("dihedral-min", _alike(_SOLIDS, "Definition 18.1", formulas.dihedral_min),
                "least angle between two facets", DEGREES, MORE),
        Measure("dihedral-max", _alike(_SOLIDS, "Definition 18.1", formulas.dihedral_max),
                "greatest angle between two facets", DEGREES, LESS),
        Measure("solid-min", _alike(_SOLIDS, "Definition 18.2", formulas.solid_min),
                "least solid angle at a vertex", STERADIANS, MORE),
        Measure("corner-min", _alike(_FACES, "Exercise 18.3", formulas.corner_min),
                "least angle of a face in the plane", DEGREES, MORE),
        Measure("corner-max", _alike(_FACES, "Exercise 18.3", formulas.corner_max),
                "greatest angle of a face in the plane", DEGREES, LESS),
        Measure("edge-min", _alike(_FACES + _SOLIDS, "18.2.2", formulas.edge_min),
                "shortest edge", LENGTH, MORE),
        Measure("edge-max", _alike(_FACES + _SOLIDS, "18.2.2", formulas.edge_max),
                "longest edge", LENGTH, LESS),
        Measure("height-min", _alike(_SIMPLICES, "", formulas.height_min),
                "least height over a facet", LENGTH, MORE),
        Measure("content", _alike(_FACES, "18.1, 18.2", formulas.content)
                | _alike(_SOLIDS, "18.3, 18.4", formulas.content), "volume, or area", CONTENT,
                MORE),
    )
}  # fmt: skip

# Those that are a Q, which reports and optimizations go by.
QUALITIES: dict[str, Measure] = {name: m for name, m in MEASURES.items() if m.is_quality}

# Those that kernels find for triangles and tetrahedra.
OF_SIMPLICES: dict[str, Measure] = {
    name: m for name, m in QUALITIES.items() if all(m.is_direct(family) for family in _SIMPLICES)
}

DEFAULT_MEASURE = "aspect-ratio"


def measure_named(name: str) -> Measure:
    """The measure of this name, which must be a Q.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    return chosen(QUALITIES, name, "measure")


def cell_quality(points: Array, cells: Array, measure: Measure) -> Array:
    """q = 1/Q of each cell, (ne,), negative for inverted ones.

    Parameters
    ----------
    points : (np, 3) float64
        With z = 0 for triangles.
    cells : (ne, 3) or (ne, 4) int64
    measure : Measure
        One that is compiled.
    """
    from ..kernels.judge import measure_cells

    q = np.empty(len(cells))
    measure_cells(measure.judge, points, cells, q)
    return q


def as_degradation(q: Array) -> Array:
    """Q = 1/q, infinite for flat and inverted cells (Remark 18.3)."""
    result = np.full(len(q), math.inf)
    with np.errstate(over="ignore"):
        np.divide(1.0, q, out=result, where=q > 0.0)
    return result
