"""Which cells a piece gives to others, and which of its cells are near a place."""

from __future__ import annotations

import numpy as np

from ..mesh.model import Array, Mesh, top_blocks

GIVEN = 4  # layers of cells around what several pieces have that one of them gets
NEAR = 3  # layers around what they had that are worked on then
_NONE = np.iinfo(np.int64).max


def taken_by(mesh: Mesh, owner: Array, layers: int = GIVEN) -> list[Array]:
    """The piece that gets each cell of the greatest dimension, by blocks, -1 where none does.

    From vertices that have an owner this goes from cell to cell, some layers far; where two owners
    come to a cell at once, it is for the one of the lower number.

    Parameters
    ----------
    owner : (np,) int64
        Piece for each point, -1 for none.
    """
    blocks = top_blocks(mesh)
    found = [np.full(len(block.cells), _NONE) for block in blocks]
    reached = np.where(owner < 0, _NONE, owner)
    for _ in range(layers):
        here = reached.copy()
        for block, own in zip(blocks, found, strict=True):
            least = np.take(reached, block.cells).min(axis=1)
            own[:] = np.where(own == _NONE, least, own)
            fresh = np.flatnonzero((least != _NONE) & (least == own))
            np.minimum.at(here, block.cells[fresh], own[fresh, None])
        reached = np.where(reached == _NONE, here, reached)
    return [np.where(own == _NONE, -1, own) for own in found]


def given_by(mesh: Mesh, i: int, owner: Array) -> list[Array]:
    """As `taken_by`, of piece i, which keeps half of its cells: in fewer layers, or none, if need
    be."""
    n = sum(len(block.cells) for block in top_blocks(mesh))
    for layers in range(GIVEN, 0, -1):
        found = taken_by(mesh, owner, layers)
        if sum(np.count_nonzero((own >= 0) & (own != i)) for own in found) <= n // 2:
            return found
    return [np.full(len(block.cells), -1) for block in top_blocks(mesh)]


def near(mesh: Mesh, marked: Array, layers: int = NEAR) -> list[Array]:
    """Which cells of the greatest dimension are within some layers of marked points, by blocks.

    Parameters
    ----------
    marked : (np,) bool
    """
    return [owner >= 0 for owner in taken_by(mesh, np.where(marked, 0, -1), layers)]
