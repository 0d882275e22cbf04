"""Straight ridges of a boundary that were split: the edges that the file declares there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..kernels.guide import LINE
from ..mesh.cast import Simplices
from ..mesh.model import Block, Mesh
from .patches import Patches, sides_of_edges

Array = np.ndarray
Ends = tuple[int, int]  # of a ridge: points of the input, the lesser one first


def lines_anew(
    mesh: Mesh, result: Mesh, patches: Patches, worked: Simplices, patch: Array, origin: Array
) -> Mesh:
    """Declare what became of the declared edges of straight ridges as they were.

    Parameters
    ----------
    mesh, result : Mesh
        Before the work, and after it as `cast.with_simplices` gives it.
    patch : (n,) int64
        Of each outer facet of `worked`.
    origin : (np',) int64
        The point of `mesh` that each point of the result was, -1 for a new one.
    """
    if not any(block.type == "line" and len(block.cells) for block in mesh.blocks):
        return result
    slides = patches.guide[:, 0] == LINE
    before = _ridges(patches.facets, patches.patch, slides, np.arange(len(slides)))
    after = _ridges(worked.outer, patch, (origin < 0) | slides[origin], origin)
    # Of each edge of a ridge that is no longer what it was: the ridge.
    changed: dict[Ends, Ends] = {}
    for ends, chain in before.items():
        if ends in after and origin[after[ends]].tolist() != chain:
            changed.update((_key(pair), ends) for pair in pairwise(chain))
    if not changed:
        return result
    number = np.full(len(mesh.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    old = iter(block for block in mesh.blocks if block.type == "line")
    blocks = [
        _declared(next(old), block, changed, after, number) if block.type == "line" else block
        for block in result.blocks
    ]
    return replace(result, blocks=blocks)


def _key(ends: Iterable[int]) -> Ends:
    a, b = ends
    return min(a, b), max(a, b)


def _declared(
    old: Block, block: Block, changed: dict[Ends, Ends], after: dict[Ends, list[int]], number: Array
) -> Block:
    """A block of declared edges, with all pieces of a ridge where it had some that changed.

    Parameters
    ----------
    old, block : Block
        Before the work, and after it without the edges whose vertices are gone.
    number : (np,) int64
        Where each point is now, -1 where it is gone.
    """
    ridges = [changed.get(_key(edge)) for edge in old.cells.tolist()]
    stays = np.array([ends is None for ends in ridges], bool)
    there = (number[old.cells] >= 0).all(axis=1)
    cells, rows = block.cells[stays[there]].tolist(), np.flatnonzero(stays & there).tolist()
    # They carry the same tags along a ridge: else a vertex between them would not slide.
    first = {ends: row for row, ends in reversed(list(enumerate(ridges))) if ends is not None}
    for ends, row in sorted(first.items()):
        pieces = list(pairwise(after[ends]))
        cells += pieces
        rows += [row] * len(pieces)
    data = {name: values[rows] for name, values in old.data.items()}
    made = np.array(cells, np.int64).reshape(-1, 2)
    return replace(block, cells=made, data=data, numbers=None)


def _ridges(facets: Array, patch: Array, slides: Array, origin: Array) -> dict[Ends, list[int]]:
    """The straight ridges between patches, by their ends: all vertices of each in turn.

    Parameters
    ----------
    slides : (np,) bool
        Vertices within a straight ridge, among others that are on none.
    origin : (np,) int64
        What a point is called as an end.
    """
    edges, one, other, _ = sides_of_edges(facets, len(slides))
    around: dict[int, list[int]] = {}
    for a, b in edges[patch[one] != patch[other]].tolist():
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    found: dict[Ends, list[int]] = {}
    for start, others in around.items():
        if slides[start]:
            continue
        for second in others:
            chain = [start, second]
            while slides[chain[-1]]:
                last = chain[-1]
                chain.append(next(v for v in around[last] if v != chain[-2]))
            ends = int(origin[start]), int(origin[chain[-1]])
            if ends[0] < ends[1]:
                found[ends] = chain
    return found
