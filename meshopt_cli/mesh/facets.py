"""Cells of one family, and their facets, those of several cells side by side.

For cells of every family, numbered through all of them; of simplices alone, `adjacency` knows more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES
from .adjacency import row_ids
from .model import Array


@dataclass(frozen=True)
class CellSet:
    """Cells of one family by their corners: (n, k) int64, and their (n,) numbers in all."""

    family: str
    cells: Array
    numbers: Array


@dataclass(frozen=True)
class FacetSet:
    """Facets with the same count of vertices, sorted so that equal ones stand together.

    Attributes
    ----------
    rows : (m, w) int64
        Vertices, turned as their cells turn them.
    owners : (m,) int64
        Number of the cell of each.
    order : (m,) int64
        Rows in which equal facets follow each other, first cells first.
    start, count : (r,) int64
        Each run of equal facets is `order[start:start + count]`.
    """

    rows: Array
    owners: Array
    order: Array
    start: Array
    count: Array

    def alone(self) -> Array:
        """Rows of the facets that bound one cell only."""
        return self.order[self.start[self.count == 1]]

    def pairs(self) -> tuple[Array, Array]:
        """Rows of the two facets, wherever exactly two cells meet."""
        start = self.start[self.count == 2]
        return self.order[start], self.order[start + 1]


def facets_of(cell_sets: list[CellSet], n_points: int) -> list[FacetSet]:
    """The facets of some cells, by their number of vertices."""
    parts: dict[int, list[tuple[Array, Array]]] = {}
    for group in cell_sets:
        for table in FAMILIES[group.family].facets:
            width = table.shape[1]
            rows = np.take(group.cells, table, axis=1).reshape(-1, width)
            parts.setdefault(width, []).append((rows, np.repeat(group.numbers, len(table))))
    sets = []
    for lists in parts.values():
        rows, owners = joined(lists)
        ids = row_ids(rows, n_points)
        order, start = _equal_together(ids)
        sets.append(FacetSet(rows, owners, order, start, np.diff(start, append=len(ids))))
    return sets


def _equal_together(ids: Array) -> tuple[Array, Array]:
    """Rows in an order in which equal ids follow each other, first rows first, and their starts.

    Most runs are pairs: to sort without regard to order and to put pairs right takes half the
    time of a stable sort.
    """
    order = np.argsort(ids)
    ids = ids[order]
    start = np.flatnonzero(np.concatenate([[True], ids[1:] != ids[:-1]])[: len(ids)])
    count = np.diff(start, append=len(ids))
    pair = start[count == 2]
    one, other = order[pair], order[pair + 1]
    order[pair], order[pair + 1] = np.minimum(one, other), np.maximum(one, other)
    for first, n in zip(start[count > 2].tolist(), count[count > 2].tolist(), strict=True):
        order[first : first + n].sort()
    return order, start


def joined(parts: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Pairs of arrays, one after the other; the most common single pair is not copied."""
    if len(parts) == 1:
        return parts[0]
    return np.concatenate([one for one, _ in parts]), np.concatenate([two for _, two in parts])
