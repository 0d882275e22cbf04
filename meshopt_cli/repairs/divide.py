"""Flat triangles between others: they go, and the triangle at their longest edge is divided."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..cells import SIMPLICES, dimension_of
from ..mesh.model import Mesh
from ..validity.examination import Examination
from .edit import New, with_cells, without_cells
from .model import Vertices

# A vertex nearer to an end of the longest edge than this part of it is not between its ends.
NEAR = 1e-6


@dataclass(frozen=True)
class _Division:
    """A flat triangle, its vertex between the ends of its longest edge, and what is beyond that.

    Attributes
    ----------
    flat, beyond : int
        Numbers of cells.
    ends : tuple of int
        Of the longest edge.
    middle : int
    """

    flat: int
    beyond: int
    ends: tuple[int, int]
    middle: int


def without_flat_triangles(study: Examination) -> tuple[Mesh, int]:
    """Drop flat triangles that have a triangle at their longest edge, and divide that in two.

    The vertex between the ends of the edge becomes one of both halves, which have the arrays of
    the whole. No two of the triangles that are changed at a time are the same.

    Returns
    -------
    mesh : Mesh
    n : int
        How many are gone.
    """
    if study.dimension != 2:
        return study.mesh, 0
    chosen = _divisions(study)
    if not chosen:
        return study.mesh, 0
    blocks = [replace(block, cells=block.cells.copy()) for block in study.mesh.blocks]
    added = []
    gone = np.zeros(study.n_cells, bool)
    for one in chosen:
        gone[one.flat] = True
        block, row = study.cells_by(np.array([one.beyond]))[0].tolist()
        nodes = blocks[block].cells[row].tolist()
        first, second = (
            tuple(one.middle if node == end else node for node in nodes) for end in one.ends
        )
        blocks[block].cells[row] = first
        added.append(New(blocks[block].type, second, block, row))
    dropped = without_cells(replace(study.mesh, blocks=blocks), gone)
    # Rows before those that are added have moved up.
    before = np.cumsum(gone) - gone
    starts = study.offsets
    added = [
        replace(one, row=one.row - int(before[starts[one.block] + one.row]
                                       - before[starts[one.block]]))
        for one in added
    ]  # fmt: skip
    return with_cells(dropped, added), len(chosen)


def _divisions(study: Examination) -> list[_Division]:
    flat = study.shape.flat & ~study.shape.inverted
    if not flat.any():
        return []
    pairs = _beyond(study, flat)
    lines = _declared_lines(study)
    busy: set[int] = set()
    chosen = []
    for group in study.sound_sets:
        if group.family != SIMPLICES[2]:
            continue
        for row in np.flatnonzero(flat[group.numbers]).tolist():
            number, corners = int(group.numbers[row]), group.cells[row].tolist()
            found = _longest(study, corners)
            if found is None:
                continue
            ends, middle = found
            beyond = pairs.get((number, frozenset(ends)))
            if beyond is None or frozenset(ends) in lines or {number, beyond} & busy:
                continue
            busy |= {number, beyond}
            chosen.append(_Division(number, beyond, ends, middle))
    return chosen


def _longest(study: Examination, corners: list[int]) -> tuple[tuple[int, int], int] | None:
    """The ends of the longest edge of a flat triangle, and its third vertex; None where that is
    not between the ends."""
    points = study.points[corners]
    squares = ((np.roll(points, -1, axis=0) - points) ** 2).sum(axis=1)
    first = int(np.argmax(squares))
    a, b, middle = (corners[(first + k) % 3] for k in range(3))
    along = study.points[b] - study.points[a]
    share = float((study.points[middle] - study.points[a]) @ along / squares[first])
    return ((a, b), middle) if NEAR < share < 1.0 - NEAR else None


def _beyond(study: Examination, flat: np.ndarray) -> dict[tuple[int, Vertices], int]:
    """The triangle of first order beyond each edge of flat ones, where there is just one that is
    sound and not flat itself."""
    able = np.zeros(study.n_cells, bool)
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        able[first : first + len(block.cells)] = block.type == SIMPLICES[2]
    able &= ~flat
    found = {}
    for facets in study.facet_sets:
        one, other = facets.pairs()
        for mine, yours in ((one, other), (other, one)):
            rows = flat[facets.owners[mine]] & able[facets.owners[yours]]
            for edge, number, beyond in zip(
                facets.rows[mine[rows]].tolist(), facets.owners[mine[rows]].tolist(),
                facets.owners[yours[rows]].tolist(), strict=True,
            ):  # fmt: skip
                found[number, frozenset(edge)] = beyond
    return found


def _declared_lines(study: Examination) -> set[Vertices]:
    """The edges that the file declares."""
    return {
        frozenset(ends)
        for block in study.mesh.blocks
        if dimension_of(block.type) == 1
        for ends in block.cells[:, :2].tolist()
    }
