"""Vectors of many cells at once: what the measures of Verdict are made of.

Cells are by their corners, x, (n, k, 3) float64, and families by their names. Each formula that
two families share is here once.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array
from ...mesh.sizes import angles_between, flux, norms, triple

# Local coordinates of the corners of a quad and a hexahedron, each -1 or 1.
SIGNS = {
    name: 2.0 * FAMILIES[name].reference[:, : FAMILIES[name].dimension] - 1.0
    for name in ("quad", "hexahedron")
}
# The ends of the edges along each axis, (d, k / 2) both: the corners behind, and those ahead.
_BEHIND = {
    name: np.array([np.flatnonzero(s < 0.0) for s in signs.T]) for name, signs in SIGNS.items()
}
_AHEAD = {
    name: np.array([
        np.argmax(signs @ (signs[behind] * turn).T, axis=0)
        for behind, turn in zip(_BEHIND[name], 1.0 - 2.0 * np.eye(signs.shape[1]), strict=True)
    ])
    for name, signs in SIGNS.items()
}  # fmt: skip


def dot(a: Array, b: Array) -> Array:
    """Products of vectors, over the last axis."""
    return np.einsum("...i,...i->...", a, b)


def squares(vectors: Array) -> Array:
    """Squares of lengths, over the last axis."""
    return dot(vectors, vectors)


def ratio(above: Array, below: Array, otherwise: float) -> Array:
    """Quotients, and a number of choice where there is nothing to divide by."""
    above, below = np.broadcast_arrays(above, below)
    result = np.full(above.shape, otherwise)
    with np.errstate(over="ignore"):
        np.divide(above, below, out=result, where=below != 0.0)
    return result


def unit(vectors: Array) -> Array:
    """Vectors of length 1, or 0 where there is no direction."""
    return ratio(vectors, norms(vectors)[..., None], 0.0)


def over(function: Callable[[Array], Array], x: Array, parts: Array) -> Array:
    """A measure of parts of cells, (n, m).

    Parameters
    ----------
    function : function of corners (m, w, 3)
        Gives (m,).
    x : (n, k, 3) float64
    parts : (m, w) int64
        Local corners of each part.
    """
    return function(x[:, parts].reshape(-1, parts.shape[1], 3)).reshape(len(x), len(parts))


def edges(x: Array, family: str) -> Array:
    """Vectors along the edges, (n, e, 3), in the order of the family."""
    start, end = FAMILIES[family].edges.T
    return x[:, end] - x[:, start]


def edge_ratio(x: Array, family: str) -> Array:
    """Longest edge by shortest."""
    lengths = norms(edges(x, family))
    return ratio(lengths.max(axis=1), lengths.min(axis=1), math.inf)


def sides(x: Array) -> Array:
    """Vectors along the sides of faces, (n, k, 3): the first sets out from corner 0."""
    return np.roll(x, -1, axis=1) - x


def corner_angles(x: Array) -> Array:
    """Angles at the corners of faces in degrees, (n, k), 0 beside a side without length."""
    along = sides(x)
    return np.degrees(angles_between(along, -np.roll(along, 1, axis=1)))


def skew_of_angles(least: Array, greatest: Array, ideal: float) -> Array:
    """How far angles are from the ideal one: 0 if none is, 1 if one is 0 or 180 degrees."""
    return np.maximum((ideal - least) / ideal, (greatest - ideal) / (180.0 - ideal))


def triangle_normals(x: Array, triangles: Array) -> Array:
    """Normals of triangles between corners, (n, m, 3), twice as long as these are large."""
    p = x[:, triangles]
    return np.cross(p[:, :, 1] - p[:, :, 0], p[:, :, 2] - p[:, :, 0])


def frames(x: Array, family: str) -> Array:
    """Edges that leave each corner, (n, corners, dimension, 3), positive in a valid cell."""
    corners = FAMILIES[family].corners
    return x[:, corners[:, 1:]] - x[:, corners[:, :1]]


def determinants(vectors: Array) -> Array:
    """Determinants of three vectors, (..., 3, 3) to (...)."""
    flat = vectors.reshape(-1, 3, 3)
    return triple(flat[:, 0], flat[:, 1], flat[:, 2]).reshape(vectors.shape[:-2])


def scaled(vectors: Array) -> Array:
    """Determinants of three vectors of length 1 each, 0 where one has no direction."""
    return ratio(determinants(vectors), norms(vectors).prod(axis=-1), 0.0)


def condition(vectors: Array) -> Array:
    """Frobenius norm of three vectors times that of their inverse; infinite unless positive."""
    crosses = np.cross(vectors, np.roll(vectors, -1, axis=-2))
    numbers = np.sqrt(squares(vectors).sum(axis=-1) * squares(crosses).sum(axis=-1))
    return ratio(numbers, np.maximum(determinants(vectors), 0.0), math.inf)


def mean_ratio(vectors: Array, ideal: float) -> Array:
    """3 det^(2/3) by the squares of three vectors; 1 for `ideal`, 0 unless positive.

    Parameters
    ----------
    vectors : (..., 3, 3) float64
    ideal : float
        The determinant of ideal vectors of length 1.
    """
    det = np.maximum(determinants(vectors), 0.0) / ideal
    return ratio(3.0 * np.cbrt(det) ** 2, squares(vectors).sum(axis=-1), 0.0)


def oddy(vectors: Array, det: Array) -> Array:
    """Departure of d vectors from equal ones at right angles, 0 for these.

    With the metric G of the vectors: |G - tr(G)/d|^2 / det(G)^(2/d).

    Parameters
    ----------
    vectors : (..., d, 3) float64
    det : (...) float64
        The root of det(G), with a sign; infinite unless positive.
    """
    d = vectors.shape[-2]
    metric = vectors @ np.swapaxes(vectors, -1, -2)
    metric -= np.trace(metric, axis1=-2, axis2=-1)[..., None, None] / d * np.eye(d)
    return ratio((metric**2).sum(axis=(-2, -1)), np.maximum(det, 0.0) ** (4.0 / d), math.inf)


def volumes(x: Array, family: str) -> Array:
    """Volumes with a sign, (n,); faces of four corners count as the mean of their divisions."""
    apart = x - x[:, :1]
    tables = FAMILIES[family].facets
    return np.sum([flux(apart[:, facet]) for table in tables for facet in table], axis=0)


def relative_size_squared(sizes: Array, mean_size: float) -> Array:
    """Square of a size by the mean, or of the mean by it: the lesser; 0 unless positive."""
    size = np.maximum(sizes, 0.0) / mean_size if mean_size > 0.0 else np.zeros(len(sizes))
    return np.minimum(size, ratio(np.ones(len(size)), size, 0.0)) ** 2


def axes(x: Array, family: str) -> Array:
    """Axes of quads and hexahedra, (n, d, 3): the sums of the edges along each.

    Of differences, so that those of a quad folded on itself are parallel to the last digit.
    """
    return (x[:, _AHEAD[family]] - x[:, _BEHIND[family]]).sum(axis=2)


def max_edge_ratio(x: Array, family: str) -> Array:
    """Longest axis by shortest."""
    lengths = norms(axes(x, family))
    return ratio(lengths.max(axis=1), lengths.min(axis=1), math.inf)


def skew(x: Array, family: str) -> Array:
    """Greatest |cos| of the angles between axes; infinite if one has no direction."""
    along = axes(x, family)
    one, other = np.triu_indices(along.shape[1], 1)
    cosines = np.abs(dot(unit(along[:, one]), unit(along[:, other]))).max(axis=1)
    return np.where((norms(along) == 0.0).any(axis=1), math.inf, cosines)


def taper(x: Array, family: str) -> Array:
    """Greatest length of a cross derivative by the shorter of its two axes."""
    signs, lengths = SIGNS[family], norms(axes(x, family))
    one, other = np.triu_indices(signs.shape[1], 1)
    across = norms(np.einsum("kp,nki->npi", signs[:, one] * signs[:, other], x - x[:, :1]))
    shorter = np.minimum(lengths[:, one], lengths[:, other])
    return ratio(across, shorter, math.inf).max(axis=1)


def stretch(x: Array, family: str) -> Array:
    """Shortest edge by longest diagonal, 1 for a square and a cube."""
    signs = SIGNS[family]
    opposite = np.argmin(signs @ signs.T, axis=1)  # the other end of each diagonal
    diagonals = norms(x[:, opposite] - x).max(axis=1)
    shortest = norms(edges(x, family)).min(axis=1)
    return math.sqrt(signs.shape[1]) * ratio(shortest, diagonals, 0.0)


def shapes(family: str, places: Array) -> Array:
    """Weights of the corners at local places (p, d) of a quad or a hexahedron, (p, k)."""
    signs = SIGNS[family]
    return (0.5 + 0.5 * signs * places[:, None]).prod(axis=2)


def gradients(family: str, places: Array) -> Array:
    """Derivatives of the weights by the local coordinates, (p, k, d)."""
    signs = SIGNS[family]
    factors = 0.5 + 0.5 * signs * places[:, None]
    result = np.empty(factors.shape)
    for j in range(signs.shape[1]):
        rest = np.delete(factors, j, axis=2).prod(axis=2)
        result[:, :, j] = 0.5 * signs[:, j] * rest
    return result


def tangents(x: Array, derivatives: Array) -> Array:
    """Derivatives of a position by the local coordinates, (n, p, d, 3).

    From corner 0, so that no digits are lost far from the origin.
    """
    return np.einsum("pkd,nki->npdi", derivatives, x - x[:, :1])
