"""Quality measures of one cell, each as q = 1/Q (Remark 18.3).

q is 1 for the regular cell, 0 for a flat one, negative for an inverted one, whatever the
position, rotation and size. `tet_quality` and `tri_quality` pick a measure by the code of a judge;
the table of measures gives the codes their names. Operators ask `judge`, not these formulas.
"""

from __future__ import annotations

import math

from ...compiled.decorators import inlined, kernel
from ..types import Judge
from ..vectors import (
    SQRT3,
    Vec,
    along,
    cross,
    distance,
    dot,
    minus,
    norm,
    ratio,
    square_distance,
)
from .angles import (
    ANGLE_Q,
    REGULAR_ANGLE_2,
    REGULAR_ANGLE_3,
    REGULAR_SOLID_ANGLE,
    solid_angle,
    tet_angle_bound,
    tet_angles,
    tet_normals,
    tri_angles,
)

(
    ASPECT_RATIO,
    VOLUME_LENGTH,
    RADIUS_RATIO,
    RADIUS_EDGE,
    EDGE_RATIO,
    VOLUME_AREA,
    MEAN_EDGE,
    ANGLE_MIN,
    ANGLE_MAX,
    SOLID_ANGLE_MIN,
    SCALED_JACOBIAN,
) = range(11)

ALPHA_2 = SQRT3 / 6.0
ALPHA_3 = math.sqrt(6.0) / 36.0
BETA_2 = SQRT3 / 12.0
BETA_3 = SQRT3 / 216.0
SQRT2 = math.sqrt(2.0)
SQRT6 = math.sqrt(6.0)


@kernel
def signed(value: float, volume: float) -> float:
    """The value with the sign of the volume, 0 for a flat cell."""
    if volume > 0.0:
        return value
    return -value if volume < 0.0 else 0.0


# Tetrahedra -----------------------------------------------------------------------------


@inlined
def tet_aspect_ratio(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """V / (alpha_3 h_max S), the inverse of (18.7)."""
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    surface = 0.5 * (norm(n3) + norm(n2) + norm(n1) + norm(n0))
    h_max = math.sqrt(
        max(
            square_distance(a, b),
            square_distance(a, c),
            square_distance(a, d),
            square_distance(b, c),
            square_distance(b, d),
            square_distance(c, d),
        )
    )
    return ratio(dot(n3, minus(d, a)) / 6.0, ALPHA_3 * h_max * surface)


@kernel
def tet_volume_length(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """V / (beta_3 h_s^3), the inverse of (18.9)."""
    ab = minus(b, a)
    ac = minus(c, a)
    ad = minus(d, a)
    h2 = dot(ab, ab) + dot(ac, ac) + dot(ad, ad)
    h2 += square_distance(b, c) + square_distance(b, d) + square_distance(c, d)
    return ratio(dot(cross(ab, ac), ad) / 6.0, BETA_3 * h2 * math.sqrt(h2))


@kernel
def tet_edges(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[float, float, float, float, float, float]:
    """Lengths of the six edges: ab, ac, ad, bc, bd, cd."""
    return (
        distance(a, b),
        distance(a, c),
        distance(a, d),
        distance(b, c),
        distance(b, d),
        distance(c, d),
    )


@kernel
def tet_circumradius(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """Radius of the sphere through the vertices of a tetrahedron that is not flat."""
    u = minus(b, a)
    v = minus(c, a)
    w = minus(d, a)
    vw = cross(v, w)
    wu = cross(w, u)
    uv = cross(u, v)
    # The centre is at (|u|^2 v x w + |v|^2 w x u + |w|^2 u x v) / (12 V) from a.
    centre = along(along(along(Vec(0.0, 0.0, 0.0), vw, dot(u, u)), wu, dot(v, v)), uv, dot(w, w))
    return norm(centre) / (2.0 * abs(dot(u, vw)))


@inlined
def lenient(times: float, q: float) -> float:
    """What a positive q counts for, if it counts more than once.

    A Q of `times` ANGLE_Q is good enough then: it counts as ANGLE_Q. What is worse counts for
    so much less that nothing becomes worse for the sake of the angles: by the 32nd power of the
    part that it has of that, so that a Q a tenth beyond counts 20 times as bad.
    """
    part = times * q * ANGLE_Q
    steep = part * part
    steep *= steep
    steep *= steep
    steep *= steep
    steep *= steep / ANGLE_Q
    return steep if times > 1.0 and part < 1.0 else times * q


@inlined
def tet_bounded_aspect_ratio(times: float, a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """`tet_bounded_quality` by the aspect ratio, with a lenience."""
    q = tet_aspect_ratio(a, b, c, d)
    return min(lenient(times, q), tet_angle_bound(a, b, c, d)) if q > 0.0 else q


@kernel
def tet_bounded_quality(judge: Judge, a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """What the q of a tet counts for by a measure, or what its angles allow if that is less."""
    if judge.code == ASPECT_RATIO:
        return tet_bounded_aspect_ratio(judge.lenience, a, b, c, d)
    if judge.code == VOLUME_LENGTH:
        q = tet_volume_length(a, b, c, d)
    else:
        q = tet_other_quality(judge.code, a, b, c, d)
    return min(lenient(judge.lenience, q), tet_angle_bound(a, b, c, d)) if q > 0.0 else q


@kernel
def tet_other_quality(measure: int, a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """The measures of the list in 18.2.2, all but the two most used."""
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    volume = dot(n3, minus(d, a)) / 6.0
    if volume == 0.0:
        return 0.0
    ab, ac, ad, bc, bd, cd = tet_edges(a, b, c, d)
    if measure == RADIUS_RATIO:
        inradius = 6.0 * volume / (norm(n0) + norm(n1) + norm(n2) + norm(n3))
        return ratio(3.0 * inradius, tet_circumradius(a, b, c, d))
    if measure == VOLUME_AREA:
        squares = 0.25 * (dot(n0, n0) + dot(n1, n1) + dot(n2, n2) + dot(n3, n3))
        v2 = volume * volume
        # 3^7 = 2187 times V^4 / (sum S^2)^3 is 1 for the regular tet.
        return signed(2187.0 * v2 * v2 / (squares * squares * squares), volume)
    if measure == MEAN_EDGE:
        mean = (ab + ac + ad + bc + bd + cd) / 6.0
        return 6.0 * SQRT2 * volume / (mean * mean * mean)
    if measure == ANGLE_MIN:
        least, _ = tet_angles(a, b, c, d)
        return signed(least / REGULAR_ANGLE_3, volume)
    if measure == ANGLE_MAX:
        _, greatest = tet_angles(a, b, c, d)
        return signed((math.pi - greatest) / (math.pi - REGULAR_ANGLE_3), volume)
    if measure == SOLID_ANGLE_MIN:
        least = min(
            solid_angle(a, b, c, d),
            solid_angle(b, a, c, d),
            solid_angle(c, a, b, d),
            solid_angle(d, a, b, c),
        )
        return signed(least / REGULAR_SOLID_ANGLE, volume)
    if measure == SCALED_JACOBIAN:
        longest = max(ab * ac * ad, ab * bc * bd, ac * bc * cd, ad * bd * cd)
        return 6.0 * SQRT2 * volume / longest
    h_min = min(ab, ac, ad, bc, bd, cd)
    if measure == RADIUS_EDGE:
        radius = tet_circumradius(a, b, c, d)
        # Of a cell that is flat but for rounding, the radius is anything.
        return signed(min(1.0, ratio(h_min * SQRT6, 4.0 * radius)), volume)
    h_max = max(ab, ac, ad, bc, bd, cd)
    return signed(h_min / h_max, volume)  # EDGE_RATIO


@inlined
def tet_quality(judge: Judge, a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """q of a tetrahedron."""
    if judge.lenience > 0.0:
        return tet_bounded_quality(judge, a, b, c, d)
    if judge.code == ASPECT_RATIO:
        return tet_aspect_ratio(a, b, c, d)
    if judge.code == VOLUME_LENGTH:
        return tet_volume_length(a, b, c, d)
    return tet_other_quality(judge.code, a, b, c, d)


# Triangles ------------------------------------------------------------------------------


@kernel
def tri_other_quality(measure: int, a: Vec, b: Vec, c: Vec, area: float) -> float:
    """The planar counterparts of the measures of 18.2.2 (Exercise 18.3)."""
    ab = distance(a, b)
    bc = distance(b, c)
    ca = distance(c, a)
    if area == 0.0:
        return 0.0
    if measure == RADIUS_RATIO:
        return signed(16.0 * area * area / ((ab + bc + ca) * ab * bc * ca), area)
    if measure == VOLUME_AREA:
        squares = ab * ab + bc * bc + ca * ca
        return signed(48.0 * area * area / (squares * squares), area)
    if measure == MEAN_EDGE:
        mean = (ab + bc + ca) / 3.0
        return 4.0 / SQRT3 * area / (mean * mean)
    if measure in (ANGLE_MIN, SOLID_ANGLE_MIN):
        least, _ = tri_angles(a, b, c)
        return signed(least / REGULAR_ANGLE_2, area)
    if measure == ANGLE_MAX:
        _, greatest = tri_angles(a, b, c)
        return signed((math.pi - greatest) / (math.pi - REGULAR_ANGLE_2), area)
    if measure == SCALED_JACOBIAN:
        return 4.0 / SQRT3 * area / max(ab * bc, bc * ca, ca * ab)
    h_min = min(ab, bc, ca)
    if measure == RADIUS_EDGE:
        return 4.0 / SQRT3 * area * h_min / (ab * bc * ca)
    return signed(h_min / max(ab, bc, ca), area)  # EDGE_RATIO


@inlined
def tri_aspect_ratio(a: Vec, b: Vec, c: Vec) -> float:
    """S / (alpha_2 h_max p), the inverse of (18.6)."""
    ab = minus(b, a)
    ac = minus(c, a)
    area = 0.5 * (ab.x * ac.y - ab.y * ac.x)
    e0 = norm(ab)
    e1 = norm(ac)
    e2 = norm(minus(c, b))
    return ratio(area, ALPHA_2 * max(e0, e1, e2) * 0.5 * (e0 + e1 + e2))


@kernel
def tri_quality(judge: Judge, a: Vec, b: Vec, c: Vec) -> float:
    """q of a triangle in the plane z = 0; angles bound none.

    `VOLUME_LENGTH` is S / (beta_2 h_s^2), the inverse of (18.8).
    """
    if judge.code == ASPECT_RATIO:
        return tri_aspect_ratio(a, b, c)
    ab = minus(b, a)
    ac = minus(c, a)
    bc = minus(c, b)
    area = 0.5 * (ab.x * ac.y - ab.y * ac.x)
    if judge.code == VOLUME_LENGTH:
        return ratio(area, BETA_2 * (dot(ab, ab) + dot(ac, ac) + dot(bc, bc)))
    return tri_other_quality(judge.code, a, b, c, area)
