"""Hexahedra by the measures of Verdict (Stimpson et al., SAND2007-1751).

Each function takes corners (n, 8, 3) float64 and gives (n,) float64. J: the Jacobian of the three
edges at a corner; a, b, c: their lengths.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array
from ...mesh.sizes import norms
from . import geometry as g
from . import quad
from .model import LENGTH, LESS, MORE, NUMBER, SIZE, VOLUME, Row

_FACES = FAMILIES["hexahedron"].facets[0]
_GAUSS = g.SIGNS["hexahedron"] / math.sqrt(3.0)
# Each face in four triangles, those of both its divisions, each from all its corners.
_TRIANGLES = _FACES[:, np.concatenate(FAMILIES["quad"].partitions)].reshape(-1, 3)
_TURNS = np.concatenate([np.roll(_TRIANGLES, turn, axis=1) for turn in range(3)])


def _corners(x: Array) -> Array:
    """The edges at each corner, (n, 8, 3, 3)."""
    return g.frames(x, "hexahedron")


def _places(x: Array) -> Array:
    """The edges at each corner, and a quarter of the axes for those at the centre."""
    centre = g.axes(x, "hexahedron")[:, None] / 4.0
    return np.concatenate([_corners(x), centre], axis=1)


def _diagonals(x: Array) -> Array:
    """Lengths of the four diagonals."""
    return norms(x[:, [6, 7, 4, 5]] - x[:, :4])


def volume(x: Array) -> Array:
    """Volume with a sign."""
    return g.volumes(x, "hexahedron")


def jacobian(x: Array) -> Array:
    """Least Jacobian at the corners and the centre."""
    return g.determinants(_places(x)).min(axis=1)


def scaled_jacobian(x: Array) -> Array:
    """Least Jacobian at the corners and the centre by its edges."""
    return g.scaled(_places(x)).min(axis=1)


def nodal_jacobian_ratio(x: Array) -> Array:
    """Least Jacobian of a corner by the greatest; infinite below 0 if none is positive."""
    values = g.determinants(_corners(x))
    greatest = np.maximum(values.max(axis=1), 0.0)
    return g.ratio(values.min(axis=1), greatest, -math.inf)


def shear(x: Array) -> Array:
    """Least Jacobian of a corner by its edges, where it is positive."""
    return np.clip(g.scaled(_corners(x)).min(axis=1), 0.0, 1.0)


def shape(x: Array) -> Array:
    """Least mean ratio of a corner."""
    return np.minimum(g.mean_ratio(_corners(x), 1.0).min(axis=1), 1.0)


def max_aspect_frobenius(x: Array) -> Array:
    """Greatest condition number of a corner."""
    return g.condition(_corners(x)).max(axis=1) / 3.0


def med_aspect_frobenius(x: Array) -> Array:
    """Mean condition number of the corners."""
    return g.condition(_corners(x)).mean(axis=1) / 3.0


def oddy(x: Array) -> Array:
    """Greatest departure of the edges at a corner, or the axes, from those of a cube."""
    places = _places(x)
    return g.oddy(places, g.determinants(places)).max(axis=1)


def relative_size_squared(x: Array, mean_size: float) -> Array:
    """Square of the mean Jacobian of the corners by the mean volume, or the inverse."""
    return g.relative_size_squared(g.determinants(_corners(x)).mean(axis=1), mean_size)


def shape_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shape(x) * relative_size_squared(x, mean_size)


def shear_and_size(x: Array, mean_size: float) -> Array:
    """Product of the two."""
    return shear(x) * relative_size_squared(x, mean_size)


def distortion(x: Array) -> Array:
    """Least Jacobian at corners and Gauss points by the mean one."""
    inside = 8.0 * g.determinants(g.tangents(x, g.gradients("hexahedron", _GAUSS)))
    least = np.minimum(inside.min(axis=1), g.determinants(_corners(x)).min(axis=1))
    return g.ratio(least, inside.mean(axis=1), 0.0)


def diagonal(x: Array) -> Array:
    """Shortest diagonal by longest."""
    lengths = _diagonals(x)
    return g.ratio(lengths.min(axis=1), lengths.max(axis=1), 0.0)


def dimension(x: Array) -> Array:
    """A length for steps of time: the volume by its gradient over the corners."""
    apart = x - x.mean(axis=1)[:, None]
    b, c = apart[:, _TURNS[:, 1]], apart[:, _TURNS[:, 2]]
    gradient = np.einsum("tk,nti->nki", _TURNS[:, :1] == np.arange(8), np.cross(b, c)) / 12.0
    steepness = np.sqrt(2.0 * g.squares(gradient).sum(axis=1))
    return g.ratio(np.abs(volume(x)), steepness, 0.0)


def equiangle_skew(x: Array) -> Array:
    """How far the angles of the faces are from 90 degrees."""
    return g.over(quad.equiangle_skew, x, _FACES).max(axis=1)


_row = partial(Row, "hexahedron")

ROWS = (
    _row("condition", NUMBER, 1.0, LESS, "max-aspect-frobenius", max_aspect_frobenius),
    _row("diagonal", NUMBER, 1.0, MORE, "shortest diagonal / longest", diagonal),
    _row("dimension", LENGTH, None, SIZE, "V / sqrt(2 sum |dV / dx|^2)", dimension),
    _row("distortion", NUMBER, 1.0, MORE, "min J / V, with the Gauss points", distortion),
    _row("edge-ratio", NUMBER, 1.0, LESS, "h_max / h_min",
         partial(g.edge_ratio, family="hexahedron"),
         note="Verdict looks for the longest among the first six of its edges"),
    _row("equiangle-skew", NUMBER, 0.0, LESS, "greatest equiangle-skew of a face",
         equiangle_skew, note=quad.ANGLES),
    _row("jacobian", VOLUME, None, MORE, "min J, with the centre", jacobian),
    _row("max-aspect-frobenius", NUMBER, 1.0, LESS, "max |J| |J^-1| / 3", max_aspect_frobenius),
    _row("max-edge-ratio", NUMBER, 1.0, LESS, "longest axis / shortest",
         partial(g.max_edge_ratio, family="hexahedron")),
    _row("med-aspect-frobenius", NUMBER, 1.0, LESS, "mean |J| |J^-1| / 3", med_aspect_frobenius),
    _row("nodal-jacobian-ratio", NUMBER, 1.0, MORE, "min J / max J", nodal_jacobian_ratio),
    _row("oddy", NUMBER, 0.0, LESS, "max |G - tr(G) / 3|^2 / det(G)^(2/3), with the centre", oddy),
    _row("relative-size-squared", NUMBER, 1.0, MORE, "min(mean J / mean, mean / mean J)^2",
         relative_size_squared, sized=True),
    _row("scaled-jacobian", NUMBER, 1.0, MORE, "min J / (a b c), with the centre",
         scaled_jacobian,
         note="Verdict gives infinite where an edge has no length; that corner is 0"),
    _row("shape", NUMBER, 1.0, MORE, "min 3 J^(2/3) / (a^2 + b^2 + c^2)", shape),
    _row("shape-and-size", NUMBER, 1.0, MORE, "shape relative-size-squared", shape_and_size,
         sized=True),
    _row("shear", NUMBER, 1.0, MORE, "min J / (a b c)", shear),
    _row("shear-and-size", NUMBER, 1.0, MORE, "shear relative-size-squared", shear_and_size,
         sized=True),
    _row("skew", NUMBER, 0.0, LESS, "max |cos| between the axes",
         partial(g.skew, family="hexahedron")),
    _row("stretch", NUMBER, 1.0, MORE, "sqrt(3) h_min / longest diagonal",
         partial(g.stretch, family="hexahedron")),
    _row("taper", NUMBER, 0.0, LESS, "max cross derivative / shorter axis",
         partial(g.taper, family="hexahedron")),
    _row("volume", VOLUME, None, SIZE, "V", volume),
)  # fmt: skip
