"""Triangles by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 3, 3) float64 and gives (n,) float64. Triangles of space have no
orientation. A, p, a, b, c: area, perimeter and sides.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ...mesh.model import Array
from ...mesh.sizes import norms
from . import geometry as g
from .model import AREA, DEGREES, LESS, MORE, NUMBER, SIZE, Row

_ROOT3 = math.sqrt(3.0)


def _double_area(x: Array) -> Array:
    return norms(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))


def area(x: Array) -> Array:
    """Area."""
    return _double_area(x) / 2.0


def aspect_ratio(x: Array) -> Array:
    """Longest side by the diameter of the inscribed circle, 1 for the regular triangle."""
    lengths = norms(g.sides(x))
    above = lengths.max(axis=1) * lengths.sum(axis=1)
    return g.ratio(above, 2.0 * _ROOT3 * _double_area(x), math.inf)


def radius_ratio(x: Array) -> Array:
    """Circumscribed circle by twice the inscribed one."""
    lengths = norms(g.sides(x))
    above = lengths.prod(axis=1) * lengths.sum(axis=1)
    return g.ratio(above, 4.0 * _double_area(x) ** 2, math.inf)


def normalized_inradius(x: Array) -> Array:
    """Twice the inscribed circle by the circumscribed one."""
    return g.ratio(np.ones(len(x)), radius_ratio(x), 0.0)


def aspect_frobenius(x: Array) -> Array:
    """Squares of the sides by the area, 1 for the regular triangle."""
    above = g.squares(g.sides(x)).sum(axis=1)
    return g.ratio(above, 2.0 * _ROOT3 * _double_area(x), math.inf)


def min_angle(x: Array) -> Array:
    """Least angle, degrees."""
    return g.corner_angles(x).min(axis=1)


def max_angle(x: Array) -> Array:
    """Greatest angle, degrees."""
    return g.corner_angles(x).max(axis=1)


def equiangle_skew(x: Array) -> Array:
    """How far the angles are from 60 degrees."""
    angles = g.corner_angles(x)
    return g.skew_of_angles(angles.min(axis=1), angles.max(axis=1), 60.0)


def scaled_jacobian(x: Array) -> Array:
    """Least sine of an angle by that of 60 degrees."""
    lengths = norms(g.sides(x))
    longest = (lengths * np.roll(lengths, 1, axis=1)).max(axis=1)
    return 2.0 / _ROOT3 * g.ratio(_double_area(x), longest, 0.0)


def shape(x: Array) -> Array:
    """The inverse of the condition number."""
    return g.ratio(np.ones(len(x)), aspect_frobenius(x), 0.0)


def distortion(x: Array) -> Array:
    """Least Jacobian by the mean one: 1, as these are the same all over a triangle."""
    return np.ones(len(x))


def relative_size_squared(x: Array, mean_size: float) -> Array:
    """Square of the area by the mean area, or the inverse."""
    return g.relative_size_squared(area(x), mean_size)


def shape_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shape(x) * relative_size_squared(x, mean_size)


_row = partial(Row, "triangle")

ROWS = (
    _row("area", AREA, None, SIZE, "A", area),
    _row("aspect-frobenius", NUMBER, 1.0, LESS, "(a^2 + b^2 + c^2) / (4 sqrt(3) A)",
         aspect_frobenius),
    _row("aspect-ratio", NUMBER, 1.0, LESS, "h_max p / (4 sqrt(3) A)", aspect_ratio),
    _row("condition", NUMBER, 1.0, LESS,
         "condition number of the map from the regular triangle; here aspect-frobenius",
         aspect_frobenius),
    _row("distortion", NUMBER, 1.0, MORE, "min J / mean J", distortion),
    _row("edge-ratio", NUMBER, 1.0, LESS, "h_max / h_min",
         partial(g.edge_ratio, family="triangle")),
    _row("equiangle-skew", NUMBER, 0.0, LESS, "max((60 - least) / 60, (greatest - 60) / 120)",
         equiangle_skew),
    _row("max-angle", DEGREES, 60.0, LESS, "greatest angle", max_angle),
    _row("min-angle", DEGREES, 60.0, MORE, "least angle", min_angle),
    _row("normalized-inradius", NUMBER, 1.0, MORE, "2 r / R", normalized_inradius,
         note="Verdict gives infinite where two corners are the same: 0"),
    _row("radius-ratio", NUMBER, 1.0, LESS, "R / (2 r)", radius_ratio),
    _row("relative-size-squared", NUMBER, 1.0, MORE, "min(A / mean, mean / A)^2",
         relative_size_squared, sized=True),
    _row("scaled-jacobian", NUMBER, 1.0, MORE, "2 / sqrt(3) least sine", scaled_jacobian),
    _row("shape", NUMBER, 1.0, MORE, "1 / condition", shape),
    _row("shape-and-size", NUMBER, 1.0, MORE, "shape relative-size-squared", shape_and_size,
         sized=True),
)  # fmt: skip
