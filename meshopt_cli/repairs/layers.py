"""Flat cells at the boundary, one layer of them at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import dimension_of
from ..mesh.model import Array, Mesh
from ..mesh.sizes import area_vectors, norms
from ..mesh.tags import is_identity
from ..validity.examination import Examination
from .edit import New, with_cells, without_cells
from .model import Vertices

# Part of its greatest facet by which another may lean out of the plane of a flat cell.
LEANING = 1e-6

Place = tuple[int, int]  # block and row of a cell


@dataclass(frozen=True)
class _Flat:
    """A flat cell by its facets on either side.

    Attributes
    ----------
    number : int
    bare : list of frozenset of int
        Facets on one side, all of which are boundary.
    covered : list of tuple of int
        Those on the other side that bound another cell, turned as that one sees them.
    """

    number: int
    bare: list[Vertices]
    covered: list[tuple[int, ...]]


def without_layer(study: Examination) -> tuple[Mesh, int, int]:
    """Drop the flat cells of which all facets to one side are boundary.

    The facets on the other side take their place; facets that the file declares are so, too.

    Returns
    -------
    mesh : Mesh
    n_left, n_gone : int
        How many flat cells are left, and how many are not.
    """
    flat = study.shape.flat & ~study.shape.inverted
    n = int(flat.sum())
    found = _at_boundary(study, flat) if n else []
    n_all = sum(len(group.numbers) for group in study.sound_sets)
    if not found or len(found) == n_all:  # something has to be left
        return study.mesh, n, 0
    declared = _Declared(study, found)
    gone = np.zeros(study.n_cells, bool)
    added: list[New] = []
    n_gone = 0
    for cell in found:
        places = declared.places_of(cell)
        if places is None:
            continue
        n_gone += 1
        gone[[cell.number, *(int(study.offsets[b]) + row for b, row in places)]] = True
        if places:
            block, row = places[0]
            kind = study.mesh.blocks[block].type
            added += [New(kind, facet, block, row) for facet in cell.covered]
    if not n_gone:
        return study.mesh, n, 0
    grown = with_cells(study.mesh, added) if added else study.mesh
    ends = zip(study.mesh.blocks, grown.blocks, study.offsets, strict=False)
    more = [
        np.concatenate([gone[first : first + len(old.cells)],
                        np.zeros(len(new.cells) - len(old.cells), bool)])
        for old, new, first in ends
    ]  # fmt: skip
    return without_cells(grown, np.concatenate(more)), n - n_gone, n_gone


def _at_boundary(study: Examination, flat: Array) -> list[_Flat]:
    """The flat cells with one side in the boundary."""
    sides: dict[int, list[tuple[tuple[int, ...], Array, bool]]] = {}
    for facets in study.facet_sets:
        count = np.empty(len(facets.rows), np.int64)
        count[facets.order] = np.repeat(facets.count, facets.count)
        mine = np.flatnonzero(flat[facets.owners])
        vectors = _vectors(study, facets.rows[mine])
        for row, vector, owner, times in zip(
            facets.rows[mine].tolist(), vectors, facets.owners[mine].tolist(),
            count[mine].tolist(), strict=True,
        ):  # fmt: skip
            sides.setdefault(owner, []).append((tuple(row), vector, times == 1))
    return [cell for number in sorted(sides) if (cell := _of(number, sides[number]))]


def _vectors(study: Examination, rows: Array) -> Array:
    """Normals of faces, or edges as vectors: those of a flat cell are all along one line."""
    if rows.shape[1] == 2:
        return study.points[rows[:, 1]] - study.points[rows[:, 0]]
    return area_vectors(study.points, rows)


def _of(number: int, facets: list[tuple[tuple[int, ...], Array, bool]]) -> _Flat | None:
    """A flat cell, if it is flat as a whole and all facets on one side bound it alone."""
    vectors = np.array([vector for _, vector, _ in facets])
    size = norms(vectors)
    along = vectors @ vectors[np.argmax(size)] / size.max() if size.max() else size
    leaning = size**2 - along**2
    if leaning.max() > (LEANING * size.max()) ** 2:
        return None
    side = np.sign(along) * (np.abs(along) > LEANING * size.max())
    alone = np.array([is_alone for *_, is_alone in facets])
    if not alone[side == 0].all():
        return None
    for sign in (1, -1):
        if alone[side == sign].all():
            bare = [frozenset(facet) for (facet, *_), s in zip(facets, side, strict=True)
                    if s != -sign]  # fmt: skip
            covered = [tuple(reversed(facet)) for (facet, _, is_alone) in facets if not is_alone]
            return _Flat(number, bare, covered)
    return None


class _Declared:
    """What a file declares among the vertices of some flat cells."""

    def __init__(self, study: Examination, cells: list[_Flat]) -> None:
        self._blocks = study.mesh.blocks
        near = np.zeros(study.n_points, bool)
        near[[v for cell in cells for facet in cell.bare for v in facet]] = True
        self._facets: dict[Vertices, list[Place]] = {}
        self._smaller: set[Vertices] = set()
        for number, block in enumerate(self._blocks):
            dimension = dimension_of(block.type)
            if dimension >= study.dimension or not len(block.cells):
                continue
            inside = (block.cells >= 0) & (block.cells < study.n_points)
            here = near[np.where(inside, block.cells, 0)] & inside
            for row in np.flatnonzero(here.all(axis=1)).tolist():
                vertices = frozenset(block.cells[row].tolist())
                if dimension == study.dimension - 1:
                    self._facets.setdefault(vertices, []).append((number, row))
                else:
                    self._smaller.add(vertices)
        self._numbers = {
            name
            for block in self._blocks
            for name, values in block.data.items()
            if is_identity(name, values)
        }

    def places_of(self, cell: _Flat) -> list[Place] | None:
        """The declared facets of the bare side; None where they cannot be put on the other one.

        They can where all of the side is declared, and alike, and no edge or vertex goes that is.
        """
        kept = [frozenset(facet) for facet in cell.covered]
        for one in self._smaller:
            in_cell = one <= frozenset.union(*cell.bare, *kept)
            if in_cell and not any(one <= facet for facet in kept):
                return None
        per_facet = [self._facets.get(facet, []) for facet in cell.bare]
        places = [place for found in per_facet for place in found]
        if not places or not kept:
            return places
        if any(len(found) != 1 for found in per_facet):
            return None
        if len({block for block, _ in places}) > 1:
            return None
        block = self._blocks[places[0][0]]
        rows = [row for _, row in places]
        for name, values in block.data.items():
            if name not in self._numbers and (values[rows] != values[rows[0]]).any():
                return None
        return places
