"""Cells, edges and faces that the boundary constrains too much (Definitions 18.8 and 18.9).

The boundary is given by its facets, (m, w) each, by their number of vertices: whoever asks says
whether interfaces between regions are part of it.
"""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from .adjacency import distinct
from .facets import CellSet
from .model import Array


def are_constrained(n_bound: Array, family: str) -> Array:
    """Which cells have all their facets in the boundary but one at most, (n,) bool.

    That is two edges of a triangle and three faces of a tet (Definition 18.8); of others, three
    edges of a quad, four faces of a pyramid or a wedge, and five of a hexahedron: fewer of them
    meet at every convex edge or corner of the domain.

    Parameters
    ----------
    n_bound : (n,) int64
        How many of the facets of each cell are in the boundary.
    """
    n_facets = sum(len(table) for table in FAMILIES[family].facets)
    return (n_bound >= n_facets - 1) & (n_facets > 0)


def bound_vertices(boundary: list[Array], n_points: int) -> Array:
    """Which points are vertices of facets of the boundary, (np,) bool."""
    bound = np.zeros(n_points, dtype=bool)
    for rows in boundary:
        bound[rows.ravel()] = True
    return bound


def between_bound(cell_sets: list[CellSet], bound: Array) -> tuple[Array, Array]:
    """Every edge of every cell with both ends in the boundary.

    Returns
    -------
    keys : (m,) int64
        The lower end times the number of points, and the other end; the same for the same edge.
    owners : (m,) int64
        Number of the cell.
    """
    keys, owners = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for group in cell_sets:
        held = bound[group.cells]
        near = np.flatnonzero(np.count_nonzero(held, axis=1) >= 2)
        held, cells = held[near], group.cells[near]
        for i, j in FAMILIES[group.family].edges:
            rows = np.flatnonzero(held[:, i] & held[:, j])
            keys.append(edge_keys(cells[rows, i], cells[rows, j], len(bound)))
            owners.append(group.numbers[near[rows]])
    return np.concatenate(keys), np.concatenate(owners)


def constrained_edges(keys: Array, boundary: list[Array], n_points: int) -> Array:
    """Keys of the internal edges with both ends in the boundary, each once, ascending.

    Parameters
    ----------
    keys : (m,) int64
        What `between_bound` gives.
    """
    keys = distinct(keys)
    outside = [np.empty(0, np.int64)]
    for rows in boundary:
        others = np.roll(rows, -1, axis=1)
        outside.append(edge_keys(rows, others, n_points).ravel())
    # All of them are among the keys: faster than `np.isin`.
    inside = np.ones(len(keys), dtype=bool)
    inside[np.searchsorted(keys, distinct(np.concatenate(outside)))] = False
    return keys[inside]


def edge_keys(one: Array, other: Array, n_points: int) -> Array:
    """A number for each edge between two vertices, the same from either end."""
    return np.minimum(one, other) * n_points + np.maximum(one, other)


def constrained_facets(facets: Array, bound: Array) -> Array:
    """Which internal facets, (m, w) int64, have all their vertices in the boundary."""
    return bound[facets].all(axis=1)
