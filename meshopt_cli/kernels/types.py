"""What kernels share: the mesh as arrays, working space, verdicts."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

MAX_BALL = 512  # cells around a vertex
MAX_SHELL = 24  # cells around an edge
MAX_CREATED = 128  # cells that one operator makes
MAX_KEPT = 4096  # cells that a composite operation changes


class Verdict(IntEnum):
    """What became of one attempt to apply an operator."""

    APPLIED = 0
    NOT_BETTER = 1  # valid, and refused by the acceptance rule
    INVALID = 2  # some cell would be flat or inverted
    FIXED = 3  # the entity is on the boundary, an interface, or required
    TOO_LARGE = 4  # the ball or shell does not fit the working space
    TOO_LONG = 5  # an edge would grow beyond the limit
    NOT_LEGAL = 6  # the result would not be a conforming mesh
    FULL = 7  # no room for more cells: the arrays must grow first


N_VERDICTS = len(Verdict)
APPLIED = int(Verdict.APPLIED)
NOT_BETTER = int(Verdict.NOT_BETTER)
INVALID = int(Verdict.INVALID)
FIXED = int(Verdict.FIXED)
TOO_LARGE = int(Verdict.TOO_LARGE)
TOO_LONG = int(Verdict.TOO_LONG)
NOT_LEGAL = int(Verdict.NOT_LEGAL)
FULL = int(Verdict.FULL)

# Places in SimplexMesh.state.
N_CELLS = 0  # cells in use, dead ones included: rows [0, n) of the cell arrays
N_FREE = 1  # dead cells on the stack `free`
CLOCK = 2  # number of the current sweep
N_POINTS = 3  # rows [0, n) of the vertex arrays in use
EDITION = 4  # raised by every change of a cell


# Places in Journal.state.
J_ACTIVE = 0  # 1 while the journal is open
J_STAMP = 1  # marks equal to it are set
J_CELLS = 2  # number of rows kept
J_VERTICES = 3
J_MESH = 4  # where SimplexMesh.state as it was begins

# Columns of Journal.cells.
J_ROW = 0
J_CORNERS = 1  # four, in space
J_BEYOND = 5  # their neighbours
J_REGION = 9
J_ALIVE = 10


# What the rows of a mesh are: simplices as they are, the simplices at the corners of solids, each
# next to that of the ideal cell, triangles and quads of the plane, or simplices in a metric.
SIMPLICES, CORNERS, FACES, MAPPED = range(4)


class Judge(NamedTuple):
    """By what the quality of a cell is judged."""

    code: int  # of a measure, see `shape.simplex`
    lenience: float  # from 1 on: dihedral angles bound the q of a tet as well, which counts so
    # many times; 0: they do not
    form: int = 0  # of what is judged: SIMPLICES, CORNERS, FACES or MAPPED


class SimplexMesh(NamedTuple):
    """A mesh of triangles (d = 2, with z = 0) or tetrahedra (d = 3) as the kernels see it.

    Boundary facets and the facets between two regions have no neighbour: an interface is a
    boundary of the cells on either side.
    """

    points: np.ndarray  # (np, 3) float64; np counts the rows kept free for new vertices; where
    # there is a metric (np, 9), with that of each: see `metric`
    cells: np.ndarray  # (capacity, d + 1) int64, positive order
    neighbours: np.ndarray  # (capacity, d + 1) int64: handle of the facet beyond, or a border:
    # see `handles`
    vertex_cell: np.ndarray  # (np,) int64: a cell of the ball of each vertex, -1 when it has none
    quality: np.ndarray  # (capacity,) float64: q = 1/Q in (-inf, 1]
    region: np.ndarray  # (capacity,) int64
    alive: np.ndarray  # (capacity,) bool
    fixed: np.ndarray  # (np,) bool: vertices that neither move nor vanish, those below apart
    guide: np.ndarray  # (np, 6) float64, or none where nothing is guided: 1 for a fixed vertex that
    # may move along a line, 2 for one that may in a plane, else 0, see `guide`; the unit direction
    # or normal; first and stop of its rows of `limits`
    limits: np.ndarray  # (n, 4) float64: unit normals and offsets of half-spaces `normal . x >= o`
    required: np.ndarray  # (k,) int64: sorted keys `a * np + b`, a < b, of internal edges to keep
    vertex_clock: np.ndarray  # (np,) int64: sweep of the last change in the ball
    free: np.ndarray  # (capacity,) int64: stack of dead cells
    state: np.ndarray  # (5,) int64: N_CELLS, N_FREE, CLOCK, N_POINTS, EDITION
    judge: Judge
    slides: bool  # whether some vertices of the boundary may move
    single: bool  # points are stored in single precision


class CellMesh(NamedTuple):
    """A mesh of any cells; in space its connectivity stays.

    Its rows are triangles and quads where d = 2, which need not be convex, and the corners of
    solids where d = 3: simplices from a vertex to its neighbours along the edges.
    """

    points: np.ndarray  # (np, 3) float64, with z = 0 where d = 2
    cells: np.ndarray  # (nr, d + 1) int64: vertices of each row; of a quad the first three
    fourth: np.ndarray  # (nr,) int64: the fourth of a quad, -1 for all else
    owner: np.ndarray  # (nr,) int64: the cell of each row
    shape: np.ndarray  # (nr,) int64: number of its stretch
    stretch: np.ndarray  # (k, 4, 3) float64: what is judged of a row are edges that are so much
    # of those from its first vertex, so that it is regular where the cell is ideal; below, how high
    # that vertex then is, and 1 over the scaled Jacobian: see `work.cells`
    ball_start: np.ndarray  # (np + 1,) int64
    ball: np.ndarray  # (n,) int64: handles `4 * row + local` at each vertex, local = 3 of a quad
    # that of its fourth vertex
    quality: np.ndarray  # (nr,) float64: q of each row
    fixed: np.ndarray  # (np,) bool
    guide: np.ndarray  # as in SimplexMesh
    limits: np.ndarray
    vertex_clock: np.ndarray  # (np,) int64: sweep of the last change around it
    state: np.ndarray  # (5,) int64: CLOCK and EDITION
    judge: Judge
    single: bool  # points are stored in single precision


# What operators take that work on the star of a vertex, whichever mesh it is laid out from.
AnyMesh = SimplexMesh | CellMesh


class Journal(NamedTuple):
    """What a composite operation changed, as it was before: see `journal`.

    A call passes every array field by field: so there are few of them, with several columns.
    """

    cells: np.ndarray  # (MAX_KEPT, 11) int64: J_ROW, J_CORNERS, J_BEYOND, J_REGION, J_ALIVE
    quality: np.ndarray  # (MAX_KEPT,) float64 of those cells
    vertices: np.ndarray  # (4 * MAX_KEPT, 3) int64: vertex, vertex_cell, vertex_clock
    points: np.ndarray  # (4 * MAX_KEPT, 3) float64
    cell_mark: np.ndarray  # (capacity,) int64
    vertex_mark: np.ndarray  # (np,) int64
    state: np.ndarray  # (9,) int64: J_ACTIVE, J_STAMP, J_CELLS, J_VERTICES, J_MESH


class Scratch(NamedTuple):
    """Working space of the operators; its contents mean nothing between two calls."""

    ball: np.ndarray  # (MAX_BALL,) int64 handles of the cells around a vertex
    other: np.ndarray  # (MAX_BALL,) int64 the same around a second vertex
    shell: np.ndarray  # (MAX_SHELL,) int64 cells around an edge
    ring: np.ndarray  # (MAX_SHELL,) int64 vertices around an edge
    table: np.ndarray  # (MAX_SHELL, MAX_SHELL) float64 worst quality of a part of the polygon
    split: np.ndarray  # (MAX_SHELL, MAX_SHELL) int64 the vertex that part is split at
    cavity: np.ndarray  # (MAX_BALL,) int64 cells to be replaced
    created: np.ndarray  # (MAX_CREATED, 4) int64 vertices of new cells
    facets: np.ndarray  # (4 * MAX_CREATED, 4) int64 facets waiting for their other side
    values: np.ndarray  # (MAX_BALL,) float64
    gradients: np.ndarray  # (MAX_BALL, 3) float64
    star: np.ndarray  # (19, MAX_BALL + 8) float64 vertices of the facets of a ball: see `star`
    cell_mark: np.ndarray  # (capacity,) int64
    vertex_mark: np.ndarray  # (np,) int64
    stamp: np.ndarray  # (1,) int64: marks equal to it are set
    journal: Journal
