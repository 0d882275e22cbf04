"""Quads, and quad faces of solids: the measures that the chapter and Robinson have for them.

Each function takes points (np, 3), cells (n, k) by their corners and the name of their family,
and gives (n,) float64. A quad need not be flat: its areas are those seen along its area vector,
its lengths those in space.
"""

from __future__ import annotations

import math

import numpy as np

from ..cells import FAMILIES, QUAD_ALPHA
from ..mesh.model import Array
from ..mesh.sizes import angles_between, area_vectors, norms, unit_normals

HALF_SQUARE = 4.0 * (math.sqrt(2.0) + 1.0)  # longest side times perimeter by the area

# The four triangles of Figure 18.1, of one division and of the other; in each division the
# second lies across the diagonal from the first.
_TRIANGLES = np.concatenate(FAMILIES["quad"].partitions)
_SIDES = FAMILIES["quad"].edges
_DIAGONALS = np.array([[0, 2], [1, 3]])

# An axis is longer than the other if it is by more than rounding.
LONGER = 1.0 + 1e-9


def aspect(points: Array, cells: Array, family: str) -> Array:
    """Q of quads, alpha h_max h_s / S_min, infinite unless they are convex (18.10)."""
    lengths = _lengths(points, cells, _SIDES)
    longest = np.maximum(lengths.max(axis=1), _lengths(points, cells, _DIAGONALS).max(axis=1))
    return _over(QUAD_ALPHA * longest * norms(lengths), _areas(points, cells).min(axis=1))


def worst_triangle(points: Array, cells: Array, family: str) -> Array:
    """Q of the worst triangle of three vertices of a quad, next to that of half a square
    (Remark 18.5, by 18.6); infinite unless the quad is convex."""
    areas = _areas(points, cells) * HALF_SQUARE
    worst = np.zeros(len(cells))
    for area, corners in zip(areas.T, _TRIANGLES, strict=True):
        sides = _lengths(points, cells, corners[[[0, 1], [1, 2], [2, 0]]])
        worst = np.maximum(worst, _over(sides.max(axis=1) * sides.sum(axis=1), area))
    return worst


def _lengths(points: Array, cells: Array, ends: Array) -> Array:
    return norms(points[cells[:, ends[:, 1]]] - points[cells[:, ends[:, 0]]])


def _areas(points: Array, cells: Array) -> Array:
    """Areas of the four triangles of quads, (n, 4), below 0 where they turn the other way."""
    normal = unit_normals(points, cells)
    triangles = [area_vectors(points, cells[:, corners]) for corners in _TRIANGLES]
    return np.stack([np.einsum("ij,ij->i", t, normal) for t in triangles], axis=1) / 2.0


def _over(value: Array, by: Array) -> Array:
    """Quotients, infinite where they would not be those of a valid cell."""
    result = np.full(len(value), math.inf)
    with np.errstate(over="ignore"):
        return np.divide(value, by, out=result, where=by > 0.0)


# Robinson ------------------------------------------------------------------------------------
#
# A quad is x = e1 + e2 s + e3 t + e4 st, y = f1 + f2 s + f3 t + f4 st for s and t in [-1, 1], where
# the x axis is that of s, so that f2 = 0. Here it is the longer one of the two axes, so that
# the numbering of a quad does not matter; of two that are as long as each other, that of the
# greater taper along it.


def robinson_aspect(points: Array, cells: Array, family: str) -> Array:
    """The greater of e2 / f3 and f3 / e2, for the worse of both axes."""
    s, t, _ = _axes(points, cells)
    longest = np.maximum(np.einsum("ij,ij->i", s, s), np.einsum("ij,ij->i", t, t))
    return _over(longest, norms(np.cross(s, t)))


def robinson_skew(points: Array, cells: Array, family: str) -> Array:
    """e3 / f3: the cotangent of the angle between the axes."""
    s, t, _ = _axes(points, cells)
    return _over(np.abs(np.einsum("ij,ij->i", s, t)), norms(np.cross(s, t)))


def robinson_taper_x(points: Array, cells: Array, family: str) -> Array:
    """f4 / f3: how the height of a quad changes along the x axis."""
    return _tapers(points, cells)[0]


def robinson_taper_y(points: Array, cells: Array, family: str) -> Array:
    """e4 / e2: how the width of a quad changes across the x axis."""
    return _tapers(points, cells)[1]


def _axes(points: Array, cells: Array) -> tuple[Array, Array, Array]:
    """e and f of s, of t and of st, in space, (n, 3) each."""
    a, b, c, d = np.moveaxis(points[cells], 1, 0)
    return (b + c - a - d) / 4.0, (c + d - a - b) / 4.0, (a + c - b - d) / 4.0


def _tapers(points: Array, cells: Array) -> tuple[Array, Array]:
    s, t, both = _axes(points, cells)
    height = norms(np.cross(s, t))
    square_s, square_t = np.einsum("ij,ij->i", s, s), np.einsum("ij,ij->i", t, t)
    by_s = _over(np.abs(np.einsum("ij,ij->i", both, s)), square_s)
    by_t = _over(np.abs(np.einsum("ij,ij->i", both, t)), square_t)
    even = np.maximum(square_s, square_t) <= LONGER * np.minimum(square_s, square_t)
    x_is_s = np.where(even, by_s >= by_t, square_s > square_t)
    across = np.where(x_is_s, norms(np.cross(s, both)), norms(np.cross(t, both)))
    return _over(across, height), np.where(x_is_s, by_s, by_t)


# Quad faces ----------------------------------------------------------------------------------


def smoothness(points: Array, cells: Array, family: str) -> Array:
    """Least planarity (1 + n . n') / 2 of the diagonals of quads, or of quad faces (18.11)."""
    return (1.0 + np.cos(_folds(points, cells, family))) / 2.0


def torsion(points: Array, cells: Array, family: str) -> Array:
    """Greatest angle by which quads, or quad faces, are folded along a diagonal, in degrees."""
    return np.degrees(_folds(points, cells, family))


def _folds(points: Array, cells: Array, family: str) -> Array:
    """Greatest angle between the normals beside a diagonal; 0 beside a triangle without area."""
    result = np.zeros(len(cells))
    for face in _quads_of(family):
        normals = area_vectors(points, cells[:, face[_TRIANGLES]].reshape(-1, 3))
        normals = normals.reshape(-1, 2, 2, 3)
        result = np.maximum(result, angles_between(normals[:, :, 0], normals[:, :, 1]).max(axis=1))
    return result


def _quads_of(family: str) -> list[Array]:
    """Corners of the quad faces of a cell; a quad is its own."""
    if family == "quad":
        return [np.arange(4)]
    return [face for table in FAMILIES[family].facets if table.shape[1] == 4 for face in table]
