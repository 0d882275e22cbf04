"""The measures of Verdict as rows of the table of measures: `quad.skew`, `tetra.collapse-ratio`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

from ...cells import FAMILIES
from ...mesh.model import Array
from ...registry import Table
from ..measures import CONTENT, LENGTH, MEASURES, MORE, NUMBER, Measure, Way
from ..measures import DEGREES as DEG
from . import VERDICT, verdict_quality
from .model import AREA, DEGREES, VOLUME, Row
from .model import LENGTH as OF_LENGTH

_UNITS = {DEGREES: DEG, OF_LENGTH: LENGTH, AREA: CONTENT, VOLUME: CONTENT}


def _measured(name: str, points: Array, cells: Array, family: str) -> Array:
    return verdict_quality(points, cells, family, name)


def _as_measure(row: Row) -> Measure:
    function: Callable[[Array, Array, str], Array] = partial(_measured, row.name)
    way = Way(f"Verdict{'; ' + row.note if row.note else ''}", function=function, at_once=True)
    name = f"{row.cell_type}.{row.name}"
    unit = _UNITS.get(row.unit, NUMBER)
    return Measure(name, {row.cell_type: way}, row.formula, unit, row.better or MORE, row.ideal)


@cache
def every_measure() -> Table[Measure]:
    """All that a limit can be put on: `MEASURES`, then those of Verdict by their families.

    Those of others are told in reports, and hold in gates; none of them steers, which takes code
    that is compiled into every operator.
    """
    rows = sorted(VERDICT.values(), key=lambda row: list(FAMILIES).index(row.cell_type))
    ours = (*MEASURES.values(), *map(_as_measure, rows))
    return Table("meshopt.measures", "measure", ours, _is_plugin)


def _is_plugin(row: object) -> bool:
    return isinstance(row, Measure) and not row.drives and not row.is_compiled
