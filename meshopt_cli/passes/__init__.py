"""The passes, one file each. `PASSES` is the list that flags, configs and docs follow."""

from __future__ import annotations

from dataclasses import fields

from ..registry import Table
from .base import Operator, Pass
from .check import Check
from .collapse import Collapse
from .confine import Confine
from .fit import Fit
from .mend import Mend
from .nonobtuse import NonObtuse
from .odt import Odt
from .relax import Relax
from .repair import Repair
from .run import UNLIMITED, Budget, Tally, Work
from .smooth import Smooth
from .split import Split
from .swap import Swap
from .untangle import Untangle

PASSES = Table[type[Pass]](
    "meshopt.passes",
    "pass",
    (
        Check,
        Repair,
        Untangle,
        Smooth,
        Swap,
        Collapse,
        Fit,
        Relax,
        Odt,
        NonObtuse,
        Confine,
        Split,
        Mend,
    ),
    lambda row: isinstance(row, type) and issubclass(row, Pass),
)


def option_rows(name: str) -> list[tuple[str, str, str]]:
    """The options of a pass: name, default, help."""
    rows = []
    for f in fields(PASSES[name]):
        choices = " | ".join(f.metadata["choices"])
        help = f.metadata["help"] + (f" [{choices}]" if choices else "")
        rows.append((f.name.replace("_", "-"), f"{f.default}", help))
    return rows


__all__ = [
    "PASSES",
    "UNLIMITED",
    "Budget",
    "Operator",
    "Pass",
    "Tally",
    "Work",
    "option_rows",
]
