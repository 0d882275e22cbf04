"""Limits that a user sets on measures, and how they are written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import ConfigError
from ..registry import Table
from .measures import DEFAULT_MEASURE, MEASURES, Measure, measure_named

# A gate as it is written: a measure, a limit, and where it holds only in a region, that region.
NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
NAME = r"[a-z][a-z0-9-]*(?:\.[a-z][a-z0-9-]*)?"
GATE = re.compile(rf"\s*({NAME})\s*(<=|>=)\s*({NUMBER})\s*(?:@\s*(.*\S)\s*)?")

LONGEST = 100  # what is shown of a gate that is none

IN_METRIC = "M406"  # the rule that reports the figures below


@dataclass(frozen=True)
class Figure:
    """A figure of a whole mesh in a metric, on which there may be a gate.

    Attributes
    ----------
    name : str
    path : str
        What it is of `metric.summary.MetricSummary`.
    summary : str
    """

    name: str
    path: str
    summary: str


FIGURES = {
    figure.name: figure
    for figure in (
        Figure("tau", "edges.tau", "the efficiency index of all edges"),
        Figure("tau-inner", "inner.tau", "that of edges with an end off the boundary"),
        Figure("unit-edges", "edges.share",
               "the part, of 1, of edges with a length from 1/sqrt(2) to sqrt(2)"),
        Figure("unit-edges-inner", "inner.share", "that of edges with an end off the boundary"),
        Figure("metric-q", "worst", "the worst Q in the metric"),
        Figure("metric-q-mean", "mean", "the mean Q in the metric"),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Limit:
    """A limit on a measure of each cell, or on a figure of the mesh.

    Attributes
    ----------
    name : str
        A key of `verdict.table.every_measure`, or of `FIGURES` where the code is `IN_METRIC`.
    is_least : bool
        Whether the value is the least allowed; else it is the greatest.
    value : float
        In degrees for angles, in the unit of the file for lengths.
    region : str, optional
        Name or tag of the only region where it holds.
    code : str
        The rule that reports it.
    """

    name: str
    is_least: bool
    value: float
    region: str | None = None
    code: str = "M404"

    @property
    def measure(self) -> Measure:
        return MEASURES[self.name] if self.name in MEASURES else _every_measure()[self.name]

    def is_broken_by(self, value: float) -> bool:
        """Whether a value is beyond it; one that is not a number is not."""
        return value < self.value if self.is_least else value > self.value

    def __str__(self) -> str:
        where = "" if self.region is None else f" @ {self.region}"
        return f"{self.name} {'>=' if self.is_least else '<='} {self.value:g}{where}"


@dataclass(frozen=True)
class Gates:
    """Limits that the user sets; None where there is none.

    Attributes
    ----------
    fail_above : float or None
        Greatest Q allowed (M401).
    measure : str or None
        By which measure; None means the default one.
    others : tuple of Limit
    of_mesh : tuple of Limit
        On `FIGURES`.
    """

    fail_above: float | None = None
    measure: str | None = None
    others: tuple[Limit, ...] = ()
    of_mesh: tuple[Limit, ...] = ()

    @property
    def limits(self) -> tuple[Limit, ...]:
        """All that are on measures of cells.

        Raises
        ------
        ConfigError
            There is no such measure.
        """
        if self.fail_above is None:
            return self.others
        name = measure_named(self.measure or DEFAULT_MEASURE).name
        return (Limit(name, False, self.fail_above, code="M401"), *self.others)

    @property
    def codes(self) -> tuple[str, ...]:
        """The rules that report what is beyond these limits."""
        return tuple(sorted({limit.code for limit in (*self.limits, *self.of_mesh)}))


NO_GATES = Gates()


def _every_measure() -> Table[Measure]:
    from .verdict.table import every_measure  # seldom needed

    return every_measure()


def limit_of(text: str) -> Limit:
    """A limit as it is written: "dihedral-min>=10", "aspect-ratio<=5 @ steel".

    Raises
    ------
    ConfigError
        It has another form, or names no measure.
    """
    match = GATE.fullmatch(text)
    value = math.inf if match is None else float(match[3])
    shown = repr(text if len(text) <= LONGEST else f"{text[:LONGEST]}...")
    if match is None or math.isinf(value):
        form = '"QUANTITY>=VALUE" or "QUANTITY<=VALUE", and "@ REGION" after it if it has one'
        raise ConfigError(f"gate {shown}: must be {form}; VALUE is a finite number")
    if match[1] in FIGURES:
        if match[4] is not None:
            raise ConfigError(f"gate {shown}: {match[1]} is of the whole mesh, not of a region")
        return Limit(match[1], match[2] == ">=", value, code=IN_METRIC)
    if match[1] not in MEASURES and match[1] not in _every_measure():
        known = ", ".join([*MEASURES, *FIGURES])
        raise ConfigError(
            f"gate {shown}: no quantity {match[1]!r}: choose one of {known}, or FAMILY.NAME of "
            "Verdict: see meshopt list measures"
        )
    return Limit(match[1], match[2] == ">=", value, match[4])


def gates_of(
    fail_above: float | None = None,
    measure: str | None = None,
    min_angle: float | None = None,
    max_angle: float | None = None,
    min_size: float | None = None,
    max_aspect: float | None = None,
    gates: Iterable[str] = (),
) -> Gates:
    """The limits that have options of their own, and all others as `limit_of` reads them.

    Raises
    ------
    ConfigError
        A gate that cannot be understood, or a measure that there is not.
    """
    if measure is not None:
        measure_named(measure)
    limits = [limit_of(text) for text in gates]
    # One of them is for solids, the other for faces.
    both = ("dihedral", "corner")
    if min_angle is not None:
        limits += [Limit(f"{kind}-min", True, min_angle, code="M402") for kind in both]
    if max_angle is not None:
        limits += [Limit(f"{kind}-max", False, max_angle, code="M402") for kind in both]
    if min_size is not None:
        limits.append(Limit("edge-min", True, min_size, code="M403"))
    if max_aspect is not None:
        limits.append(Limit("aspect-ratio", False, max_aspect))
    others = tuple(limit for limit in limits if limit.code != IN_METRIC)
    return Gates(fail_above, measure, others, tuple(x for x in limits if x.code == IN_METRIC))
