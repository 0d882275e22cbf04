"""What `check` found, as text and as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..formats import Source
    from ..mesh import Mesh
    from ..validity import Finding, Report

MOST_LINES = 10  # findings of one rule that are shown one by one


def _places(finding: Finding, numbering: Any) -> list[str]:
    """The entities of a finding as the file numbers them."""
    places = []
    if finding.block is not None and finding.cell is not None:
        places.append(numbering.cell(finding.block, finding.cell))
    if finding.point is not None:
        places.append(numbering.point(finding.point))
    return places


def line_of(path: Path, finding: Finding, numbering: Any) -> str:
    """One finding as a line: file:cell: CODE message (with others) at coordinates."""
    where = ", ".join(_places(finding, numbering))
    text = f"{path}:{where or 'mesh'}: {finding.code} {finding.message}"
    others = [numbering.cell(*c) for c in finding.other_cells]
    others += [numbering.point(p) for p in finding.other_points]
    if others:
        text += f" ({', '.join(others)})"
    if finding.where is not None:
        text += f" at ({', '.join(f'{x:.6g}' for x in finding.where)})"
    return text


def show_findings(
    path: Path, source: Source, mesh: Mesh, report: Report, err: bool = False
) -> None:
    """Print findings as text, the first of each rule one by one, then how many more there are."""
    from .. import formats

    numbering = formats.numbering(source.encoding, mesh)
    for group in report.groups:
        for finding in group.findings(mesh, MOST_LINES):
            click.echo(line_of(path, finding, numbering), err=err)
        if len(group) > MOST_LINES:
            click.echo(f"{path}: {group.code} {len(group) - MOST_LINES:,} more", err=err)


def _coordinates(finding: Finding) -> list[float | None] | None:
    """Coordinates for JSON, which knows neither nan nor inf."""
    if finding.where is None:
        return None
    return [x if math.isfinite(x) else None for x in finding.where]


def report_dict(path: Path, source: Source, mesh: Mesh, report: Report, status: int) -> dict:
    """Findings of one file as plain values."""
    from .. import formats

    numbering = formats.numbering(source.encoding, mesh)
    findings = []
    for group in report.groups:
        for finding in group.findings(mesh, MOST_LINES):
            findings.append(
                {
                    "code": finding.code,
                    "severity": group.rule.severity,
                    "message": finding.message,
                    "entities": _places(finding, numbering),
                    "others": [numbering.cell(*c) for c in finding.other_cells]
                    + [numbering.point(p) for p in finding.other_points],
                    "where": _coordinates(finding),
                }
            )
    return {
        "path": str(path),
        "format": source.encoding.format,
        "sha256": source.sha256,
        "valid": status == 0,
        "status": status,
        "counts": {group.code: len(group) for group in report.groups},
        "findings": findings,
    }


def dump(values: list[dict]) -> str:
    """The JSON of a check."""
    return json.dumps({"files": values}, indent=1)
