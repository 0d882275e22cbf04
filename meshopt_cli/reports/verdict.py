"""What was found in one file, as plain values that every output of `check` is written from."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import EXIT_BAD_MESH, EXIT_DONE


@dataclass(frozen=True)
class Finding:
    """One place where a rule is broken, as the file numbers its entities.

    Attributes
    ----------
    code, severity, message : str
    entities : tuple of str
        The cell, the point: "element 12", "node 7"; none where it is the whole mesh.
    others : tuple of str
        Cells and points that have a part in it.
    where : tuple of float, optional
        Coordinates; may be infinite or nan.
    """

    code: str
    severity: str
    message: str
    entities: tuple[str, ...]
    others: tuple[str, ...]
    where: tuple[float, ...] | None

    @property
    def place(self) -> str:
        """The entities, or the mesh."""
        return ", ".join(self.entities) or "mesh"

    @property
    def text(self) -> str:
        """The message, with what has a part in it and the coordinates."""
        text = self.message
        if self.others:
            text += f" ({', '.join(self.others)})"
        if self.where is not None:
            text += f" at ({', '.join(f'{x:.6g}' for x in self.where)})"
        return text

    @property
    def finite(self) -> list[float | None] | None:
        """Coordinates for JSON, which knows neither nan nor inf."""
        if self.where is None:
            return None
        return [x if math.isfinite(x) else None for x in self.where]


@dataclass(frozen=True)
class Verdict:
    """What became of one file.

    Attributes
    ----------
    path : str
    status : int
        `EXIT_DONE`, `EXIT_BAD_MESH`, or the exit status of what went wrong.
    checked : tuple of str
        Codes of the rules that were looked for.
    counts : dict of str to int
        How many places break each rule.
    severities : dict of str to str
        Of the rules in `counts`.
    findings : tuple of Finding
        The first of each rule.
    format, sha256 : str
        Empty where the file was not read.
    error : str
        One line: why the file could not be judged, or is none to judge.
    """

    path: str
    status: int
    checked: tuple[str, ...] = ()
    counts: dict[str, int] | None = None
    severities: dict[str, str] | None = None
    findings: tuple[Finding, ...] = ()
    format: str = ""
    sha256: str = ""
    error: str = ""

    @property
    def is_valid(self) -> bool:
        return self.status == EXIT_DONE

    @property
    def was_read(self) -> bool:
        return self.status in (EXIT_DONE, EXIT_BAD_MESH)

    def total(self, severity: str) -> int:
        """How many places break rules of a severity."""
        severities = self.severities or {}
        return sum(n for code, n in (self.counts or {}).items() if severities[code] == severity)

    def more(self) -> dict[str, tuple[int, int]]:
        """For each rule with findings that are not listed: how many, and how many in all."""
        listed = Counter(finding.code for finding in self.findings)
        counts = self.counts or {}
        return {code: (n - listed[code], n) for code, n in counts.items() if n > listed[code]}


def statistics(verdicts: Iterable[Verdict]) -> dict[str, int]:
    """How many places of all files break each rule, in the order of the codes."""
    total: Counter[str] = Counter()
    for verdict in verdicts:
        total.update(verdict.counts or {})
    return dict(sorted(total.items()))
