"""Verdicts as SARIF 2.1.0, which code scanning services read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..validity.model import Rule
from .verdict import Finding, Verdict

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def to_sarif(verdicts: list[Verdict], rules: dict[str, Rule], version: str) -> str:
    """All files as one run."""
    codes = list(rules)
    driver = {
        "name": "meshopt",
        "version": version,
        "rules": [_rule(row) for row in rules.values()],
    }
    run = {
        "tool": {"driver": driver},
        "invocations": [
            {
                "executionSuccessful": all(verdict.was_read for verdict in verdicts),
                "toolExecutionNotifications": [
                    {
                        "level": "error",
                        "message": {"text": verdict.error},
                        "locations": [_location(verdict)],
                    }
                    for verdict in verdicts
                    if verdict.error
                ],
            }
        ],
        "results": [
            _result(verdict, finding, codes.index(finding.code))
            for verdict in verdicts
            for finding in verdict.findings
        ],
    }
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=1)


def _rule(row: Rule) -> dict[str, Any]:
    return {
        "id": row.code,
        "name": row.title,
        "shortDescription": {"text": row.title},
        "fullDescription": {"text": row.explanation},
        "help": {"text": row.advice},
        "defaultConfiguration": {"level": row.severity, "enabled": not row.on_request},
    }


def _result(verdict: Verdict, finding: Finding, index: int) -> dict[str, Any]:
    location = _location(verdict)
    location["logicalLocations"] = [
        {"name": name, "fullyQualifiedName": f"{verdict.path}:{name}"} for name in finding.entities
    ]
    total = (verdict.counts or {})[finding.code]
    return {
        "ruleId": finding.code,
        "ruleIndex": index,
        "level": finding.severity,
        "message": {"text": f"{finding.place}: {finding.text}"},
        "locations": [location],
        "properties": {"others": list(finding.others), "where": finding.finite, "total": total},
    }


def _location(verdict: Verdict) -> dict[str, Any]:
    path = Path(verdict.path)
    uri = path.as_uri() if path.is_absolute() else quote(path.as_posix(), errors="replace")
    return {"physicalLocation": {"artifactLocation": {"uri": uri}}}
