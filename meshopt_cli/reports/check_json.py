"""Verdicts as JSON. Its keys are stable and documented in the README."""

from __future__ import annotations

import json
from typing import Any

from .verdict import Verdict, statistics


def to_json(verdicts: list[Verdict], with_statistics: bool = False) -> str:
    """All files in one object."""
    value: dict[str, Any] = {"files": [_file(verdict) for verdict in verdicts]}
    if with_statistics:
        value["statistics"] = statistics(verdicts)
    return json.dumps(value, indent=1)


def _file(verdict: Verdict) -> dict[str, Any]:
    value: dict[str, Any] = {
        "path": verdict.path,
        "valid": verdict.is_valid,
        "status": verdict.status,
    }
    if verdict.error:
        value["error"] = verdict.error
    if verdict.counts is None:
        return value
    value |= {"format": verdict.format, "sha256": verdict.sha256, "counts": verdict.counts}
    value["findings"] = [
        {
            "code": finding.code,
            "severity": finding.severity,
            "message": finding.message,
            "entities": list(finding.entities),
            "others": list(finding.others),
            "where": finding.finite,
        }
        for finding in verdict.findings
    ]
    return value
