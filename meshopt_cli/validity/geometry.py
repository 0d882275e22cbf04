"""Flat cells and coincident points, for the rules of `check`.

All of it works on whole arrays and allows for the rounding of the coordinates: `noise`
is the error of a coordinate, in the unit of the points.
"""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from ..mesh.quads import FLAT
from ..mesh.sizes import area_vectors, chunks, edges_at_apex, norms, triple

Pairs = tuple[Array, Array]


def corner_volumes(points: Array, noise: Array, cells: Array, family: str) -> Pairs:
    """Volumes at the corners of 3-D cells, six times that of the tet of each corner.

    Parameters
    ----------
    points : (np, 3) float64
    noise : (np,) float64
    cells : (n, k) int64
    family : str
        Of dimension 3; the corners are those of the table of families.

    Returns
    -------
    volume : (n, c) float64
    flat : (n, c) bool
        The least height of the tet is nothing but rounding, or `FLAT` of its longest edge.
    """
    table = FAMILIES[family].corners
    volume = np.empty((len(cells), len(table)))
    flat = np.zeros(volume.shape, dtype=bool)
    worst = noise.max(initial=0.0)
    for corner, local in enumerate(table):
        for rows in chunks(len(cells)):
            tets = np.take(cells[rows], local, axis=1)
            a, b, c = edges_at_apex(points, tets)
            volume[rows, corner] = triple(a, b, c)
            size = np.maximum(np.maximum(norms(a), norms(b)), norms(c))
            # Twice the longest edge at one vertex bounds all edges: few tets stay in doubt.
            bound = 8 * size**2 * (FLAT * size + worst)
            doubt = np.flatnonzero(np.abs(volume[rows, corner]) <= bound)
            flat[rows.start + doubt, corner] = _are_flat(points, noise, tets[doubt])
    return volume, flat


def _are_flat(points: Array, noise: Array, tets: Array) -> Array:
    """Whether the least height of each tet is none."""
    volume = triple(*edges_at_apex(points, tets))
    corners = points[tets]
    edges = [corners[:, j] - corners[:, i] for i in range(4) for j in range(i + 1, 4)]
    longest = np.max([norms(edge) for edge in edges], axis=0)
    faces = [np.cross(edges[i], edges[j]) for i, j in ((0, 1), (0, 2), (1, 2), (3, 4))]
    area = np.max([norms(face) for face in faces], axis=0)
    least = FLAT * longest + noise[tets].max(axis=1, initial=0.0)
    # The height is volume / area, unless the tet is no more than a line.
    return (np.abs(volume) <= area * least) | (area <= longest * least)


def flat_in_space(points: Array, noise: Array, cells: Array) -> Array:
    """Which lines have no length, or triangles or quads of a surface no area, (n,) bool."""
    corners = points[cells]
    if cells.shape[1] == 2:
        return norms(corners[:, 1] - corners[:, 0]) <= noise[cells].max(axis=1, initial=0.0)
    longest = norms(np.roll(corners, -1, axis=1) - corners).max(axis=1, initial=0.0)
    height = FLAT * longest + noise[cells].max(axis=1, initial=0.0)
    return norms(area_vectors(points, cells)) <= longest * height


def near_pairs(points: Array, distance: float) -> Pairs:
    """Points nearer to each other than a distance, (n,) and (n,) int64.

    Of more than two points in one place, enough pairs to link them all.
    """
    # Along a direction that no grid follows, few points come close by chance.
    along = points @ np.array([0.5773, 0.6301, 0.5193])
    order = np.argsort(along, kind="stable")
    along, points = along[order], points[order]
    reach = distance + 4 * np.finfo(float).eps * np.abs(along).max(initial=0.0)
    left = np.arange(len(order) - 1)
    found: list[Pairs] = []
    # The bound on the lag is for points of which very many lie within the distance.
    for lag in range(1, 64):
        left = left[left + lag < len(order)]
        left = left[along[left + lag] - along[left] <= reach]
        if not len(left):
            break
        apart = norms(points[left + lag] - points[left])
        near = left[apart <= distance]
        found.append((order[near], order[near + lag]))
        # The rest of those in the very same place follow from their neighbour in the list.
        left = left[apart > 0]
    one, other = (np.concatenate([pair[k] for pair in found] or [order[:0]]) for k in (0, 1))
    return one, other
