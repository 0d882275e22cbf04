"""Quality of triangles and quads in the plane, as q = 1/Q."""

from __future__ import annotations

import math

from ...cells import QUAD_ALPHA
from ...compiled.decorators import inlined, kernel
from ..types import Judge
from ..vectors import ZERO, Vec, minus, norm, ratio, square_distance
from .simplex import ASPECT_RATIO, SCALED_JACOBIAN, tri_quality

# A right isosceles triangle becomes regular where each edge at its right angle takes so much of
# itself and of the other: see `cells.stretch_of`.
OWN = (math.sqrt(3.0) + 1.0) / (2.0 * math.sqrt(2.0))
OTHER = (math.sqrt(3.0) - 1.0) / (2.0 * math.sqrt(2.0))


@inlined
def turn(a: Vec, b: Vec, c: Vec) -> float:
    """Twice the area of a triangle of the plane."""
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)


@kernel
def quad_aspect_ratio(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """S_min / (alpha h_max h_s), the inverse of (18.10): not positive unless the quad is convex."""
    least = min(turn(a, b, d), turn(b, c, a), turn(c, d, b), turn(d, a, c)) / 2.0
    ab = square_distance(a, b)
    bc = square_distance(b, c)
    cd = square_distance(c, d)
    da = square_distance(d, a)
    longest = max(ab, bc, cd, da, square_distance(a, c), square_distance(b, d))
    return ratio(least, QUAD_ALPHA * math.sqrt(longest * (ab + bc + cd + da)))


@kernel
def corner_quality(judge: Judge, at: Vec, following: Vec, last: Vec) -> float:
    """q of the triangle at a corner of a quad, next to that of a square (18.2.4)."""
    a = minus(following, at)
    b = minus(last, at)
    if judge.code == SCALED_JACOBIAN:
        return ratio(a.x * b.y - a.y * b.x, norm(a) * norm(b))
    return tri_quality(
        judge,
        ZERO,
        Vec(OWN * a.x + OTHER * b.x, OWN * a.y + OTHER * b.y, 0.0),
        Vec(OTHER * a.x + OWN * b.x, OTHER * a.y + OWN * b.y, 0.0),
    )


@kernel
def quad_quality(judge: Judge, a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """q of a quad, by (18.10) or by its worst corner."""
    if judge.code == ASPECT_RATIO:
        return quad_aspect_ratio(a, b, c, d)
    return min(
        corner_quality(judge, a, b, d),
        corner_quality(judge, b, c, a),
        corner_quality(judge, c, d, b),
        corner_quality(judge, d, a, c),
    )
