"""The cells of a mesh with what bounds them, for what is counted of its entities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES, SIMPLICES, family_of
from . import adjacency
from .cast import Simplices
from .constrained import bound_vertices, constrained_facets
from .facets import CellSet, facets_of
from .model import Array, Mesh, declared, top_blocks
from .tags import regions_of


@dataclass(frozen=True)
class Bordered:
    """Cells, and the facets in their boundary.

    The boundary is that which has to stay: where the mesh ends, interfaces between regions, facets
    of more than two cells, and those that the file declares.

    Attributes
    ----------
    dimension : int
        Of the cells: 2 or 3.
    cell_sets : list of CellSet
        By their corners, numbered through all sets.
    boundary : list of (m, w) int64
        Facets of the boundary by their number of vertices, those between two cells from either
        side.
    outer : list of (m, w) int64
        Those of them that bound one cell only.
    n_bound : (ne,) int64
        How many facets of each cell are in the boundary.
    bound : (np,) bool
        Which points are vertices of the boundary.
    n_constrained_facets : int
        Facets inside whose vertices are all in the boundary (Definition 18.9).
    """

    dimension: int
    cell_sets: list[CellSet]
    boundary: list[Array]
    outer: list[Array]
    n_bound: Array
    bound: Array
    n_constrained_facets: int


def of_simplices(simplices: Simplices) -> Bordered:
    """Simplices with what they know of their neighbours."""
    cells, beyond = simplices.cells, simplices.neighbours
    d = simplices.dimension
    bound = bound_vertices([simplices.skin], len(simplices.points))
    near = np.flatnonzero(np.count_nonzero(bound[cells], axis=1) >= d)
    # Facets inside, each from one of its cells only.
    inside = adjacency.facets_at(cells[near], beyond[near] > 4 * near[:, None] + np.arange(d + 1))
    return Bordered(
        d,
        [CellSet(SIMPLICES[d], cells, np.arange(len(cells)))],
        [simplices.skin],
        [simplices.outer],
        np.count_nonzero(beyond < 0, axis=1),
        bound,
        int(np.count_nonzero(constrained_facets(inside, bound))),
    )


def of_mesh(mesh: Mesh) -> Bordered:
    """The cells of the greatest dimension, of any families; none of types that are not known."""
    blocks = [block for block in top_blocks(mesh) if family_of(block.type)]
    cell_sets, first = [], 0
    for block in blocks:
        family = family_of(block.type)
        assert family is not None
        # A copy where it is needed only, and no view that cannot be written to: kernels take none.
        cells = np.require(block.cells[:, : family.n_corners], np.int64, ["C", "W"])
        cell_sets.append(CellSet(family.name, cells, np.arange(first, first + len(cells))))
        first += len(cells)
    dimension = mesh.dimension()
    region = regions_of(blocks, mesh.regions) if blocks else np.empty(0, np.int64)
    n_bound = np.zeros(first, dtype=np.int64)
    n_points = len(mesh.points)
    boundary, outer, inner = [], [], []
    for facets in facets_of(cell_sets, n_points):
        one, other = facets.pairs()
        width = facets.rows.shape[1]
        cuts = [declared(mesh, name) for name, row in FAMILIES.items()
                if (row.dimension, row.n_corners) == (dimension - 1, width)]  # fmt: skip
        is_cut = region[facets.owners[one]] != region[facets.owners[other]]
        if sum(map(len, cuts)):
            is_cut |= adjacency.places_in(np.concatenate(cuts), facets.rows[one], n_points) >= 0
        alone, crowded = facets.alone(), facets.order[np.repeat(facets.count > 2, facets.count)]
        held = np.concatenate([alone, crowded, one[is_cut], other[is_cut]])
        n_bound += np.bincount(facets.owners[held], minlength=first)
        boundary.append(facets.rows[held])
        outer.append(facets.rows[alone])
        inner.append(facets.rows[one[~is_cut]])
    bound = bound_vertices(boundary, n_points)
    n_held = sum(int(np.count_nonzero(constrained_facets(rows, bound))) for rows in inner)
    return Bordered(dimension, cell_sets, boundary, outer, n_bound, bound, n_held)
