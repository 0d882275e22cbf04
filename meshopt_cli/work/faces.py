"""Swaps in plane meshes of triangles and quads (18.4.2, Figure 18.9).

The outline of two faces with an edge in common is divided by another of its diagonals, into faces
of as many corners as before: two triangles have one other way, two quads have two, and a triangle
with a quad has four.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..mesh import adjacency

Array = np.ndarray

# Corners of the two faces: each pair of counts stands once, the greater one last.
KINDS = ((3, 3), (3, 4), (4, 4))


class Swap(NamedTuple):
    """Two faces and what may stand in their places.

    Attributes
    ----------
    rows : (n, 2) int64
        Of the faces: that with fewer corners first.
    faces : (n, 2, 4) int64
        Corners of the new ones, -1 for the fourth of a triangle.
    before, after : (n, 2) float64
        q of the faces.
    edge, other : (n, 2) int64
        Ends of the edge that goes, and of that which comes.
    """

    rows: Array
    faces: Array
    before: Array
    after: Array
    edge: Array
    other: Array

    def vertices(self, k: int) -> Array:
        """The vertices of both faces in one of them."""
        around = self.faces[k].ravel()
        return around[around >= 0]

    def kinds(self, rows: Array) -> dict[str, int]:
        """How many of some are between which faces."""
        n_quads = np.count_nonzero(self.faces[rows, :, 3] >= 0, axis=1)
        return counted(n_quads)

    def chosen(self, rows: Array) -> Swap:
        return Swap(*(column[rows] for column in self))


def counted(n_quads: Array) -> dict[str, int]:
    """How many pairs of faces there are of so many quads each."""
    names = ("triangle-triangle", "triangle-quad", "quad-quad")
    return {name: int(np.count_nonzero(n_quads == n)) for n, name in enumerate(names)}


def swaps(
    faces: Array,
    quality: Array,
    may_meet: Callable[[Array, Array, Array], Array],
    measure: Callable[[Array], Array],
    n_points: int,
) -> Swap:
    """What swaps there are, each pair of faces as often as there are ways to divide them.

    Parameters
    ----------
    faces : (nf, 4) int64
        Corners, anticlockwise; the fourth of a triangle is -1.
    quality : (nf,) float64
    may_meet : function of rows of faces, (n,) each, and the edges between them, (n, 2)
        Which of them may be swapped.
    measure : function of faces
        Gives q.
    """
    parts = [_of_kind(faces, pairs_of(faces, kind, may_meet, n_points), *kind) for kind in KINDS]
    rows, new, edge, other = (np.concatenate(column) for column in zip(*parts, strict=True))
    after = measure(new.reshape(-1, 4)).reshape(-1, 2)
    return Swap(rows, new, quality[rows], after, edge, other)


def best_of(found: Swap) -> Swap:
    """The best way of each pair of faces: of those alike the first."""
    order = np.lexsort([-found.after.min(axis=1), found.rows[:, 1], found.rows[:, 0]])
    rows = found.rows[order]
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return found.chosen(order[first])


def pairs_of(
    faces: Array,
    kind: tuple[int, int],
    may_meet: Callable[[Array, Array, Array], Array],
    n_points: int,
) -> Array:
    """Pairs of faces with so many corners that share an edge, (n, 4): the row of each and which
    of its sides the edge is."""
    n_corners = np.where(faces[:, 3] < 0, 3, 4)
    row, side = np.nonzero(np.arange(4) < n_corners[:, None])
    ends = np.stack([faces[row, side], faces[row, (side + 1) % n_corners[row]]], axis=1)
    order = np.argsort(adjacency.row_keys(ends, n_points), kind="stable")
    keys = adjacency.row_keys(ends[order], n_points)
    same = np.concatenate([[False], keys[1:] == keys[:-1], [False]])
    first = np.flatnonzero(same[1:-1] & ~same[:-2] & ~same[2:])
    one, other = order[first], order[first + 1]
    one, other = (
        np.where(n_corners[row[one]] <= n_corners[row[other]], a, b)
        for a, b in ((one, other), (other, one))
    )
    chosen = (n_corners[row[one]] == kind[0]) & (n_corners[row[other]] == kind[1])
    chosen &= ends[one, 0] == ends[other, 1]
    chosen &= may_meet(row[one], row[other], ends[one])
    one, other = one[chosen], other[chosen]
    return np.stack([row[one], side[one], row[other], side[other]], axis=1)


def _of_kind(
    faces: Array, pairs: Array, fewer: int, more: int
) -> tuple[Array, Array, Array, Array]:
    """Rows, the faces in their places, the ends of the edge that goes and of that which comes."""
    # The outline: from the start of the edge around the second face, then around the first.
    around = [(pairs[:, 2 * k + 1, None] + 1 + np.arange(n)) % n
              for k, n in enumerate((fewer, more))]  # fmt: skip
    first, second = (np.take_along_axis(faces[pairs[:, 2 * k]], around[k], axis=1) for k in (0, 1))
    outline = np.concatenate([second[:, :-1], first[:, :-1]], axis=1)
    k = outline.shape[1]
    # Half of the diagonals of two faces alike are the other half.
    starts = range(1, k if fewer != more else k // 2)
    new = np.full((len(starts), len(pairs), 2, 4), -1)
    ends = np.empty((len(starts), len(pairs), 2), dtype=np.int64)
    for way, start in enumerate(starts):
        new[way, :, 1, :more] = outline[:, (start + np.arange(more)) % k]
        new[way, :, 0, :fewer] = outline[:, (start + more - 1 + np.arange(fewer)) % k]
        ends[way] = outline[:, [start, (start + more - 1) % k]]
    n = len(starts)
    rows, edge = np.tile(pairs[:, [0, 2]], (n, 1)), np.tile(first[:, [0, -1]], (n, 1))
    return rows, new.reshape(-1, 2, 4), edge, ends.reshape(-1, 2)
