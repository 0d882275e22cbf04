"""The sheets of a surface in space: cells that agree in orientation across the edges of two cells.

A solid, or a mesh in the plane, has one orientation. A surface in space may be put together from
sheets, each oriented by itself, as plates of a frame or faces of a CAD model are; and some have one
side only. A cell that is turned over among its neighbours is wrong all the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES
from ..mesh.adjacency import same_direction
from ..mesh.model import Array
from ..mesh.sizes import area_vectors, norms
from .boundary import components
from .study import Study

# Faces that meet at a smaller angle than this, 20 degrees, are one smooth sheet.
FOLD = float(np.cos(np.radians(20.0)))


@dataclass(frozen=True)
class Sheets:
    """Where the cells of a surface disagree in orientation.

    Attributes
    ----------
    sheet : (n_cells,) int64
        The same for cells that agree across edges: the least number of a cell of the sheet.
    is_seam : (n,) bool
        Which pairs of cells that disagree may do so.
    """

    sheet: Array
    is_seam: Array


def sheets_of(study: Study, one: Array, other: Array, region: Array | None) -> Sheets:
    """Tell neighbours that disagree because one is turned over from sheets that may disagree.

    Two sheets may where they meet at a fold, or are of different regions, unless one of them is a
    cell alone that disagrees across all of its edges. A sheet may disagree with itself: no
    turning of its cells mends that.

    Parameters
    ----------
    one, other : (n,) int64
        Numbers of the cells that disagree.
    region : (n_cells,) int64, optional
    """
    none = np.zeros(len(one), dtype=bool)
    if not study.may_branch or not len(one):
        return Sheets(np.arange(study.n_cells), none)
    sheet = components(study.n_cells, *_agreeing(study))
    normal = np.zeros((study.n_cells, 3))
    n_edges = np.zeros(study.n_cells, dtype=np.int64)
    for group in study.cell_sets:
        vectors = area_vectors(study.points, group.cells)
        length = norms(vectors)
        normal[group.numbers] = vectors / np.where(length > 0, length, 1.0)[:, None]
        n_edges[group.numbers] = len(FAMILIES[group.family].edges)
    # Turned to agree, smooth neighbours have nearly the same normal.
    is_fold = -np.einsum("ij,ij->i", normal[one], normal[other]) < FOLD
    if region is not None:
        is_fold |= region[one] != region[other]
    times = np.bincount(np.concatenate([one, other]), minlength=study.n_cells)
    is_turned = times == n_edges
    is_seam = is_fold & ~is_turned[one] & ~is_turned[other]
    return Sheets(sheet, is_seam | (sheet[one] == sheet[other]))


def _agreeing(study: Study) -> tuple[Array, Array]:
    """Numbers of the cells that agree across an edge of two."""
    ones, others = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for facets in study.facet_sets:
        one, other = facets.pairs()
        agree = ~same_direction(facets.rows[one], facets.rows[other])
        ones.append(facets.owners[one[agree]])
        others.append(facets.owners[other[agree]])
    return np.concatenate(ones), np.concatenate(others)
