"""Cells that run the other way round than the rest of their mesh, and how they are turned.

The vertices of a simplex are listed in one of two directions. Files come with cells in both: then
a cell has a negative volume, or area in the plane, or sees a facet as its neighbour does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..cells import SIMPLICES, dimension_of, family_of
from . import adjacency
from .model import Array, Mesh, main_blocks, main_type
from .plane import plane_of, precision_of, with_depth
from .second_order import by_corners, has_known_nodes, taken_in_order
from .sizes import contents

# The other direction of each family: its corners as a mirror would show them.
_MIRRORED = {
    "line": [1, 0],
    "triangle": [0, 2, 1],
    "quad": [0, 3, 2, 1],
    "tetra": [0, 1, 3, 2],
    "pyramid": [0, 3, 2, 1, 4],
    "wedge": [0, 2, 1, 3, 5, 4],
    "hexahedron": [0, 3, 2, 1, 4, 7, 6, 5],
}


def can_be_turned(cell_type: str) -> bool:
    """Whether cells of a type can be listed in the other direction: of first or second order."""
    return has_known_nodes(cell_type)


def turned(cells: Array, cell_type: str | None = None) -> Array:
    """Cells in the other direction; simplices with their last two corners exchanged.

    Parameters
    ----------
    cells : (n, k) int64
    cell_type : str, optional
        See `can_be_turned`; the simplex with so many vertices where it is left out.
    """
    cell_type = cell_type or SIMPLICES[cells.shape[1] - 1]
    family = family_of(cell_type)
    assert family is not None
    return cells[:, taken_in_order(cell_type, _MIRRORED[family.name])]


def with_positive_cells(mesh: Mesh) -> tuple[Mesh, int]:
    """Turn the simplices of negative volume, or area; also returns how many they were.

    This mends a mesh whose cells were written in either direction. In a tangle it makes
    neighbours overlap, which `validity.check` sees (M207). In a plane, most of the area says
    which side is up.
    """
    return _with_turned(mesh, _sizes(mesh, _cells(mesh)) < 0)


def with_agreeing_cells(mesh: Mesh) -> tuple[Mesh, int]:
    """Turn simplices until each sees a facet from the other side than its neighbour there.

    Returns the mesh and how many were turned. Of cells that hang together by facets, most of the
    volume, or area, says which way round is right. So cells that were written in either
    direction are told from cells that are inverted, which agree with their neighbours. Cells of
    a part that has no two sides stay as they are.
    """
    cells = _cells(mesh)
    n, width = cells.shape
    if not n:
        return mesh, 0
    beyond = adjacency.neighbours(cells, np.zeros(n, np.int64), len(mesh.points)).ravel()
    one = np.flatnonzero(beyond >= 0)
    one = one[one < width * (beyond[one] // 4) + beyond[one] % 4]
    other = width * (beyond[one] // 4) + beyond[one] % 4
    rows = adjacency.facets(cells)
    against = adjacency.same_direction(rows[one], rows[other])
    return _with_turned(
        mesh, against_most(one // width, other // width, against, _sizes(mesh, cells))
    )


def against_most(one: Array, other: Array, against: Array, size: Array) -> Array:
    """Which cells run the other way round than most of what they hang together with.

    Parameters
    ----------
    one, other : (m,) int64
        Cells that have a facet in common.
    against : (m,) bool
        Whether both run round it in the same direction, so that one of them is to be turned.
    size : (n,) float64
        Signed volumes, or areas, of all cells: the greater sum is the right way round.

    Returns
    -------
    chosen : (n,) bool
        None of a part that has no two sides.
    """
    n = len(size)
    # Every cell is there twice, as it is (k) and turned (n + k), and linked to what it agrees with.
    ones = np.concatenate([one, n + one])
    others = np.concatenate([np.where(against, n, 0) + other, np.where(against, 0, n) + other])
    part = adjacency.first_of(2 * n, ones, others)
    as_is, reverse = part[:n], part[n:]
    total = np.bincount(as_is, size, 2 * n) + np.bincount(reverse, -size, 2 * n)
    is_less, is_equal = total[as_is] < total[reverse], total[as_is] == total[reverse]
    return is_less | (is_equal & (as_is > reverse))  # of two halves, that of the first cell stays


def hangs_together(mesh: Mesh, near: Array | None = None) -> bool:
    """Whether the main cells at each vertex hang together by facets.

    In a sound mesh that is a matter of taste (M212). Where cells are inverted or overlap, changes
    could make what is there already, so that they are to be told apart.

    Parameters
    ----------
    near : (ne,) bool, optional
        Only vertices inside of the mesh, and those of cells around these ones.
    """
    cells, n_points = _cells(mesh), len(mesh.points)
    several = adjacency.n_fans(cells, n_points) > 1
    if near is not None:
        inside = np.ones(n_points, bool)
        beyond = adjacency.neighbours(cells, np.zeros(len(cells), np.int64), n_points)
        inside[adjacency.boundary_facets(cells, beyond)] = False
        around = adjacency.is_used(cells[near], n_points)[cells].any(axis=1)
        several &= inside | adjacency.is_used(cells[around], n_points)
    return not several.any()


def _cells(mesh: Mesh) -> Array:
    """The main cells by their corners."""
    mesh = by_corners(mesh)
    return np.concatenate([block.cells for block in main_blocks(mesh, main_type(mesh))])


def _sizes(mesh: Mesh, cells: Array) -> Array:
    """Signed volumes, or areas as seen from where most of the area is positive; without a plane
    they are all positive."""
    points = with_depth(mesh.points)
    if cells.shape[1] == 3 and (frame := plane_of(points, cells, precision_of(mesh.points))):
        points = frame.flatten(points)[:, :2]
    return contents(points, cells, SIMPLICES[cells.shape[1] - 1])


def _with_turned(mesh: Mesh, chosen: Array) -> tuple[Mesh, int]:
    """Turn the main cells that a mask chooses, (ne,)."""
    at, blocks = 0, []
    for block in mesh.blocks:
        if dimension_of(block.type) == mesh.dimension():
            here = chosen[at : at + len(block.cells), None]
            at += len(block.cells)
            cells = np.where(here, turned(block.cells, block.type), block.cells)
            blocks.append(replace(block, cells=cells))
        else:
            blocks.append(block)
    return replace(mesh, blocks=blocks), int(np.count_nonzero(chosen))
