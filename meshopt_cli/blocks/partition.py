"""Which vertices are in which block: bisection at medians, in one frame and another.

Labels of vertices stay good whatever happens to the cells: which cells and vertices a block has for
itself is found from them anew before every sweep (`find_homes`), so that nothing can be out of
date.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..kernels.blocks import find_homes
from ..work.session import Workspace

Array = np.ndarray

# Meshes with fewer cells than this are worked on in one piece, by dimension. In the plane all are:
# a sweep takes a tenth of the time there, a third of which it would take to find the blocks.
LEAST_CELLS = {2: math.inf, 3: 100_000}
# Most cells of a block. Blocks of 6000 made a mesh of 50,000 worse by 5 % of its worst Q.
BLOCK_CELLS = 32_768

# Directions across which blocks are cut, by turn. Cuts of the second turn cross those of the first
# steeply, so that little is on the rims of both.
N_TURNS = 2
ANGLE = 0.6
COS, SIN = math.cos(ANGLE), math.sin(ANGLE)
FRAMES = {
    2: (
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((COS, SIN, 0.0), (-SIN, COS, 0.0)),
    ),
    3: (
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        # about z, then about x by the same angle
        ((COS, SIN, 0.0), (-COS * SIN, COS * COS, SIN), (SIN * SIN, -COS * SIN, COS)),
    ),
}


@dataclass(frozen=True)
class Partition:
    """Blocks of a mesh by the labels of its vertices.

    Attributes
    ----------
    n_points : int
        Rows of vertices in use when it was made: new ones ask for another.
    n_blocks : int
    labels : tuple of (np,) int64
        One for each turn, from 0 on; 0 for rows that are not in use.
    """

    n_points: int
    n_blocks: int
    labels: tuple[Array, ...]


def is_large(work: object) -> bool:
    """Whether a mesh is worked on in blocks."""
    return isinstance(work, Workspace) and work.n_input_cells >= LEAST_CELLS[work.dimension]


def partition_of(work: Workspace) -> Partition:
    """The blocks of a mesh; made once, and again when there are new vertices."""
    kept = work.partition
    if isinstance(kept, Partition) and kept.n_points == work.n_points:
        return kept
    rows = np.flatnonzero(work.mesh.vertex_cell >= 0)
    levels = max(0, math.ceil(math.log2(work.n_cells / BLOCK_CELLS)))
    labels = tuple(
        bisected(work.mesh.points, rows, frame, levels) for frame in FRAMES[work.dimension]
    )
    work.partition = Partition(work.n_points, 2**levels, labels)
    return work.partition


def bisected(
    points: Array, rows: Array, frame: tuple[tuple[float, ...], ...], levels: int
) -> Array:
    """Labels of points: parts are cut in two at the median across the direction they are longest.

    Parameters
    ----------
    points : (np, 3 or more) float64
    rows : (n,) int64
        The points to be labelled, ascending.
    frame : tuple of unit vectors
        The directions.
    levels : int
        There are 2**levels parts, of the same size but for one point.

    Returns
    -------
    label : (np,) int64
        From 0 on; 0 for other points.
    """
    # Written out: a product of matrices adds in an order that depends on the machine.
    along = [x * points[:, 0] + y * points[:, 1] + z * points[:, 2] for x, y, z in frame]
    parts = [rows]
    for _ in range(levels):
        parts = [half for part in parts for half in _halves(along, part)]
    label = np.zeros(len(points), dtype=np.int64)
    for number, part in enumerate(parts):
        label[part] = number
    return label


def _halves(along: list[Array], part: Array) -> tuple[Array, Array]:
    """A part, ascending, cut in two; points with the median go by their rows."""
    if len(part) < 2:
        return part, part[:0]
    values = max((one[part] for one in along), key=lambda one: float(one.max() - one.min()))
    order = np.argsort(values, kind="stable")
    middle = (len(part) + 1) // 2
    return part[np.sort(order[:middle])], part[np.sort(order[middle:])]


def homes(work: Workspace, label: Array) -> tuple[Array, Array]:
    """The blocks of cells, (capacity,), and of vertices, (np,) int64: see `find_homes`."""
    owner = np.empty(len(work.mesh.cells), dtype=np.int64)
    home = np.empty(len(work.mesh.points), dtype=np.int64)
    find_homes(work.mesh, label, owner, home)
    return owner, home
