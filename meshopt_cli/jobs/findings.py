"""From what `check` found in a mesh to a verdict on its file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..reports.verdict import Finding, Verdict

if TYPE_CHECKING:
    from ..formats import Source
    from ..mesh.model import Mesh
    from ..validity import Report

MOST_LINES = 10  # findings of one rule that are shown one by one


def verdict_on(
    path: Path,
    source: Source,
    mesh: Mesh,
    report: Report,
    status: int,
    checked: tuple[str, ...] = (),
    limit: int | None = MOST_LINES,
    error: str = "",
) -> Verdict:
    """What was found, with the entities as the file numbers them.

    Parameters
    ----------
    checked : tuple of str
        Codes of the rules that were looked for.
    limit : int or None
        How many findings of each rule to list; None means all.
    """
    from .. import formats

    numbering = formats.numbering(source.encoding, mesh)
    findings = []
    for group in report.groups:
        for one in group.findings(mesh, limit):
            entities = []
            if one.block is not None and one.cell is not None:
                entities.append(numbering.cell(one.block, one.cell))
            if one.point is not None:
                entities.append(numbering.point(one.point))
            others = [numbering.cell(*cell) for cell in one.other_cells]
            others += [numbering.point(point) for point in one.other_points]
            findings.append(
                Finding(
                    one.code,
                    group.rule.severity,
                    one.message,
                    tuple(entities),
                    tuple(others),
                    one.where,
                )
            )
    return Verdict(
        path=str(path),
        status=status,
        checked=checked,
        counts={group.code: len(group) for group in report.groups},
        severities={group.code: group.rule.severity for group in report.groups},
        findings=tuple(findings),
        format=source.encoding.format,
        sha256=source.sha256,
        error=error,
    )
