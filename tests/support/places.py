"""Cells by the places of their corners, so that numbering does not matter."""

from collections import Counter

import numpy as np


def cells_of(one, kind):
    return np.concatenate([b.cells for b in one.blocks if b.type == kind])


def places(one, rows):
    """Cells as a multiset of sets of coordinates, so that numbering does not matter."""
    return Counter(frozenset(map(tuple, one.points[row].tolist())) for row in rows)


def facets(cells):
    """All facets of triangles or tets."""
    width = cells.shape[1]
    return np.concatenate([np.delete(cells, k, axis=1) for k in range(width)])


def edges(cells):
    width = cells.shape[1]
    return np.concatenate([cells[:, [i, j]] for i in range(width) for j in range(i)])


def areas(points, triangles):
    """Signed areas seen from above z = 0."""
    corners = points[triangles][:, :, :2]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 2
