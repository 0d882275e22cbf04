"""Verdicts as JUnit XML: a suite a file, a case a rule that was looked for."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

from .check_text import finding_lines
from .verdict import Verdict

# What XML 1.0 cannot hold, not even as a reference.
FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def to_junit(verdicts: list[Verdict], titles: dict[str, str]) -> str:
    """All files as one document."""
    suites = [_suite(verdict, titles) for verdict in verdicts]
    root = ET.Element("testsuites", {"name": "meshopt check", **_sums(suites)})
    root.extend(suites)
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _sums(elements: list[ET.Element]) -> dict[str, str]:
    names = ("tests", "failures", "errors")
    return {name: str(sum(int(e.get(name, 0)) for e in elements)) for name in names}


def _suite(verdict: Verdict, titles: dict[str, str]) -> ET.Element:
    path = _clean(verdict.path)
    suite = ET.Element("testsuite", name=path)
    n_failures = n_errors = 0
    lines = list(finding_lines(verdict))
    severities = verdict.severities or {}
    for code in verdict.checked:
        case = ET.SubElement(suite, "testcase", classname=path, name=f"{code} {titles[code]}")
        if code not in severities:
            continue
        own = [line for line in lines if re.search(rf": {code} ", line)]
        if severities[code] == "error":
            n_failures += 1
            n = (verdict.counts or {})[code]
            text = f"{n:,} {'place' if n == 1 else 'places'}"
            failure = ET.SubElement(case, "failure", type=code, message=text)
            failure.text = _clean("\n".join(own))
        else:
            ET.SubElement(case, "system-out").text = _clean("\n".join(own))
    if verdict.error:
        n_errors += 1
        case = ET.SubElement(suite, "testcase", classname=path, name="the file can be checked")
        ET.SubElement(case, "error", message=_clean(verdict.error))
    suite.set("tests", str(len(suite)))
    suite.set("failures", str(n_failures))
    suite.set("errors", str(n_errors))
    return suite


def _clean(text: str) -> str:
    return FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)
