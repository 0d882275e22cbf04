"""Pyramids by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 5, 3) float64, the apex last, and gives (n,) float64. The four
tetrahedra of a pyramid are those on three corners of the base, below the apex.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array
from ...mesh.sizes import norms
from . import geometry as g
from . import quad, tetra, triangle
from .model import LESS, MORE, NUMBER, SIZE, VOLUME, Row

_FAMILY = FAMILIES["pyramid"]
_TRIANGLES, _QUADS = _FAMILY.facets


def volume(x: Array) -> Array:
    """Volume with a sign."""
    return g.volumes(x, "pyramid")


def jacobian(x: Array) -> Array:
    """Least Jacobian of the four tetrahedra."""
    return g.over(tetra.jacobian, x, _FAMILY.corners).min(axis=1)


def scaled_jacobian(x: Array) -> Array:
    """Least scaled Jacobian of the four tetrahedra, 1 for the ideal pyramid.

    What is beyond 1 counts as as much below it.
    """
    least = g.over(tetra.scaled_jacobian, x, _FAMILY.corners).min(axis=1)
    least = math.sqrt(2.0) * np.maximum(least, 0.0)
    return np.minimum(least, 2.0 - least)


def equiangle_skew(x: Array) -> Array:
    """How far the angles of the faces are from 60 and 90 degrees."""
    return np.maximum(
        g.over(triangle.equiangle_skew, x, _TRIANGLES).max(axis=1),
        g.over(quad.equiangle_skew, x, _QUADS).max(axis=1),
    )


def shape(x: Array) -> Array:
    """Shape of the base, how straight the apex stands above it, and whether at its height."""
    normal = g.unit(np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 0]))
    axis = x[:, 4] - x[:, :4].mean(axis=1)
    height = np.maximum(g.dot(axis, normal), 0.0)
    ideal = norms(g.edges(x, "pyramid")).max(axis=1) / math.sqrt(2.0)
    straight = g.ratio(height, norms(axis), 0.0)
    tall = np.minimum(g.ratio(height, ideal, 0.0), g.ratio(ideal, height, 0.0))
    return quad.shape(x[:, :4]) * straight * tall


_row = partial(Row, "pyramid")

ROWS = (
    _row("equiangle-skew", NUMBER, 0.0, LESS, "greatest equiangle-skew of a face",
         equiangle_skew, note=quad.ANGLES),
    _row("jacobian", VOLUME, None, MORE, "least 6 V of the four tetrahedra", jacobian),
    _row("scaled-jacobian", NUMBER, 1.0, MORE,
         "q = sqrt(2) least scaled-jacobian of the four tetrahedra, 2 - q beyond 1",
         scaled_jacobian),
    _row("shape", NUMBER, 1.0, MORE, "shape of the base, cos of its normal and the axis, "
         "min(height / ideal, ideal / height)", shape,
         note="Verdict leaves out the longer of the edges 01 and 12 as the longest edge"),
    _row("volume", VOLUME, None, SIZE, "V", volume),
)  # fmt: skip
