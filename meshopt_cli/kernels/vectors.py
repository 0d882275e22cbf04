"""Vectors, lengths, signed areas and volumes (18.1), ideal points (18.4.1)."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..compiled.decorators import inlined, kernel

SQRT3 = math.sqrt(3.0)
# Height of the regular simplex over a facet of unit mean edge.
TRI_HEIGHT = SQRT3 / 2.0
TET_HEIGHT = math.sqrt(2.0 / 3.0)


class Vec(NamedTuple):
    """A point or vector of space; z = 0 in planar meshes."""

    x: float
    y: float
    z: float


@inlined
def at(points, i):
    """Point i of an (n, 3) array."""
    return Vec(points[i, 0], points[i, 1], points[i, 2])


@inlined
def ratio(numerator, denominator):
    """The quotient, and 0 for what shrank to a point or a line."""
    return numerator / denominator if denominator > 0.0 else 0.0


@inlined
def minus(a, b):
    return Vec(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def toward(a, b, t):
    """The point a + t (b - a)."""
    return Vec(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z))


@inlined
def along(a, d, t):
    """The point a + t d."""
    return Vec(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z)


@inlined
def dot(a, b):
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a, b):
    return Vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def norm(a):
    return math.sqrt(dot(a, a))


@inlined
def square_distance(a, b):
    d = minus(a, b)
    return dot(d, d)


@inlined
def distance(a, b):
    return math.sqrt(square_distance(a, b))


class Guide(NamedTuple):
    """What a point may move along: everything (0), a line (1) or a plane (2)."""

    kind: float
    direction: Vec  # of the line, or normal of the plane


FREE = Guide(0.0, Vec(0.0, 0.0, 0.0))


@inlined
def guided(guide, v):
    """The part of a vector that a guide allows."""
    if guide.kind == 0.0:
        return v
    part = dot(v, guide.direction)
    if guide.kind == 1.0:
        return Vec(part * guide.direction.x, part * guide.direction.y, part * guide.direction.z)
    return along(v, guide.direction, -part)


@kernel
def tri_area(a, b, c):
    """Signed area of a triangle in the plane z = 0 (18.1)."""
    return 0.5 * ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y))


@kernel
def tet_volume(a, b, c, d):
    """Signed volume of a tetrahedron (18.3)."""
    return dot(cross(minus(b, a), minus(c, a)), minus(d, a)) / 6.0


@kernel
def tri_ideal_point(a, b):
    """Apex of the equilateral triangle to the left of the edge a b."""
    return Vec(
        0.5 * (a.x + b.x) - TRI_HEIGHT * (b.y - a.y),
        0.5 * (a.y + b.y) + TRI_HEIGHT * (b.x - a.x),
        0.0,
    )


@inlined
def tet_ideal_height(a, b, c):
    """What the normal (b - a) x (c - a) of a facet is to be times, to be the ideal height.

    That is the height of a regular tet of the facet's mean edge; 0 for a flat facet, which has
    no side to stand on.
    """
    normal = cross(minus(b, a), minus(c, a))
    edge = (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0
    return ratio(TET_HEIGHT * edge, norm(normal))


@inlined
def tet_ideal_point(a, b, c, height):
    """Apex over the centroid of a triangle; `height` is that of `tet_ideal_height`."""
    normal = cross(minus(b, a), minus(c, a))
    return Vec(
        (a.x + b.x + c.x) / 3.0 + height * normal.x,
        (a.y + b.y + c.y) / 3.0 + height * normal.y,
        (a.z + b.z + c.z) / 3.0 + height * normal.z,
    )
