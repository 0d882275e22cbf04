"""Verdicts as lines for people: one a finding, the rest of each rule counted."""

from __future__ import annotations

from collections.abc import Iterator

from ..errors import shown
from ..validity.model import Rule
from .verdict import Verdict, statistics


def finding_lines(verdict: Verdict) -> Iterator[str]:
    """`file:cell: CODE message`, then how many more of the same there are."""
    more = verdict.more()
    for code in verdict.counts or {}:
        for finding in verdict.findings:
            if finding.code == code:
                yield shown(f"{verdict.path}:{finding.place}: {code} {finding.text}")
        if code in more:
            left, total = more[code]
            yield shown(f"{verdict.path}: {code} {left:,} more, {total:,} in all")


def last_line(verdict: Verdict) -> str:
    """Whether a file is valid, and how much was found."""
    word = "valid" if verdict.is_valid else "not valid"
    counts = ", ".join(
        _counted(verdict.total(severity), severity)
        for severity in ("error", "warning")
        if verdict.total(severity)
    )
    return shown(f"{verdict.path}: {word}") + (f" ({counts})" if counts else "")


def summary_line(verdicts: list[Verdict]) -> str:
    """All files in one line."""
    kinds = {
        "valid": sum(v.is_valid for v in verdicts),
        "not valid": sum(v.was_read and not v.is_valid for v in verdicts),
        "not checked": sum(not v.was_read for v in verdicts),
    }
    return f"{_counted(len(verdicts), 'file')}: " + ", ".join(
        f"{n:,} {kind}" for kind, n in kinds.items() if n
    )


def statistics_lines(verdicts: list[Verdict], titles: dict[str, str]) -> Iterator[str]:
    """How often each rule is broken in all files."""
    counts = statistics(verdicts)
    width = max((len(f"{n:,}") for n in counts.values()), default=0)
    for code, n in counts.items():
        yield f"{n:>{width},} {code} {titles[code]}"


def explanation(rule: Rule) -> str:
    """All that there is to say of a rule."""
    on_request = ", on request (--extend-select)" if rule.on_request else ""
    lines = [f"{rule.code} {rule.title} ({rule.severity}{on_request})", rule.explanation]
    if rule.source:
        lines.append(f"Source: {rule.source}.")
    return "\n".join([*lines, f"Fix: {rule.advice}"])


def _counted(n: int, what: str) -> str:
    return f"{n:,} {what}{'' if n == 1 else 's'}"
