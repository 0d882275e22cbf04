"""Areas at the corners of faces, and what they say of a quad (18.1.3, Figure 18.5)."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from ..cells import FAMILIES
from .model import Array
from .sizes import area_vectors, norms

FLAT = 1e-10  # least height of a cell, as a fraction of its longest edge


class QuadCase(IntEnum):
    """The configurations of a quad, in the order of Figure 18.5."""

    POSITIVE = 0  # all four areas are: the quad is convex
    DEGENERATED = 1  # some are null: two consecutive sides are aligned
    NON_CONVEX = 2  # one is negative
    SELF_INTERSECTING = 3  # two are, one of each division in triangles
    NEGATIVE = 4  # both of one division are: the quad runs clockwise


def quad_cases(n_negative: Array, n_positive: Array) -> Array:
    """The case of quads, (n,) int64, one of `QuadCase`.

    The areas of either division add up to the same, so that their signs tell which are of one.
    One that is null lets them cancel; a quad without area is degenerated.

    Parameters
    ----------
    n_negative, n_positive : (n,) int64
        How many of the four areas are negative, and positive; the others are null.
    """
    is_crossed = (n_negative == n_positive) & (n_negative > 0)
    return np.select(
        [n_negative > n_positive, is_crossed, n_negative > 0, n_positive < 4],
        [
            QuadCase.NEGATIVE,
            QuadCase.SELF_INTERSECTING,
            QuadCase.NON_CONVEX,
            QuadCase.DEGENERATED,
        ],
        QuadCase.POSITIVE,
    )


def corner_areas(points: Array, noise: Array, cells: Array, family: str) -> tuple[Array, Array]:
    """Areas at the corners of triangles and quads, signed and twice as large (18.1.3).

    Parameters
    ----------
    points : (np, 2) or (np, 3) float64
        Areas have a sign in the plane; in space they are seen from where the mean normal of the
        cell points to.
    noise : (np,) float64
        Error of the coordinates.
    cells : (n, k) int64
    family : str
        Of dimension 2; a quad has four corners (Figure 18.1), a triangle is one.

    Returns
    -------
    area : (n, c) float64
    flat : (n, c) bool
        The height is nothing but rounding, or `FLAT` of the longest edge of the cell.
    """
    corners = points[cells]
    apex, after, before = FAMILIES[family].corners.T
    a, b = corners[:, after] - corners[:, apex], corners[:, before] - corners[:, apex]
    if points.shape[1] == 2:
        area = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    else:
        normals = np.cross(a, b)
        normal = _mean_normals(points, cells, normals)
        area = np.einsum("ncx,nx->nc", normals, normal)
    longest = norms(np.roll(corners, -1, axis=1) - corners).max(axis=1, initial=0.0)
    height = FLAT * longest + noise[cells].max(axis=1, initial=0.0)
    return area, np.abs(area) <= (longest * height)[:, None]


def _mean_normals(points: Array, cells: Array, at_corners: Array) -> Array:
    """Unit normals of faces in space, (n, 3); that of the largest corner, (n, c, 3), where a quad
    intersects itself so that none is left over."""
    normal, lengths = area_vectors(points, cells), norms(at_corners)
    rows, greatest = np.arange(len(cells)), lengths.argmax(axis=1)
    is_none = norms(normal) <= FLAT * lengths[rows, greatest]
    normal[is_none] = at_corners[rows, greatest][is_none]
    length = norms(normal)
    return normal / np.where(length > 0.0, length, 1.0)[:, None]


def signs_of(area: Array, flat: Array) -> tuple[Array, Array]:
    """How many areas of each cell are negative, and positive, (n,) int64 each."""
    return ((area < 0) & ~flat).sum(axis=1), ((area > 0) & ~flat).sum(axis=1)
