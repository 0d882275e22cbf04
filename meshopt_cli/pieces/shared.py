"""The points that several pieces have, and which of these gets what lies around."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.adjacency import distinct_rows
from ..mesh.model import Array


@dataclass(frozen=True)
class Shared:
    """Points of the borders of several pieces.

    Attributes
    ----------
    ids : (n,) int64
        Their numbers through all pieces, ascending.
    least, most : (n,) int64
        The first and the last of the pieces that have each.
    n_again : int
        How often such a point is there once more.
    """

    ids: Array
    least: Array
    most: Array
    n_again: int

    def owners(self, ids: Array, turn: int) -> Array:
        """The piece that gets what lies around points, (n,), -1 where they are one piece's alone.

        In turn it is the first and the last of those that have them.
        """
        place = np.minimum(np.searchsorted(self.ids, ids), max(len(self.ids) - 1, 0))
        if not len(self.ids):
            return np.full(len(ids), -1)
        owner = (self.least if turn % 2 == 0 else self.most)[place]
        return np.where(self.ids[place] == ids, owner, -1)


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
    last = start + count - 1
    return Shared(
        ids[start][several], piece[start][several], piece[last][several],
        int((count - 1)[several].sum()),
    )  # fmt: skip


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
