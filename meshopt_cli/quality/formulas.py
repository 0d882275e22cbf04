"""Angles and sizes of many cells at once, a function a measure.

Each takes points (np, 3), cells (n, k) by their corners and the name of their family, and gives
(n,) float64: degrees, or lengths, areas and volumes in the unit of the points.
"""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from ..mesh.sizes import angles_between, contents, dihedral_angles, facet_normals, norms


def dihedral_min(points: Array, cells: Array, family: str) -> Array:
    """Least angle between two facets of a solid (Definition 18.1)."""
    return np.degrees(dihedral_angles(points, cells, family).min(axis=1))


def dihedral_max(points: Array, cells: Array, family: str) -> Array:
    """Greatest angle between two facets of a solid (Definition 18.1)."""
    return np.degrees(dihedral_angles(points, cells, family).max(axis=1))


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
    return angles_between(to_next, to_last)
