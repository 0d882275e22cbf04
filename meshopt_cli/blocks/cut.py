"""What each block of a mesh has for itself while a sweep goes on in all of them.

All have the arrays of the mesh, in which no one reads what another one writes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import ClassVar

import numpy as np

from ..kernels.blocks import cut_rims, find_blocks, sew_rims
from ..kernels.types import EDITION, N_CELLS, N_FREE, SimplexMesh
from ..work.session import Workspace
from .crew import Share
from .partition import homes

Array = np.ndarray

# Part of the cells that there is room for more of, in all blocks together: a block that runs short
# of it leaves cells to the next turn.
SPARE_PART = 0.06
SPARE_ROWS = 64  # and of each block besides


class Balls:
    """Vertices that move, each of which has its whole ball in one block.

    The clocks of vertices on rims are set by several blocks, to the same.

    Parameters
    ----------
    label : (np,) int64
        Of the vertices: the blocks.
    order : (n,) int64
        Vertices.

    Attributes
    ----------
    least_part : float
        Shorter orders, as a part of the cells, take two threads no less time than one.
    shares : list of Share
        What each block visits.
    """

    least_part: ClassVar[float] = 0.02

    def __init__(self, work: Workspace, label: Array, n_blocks: int, order: Array) -> None:
        self._mesh = mesh = work.mesh
        self.shares = [
            Share(mesh._replace(state=mesh.state.copy()), order[places], places)
            for places in _places(homes(work, label)[1][order], n_blocks)
        ]

    def close(self) -> None:
        """Count the changes of all blocks."""
        _count(self._mesh, self.shares)


class Shells:
    """Cells whose edges and faces are swapped, in blocks that the mesh is cut into.

    Parameters and attributes as those of `Balls`, but for the order: cells, alive or not. Those
    with an edge on a rim are nobody's.
    """

    least_part: ClassVar[float] = 0.2

    def __init__(self, work: Workspace, label: Array, n_blocks: int, order: Array) -> None:
        while _n_spare(work) < SPARE_PART * work.n_cells + SPARE_ROWS * n_blocks:
            work.grow()
        self._mesh = mesh = work.mesh
        owner, self._home = homes(work, label)
        self._n_facets = cut_rims(mesh, owner)
        blocks = np.empty(len(order), dtype=np.int64)
        find_blocks(mesh, order, owner, self._home, blocks)
        rows = np.flatnonzero(~mesh.alive)
        self.shares = [
            self._share(spare, order[places], places)
            for spare, places in zip(
                np.array_split(rows, n_blocks), _places(blocks, n_blocks), strict=True
            )
        ]

    def _share(self, spare: Array, order: Array, places: Array) -> Share:
        """What a block visits, with some rows for new cells."""
        mesh = self._mesh
        free, state = np.empty_like(mesh.free), mesh.state.copy()
        free[: len(spare)] = spare[::-1]  # the least row is used first
        state[[N_CELLS, N_FREE]] = len(mesh.cells), len(spare)
        clock = mesh.vertex_clock.copy()
        return Share(mesh._replace(free=free, state=state, vertex_clock=clock), order, places)

    def close(self) -> None:
        """Make one mesh of the blocks again."""
        mesh = self._mesh
        _count(mesh, self.shares)
        for share in self.shares:
            np.maximum(mesh.vertex_clock, share.mesh.vertex_clock, out=mesh.vertex_clock)
        n = int(np.flatnonzero(mesh.alive)[-1]) + 1
        dead = np.flatnonzero(~mesh.alive[:n])[::-1]
        mesh.free[: len(dead)] = dead
        mesh.state[[N_CELLS, N_FREE]] = n, len(dead)
        sew_rims(mesh, self._home, np.full(self._n_facets, -1))


def _count(mesh: SimplexMesh, shares: list[Share]) -> None:
    """Raise the edition of a mesh by the changes of all blocks."""
    before = int(mesh.state[EDITION])
    mesh.state[EDITION] += sum(int(share.mesh.state[EDITION]) - before for share in shares)


def _n_spare(work: Workspace) -> int:
    """Rows for more cells."""
    return len(work.mesh.cells) - work.n_cells


def _places(blocks: Array, n_blocks: int) -> list[Array]:
    """Where in an order each block has its entities, whose blocks are these, or negative."""
    # Sorting takes a tenth of the time where numbers are small.
    small = blocks.astype(np.int16) if n_blocks < 2**15 else blocks
    in_turn = np.argsort(small, kind="stable")
    limits = np.searchsorted(small[in_turn], np.arange(n_blocks + 1))
    return [in_turn[a:b] for a, b in pairwise(limits)]
