"""Verdicts as workflow commands of GitHub Actions, which shows them on the changed files."""

from __future__ import annotations

from collections.abc import Iterator

from ..errors import shown
from .verdict import Verdict


def commands(verdict: Verdict, titles: dict[str, str]) -> Iterator[str]:
    """One command a finding, one a rule with findings that are not listed, one an error."""
    if verdict.error:
        yield _command("error", verdict.path, "meshopt check", verdict.error)
    more = verdict.more()
    for code, severity in (verdict.severities or {}).items():
        title = f"{code} {titles[code]}"
        for finding in verdict.findings:
            if finding.code == code:
                yield _command(severity, verdict.path, title, f"{finding.place}: {finding.text}")
        if code in more:
            left, total = more[code]
            yield _command(severity, verdict.path, title, f"{left:,} more, {total:,} in all")


def _command(level: str, path: str, title: str, message: str) -> str:
    return f"::{level} file={_property(path)},title={_property(title)}::{_data(message)}"


def _data(text: str) -> str:
    text = text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    return shown(text)


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
