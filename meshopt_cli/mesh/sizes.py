"""Lengths, areas, volumes and angles of many cells at once.

There is one formula for each, whoever asks: what is cut out of a mesh, the proof that its volumes
stayed, the check, the limits a user sets. Cells are by their corners, families by their names.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..cells import FAMILIES
from .model import Array

CHUNK = 1 << 16  # cells at a time: what fits in the cache of a processor


def chunks(n: int) -> Iterator[slice]:
    """Slices that cover `n` rows."""
    return (slice(first, first + CHUNK) for first in range(0, n, CHUNK))


def norms(vectors: Array) -> Array:
    """Lengths of vectors, over the last axis."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def triple(a: Array, b: Array, c: Array) -> Array:
    """Triple products a . (b x c) of vectors, (n, 3) each."""
    return (
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )


def contents(points: Array, cells: Array, family: str) -> Array:
    """Signed volumes of solids, or areas of triangles and quads, (n,) (18.1, 18.3).

    Parameters
    ----------
    points : (np, 2) or (np, 3) float64
        Areas have a sign in the plane, where there are two columns; those in space have none.
    cells : (n, k) int64
    family : str
        Of dimension 2 or 3. Faces of four vertices count as the mean of their two divisions.
    """
    row = FAMILIES[family]
    if row.dimension == 2:
        if points.shape[1] == 3:
            return norms(area_vectors(points, cells)) / 2
        a, b = _diagonals(points, cells)
        return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    if row.is_simplex:
        parts = [triple(*edges_at_apex(points, cells[rows])) for rows in chunks(len(cells))]
        return np.concatenate([np.empty(0), *parts]) / 6
    origin = points[cells[:, :1]]
    total = np.zeros(len(cells))
    for table in row.facets:
        for facet in table:
            total += flux(points[cells[:, facet]] - origin)
    return total


def edges_at_apex(points: Array, tets: Array) -> tuple[Array, Array, Array]:
    """Vectors from the first vertex of tetrahedra to the others: six times the volume is their
    triple product."""
    origin = points[tets[:, 0]]
    return points[tets[:, 1]] - origin, points[tets[:, 2]] - origin, points[tets[:, 3]] - origin


def _diagonals(points: Array, faces: Array) -> tuple[Array, Array]:
    """Vectors whose cross product is twice the area: sides of triangles, diagonals of quads."""
    start = points[faces[:, 0]]
    if faces.shape[1] == 3:
        return points[faces[:, 1]] - start, points[faces[:, 2]] - start
    return points[faces[:, 2]] - start, points[faces[:, 3]] - points[faces[:, 1]]


def area_vectors(points: Array, faces: Array) -> Array:
    """Normals of triangles or quads in space, twice as long as these are large, (n, 3).

    That of a quad is the mean of its two divisions in triangles.

    Parameters
    ----------
    points : (np, 3) float64
    faces : (n, 3) or (n, 4) int64
        Those that run anticlockwise have a normal towards the viewer.
    """
    return np.cross(*_diagonals(points, faces))


def unit_normals(points: Array, faces: Array) -> Array:
    """The same with length 1, 0 of faces without area."""
    whole = area_vectors(points, faces)
    length = norms(whole)[:, None]
    return np.divide(whole, length, out=np.zeros_like(whole), where=length > 0.0)


def flux(facets: Array) -> Array:
    """What each facet adds to the content that a closed boundary encloses, (n,).

    By the divergence theorem: the volume, or the area in the plane, of the cone from the
    origin. A quad counts as the mean of its two divisions in triangles, so that both of its
    cells see the same.

    Parameters
    ----------
    facets : (n, w, d) float64
        Corners, turned outwards.
    """
    if facets.shape[-1] == 2:
        a, b = facets[:, 0], facets[:, 1]
        return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    if facets.shape[1] == 3:
        return triple(facets[:, 0], facets[:, 1], facets[:, 2]) / 6
    halves = np.concatenate(FAMILIES["quad"].partitions)
    return np.sum([flux(facets[:, half]) for half in halves], axis=0) / 2


def facet_normals(points: Array, cells: Array, family: str) -> Array:
    """Outward normals of the facets of solids, (n, f, 3), twice as long as the facet is large."""
    tables = FAMILIES[family].facets
    normals = [area_vectors(points, cells[:, facet]) for table in tables for facet in table]
    return np.stack(normals, axis=1)


def angles_between(a: Array, b: Array) -> Array:
    """Angles of vectors of space in [0, pi], over the last axis, accurate near 0 and pi too."""
    return np.arctan2(norms(np.cross(a, b)), np.einsum("...i,...i->...", a, b))


def dihedral_angles(points: Array, cells: Array, family: str) -> Array:
    """Angles of solids between two facets, (n, hinges), in radians (Definition 18.1).

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
    family : str
        Of dimension 3: the angles are in the order of its `hinges`. That beside a facet without
        area is pi.
    """
    normals = facet_normals(points, cells, family)
    length = norms(normals)[..., None]
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0.0)
    one, other = FAMILIES[family].hinges.T
    # Both point outwards: the angle inside is what is left of pi.
    return angles_between(normals[:, one], -normals[:, other])


def unfolded(points: Array, triangles: Array) -> tuple[Array, Array]:
    """Each triangle in a plane of its own, seen anticlockwise.

    Parameters
    ----------
    points : (np, 3) float64
    triangles : (n, 3) int64

    Returns
    -------
    points : (3 n, 3) float64
        With z = 0.
    cells : (n, 3) int64
    """
    along, across = _diagonals(points, triangles)
    base = norms(along)
    unit = along / np.where(base > 0.0, base, 1.0)[:, None]
    flat = np.zeros((len(triangles), 3, 3))
    flat[:, 1, 0] = base
    flat[:, 2, 0] = np.einsum("ij,ij->i", across, unit)
    flat[:, 2, 1] = norms(np.cross(unit, across))
    return flat.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
