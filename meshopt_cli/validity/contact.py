"""Where a mesh touches itself although its cells share nothing there, for the rules of `check`.

A valid mesh is conforming: its boundary facets meet other cells in vertices, edges and faces
that they share with them. So it is enough to look around the boundary facets.
"""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..mesh.adjacency import distinct, row_ids, same_direction
from ..mesh.facets import FacetSet, facets_of
from ..mesh.model import Array
from ..mesh.sizes import norms
from .boxes import around, bounding
from .geometry import Pairs
from .study import Study

QUAD = FAMILIES["quad"]


def hanging_nodes(study: Study, first: Array, flat: Array) -> Pairs:
    """Vertices that lie on a boundary facet without being one of its vertices.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each, see `coincidence.first_points`.
    flat : (n_cells,) bool
        Flat cells: whatever lies in their plane may lie on their facets.

    Returns
    -------
    vertices : (n,) int64
        Each once, in order.
    owners : (n,) int64
        Numbers of the cells of the facets.
    """
    found = []
    boundary = boundary_vertices(study, first)
    for facets in study.facet_sets:
        sides, owners = boundary_facets(study, facets, first, flat)
        if sides.shape[1] == QUAD.n_corners:
            sides = sides[:, QUAD.partitions[0]].reshape(-1, 3)
            owners = np.repeat(owners, len(QUAD.partitions[0]))
        low, high = bounding(study.points, study.noise, sides, study.touch)
        for vertex, side in around(study.points[boundary], low, high):
            on = lies_on(study.points, study.noise, boundary[vertex], sides[side], study.touch)
            found.append((boundary[vertex[on]], owners[side[on]]))
    vertices, owners = _joined(found)
    corners = study.corners_of(owners)
    corners = np.where(corners < 0, -1, first[corners])
    # The vertex opposite lies on the facet, or nearly so, if the cell is very thin.
    foreign = (corners != vertices[:, None]).all(axis=1)
    vertices, row = np.unique(vertices[foreign], return_index=True)
    return vertices, owners[foreign][row]


def cracks(study: Study, first: Array) -> Pairs:
    """Numbers of the cells of boundary facets that coincide, the later and the earlier ones.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each.
    """
    found = []
    for facets in study.facet_sets:
        rows = facets.alone()
        ids = row_ids(first[facets.rows[rows]], study.n_points)
        _, row, inverse = np.unique(ids, return_index=True, return_inverse=True)
        again = np.flatnonzero(row[inverse] != np.arange(len(ids)))
        one, other = facets.owners[rows[again]], facets.owners[rows[row[inverse[again]]]]
        found.append((np.maximum(one, other), np.minimum(one, other)))
    found.append(_halves(study, first))
    return _joined(found)


def _halves(study: Study, first: Array) -> Pairs:
    """Cells of boundary quads and of boundary triangles that are halves of them."""
    sides = {facets.rows.shape[1]: facets for facets in study.facet_sets}
    if not {3, 4} <= set(sides):
        return _joined([])
    rows = {width: facets.alone() for width, facets in sides.items()}
    # There are four halves: a quad may be divided by either diagonal.
    halves = first[sides[4].rows[rows[4]]][:, QUAD.corners].reshape(-1, 3)
    triangles = first[sides[3].rows[rows[3]]]
    ids = row_ids(np.concatenate([halves, triangles]), study.n_points)
    order = np.argsort(ids[: len(halves)], kind="stable")
    at = np.searchsorted(ids[order], ids[len(halves) :])
    at = order[np.minimum(at, len(order) - 1)] if len(order) else at
    same = np.flatnonzero(ids[at] == ids[len(halves) :]) if len(order) else at[:0]
    one = sides[3].owners[rows[3][same]]
    other = sides[4].owners[rows[4][at[same] // len(QUAD.corners)]]
    return np.maximum(one, other), np.minimum(one, other)


def vertices_apart(study: Study, first: Array, hanging: Pairs) -> Array:
    """Vertices of the file where cells meet without sharing all that they meet in, ascending.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each.
    hanging : pair of (n,) int64
        See `hanging_nodes`.
    """
    apart = first != np.arange(study.n_points)
    apart[first[apart]] = True
    apart[hanging[0]] = True
    for facets in facets_of(study.sound_sets, study.n_points):
        alone = facets.alone()
        rows = facets.rows[alone]
        ids = row_ids(first[rows], study.n_points)
        _, number, count = np.unique(ids, return_inverse=True, return_counts=True)
        meets = (count[number] > 1) | np.isin(facets.owners[alone], hanging[1])
        apart[rows[meets].ravel()] = True
    return np.flatnonzero(apart)


def unmatched(study: Study, facets: FacetSet, first: Array) -> Array:
    """Rows of the facets that bound one cell only, but for those seen from both sides.

    Where two cells have points of their own along a facet, each has its own, and the two coincide:
    there is as little beside them as beside a facet that is shared.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each.
    """
    alone = facets.alone()
    rows = facets.rows[alone]
    apart = first != np.arange(study.n_points)
    apart[first[apart]] = True
    doubled = np.flatnonzero(apart[rows].all(axis=1))
    places = first[rows[doubled]]
    _, number, count = np.unique(
        row_ids(places, study.n_points), return_inverse=True, return_counts=True
    )
    order = np.argsort(number, kind="stable")
    start = (np.cumsum(count) - count)[count == 2]
    one, other = order[start], order[start + 1]
    opposite = ~same_direction(places[one], places[other])
    kept = np.ones(len(alone), dtype=bool)
    kept[doubled[one[opposite]]] = kept[doubled[other[opposite]]] = False
    return alone[kept]


def boundary_vertices(study: Study, first: Array) -> Array:
    """Vertices of the facets that no cell is beside, one for each place."""
    rows = [
        first[facets.rows[unmatched(study, facets, first)]].ravel() for facets in study.facet_sets
    ]
    return distinct(np.concatenate([np.empty(0, dtype=np.int64), *rows]))


def boundary_facets(study: Study, facets: FacetSet, first: Array, dropped: Array) -> Pairs:
    """Facets that no cell is beside, one for each place, and the numbers of their cells.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each.
    dropped : (n_cells,) bool
        Cells whose facets are left out.
    """
    rows = unmatched(study, facets, first)
    rows = rows[~dropped[facets.owners[rows]]]
    ids = row_ids(first[facets.rows[rows]], study.n_points)
    rows = rows[np.unique(ids, return_index=True)[1]]
    return facets.rows[rows], facets.owners[rows]


def _joined(found: list[Pairs]) -> Pairs:
    none = np.empty(0, dtype=np.int64)
    return (
        np.concatenate([none, *(one for one, _ in found)]),
        np.concatenate([none, *(other for _, other in found)]),
    )


def lies_on(points: Array, noise: Array, vertices: Array, facets: Array, touch: float) -> Array:
    """Whether vertices lie on edges or triangles, but at no corner of them.

    Parameters
    ----------
    points : (np, d) float64
    noise : (np,) float64
    vertices : (n,) int64
    facets : (n, 2) or (n, 3) int64
    touch : float
        Part of the longest edge of the facet.
    """
    corners = points[facets]
    away = points[vertices][:, None] - corners
    longest = norms(np.roll(corners, -1, axis=1) - corners).max(axis=1, initial=0.0)
    margin = touch * longest + noise[facets].max(axis=1, initial=0.0)
    a = corners[:, 1] - corners[:, 0]
    if facets.shape[1] == 2:
        along = np.einsum("ij,ij->i", away[:, 0], a) / np.einsum("ij,ij->i", a, a)
        inside = (along > 0) & (along < 1)
        distance = norms(away[:, 0] - along[:, None] * a)
    else:
        normal = np.cross(a, corners[:, 2] - corners[:, 0])
        area = norms(normal)
        unit = normal / area[:, None]
        distance = np.abs(np.einsum("ij,ij->i", away[:, 0], unit))
        # Distance to each side, towards the inside.
        sides = np.roll(corners, -1, axis=1) - corners
        inward = np.einsum("ijk,ik->ij", np.cross(sides, away), unit) / norms(sides)
        inside = (inward >= -margin[:, None]).all(axis=1)
    return inside & (distance <= margin) & (norms(away) > margin[:, None]).all(axis=1)
