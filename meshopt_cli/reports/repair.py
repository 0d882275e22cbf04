"""What a repair did, as lines for people and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import shown
from .check_text import finding_lines
from .verdict import Verdict


@dataclass(frozen=True)
class RepairReport:
    """The mends of one mesh.

    Attributes
    ----------
    version : str
        Of this program.
    before : dict of str to int
        How many places of the input broke each rule.
    after : Verdict
        On the mesh that was written.
    mends : dict of str to dict of str to int
        How many of what each mend changed.
    notes : tuple of str
        What could not be mended, or is to be known.
    lost : tuple of str
        What of the input is not in the output.
    """

    version: str
    input: str
    before: Mapping[str, int]
    after: Verdict
    mends: Mapping[str, Mapping[str, int]]
    notes: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()


def repair_lines(report: RepairReport, titles: Mapping[str, str]) -> Iterator[str]:
    """What changed, which rules are still broken, and what is left to know."""
    return map(shown, _repair_lines(report, titles))


def _repair_lines(report: RepairReport, titles: Mapping[str, str]) -> Iterator[str]:
    counts = {what: n for mend in report.mends.values() for what, n in mend.items() if n}
    for what, n in counts.items():
        yield f"{report.input}: {what}: {n:,}"
    if not counts:
        yield f"{report.input}: nothing to mend"
    for note in report.notes:
        yield f"{report.input}: {note}"
    after = report.after.counts or {}
    for code in sorted({*report.before, *after}):
        was, now = report.before.get(code, 0), after.get(code, 0)
        left = f"{now:,} left" if now else "none left"
        yield f"{report.input}: {code} {titles[code]}: {was:,}, {left}"


def left_lines(report: RepairReport) -> Iterator[str]:
    """What `check` still finds in the mesh that was written."""
    yield from finding_lines(report.after)


def to_json(report: RepairReport) -> str:
    """The report as an object. Its keys are stable and documented in the README."""
    values: dict[str, Any] = {
        "meshopt": report.version,
        "input": report.input,
        "output": report.after.path,
        "mends": {name: dict(counts) for name, counts in report.mends.items()},
        "notes": list(report.notes),
        "before": dict(report.before),
        "after": dict(report.after.counts or {}),
        "valid": report.after.is_valid,
        "lost": list(report.lost),
    }
    return json.dumps(values, indent=1) + "\n"
