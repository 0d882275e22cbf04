"""Which nodes of a Gmsh file stand for each other: $Periodic, of all versions."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from ...mesh.periodic import Link
from ..sniff import GmshHeader
from .entities import Entities
from .numbers import COUNT, INTEGER, REAL, Numbers
from .places import Places
from .sink import Sink

_MATRIX = 16  # numbers of an affine map


def read_periodic(content: bytes, header: GmshHeader) -> list[Link]:
    """Read $Periodic; the pairs are of nodes as the file numbers them.

    Before version 4 it is text in binary files too; before 4.1 the word Affine comes before a
    map, and nothing stands in the place of one.
    """
    new = header.version >= 4.1
    if not new:
        content = content.replace(b"Affine", b"-1")
        header = header._replace(text=True)
    numbers = Numbers("Periodic", content, header)
    links = []
    for _ in range(numbers.one()):
        dimension, tag, master = numbers.take(INTEGER, 3).tolist()
        affine: tuple[float, ...] = ()
        if new:
            affine = tuple(numbers.take(REAL, numbers.one()).tolist())
        elif numbers.peek((INTEGER, 1)) == [[-1]]:
            numbers.one()
            affine = tuple(numbers.take(REAL, _MATRIX).tolist())
        (pairs,) = numbers.rows(numbers.one(), (COUNT, 2))
        links.append(Link(dimension, tag, master, affine, pairs))
    return links


def placed(links: list[Link], nodes: Places, entities: Entities, lost: list[str]) -> list[Link]:
    """The links between points of a mesh, on the entities of the model."""
    result = []
    for link in links:
        pairs, there = nodes.there(link.pairs)
        inside = np.logical_and.reduce(there, axis=1)
        if not inside.all():
            lost.append("the pairs of $Periodic with nodes that are not there")
        d = link.dimension
        tag, master = (entities.home((d, tag))[1] for tag in (link.tag, link.master))
        result.append(Link(d, tag, master, link.affine, pairs[inside]))
    return result


def write_periodic(f: BinaryIO, links: list[Link], old: bool, binary: bool) -> None:
    """Write $Periodic, if there are links: `old` is version 2.2, where it is text always."""
    if not links:
        return
    f.write(b"$Periodic\n")
    sink = Sink(f, binary and not old)
    sink.put(("u8", len(links)))
    for link in links:
        sink.put(("i4", (link.dimension, link.tag, link.master)))
        if not old:
            sink.put(("u8", len(link.affine)), ("f8", link.affine))
        elif len(link.affine) == _MATRIX:
            f.write(b"Affine ")
            sink.put(("f8", link.affine))
        sink.put(("u8", len(link.pairs)))
        sink.rows(("u8", link.pairs + 1))
    sink.end("Periodic")
