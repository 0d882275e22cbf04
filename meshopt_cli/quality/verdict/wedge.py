"""Wedges by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 6, 3) float64 and gives (n,) float64. The ideal wedge is straight
on a regular triangle, with all edges the same.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array
from . import geometry as g
from . import quad, tetra, triangle
from .model import LESS, MORE, NUMBER, SIZE, VOLUME, Row

_FAMILY = FAMILIES["wedge"]
_TRIANGLES, _QUADS = _FAMILY.facets
_JACOBIAN = math.sqrt(3.0) / 2.0  # of the corners of an ideal wedge with edges of length 1
_ASPECT = 4.0 / (3.0 * math.cbrt(1.5))  # their aspect-frobenius


def _jacobians(x: Array) -> Array:
    """Jacobians at the corners, (n, 6)."""
    return g.determinants(g.frames(x, "wedge"))


def _aspects(x: Array) -> Array:
    """Aspects of the tetrahedra at the corners, (n, 6), 1 for those of the ideal wedge."""
    return g.over(tetra.aspect_frobenius, x, _FAMILY.corners) / _ASPECT


def volume(x: Array) -> Array:
    """Volume with a sign."""
    return g.volumes(x, "wedge")


def jacobian(x: Array) -> Array:
    """Least Jacobian of a corner."""
    return _jacobians(x).min(axis=1)


def scaled_jacobian(x: Array) -> Array:
    """Least Jacobian of a corner by its edges."""
    return g.scaled(g.frames(x, "wedge")).min(axis=1) / _JACOBIAN


def shape(x: Array) -> Array:
    """Least mean ratio of a corner."""
    return np.minimum(g.mean_ratio(g.frames(x, "wedge"), _JACOBIAN).min(axis=1), 1.0)


def distortion(x: Array) -> Array:
    """Least Jacobian of a corner by the mean one."""
    return g.ratio(jacobian(x) / 2.0, volume(x), 0.0)


def max_aspect_frobenius(x: Array) -> Array:
    """Greatest aspect of a corner, at least 1."""
    return np.maximum(_aspects(x).max(axis=1), 1.0)


def mean_aspect_frobenius(x: Array) -> Array:
    """Mean aspect of the corners, at least 1."""
    return np.maximum(_aspects(x).mean(axis=1), 1.0)


def max_stretch(x: Array) -> Array:
    """Greatest stretch of a face of four corners."""
    return g.over(partial(g.stretch, family="quad"), x, _QUADS).max(axis=1)


def equiangle_skew(x: Array) -> Array:
    """How far the angles of the faces are from 60 and 90 degrees."""
    return np.maximum(
        g.over(triangle.equiangle_skew, x, _TRIANGLES).max(axis=1),
        g.over(quad.equiangle_skew, x, _QUADS).max(axis=1),
    )


_row = partial(Row, "wedge")
_ROUNDED = "Verdict divides by 1.16477 for the number of the ideal wedge, 4 / (3 1.5^(1/3))"

ROWS = (
    _row("condition", NUMBER, 1.0, LESS, "max-aspect-frobenius", max_aspect_frobenius,
         note=_ROUNDED),
    _row("distortion", NUMBER, 1.0, MORE, "min J / (2 V)", distortion,
         note="Verdict has 0.433013 / 0.866025 for 1/2"),
    _row("edge-ratio", NUMBER, 1.0, LESS, "h_max / h_min", partial(g.edge_ratio, family="wedge")),
    _row("equiangle-skew", NUMBER, 0.0, LESS, "greatest equiangle-skew of a face",
         equiangle_skew, note=quad.ANGLES),
    _row("jacobian", VOLUME, None, MORE, "min J", jacobian),
    _row("max-aspect-frobenius", NUMBER, 1.0, LESS,
         "max aspect-frobenius of a corner's tetrahedron, by that of the ideal wedge",
         max_aspect_frobenius, note=_ROUNDED),
    _row("max-stretch", NUMBER, 1.0, MORE, "greatest stretch of a face of four corners",
         max_stretch),
    _row("mean-aspect-frobenius", NUMBER, 1.0, LESS,
         "mean aspect-frobenius of the corners' tetrahedra, by that of the ideal wedge",
         mean_aspect_frobenius, note=_ROUNDED),
    _row("scaled-jacobian", NUMBER, 1.0, MORE, "2 / sqrt(3) min J / (a b c)", scaled_jacobian,
         note="Verdict leaves out corners where an edge has no length, which are 0"),
    _row("shape", NUMBER, 1.0, MORE, "min 3 (2 J / sqrt(3))^(2/3) / (a^2 + b^2 + c^2)", shape),
    _row("volume", VOLUME, None, SIZE, "V", volume),
)  # fmt: skip
