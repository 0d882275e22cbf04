"""Voids that one cell would fill."""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..elements import ELEMENTS, element_of
from ..mesh.adjacency import distinct
from ..mesh.model import Array
from ..validity.boundary import Skin
from ..validity.examination import Examination
from .closing import cell_within
from .edit import New, with_cells
from .model import Mended, Vertices
from .signs import has_one_sign

FILLED = "missing cells added"


def fill(study: Examination) -> Mended:
    """Add the cells that are missing (M211), each with the tags of most cells around it."""
    voids = study.domain.voids if study.is_whole and len(study.domain.skin.rows) else []
    added, n_left = [], 0
    for void in voids:
        cell = _missing(study, void)
        if cell is None:
            n_left += 1
        else:
            added.append(cell)
    left = (f"voids that no valid cell fits in: {n_left:,} left",) if n_left else ()
    mesh = with_cells(study.mesh, added) if added else study.mesh
    return Mended(mesh, {FILLED: len(added)}, left=left)


def _missing(study: Examination, void: Skin) -> New | None:
    """The cell that fills a void; None where none does that is valid and fits to those around."""
    rows = [tuple(row[:width]) for row, width in zip(void.rows.tolist(), void.width, strict=True)]
    found = cell_within(rows, study.dimension)
    if found is None:
        return None
    family, corners = found
    if not has_one_sign(study, np.array([corners]), family)[0]:
        return None
    block, row = study.cells_by(np.array([_donor(study, void.owners)]))[0].tolist()
    around = study.cells_by(distinct(void.owners)).tolist()
    types = {study.mesh.blocks[b].type for b, _ in around}
    if types <= FAMILIES.keys():
        return New(family, corners, block, row)
    middles = _middles(study, around)
    for kind in sorted(types):
        element = ELEMENTS.get(kind)
        if element is not None and element.family == family:
            ends = [frozenset(corners[k] for k in middle) for middle in element.middles]
            if all(one in middles for one in ends):
                return New(kind, (*corners, *(middles[one] for one in ends)), block, row)
    return None


def _middles(study: Examination, cells: list[list[int]]) -> dict[Vertices, int]:
    """The middle nodes of some cells, by block and row: of the edge or face with these corners."""
    found: dict[Vertices, int] = {}
    for block, row in cells:
        nodes = study.mesh.blocks[block].cells[row].tolist()
        element = element_of(study.mesh.blocks[block].type, len(nodes))
        if element is not None:
            own = zip(element.middles, nodes[len(nodes) - len(element.middles) :], strict=True)
            found |= {frozenset(nodes[k] for k in corners): node for corners, node in own}
    return found


def _donor(study: Examination, owners: Array) -> int:
    """The first cell around a void of the region that most of those around it are of."""
    around = distinct(owners)
    if study.region is None:
        return int(around[0])
    _, first, count = np.unique(study.region[around], return_index=True, return_counts=True)
    return int(around[first[np.argmax(count)]])
