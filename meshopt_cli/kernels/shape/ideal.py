"""Ideal points (18.4.1): the apex that makes the best simplex over a facet."""

from __future__ import annotations

import math

from ...compiled.decorators import inlined, kernel
from ..vectors import SQRT3, Vec, cross, distance, minus, norm, ratio

# Height of the regular simplex over a facet of unit mean edge.
TRI_HEIGHT = SQRT3 / 2.0
TET_HEIGHT = math.sqrt(2.0 / 3.0)


@kernel
def tri_ideal_point(a: Vec, b: Vec) -> Vec:
    """Apex of the equilateral triangle to the left of the edge a b."""
    return Vec(
        0.5 * (a.x + b.x) - TRI_HEIGHT * (b.y - a.y),
        0.5 * (a.y + b.y) + TRI_HEIGHT * (b.x - a.x),
        0.0,
    )


@inlined
def tet_ideal_height(a: Vec, b: Vec, c: Vec) -> float:
    """What the normal (b - a) x (c - a) of a facet is to be times, to be the ideal height.

    That is the height of a regular tet of the facet's mean edge; 0 for a flat facet, which has
    no side to stand on.
    """
    normal = cross(minus(b, a), minus(c, a))
    edge = (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0
    return ratio(TET_HEIGHT * edge, norm(normal))


@inlined
def tet_ideal_point(a: Vec, b: Vec, c: Vec, height: float) -> Vec:
    """Apex over the centroid of a triangle; `height` is that of `tet_ideal_height`."""
    normal = cross(minus(b, a), minus(c, a))
    return Vec(
        (a.x + b.x + c.x) / 3.0 + height * normal.x,
        (a.y + b.y + c.y) / 3.0 + height * normal.y,
        (a.z + b.z + c.z) / 3.0 + height * normal.z,
    )
