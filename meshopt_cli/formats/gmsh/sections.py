"""The sections of a Gmsh file, in the order they stand there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from ..sniff import GMSH_1, MARGIN, GmshHeader, UnreadableError, gmsh_header

_START = re.compile(rb"^(?:\xef\xbb\xbf)?[ \t]*\$(?!End)(?!END)(\w+)[ \t]*\r?\n", re.MULTILINE)
_CUT = re.compile(rb"^[ \t]*\$(?!End)(?!END)\w*\Z", re.MULTILINE)
_FIRST = GmshHeader(1.0, True, 8, "<")
# The names of version 1, and what they are called since.
_LATER_NAMES = {"NOD": "Nodes", "NOE": "Nodes", "ELM": "Elements", "PARA": "ParametricNodes"}


class Section(NamedTuple):
    """A section: its name in the later versions, and all that stands between its two lines.

    `start` is where that is in the file.
    """

    name: str
    content: bytes
    start: int


def header_of(data: bytes) -> GmshHeader:
    """What a file says about itself; one that starts with nodes is of version 1."""
    if data[:MARGIN].lstrip().startswith(GMSH_1):
        return _FIRST
    return next((gmsh_header(s.content) for s in sections(data) if s.name == "MeshFormat"), _FIRST)


def sections(data: bytes) -> Iterator[Section]:
    """Go through the sections of a file; what stands between them is passed over, as Gmsh does.

    Raises
    ------
    UnreadableError
        One has no end, or the file stops in the first line of one.
    """
    at = 0
    while match := _START.search(data, at):
        name = match[1]
        last = (b"$END" if name.decode() in _LATER_NAMES else b"$End") + name
        end = data.find(last, match.end())
        if end < 0:
            raise UnreadableError(f"truncated: the section ${name.decode()} has no end")
        if data.find(b"\n$" + name, match.end(), end) >= 0:  # it starts once more: no end so far
            end, last = data.find(b"\n$", match.end(), end) + 1, b"$"  # which is misspelt
        later = _LATER_NAMES.get(name.decode(), name.decode())
        yield Section(later, data[match.end() : end], match.end())
        at = end + len(last)
    if _CUT.search(data[at:].rstrip()):
        raise UnreadableError("truncated: it ends in the first line of a section")
