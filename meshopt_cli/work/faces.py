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
    """Two faces and the best that may stand in their places.

    Attributes
    ----------
    rows : (n, 2) int64
        Of the faces: that with fewer corners first.
    faces : (n, 2, 4) int64
        Corners of the new ones, -1 for the fourth of a triangle.
    before, after : (n, 2) float64
        q of the faces.
    """

    rows: Array
    faces: Array
    before: Array
    after: Array


def swaps(
    faces: Array,
    quality: Array,
    may_meet: Callable[[Array, Array, Array], Array],
    measure: Callable[[Array], Array],
    n_points: int,
) -> Swap:
    """What swaps there are, each pair of faces once.

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
    found = [_of_kind(faces, pair, *kind, measure) for kind in KINDS
             for pair in [_pairs(faces, kind, may_meet, n_points)] if len(pair)]  # fmt: skip
    if not found:
        return Swap(np.empty((0, 2), np.int64), np.empty((0, 2, 4), np.int64), *np.empty((2, 0, 2)))
    rows, others, after = (np.concatenate(column) for column in zip(*found, strict=True))
    return Swap(rows, others, quality[rows], after)


def _pairs(
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
    faces: Array, pairs: Array, fewer: int, more: int, measure: Callable[[Array], Array]
) -> tuple[Array, Array, Array]:
    """Rows, the best faces in their places, and the q of these."""
    # The outline: from the start of the edge around the second face, then around the first.
    around = [(pairs[:, 2 * k + 1, None] + 1 + np.arange(n)) % n
              for k, n in enumerate((fewer, more))]  # fmt: skip
    first, second = (np.take_along_axis(faces[pairs[:, 2 * k]], around[k], axis=1) for k in (0, 1))
    outline = np.concatenate([second[:, :-1], first[:, :-1]], axis=1)
    k = outline.shape[1]
    worst = np.full(len(pairs), -np.inf)
    best, q = np.full((len(pairs), 2, 4), -1), np.zeros((len(pairs), 2))
    # Half of the diagonals of two faces alike are the other half.
    for start in range(1, k if fewer != more else k // 2):
        new = np.full((len(pairs), 2, 4), -1)
        new[:, 1, :more] = outline[:, (start + np.arange(more)) % k]
        new[:, 0, :fewer] = outline[:, (start + more - 1 + np.arange(fewer)) % k]
        now = measure(new.reshape(-1, 4)).reshape(-1, 2)
        better = now.min(axis=1) > worst
        worst[better] = now.min(axis=1)[better]
        best[better], q[better] = new[better], now[better]
    return pairs[:, [0, 2]], best, q
