"""Cells without content: those that have a vertex twice, and those that are flat."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import chain

import numpy as np

from ..cells import FAMILIES, dimension_of, family_of
from ..mesh.adjacency import distinct_rows
from ..mesh.model import Array, Block, Mesh
from ..validity.examination import Examination
from ..validity.shape import flat_in
from .closing import Row, cell_within
from .divide import without_flat_triangles
from .edit import rows_of
from .layers import without_layer
from .model import Mended

DROPPED, SIMPLER = "flat cells dropped", "cells written as the simpler ones that they are"
# Flat cells may lie on each other: one layer goes after the other.
MOST_LAYERS = 64


def drop_flat(study: Examination) -> Mended:
    """Drop cells without content (M003, M102), where what is left goes on to fit together.

    A cell that has a vertex twice goes where it has no content; else it is of a simpler family,
    and becomes a cell of that. A flat cell goes where all its facets to one side are boundary:
    those on its other side take their place. A flat triangle goes between others, too, where the
    one at its longest edge can be divided.
    """
    mesh, n_gone, n_simpler, n_left = _without_repeated(study)
    counts = {DROPPED: n_gone, SIMPLER: n_simpler}
    n_flat = 0
    for _ in range(MOST_LAYERS):
        if mesh is not study.mesh:
            study = Examination(mesh, tolerance=study.tolerance)
        mesh, n_flat, n = without_layer(study)
        if not n:
            mesh, n = without_flat_triangles(study)
            n_flat -= n
        counts[DROPPED] += n
        if not n:
            break
    left = []
    if n_left:
        left.append(f"cells with a vertex twice that are of no simpler type: {n_left:,} left")
    n_flat += len(flat_in(study, study.lower.sets))
    if n_flat:
        left.append(f"flat cells without which the rest would not fit together: {n_flat:,} left")
    return Mended(mesh, counts, left=tuple(left))


def _without_repeated(study: Examination) -> tuple[Mesh, int, int, int]:
    """The mesh without them, how many are gone, of a simpler family now, and left as they are."""
    repeated = (study.repeated & ~study.out_of_range) | study.repeated_lower
    if not repeated.any():
        return study.mesh, 0, 0, 0
    blocks: list[Block] = []
    n_gone = n_simpler = n_left = 0
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        here = np.flatnonzero(repeated[first : first + len(block.cells)])
        if not len(here):
            blocks.append(block)
            continue
        lower = dimension_of(block.type) < study.dimension
        gone, simpler = (here, []) if lower else _simplified(block, here)
        moved = np.concatenate([gone, *(rows for _, rows, _ in simpler)])
        blocks.append(rows_of(block, np.setdiff1d(np.arange(len(block.cells)), moved)))
        for kind, rows, corners in simpler:
            part = rows_of(block, rows)
            blocks.append(replace(part, type=kind, cells=part.cells[:, list(corners)]))
            n_simpler += len(rows)
        n_gone += len(gone)
        n_left += len(here) - len(moved)
    mesh = replace(study.mesh, blocks=blocks) if n_gone or n_simpler else study.mesh
    return mesh, n_gone, n_simpler, n_left


def _simplified(block: Block, rows: Array) -> tuple[Array, list[tuple[str, Array, Row]]]:
    """Which of some cells with a vertex twice have no content, and which are of another family.

    Returns
    -------
    gone : (n,) int64
        Rows of the block.
    simpler : list of (type, rows, corners)
        The family that they are of, and which of their vertices are its corners.
    """
    family = family_of(block.type)
    assert family is not None
    cells = block.cells[rows, : family.n_corners]
    # Which corner each vertex was first: cells with the same pattern are of the same family.
    pattern = np.argmax(cells[:, :, None] == cells[:, None, :], axis=2)
    kinds, kind, _ = distinct_rows(pattern)
    gone, simpler = [np.empty(0, np.int64)], []
    for number, row in enumerate(kinds.tolist()):
        here = rows[kind == number]
        facets = _facets_of(family.name, row)
        if not facets:
            gone.append(here)
        elif block.type == family.name:
            inside = [tuple(reversed(facet)) for facet in facets]
            found = cell_within(inside, family.dimension)
            if found is not None:
                simpler.append((found[0], here, found[1]))
    return np.concatenate(gone), simpler


def _facets_of(family: str, corners: list[int]) -> list[Row]:
    """The facets of a cell, turned outwards, of which none is twice; of a cell drawn together."""
    facets: list[Row] = []
    width = FAMILIES[family].dimension
    for row in chain.from_iterable(table.tolist() for table in FAMILIES[family].facets):
        around = [corners[k] for k in row]
        facet = tuple(v for v, before in zip(around, around[-1:] + around, strict=False)
                      if v != before)  # fmt: skip
        if len(set(facet)) >= width:
            facets.append(facet)
    # Two that have come to lie on each other enclose nothing.
    times = Counter(frozenset(facet) for facet in facets)
    return [facet for facet in facets if times[frozenset(facet)] == 1]
