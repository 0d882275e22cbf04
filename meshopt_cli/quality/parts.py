"""Cells that are no simplices, by the simplices that they are made of (18.2.4).

A simplex of a cell is compared with the one at the same place in the ideal cell: that one is
stretched, without a turn, until it is regular; what the map from the ideal cell makes of it then
is measured. So every measure of simplices is one of all cells, 1 for the ideal one, wherever the
numbering of a cell begins.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..cells import FAMILIES, stretch_of
from ..kernels.judge import measure_cells
from ..mesh.model import Array
from ..mesh.sizes import area_vectors, contents, unfolded
from . import quads

if TYPE_CHECKING:
    from ..kernels.types import Judge


def partitions_of(family: str) -> Array:
    """The simplices of all partitions of a cell, each once, (n, d + 1)."""
    simplices = np.concatenate(FAMILIES[family].partitions)
    _, first = np.unique(np.sort(simplices, axis=1), axis=0, return_index=True)
    return simplices[np.sort(first)]


def least_quality(
    judge: Judge, points: Array, cells: Array, family: str, simplices: Array
) -> Array:
    """q of the worst of some simplices of cells, (n,): 0 or less where one is not positive.

    Parameters
    ----------
    judge : Judge
        The measure.
    points : (np, 3) float64
    cells : (n, k) int64
        Whichever way they are turned: solids as their volumes say, faces as most of them sees.
    family : str
        Theirs.
    simplices : (s, d + 1) int64
        By local numbers.
    """
    least = np.full(len(cells), math.inf)
    for simplex in simplices:
        shapes = _next_to_ideal(points, cells, family, simplex)
        q = np.empty(len(cells))
        rows = np.arange(shapes[..., 0].size).reshape(len(cells), -1)
        if shapes.shape[1] == 3:
            measure_cells(judge, *unfolded(shapes.reshape(-1, 3), rows), q)
            turned = np.einsum(
                "ij,ij->i", area_vectors(shapes.reshape(-1, 3), rows), area_vectors(points, cells)
            )
            q = np.copysign(q, turned)
        else:
            measure_cells(judge, shapes.reshape(-1, 3), rows, q)
        least = np.minimum(least, q)
    return least


def _next_to_ideal(points: Array, cells: Array, family: str, simplex: Array) -> Array:
    """What the stretched simplex becomes where the ideal cell becomes each cell, (n, d + 1, 3)."""
    corners = points[cells[:, simplex]]
    result = np.zeros_like(corners)
    edges = corners[:, 1:] - corners[:, :1]
    result[:, 1:] = np.einsum("ij,njk->nik", stretch_of(family, simplex), edges)
    if FAMILIES[family].dimension == 3:
        result[contents(points, cells, family) < 0.0] *= -1.0
    return result


def worst_part(judge: Judge, points: Array, cells: Array, family: str) -> Array:
    """q of the worst tetrahedron of the partitions of solids, or of the worst face if it is less.

    The partitions are those of Figures 18.2 to 18.4 with all their rotations.
    """
    tets = least_quality(judge, points, cells, family, partitions_of(family))
    return np.minimum(tets, worst_face(judge, points, cells, family))


def worst_corner(judge: Judge, points: Array, cells: Array, family: str) -> Array:
    """q of the worst simplex at a corner of cells."""
    return least_quality(judge, points, cells, family, FAMILIES[family].corners)


def worst_face(judge: Judge, points: Array, cells: Array, family: str) -> Array:
    """q of the worst face of solids: triangles by a measure, quads by (18.10)."""
    worst = np.full(len(cells), math.inf)
    for table in FAMILIES[family].facets:
        for face in table:
            if len(face) == 4:
                q = 1.0 / quads.aspect(points, cells[:, face], "quad")
            else:
                q = np.empty(len(cells))
                measure_cells(judge, *unfolded(points, cells[:, face]), q)
            worst = np.minimum(worst, q)
    return worst


# How a measure of simplices is one of other cells.
WAYS = {"corners": worst_corner, "parts": worst_part, "faces": worst_face}
