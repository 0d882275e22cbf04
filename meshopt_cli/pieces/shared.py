"""The points that several pieces have, and which of these gets what lies around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.adjacency import distinct_rows
from ..mesh.model import Array

MIXER = np.uint64(0x9E3779B97F4A7C15)  # 2^64 by the golden ratio: what follows goes far apart


@dataclass(frozen=True)
class Shared:
    """Points of the borders of several pieces.

    Attributes
    ----------
    ids : (n,) int64
        Their numbers through all pieces, ascending.
    start : (n,) int64
        Where the pieces that have each begin in `pieces`.
    pieces : (m,) int64
        All of them, ascending for each point.
    """

    ids: Array
    start: Array
    pieces: Array

    @property
    def n_again(self) -> int:
        """How often such points are there once more."""
        return len(self.pieces) - len(self.ids)

    def among(self, ids: Array) -> Shared:
        """Those of some points."""
        chosen = np.isin(self.ids, ids)
        count = np.diff(self.start, append=len(self.pieces))
        start = np.cumsum(count[chosen]) - count[chosen]
        return Shared(self.ids[chosen], start, self.pieces[np.repeat(chosen, count)])

    def owners(self, ids: Array, turn: int) -> Array:
        """The piece that gets what lies around points, (n,), -1 where they are one piece's alone.

        It is the first of those that have them in an order of the pieces that is another in each
        turn: upwards, downwards, and then mixed.
        """
        if not len(self.ids):
            return np.full(len(ids), -1)
        n = int(self.pieces.max()) + 1
        order = _order(n, turn)
        rank = np.empty(n, dtype=np.int64)
        rank[order] = np.arange(n)
        owner = order[np.minimum.reduceat(rank[self.pieces], self.start)]
        place = np.minimum(np.searchsorted(self.ids, ids), len(self.ids) - 1)
        return np.where(self.ids[place] == ids, owner[place], -1)


def _order(n: int, turn: int) -> Array:
    pieces = np.arange(n)
    if turn < 2:
        return pieces if turn == 0 else pieces[::-1]
    mixed = (pieces + n * turn).astype(np.uint64) * MIXER
    return np.argsort(mixed, kind="stable")


def shared_by(borders: list[Array]) -> Shared:
    """What several pieces have of the points on their borders.

    Parameters
    ----------
    borders : list of (n,) int64
        The numbers of the points on the border of each piece, each once.
    """
    ids = np.concatenate(borders)
    piece = np.repeat(np.arange(len(borders)), [len(one) for one in borders])
    order = np.lexsort((piece, ids))
    ids, piece = ids[order], piece[order]
    start = np.flatnonzero(np.concatenate([[True], ids[1:] != ids[:-1]])[: len(ids)])
    count = np.diff(start, append=len(ids))
    several = count > 1
    kept = np.repeat(several, count)
    begins = np.cumsum(count[several]) - count[several]
    return Shared(ids[start][several], begins, piece[kept])


def faces_among(pieces: list[Array]) -> list[Array]:
    """The faces of each piece that another one has, (n, 3) int64.

    Parameters
    ----------
    pieces : list of (m, 3) int64
        The faces on the border of each, by the numbers of their points, in order.
    """
    _, number, count = distinct_rows(np.concatenate(pieces))
    ends = np.cumsum([len(one) for one in pieces])[:-1]
    several = np.split(count[number] > 1, ends)
    return [faces[mask] for faces, mask in zip(pieces, several, strict=True)]
