"""Quads by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 4, 3) float64 and gives (n,) float64. A quad faces the way of the
product of its axes; a corner has a negative area where it turns the other way. One whose corners
2 and 3 are the same is a triangle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ...mesh.model import Array
from ...mesh.sizes import norms
from . import geometry as g
from . import triangle
from .model import AREA, DEGREES, LESS, MORE, NUMBER, SIZE, Row

_GAUSS = g.SIGNS["quad"] / math.sqrt(3.0)
_LAST = np.array([2])
_ALL = np.array([2, 0, 1, 3])


def _crosses(x: Array) -> Array:
    """Products of the sides at each corner, (n, 4, 3)."""
    along = g.sides(x)
    return np.cross(np.roll(along, 1, axis=1), along)


def _corner_areas(x: Array) -> Array:
    """Areas of the parallelograms at the corners, (n, 4), by the way that the quad faces."""
    along = g.axes(x, "quad")
    return g.dot(_crosses(x), g.unit(np.cross(along[:, 0], along[:, 1]))[:, None])


def _neighbour_squares(x: Array) -> Array:
    """Sums of the squares of the two sides at each corner, (n, 4)."""
    squares = g.squares(g.sides(x))
    return squares + np.roll(squares, 1, axis=1)


def _or_triangle(
    values: Array, x: Array, function: Callable[[Array], Array], which: Array = _LAST
) -> Array:
    """Values, and those of triangles for quads with a side (one of `which`) without length."""
    short = (norms(g.sides(x)) == 0.0)[:, which]
    rows = np.flatnonzero(short.any(axis=1))
    if len(rows):
        first = which[short[rows].argmax(axis=1)]
        kept = (first[:, None] + np.arange(1, 4)) % 4
        values = values.copy()
        values[rows] = function(x[rows[:, None], kept])
    return values


def area(x: Array) -> Array:
    """A quarter of the areas at the corners."""
    return _corner_areas(x).sum(axis=1) / 4.0


def aspect_ratio(x: Array) -> Array:
    """Longest side times perimeter by four times the area."""
    lengths = norms(g.sides(x))
    return g.ratio(lengths.max(axis=1) * lengths.sum(axis=1), 4.0 * area(x), math.inf)


def radius_ratio(x: Array) -> Array:
    """Sides and longest line between corners by the least triangle of three of these."""
    squares = g.squares(g.sides(x))
    diagonals = g.squares(x[:, 2:] - x[:, :2])
    longest = np.maximum(squares.max(axis=1), diagonals.max(axis=1))
    least = norms(_crosses(x)).min(axis=1)
    return g.ratio(np.sqrt(squares.sum(axis=1) * longest / 8.0), least, math.inf)


def _aspects(x: Array) -> Array:
    """Frobenius aspects of the corners, (n, 4)."""
    return g.ratio(_neighbour_squares(x), 2.0 * norms(_crosses(x)), math.inf)


def med_aspect_frobenius(x: Array) -> Array:
    """Mean of the aspects of the corners."""
    return _aspects(x).mean(axis=1)


def max_aspect_frobenius(x: Array) -> Array:
    """Greatest of the aspects of the corners."""
    return _aspects(x).max(axis=1)


def min_angle(x: Array) -> Array:
    """Least angle, degrees."""
    return _or_triangle(g.corner_angles(x).min(axis=1), x, triangle.min_angle, _ALL)


def max_angle(x: Array) -> Array:
    """Greatest angle, degrees: beyond 180 where a corner turns the other way."""
    greatest = g.corner_angles(x).max(axis=1)
    reflex = (_corner_areas(x) < 0.0).any(axis=1)
    greatest = np.where(reflex, 360.0 - greatest, greatest)
    return _or_triangle(greatest, x, triangle.max_angle, _ALL)


def equiangle_skew(x: Array) -> Array:
    """How far the angles are from 90 degrees."""
    return g.skew_of_angles(min_angle(x), max_angle(x), 90.0)


def condition(x: Array) -> Array:
    """Greatest condition number of a corner, infinite unless all turn the same way."""
    areas = np.maximum(_corner_areas(x), 0.0)
    numbers = g.ratio(_neighbour_squares(x), 2.0 * areas, math.inf)
    return _or_triangle(numbers.max(axis=1), x, triangle.aspect_frobenius)


def jacobian(x: Array) -> Array:
    """Least area of a corner."""
    return _or_triangle(_corner_areas(x).min(axis=1), x, lambda t: 2.0 * triangle.area(t))


def scaled_jacobian(x: Array) -> Array:
    """Least area of a corner by its sides."""
    lengths = norms(g.sides(x))
    sines = g.ratio(_corner_areas(x), lengths * np.roll(lengths, 1, axis=1), 0.0)
    return _or_triangle(sines.min(axis=1), x, triangle.scaled_jacobian)


def shear(x: Array) -> Array:
    """The scaled Jacobian, where it is positive."""
    return np.maximum(scaled_jacobian(x), 0.0)


def shape(x: Array) -> Array:
    """Least area of a corner by the squares of its sides, where it is positive."""
    least = g.ratio(_corner_areas(x), _neighbour_squares(x), 0.0).min(axis=1)
    return 2.0 * np.maximum(least, 0.0)


def relative_size_squared(x: Array, mean_size: float) -> Array:
    """Square of the area by the mean area, or the inverse."""
    return g.relative_size_squared(area(x), mean_size)


def shape_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shape(x) * relative_size_squared(x, mean_size)


def shear_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shear(x) * relative_size_squared(x, mean_size)


def oddy(x: Array) -> Array:
    """Greatest departure of the sides at a corner from those of a square."""
    return g.oddy(g.frames(x, "quad"), norms(_crosses(x))).max(axis=1)


def warpage(x: Array) -> Array:
    """Cube of the lesser cosine between normals of opposite corners."""
    normals = g.unit(_crosses(x))
    cosines = g.dot(normals[:, :2], normals[:, 2:]).min(axis=1)
    return np.where((normals == 0.0).all(axis=2).any(axis=1), 0.0, cosines) ** 3


def _facing(normals: Array) -> Array:
    """The side that most of the corners 0, 2 and 1 see, (n, 3), from their normals."""
    n0, n1, n2 = normals[:, 0], normals[:, 1], normals[:, 2]
    agree = (g.dot(n0, n2) > 0.0)[:, None]
    then = (g.dot(n0, n1) > 0.0)[:, None]
    return np.where(agree, n0 + n2, np.where(then, n0 + n1, n1 + n2))


def distortion(x: Array) -> Array:
    """Least Jacobian at corners and Gauss points by the mean one.

    A quad that is not flat within 0.99 of a cosine counts as a shell with a thickness of a
    thousandth of its size, on both sides of its middle.
    """
    derivatives = g.gradients("quad", _GAUSS)
    along = g.tangents(x, derivatives)
    whole = norms(np.cross(along[:, :, 0], along[:, :, 1])).sum(axis=1)
    crosses = _crosses(x)
    normals = g.unit(crosses)
    flat = (np.abs(g.dot(normals, normals[:, :1])) >= 0.99).all(axis=1)
    offset = np.where(flat, 0.0, 0.0005 / math.sqrt(3.0) * np.sqrt(whole))[:, None, None, None]
    bend = g.tangents(normals, derivatives) * offset
    middle = np.einsum("pk,nki->npi", g.shapes("quad", _GAUSS), normals)
    inside = [
        g.dot(middle, np.cross(sheet[:, :, 0], sheet[:, :, 1]))
        for sheet in (along + bend, along - bend)
    ]
    turned = np.where(g.dot(crosses, _facing(normals)[:, None]) > 0.0, 0.25, -0.25)
    least = np.concatenate([*inside, turned * norms(crosses)], axis=1).min(axis=1)
    return _or_triangle(g.ratio(4.0 * least, whole, 0.0), x, triangle.distortion)


_row = partial(Row, "quad")
ANGLES = "Verdict gives 360 and 0 as the angles where a side other than 2-3 has no length: " \
          "here that is a triangle, as it is for side 2-3"  # fmt: skip

ROWS = (
    _row("area", AREA, None, SIZE, "A, a quarter of the corner areas", area),
    _row("aspect-ratio", NUMBER, 1.0, LESS, "h_max perimeter / (4 A)", aspect_ratio),
    _row("condition", NUMBER, 1.0, LESS, "max (a^2 + b^2) / (2 corner area)", condition),
    _row("distortion", NUMBER, 1.0, MORE, "4 min J / A", distortion,
         note="Verdict gives 2 for every triangle (sides 2-3 without length), which is 1"),
    _row("edge-ratio", NUMBER, 1.0, LESS, "h_max / h_min", partial(g.edge_ratio, family="quad")),
    _row("equiangle-skew", NUMBER, 0.0, LESS, "max(90 - least, greatest - 90) / 90",
         equiangle_skew, note=ANGLES),
    _row("jacobian", AREA, None, MORE, "least corner area", jacobian),
    _row("max-angle", DEGREES, 90.0, LESS, "greatest angle", max_angle, note=ANGLES),
    _row("max-aspect-frobenius", NUMBER, 1.0, LESS, "max (a^2 + b^2) / (2 |a x b|)",
         max_aspect_frobenius),
    _row("max-edge-ratio", NUMBER, 1.0, LESS, "longer axis / shorter axis",
         partial(g.max_edge_ratio, family="quad")),
    _row("med-aspect-frobenius", NUMBER, 1.0, LESS, "mean (a^2 + b^2) / (2 |a x b|)",
         med_aspect_frobenius),
    _row("min-angle", DEGREES, 90.0, MORE, "least angle", min_angle, note=ANGLES),
    _row("oddy", NUMBER, 0.0, LESS, "max |G - tr(G) / 2|^2 / det(G)", oddy),
    _row("radius-ratio", NUMBER, 1.0, LESS,
         "sqrt(sum a^2 max(a^2, diagonal^2) / 8) / min |a x b|", radius_ratio),
    _row("relative-size-squared", NUMBER, 1.0, MORE, "min(A / mean, mean / A)^2",
         relative_size_squared, sized=True),
    _row("scaled-jacobian", NUMBER, 1.0, MORE, "min corner area / (a b)", scaled_jacobian),
    _row("shape", NUMBER, 1.0, MORE, "max(0, min 2 corner area / (a^2 + b^2))", shape),
    _row("shape-and-size", NUMBER, 1.0, MORE, "shape relative-size-squared", shape_and_size,
         sized=True),
    _row("shear", NUMBER, 1.0, MORE, "max(0, scaled-jacobian)", shear),
    _row("shear-and-size", NUMBER, 1.0, MORE, "shear relative-size-squared", shear_and_size,
         sized=True),
    _row("skew", NUMBER, 0.0, LESS, "|cos| between the axes", partial(g.skew, family="quad"),
         note="Verdict gives 0, the best there is, where an axis has no length, and infinite for "
              "such a hexahedron; here both are infinite"),
    _row("stretch", NUMBER, 1.0, MORE, "sqrt(2) h_min / longest diagonal",
         partial(g.stretch, family="quad")),
    _row("taper", NUMBER, 0.0, LESS, "|x0 - x1 + x2 - x3| / shorter axis",
         partial(g.taper, family="quad")),
    _row("warpage", NUMBER, 1.0, MORE, "min(n0 . n2, n1 . n3)^3", warpage),
)  # fmt: skip
