"""Tetrahedra by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 4, 3) float64 and gives (n,) float64. V, S, r, R: volume (with a
sign), area of all facets, inscribed and circumscribed sphere. Facet i is opposite corner i.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array
from ...mesh.sizes import angles_between, norms
from . import geometry as g
from .model import DEGREES, LENGTH, LESS, MORE, NUMBER, SIZE, VOLUME, Row

_FACETS = FAMILIES["tetra"].facets[0]
_HINGES = FAMILIES["tetra"].hinges
_REGULAR = math.acos(1.0 / 3.0)  # its angle between two facets


def _frame(x: Array) -> Array:
    """Edges from corner 0, (n, 3, 3)."""
    return g.frames(x, "tetra")[:, 0]


def _squares(x: Array) -> Array:
    """Sum of the squares of the edges."""
    return g.squares(g.edges(x, "tetra")).sum(axis=1)


def _areas(x: Array) -> Array:
    """Areas of the facets, (n, 4)."""
    return norms(g.triangle_normals(x, _FACETS)) / 2.0


def _radius(x: Array) -> Array:
    """R, infinite for a flat cell."""
    frame = _frame(x)
    crosses = np.cross(np.roll(frame, -1, axis=1), np.roll(frame, -2, axis=1))
    centre = (g.squares(frame)[..., None] * crosses).sum(axis=1)
    return g.ratio(norms(centre), 2.0 * np.abs(jacobian(x)), math.inf)


def jacobian(x: Array) -> Array:
    """Six times the volume."""
    return g.determinants(_frame(x))


def volume(x: Array) -> Array:
    """Volume with a sign."""
    return jacobian(x) / 6.0


def inradius(x: Array) -> Array:
    """Radius of the inscribed sphere, with the sign of the volume."""
    return g.ratio(3.0 * volume(x), _areas(x).sum(axis=1), 0.0)


def aspect_ratio(x: Array) -> Array:
    """Longest edge by the inscribed sphere, 1 for the regular tetrahedron."""
    longest = norms(g.edges(x, "tetra")).max(axis=1)
    return g.ratio(longest, 2.0 * math.sqrt(6.0) * np.abs(inradius(x)), math.inf)


def radius_ratio(x: Array) -> Array:
    """Circumscribed sphere by three times the inscribed one."""
    return g.ratio(_radius(x), 3.0 * np.abs(inradius(x)), math.inf)


def aspect_gamma(x: Array) -> Array:
    """Cube of the root of the mean square of the edges by the volume."""
    above = (_squares(x) / 6.0) ** 1.5
    return g.ratio(above, 6.0 * math.sqrt(2.0) * np.abs(volume(x)), math.inf)


def mean_ratio(x: Array) -> Array:
    """The inverse of aspect-gamma, with the sign of the volume."""
    return g.ratio(6.0 * math.sqrt(2.0) * volume(x), (_squares(x) / 6.0) ** 1.5, 0.0)


def _from_regular(x: Array) -> Array:
    """Vectors that edges of the regular tetrahedron map unit vectors at right angles to,
    (n, 3, 3): the Jacobian of the map from the regular cell."""
    a, b, c = np.moveaxis(_frame(x), 1, 0)
    return np.stack([a, (2.0 * b - a) / math.sqrt(3.0), (3.0 * c - b - a) / math.sqrt(6.0)], axis=1)


def aspect_frobenius(x: Array) -> Array:
    """Squares of the map from the regular cell by its determinant, whichever its sign."""
    below = 3.0 * np.cbrt(math.sqrt(2.0) * jacobian(x)) ** 2
    return g.ratio(g.squares(_from_regular(x)).sum(axis=1), below, math.inf)


def condition(x: Array) -> Array:
    """Condition number of the map from the regular cell, with the sign of the volume."""
    mapped = _from_regular(x)
    det = g.determinants(mapped)
    turned = np.where((det < 0.0)[:, None, None], mapped[:, [1, 0, 2]], mapped)
    return np.where(det < 0.0, -1.0, 1.0) * g.condition(turned) / 3.0


def shape(x: Array) -> Array:
    """The inverse of aspect-frobenius, 0 unless the volume is positive."""
    return np.where(jacobian(x) > 0.0, g.ratio(np.ones(len(x)), aspect_frobenius(x), 0.0), 0.0)


def scaled_jacobian(x: Array) -> Array:
    """Jacobian by the greatest product of three edges that meet."""
    lengths = norms(x[:, :, None] - x[:, None]) + np.eye(4)
    return math.sqrt(2.0) * g.ratio(jacobian(x), lengths.prod(axis=2).max(axis=1), 0.0)


def relative_size_squared(x: Array, mean_size: float) -> Array:
    """Square of the volume by the mean volume, or the inverse."""
    return g.relative_size_squared(volume(x), mean_size)


def shape_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shape(x) * relative_size_squared(x, mean_size)


def distortion(x: Array) -> Array:
    """Least Jacobian by the mean one: 1, as these are the same all over a tetrahedron."""
    return np.ones(len(x))


def _dihedral_angles(x: Array) -> Array:
    """Angles between facets, (n, 6), degrees; 90 beside a facet without area."""
    normals = g.unit(g.triangle_normals(x, _FACETS))
    one, other = _HINGES.T
    return np.degrees(angles_between(normals[:, one], -normals[:, other]))


def min_angle(x: Array) -> Array:
    """Least angle between facets, degrees."""
    return _dihedral_angles(x).min(axis=1)


def equiangle_skew(x: Array) -> Array:
    """How far the angles between facets and in them are from those of the regular cell."""
    between = _dihedral_angles(x)
    inside = np.concatenate([g.corner_angles(x[:, facet]) for facet in _FACETS], axis=1)
    return np.maximum(
        g.skew_of_angles(between.min(axis=1), between.max(axis=1), math.degrees(_REGULAR)),
        g.skew_of_angles(inside.min(axis=1), inside.max(axis=1), 60.0),
    )


def equivolume_skew(x: Array) -> Array:
    """What the volume lacks of that of the regular cell in the same sphere: 1 if all."""
    best = 8.0 * math.sqrt(3.0) / 27.0 * _radius(x) ** 3
    return 1.0 - g.ratio(np.abs(volume(x)), best, 0.0)


def squish_index(x: Array) -> Array:
    """Greatest 1 - cos between the normal of a facet and the way to it from the centre."""
    ways = x[:, _FACETS].mean(axis=2) - x.mean(axis=1)[:, None]
    cosines = g.dot(g.unit(g.triangle_normals(x, _FACETS)), g.unit(ways))
    return np.maximum(1.0 - cosines.min(axis=1), 0.0)


def collapse_ratio(x: Array) -> Array:
    """Least height by the longest edge of the facet below it, with the sign of the volume."""
    heights = g.ratio(jacobian(x)[:, None], 2.0 * _areas(x), 0.0)
    longest = norms(np.roll(x[:, _FACETS], -1, axis=2) - x[:, _FACETS]).max(axis=2)
    return g.ratio(heights, longest, 0.0).min(axis=1)


def normalized_inradius(x: Array) -> Array:
    """Least inscribed sphere of the cell's twelve parts by R, with the sign of the volume.

    The parts are one of half the size at each corner, whose number is 3 r / R, and eight around
    the centre of the octahedron between them, each with a quarter of a facet and a sixteenth of
    the volume; the faces inside meet in the centre and are as large in all eight.
    """
    a, b, c = np.moveaxis(_frame(x), 1, 0)
    ways = (a - b - c) / 4.0, (b - a - c) / 4.0, (c - a - b) / 4.0  # from the centre to middles
    inside = np.sum([norms(np.cross(ways[i - 1], ways[i])) for i in range(3)], axis=0) / 2.0
    inner = g.ratio(3.0 / 16.0 * volume(x)[:, None], _areas(x) / 4.0 + inside[:, None], 0.0)
    least = np.minimum(3.0 * inradius(x), 3.0 * (1.0 + math.sqrt(3.0)) * inner.min(axis=1))
    return g.ratio(least, _radius(x), 0.0)


_row = partial(Row, "tetra")

ROWS = (
    _row("aspect-frobenius", NUMBER, 1.0, LESS,
         "|J|^2 / (3 |det J|^(2/3)), J from the regular cell", aspect_frobenius),
    _row("aspect-gamma", NUMBER, 1.0, LESS, "h_rms^3 / (6 sqrt(2) |V|)", aspect_gamma),
    _row("aspect-ratio", NUMBER, 1.0, LESS, "h_max / (2 sqrt(6) r)", aspect_ratio),
    _row("collapse-ratio", NUMBER, math.sqrt(2.0 / 3.0), MORE,
         "min height / longest edge of the facet", collapse_ratio,
         note="Verdict takes edge 13 for 12 in facet 012, and 12 for 13 in facet 013; and gives "
              "infinite for facet 012 without area: 0"),
    _row("condition", NUMBER, 1.0, LESS, "|J| |J^-1| / 3, J from the regular cell; < 0 if inverted",
         condition),
    _row("distortion", NUMBER, 1.0, MORE, "min J / mean J", distortion),
    _row("edge-ratio", NUMBER, 1.0, LESS, "h_max / h_min", partial(g.edge_ratio, family="tetra")),
    _row("equiangle-skew", NUMBER, 0.0, LESS,
         "max (ideal - least) / ideal, (greatest - ideal) / (180 - ideal), all angles",
         equiangle_skew),
    _row("equivolume-skew", NUMBER, 0.0, LESS, "1 - V / V of the regular cell of the same R",
         equivolume_skew, note="Verdict gives infinite for a flat cell, which lacks all: 1"),
    _row("inradius", LENGTH, None, SIZE, "r = 3 V / S", inradius),
    _row("jacobian", VOLUME, None, MORE, "6 V", jacobian),
    _row("mean-ratio", NUMBER, 1.0, MORE, "6 sqrt(2) V / h_rms^3", mean_ratio),
    _row("min-angle", DEGREES, math.degrees(_REGULAR), MORE, "least angle between facets",
         min_angle,
         note="Verdict takes what is left to 180 of the angles at the edges 02 and 13"),
    _row("normalized-inradius", NUMBER, 1.0, MORE,
         "min(3 r, 3 (1 + sqrt(3)) r of an eighth of the inner octahedron) / R",
         normalized_inradius, note="Verdict gives infinite where two corners are the same: 0"),
    _row("radius-ratio", NUMBER, 1.0, LESS, "R / (3 r)", radius_ratio),
    _row("relative-size-squared", NUMBER, 1.0, MORE, "min(V / mean, mean / V)^2",
         relative_size_squared, sized=True),
    _row("scaled-jacobian", NUMBER, 1.0, MORE, "6 sqrt(2) V / max a b c of a corner",
         scaled_jacobian),
    _row("shape", NUMBER, 1.0, MORE, "3 det J^(2/3) / |J|^2, J from the regular cell", shape),
    _row("shape-and-size", NUMBER, 1.0, MORE, "shape relative-size-squared", shape_and_size,
         sized=True),
    _row("squish-index", NUMBER, 0.0, LESS, "max 1 - cos(normal of a facet, way from the centre)",
         squish_index),
    _row("volume", VOLUME, None, SIZE, "V", volume),
)  # fmt: skip
