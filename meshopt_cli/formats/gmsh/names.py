"""The names of physical groups."""

from __future__ import annotations

import re

from ...cells import dimension_of
from ...mesh.model import Block, Mesh
from ...mesh.tags import PHYSICAL
from ..sniff import UnreadableError

_NAME = re.compile(rb'^[ \t]*(?:(-?\d+)[ \t]+)?(-?\d+)[ \t]+(?:"([^"\r\n]*)"|(\S+))', re.MULTILINE)
_COUNT = re.compile(rb"\s*(\d+)[ \t]*\r?\n?")

# Dimension, None where the file does not say it, tag, and name.
Names = list[tuple[int | None, int, str]]


def decoded(text: bytes) -> str:
    """A text as UTF-8, and as Latin-1 where it is not that."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def read_names(content: bytes) -> Names:
    """Read $PhysicalNames; lines of version 2.0 have no dimension."""
    count = _COUNT.match(content)
    if not count:
        raise UnreadableError("in the section $PhysicalNames, a count was expected")
    n = int(count[1])
    found = list(_NAME.finditer(content, count.end()))[:n]
    if len(found) < n:
        raise UnreadableError(f"$PhysicalNames announces {n} names, and {len(found)} are found")
    return [
        (None if m[1] is None else int(m[1]), int(m[2]), decoded(m[3] if m[4] is None else m[4]))
        for m in found
    ]


def attach_names(mesh: Mesh, names: Names, lost: list[str]) -> None:
    """Give a mesh the names of its groups.

    One without a dimension is for those that have cells in a group of this tag, or for that of
    the mesh where none has.
    """
    for said, tag, name in names:
        if not name:
            continue
        here = {dimension_of(b.type) for b in mesh.blocks if said is None and _has(b, tag)}
        for dimension in sorted(here) or [max(mesh.dimension(), 0) if said is None else said]:
            if mesh.names.setdefault((dimension, tag), name) != name:
                lost.append(f"the name {name} of a group that has another")


def _has(block: Block, tag: int) -> bool:
    return bool((block.data[PHYSICAL] == tag).any()) if PHYSICAL in block.data else False
