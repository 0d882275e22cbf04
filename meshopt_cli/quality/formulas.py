"""Angles and sizes of many cells at once, a function a measure.

Each takes points (np, 3), cells (n, k) by their corners and the name of their family, and gives
(n,) float64: numbers, degrees, steradians, or lengths, areas and volumes in the unit of the points.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from ..mesh.sizes import (
    angles_between,
    area_vectors,
    contents,
    dihedral_angles,
    edges_at_apex,
    facet_normals,
    norms,
    triple,
    unit_normals,
)


def dihedral_min(points: Array, cells: Array, family: str) -> Array:
    """Least angle between two facets of a solid (Definition 18.1)."""
    return np.degrees(dihedral_angles(points, cells, family).min(axis=1))


def dihedral_max(points: Array, cells: Array, family: str) -> Array:
    """Greatest angle between two facets of a solid (Definition 18.1)."""
    return np.degrees(dihedral_angles(points, cells, family).max(axis=1))


def solid_min(points: Array, cells: Array, family: str) -> Array:
    """Least solid angle at a vertex of a solid, in steradians (Definition 18.2)."""
    angles = np.zeros((FAMILIES[family].n_corners, len(cells)))
    for vertex, weight, tet in _tips(family):
        angles[vertex] += weight * _solid_angle(points, cells[:, tet])
    return angles.min(axis=0)


def _solid_angle(points: Array, tets: Array) -> Array:
    """Solid angle at the first vertex of tetrahedra, by Van Oosterom and Strackee."""
    a, b, c = edges_at_apex(points, tets)
    la, lb, lc = norms(a), norms(b), norms(c)
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(np.abs(triple(a, b, c)), la * lb * lc + ab * lc + bc * la + ca * lb)


@cache
def _tips(family: str) -> list[tuple[int, float, list[int]]]:
    """Vertices of a solid with tetrahedra that fill it there, and how much these count.

    At a vertex of three edges there is one; at the top of a pyramid the mean of both divisions.
    """
    row = FAMILIES[family]
    if row.is_simplex:
        return [(v, 1.0, [v, *({0, 1, 2, 3} - {v})]) for v in range(4)]
    tips = [(corner[0], 1.0, corner) for corner in row.corners.tolist()]
    for vertex in set(range(row.n_corners)) - {tip[0] for tip in tips}:
        for division in row.partitions:
            for tet in division.tolist():
                rest = [v for v in tet if v != vertex]
                tips.append((vertex, 1.0 / len(row.partitions), [vertex, *rest]))
    return tips


def corner_min(points: Array, cells: Array, family: str) -> Array:
    """Least angle at a corner of a face."""
    return np.degrees(_corner_angles(points, cells).min(axis=1))


def corner_max(points: Array, cells: Array, family: str) -> Array:
    """Greatest angle at a corner of a face."""
    return np.degrees(_corner_angles(points, cells).max(axis=1))


def edge_min(points: Array, cells: Array, family: str) -> Array:
    """Length of the shortest edge."""
    return _edges(points, cells, family).min(axis=1)


def edge_max(points: Array, cells: Array, family: str) -> Array:
    """Length of the longest edge."""
    return _edges(points, cells, family).max(axis=1)


def edge_ratio(points: Array, cells: Array, family: str) -> Array:
    """Longest edge by shortest, infinite where that has no length."""
    lengths = _edges(points, cells, family)
    shortest = lengths.min(axis=1)
    result = np.full(len(cells), np.inf)
    with np.errstate(over="ignore"):
        return np.divide(lengths.max(axis=1), shortest, out=result, where=shortest > 0.0)


def edge_share(points: Array, cells: Array, family: str) -> Array:
    """Shortest edge by longest, 0 where none has a length."""
    lengths = _edges(points, cells, family)
    longest = lengths.max(axis=1)
    return np.divide(lengths.min(axis=1), longest, out=np.zeros(len(cells)), where=longest > 0.0)


def scaled_jacobian(points: Array, cells: Array, family: str) -> Array:
    """Q of cells that are no simplices: 1 over the least Jacobian of a corner by its edges, next
    to that of the ideal cell; infinite where a corner is not positive."""
    row = FAMILIES[family]
    least = np.ones(len(cells))  # the base of a pyramid may have better corners than the ideal one
    for corner in row.corners:
        ideal = row.reference[corner[1:]] - row.reference[corner[0]]
        edges = points[cells[:, corner[1:]]] - points[cells[:, corner[:1]]]
        if row.dimension == 3:
            size, unit = triple(edges[:, 0], edges[:, 1], edges[:, 2]), np.linalg.det(ideal)
        else:
            size = np.einsum(
                "ij,ij->i", np.cross(edges[:, 0], edges[:, 1]), unit_normals(points, cells)
            )
            unit = 1.0
        lengths = norms(edges).prod(axis=1)
        sines = np.divide(size, lengths, out=np.zeros(len(cells)), where=lengths > 0.0)
        if row.dimension == 3:
            sines[contents(points, cells, family) < 0.0] *= -1.0
        least = np.minimum(least, sines / unit)
    result = np.full(len(cells), np.inf)
    with np.errstate(over="ignore"):
        return np.divide(1.0, least, out=result, where=least > 0.0)


def radius_diameter(points: Array, cells: Array, family: str) -> Array:
    """Circumradius of a simplex by its longest edge, infinite for flat ones."""
    lengths = _edges(points, cells, family)
    if FAMILIES[family].dimension == 2:
        radius = lengths.prod(axis=1), 4.0 * content(points, cells, family)
    else:
        # The products of opposite edges are the sides of a triangle whose area is 6 V r.
        a, b, c = (lengths * lengths[:, ::-1])[:, :3].T
        half = (a + b + c) / 2.0
        area = np.sqrt(np.maximum(half * (half - a) * (half - b) * (half - c), 0.0))
        radius = area, 6.0 * content(points, cells, family)
    result = np.full(len(cells), np.inf)
    with np.errstate(over="ignore"):
        np.divide(*radius, out=result, where=radius[1] > 0.0)
        return result / np.where(lengths.max(axis=1) > 0.0, lengths.max(axis=1), 1.0)


def height_min(points: Array, cells: Array, family: str) -> Array:
    """Least distance of a vertex of a simplex from its opposite facet."""
    if FAMILIES[family].dimension == 2:
        return 2 * content(points, cells, family) / edge_max(points, cells, family)
    normals = norms(facet_normals(points, cells, family))
    return 6 * content(points, cells, family) / normals.max(axis=1)


def content(points: Array, cells: Array, family: str) -> Array:
    """Volume, or area, of cells of either orientation."""
    return np.abs(contents(points, cells, family))


def _edges(points: Array, cells: Array, family: str) -> Array:
    start, end = FAMILIES[family].edges.T
    return norms(points[cells[:, end]] - points[cells[:, start]])


def _corner_angles(points: Array, cells: Array) -> Array:
    corners = points[cells]
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, 1, axis=1) - corners
    angles = angles_between(to_next, to_last)
    if cells.shape[1] == 3:
        return angles
    # A corner that turns the other way than the face has more than pi inside.
    turns = np.einsum("nij,nj->ni", np.cross(to_next, to_last), area_vectors(points, cells))
    return np.where(turns < 0.0, 2.0 * np.pi - angles, angles)
