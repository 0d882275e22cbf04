"""Quality measures of one cell, each as q = 1/Q (Remark 18.3).

q is 1 for the regular cell, 0 for a flat one, negative for an inverted one, whatever the
position, rotation and size. `tet_quality` and `tri_quality` pick a measure by its code;
`meshopt_cli.quality.MEASURES` gives the codes their names.
"""

from __future__ import annotations

import math

from ._kernel import entry, inlined, kernel
from .geometry import (
    SQRT3,
    Vec,
    along,
    at,
    cross,
    distance,
    dot,
    minus,
    norm,
    ratio,
    square_distance,
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
) = range(10)

# Added to a code n times: the dihedral angles of a tet bound its q as well (`tet_angle_bound`),
# and its q counts n / PERCENT times (`lenient`).
WITH_ANGLES = 100
PERCENT = 100

ALPHA_2 = SQRT3 / 6.0
ALPHA_3 = math.sqrt(6.0) / 36.0
BETA_2 = SQRT3 / 12.0
BETA_3 = SQRT3 / 216.0
REGULAR_ANGLE_2 = math.pi / 3.0
REGULAR_ANGLE_3 = math.acos(1.0 / 3.0)
REGULAR_SOLID_ANGLE = 3.0 * REGULAR_ANGLE_3 - math.pi
SQRT2 = math.sqrt(2.0)
SQRT6 = math.sqrt(6.0)
# Dihedral angles of LEAST_ANGLE and GREATEST_ANGLE degrees count as bad as Q = ANGLE_Q; an
# angle of 0 or 180 degrees as 1 / ANGLE_WEIGHT times that, so that a bad Q goes first.
LEAST_ANGLE = 30.0
GREATEST_ANGLE = 130.0
ANGLE_Q = 1.84
ANGLE_WEIGHT = 0.25
LEAST_SINE = math.sin(math.radians(LEAST_ANGLE / 2.0))
LEAST_COSINE = math.cos(math.radians(GREATEST_ANGLE / 2.0))


@kernel
def angle_between(u, v):
    """Angle of two vectors in [0, pi], accurate near 0 and pi too."""
    return math.atan2(norm(cross(u, v)), dot(u, v))


@kernel
def signed(value, volume):
    """The value with the sign of the volume, 0 for a flat cell."""
    if volume > 0.0:
        return value
    return -value if volume < 0.0 else 0.0


# Tetrahedra -----------------------------------------------------------------------------


@inlined
def tet_aspect_ratio(a, b, c, d):
    """V / (alpha_3 h_max S), the inverse of (18.7)."""
    ab = minus(b, a)
    ac = minus(c, a)
    ad = minus(d, a)
    bc = minus(c, b)
    bd = minus(d, b)
    cd = minus(d, c)
    n_abc = cross(ab, ac)
    n_abd = cross(ab, ad)
    n_acd = cross(ac, ad)
    n_bcd = cross(bc, bd)
    surface = 0.5 * (norm(n_abc) + norm(n_abd) + norm(n_acd) + norm(n_bcd))
    h_max = math.sqrt(
        max(dot(ab, ab), dot(ac, ac), dot(ad, ad), dot(bc, bc), dot(bd, bd), dot(cd, cd))
    )
    return ratio(dot(n_abc, ad) / 6.0, ALPHA_3 * h_max * surface)


@kernel
def tet_volume_length(a, b, c, d):
    """V / (beta_3 h_s^3), the inverse of (18.9)."""
    ab = minus(b, a)
    ac = minus(c, a)
    ad = minus(d, a)
    h2 = dot(ab, ab) + dot(ac, ac) + dot(ad, ad)
    h2 += square_distance(b, c) + square_distance(b, d) + square_distance(c, d)
    return ratio(dot(cross(ab, ac), ad) / 6.0, BETA_3 * h2 * math.sqrt(h2))


@kernel
def tet_edges(a, b, c, d):
    """Lengths of the six edges: ab, ac, ad, bc, bd, cd."""
    return (
        distance(a, b),
        distance(a, c),
        distance(a, d),
        distance(b, c),
        distance(b, d),
        distance(c, d),
    )


@inlined
def tet_normals(a, b, c, d):
    """Inward normals of the faces opposite a, b, c, d, twice their areas long."""
    ab = minus(b, a)
    ac = minus(c, a)
    ad = minus(d, a)
    bc = minus(c, b)
    bd = minus(d, b)
    return cross(bd, bc), cross(ac, ad), cross(ad, ab), cross(ab, ac)


@kernel
def tet_circumradius(a, b, c, d):
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


@kernel
def tet_dihedral_angle(n1, n2):
    """Angle inside the cell between two faces, from their inward normals (Definition 18.1)."""
    return math.pi - angle_between(n1, n2)


@kernel
def tet_angles(a, b, c, d):
    """Least and greatest dihedral angle in radians."""
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    d01 = tet_dihedral_angle(n0, n1)
    d02 = tet_dihedral_angle(n0, n2)
    d03 = tet_dihedral_angle(n0, n3)
    d12 = tet_dihedral_angle(n1, n2)
    d13 = tet_dihedral_angle(n1, n3)
    d23 = tet_dihedral_angle(n2, n3)
    least = min(d01, d02, d03, d12, d13, d23)
    greatest = max(d01, d02, d03, d12, d13, d23)
    return least, greatest


@kernel
def solid_angle(apex, a, b, c):
    """Solid angle at the apex (Definition 18.2), by the formula of Van Oosterom and Strackee."""
    u = minus(a, apex)
    v = minus(b, apex)
    w = minus(c, apex)
    lu = norm(u)
    lv = norm(v)
    lw = norm(w)
    numerator = abs(dot(u, cross(v, w)))
    denominator = lu * lv * lw + dot(u, v) * lw + dot(v, w) * lu + dot(w, u) * lv
    return 2.0 * math.atan2(numerator, denominator)


@inlined
def inverse_length(a):
    """1 over the length of a vector; 0 for one that vanishes."""
    return ratio(1.0, norm(a))


@inlined
def tet_angle_bound(a, b, c, d):
    """The q that the dihedral angles of a positive tet allow.

    It grows with the sine of half the least angle and the cosine of half the greatest.
    """
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    l0 = inverse_length(n0)
    l1 = inverse_length(n1)
    l2 = inverse_length(n2)
    l3 = inverse_length(n3)
    c01 = dot(n0, n1) * (l0 * l1)
    c02 = dot(n0, n2) * (l0 * l2)
    c03 = dot(n0, n3) * (l0 * l3)
    c12 = dot(n1, n2) * (l1 * l2)
    c13 = dot(n1, n3) * (l1 * l3)
    c23 = dot(n2, n3) * (l2 * l3)
    # The normals point inwards: the angle between two faces is pi less that between them.
    of_least = -min(c01, c02, c03, c12, c13, c23)
    of_greatest = -max(c01, c02, c03, c12, c13, c23)
    sine = math.sqrt(max(0.0, 0.5 * (1.0 - of_least)))
    cosine = math.sqrt(max(0.0, 0.5 * (1.0 + of_greatest)))
    bound = min(sine / LEAST_SINE, cosine / LEAST_COSINE)
    bound = bound if bound >= 1.0 else ANGLE_WEIGHT + (1.0 - ANGLE_WEIGHT) * bound
    return min(1.0, bound / ANGLE_Q)


@inlined
def lenience(measure):
    """How many times q counts under a measure with angles: 1 or more."""
    return measure // WITH_ANGLES / PERCENT


@inlined
def lenient(times, q):
    """What a positive q counts for, if it counts more than once.

    A Q of `times` ANGLE_Q is good enough then: it counts as ANGLE_Q. What is worse counts for
    so much less that nothing becomes worse for the sake of the angles.
    """
    part = times * q * ANGLE_Q
    steep = part * part
    steep *= steep
    steep *= steep
    steep *= steep
    steep *= steep / ANGLE_Q
    return steep if times > 1.0 and part < 1.0 else times * q


@inlined
def tet_bounded_aspect_ratio(times, a, b, c, d):
    """`tet_bounded_quality` by the aspect ratio, with a lenience."""
    q = tet_aspect_ratio(a, b, c, d)
    return min(lenient(times, q), tet_angle_bound(a, b, c, d)) if q > 0.0 else q


@kernel
def tet_bounded_quality(measure, a, b, c, d):
    """What the q of a tet counts for by a measure, or what its angles allow if that is less."""
    times = lenience(measure)
    base = measure % WITH_ANGLES
    if base == ASPECT_RATIO:
        return tet_bounded_aspect_ratio(times, a, b, c, d)
    if base == VOLUME_LENGTH:
        q = tet_volume_length(a, b, c, d)
    else:
        q = tet_other_quality(base, a, b, c, d)
    return min(lenient(times, q), tet_angle_bound(a, b, c, d)) if q > 0.0 else q


@kernel
def tet_other_quality(measure, a, b, c, d):
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
    h_min = min(ab, ac, ad, bc, bd, cd)
    if measure == RADIUS_EDGE:
        radius = tet_circumradius(a, b, c, d)
        # Of a cell that is flat but for rounding, the radius is anything.
        return signed(min(1.0, ratio(h_min * SQRT6, 4.0 * radius)), volume)
    h_max = max(ab, ac, ad, bc, bd, cd)
    return signed(h_min / h_max, volume)  # EDGE_RATIO


@inlined
def tet_quality(measure, a, b, c, d):
    """q of a tetrahedron by the measure with this code."""
    if measure == ASPECT_RATIO:
        return tet_aspect_ratio(a, b, c, d)
    if measure == VOLUME_LENGTH:
        return tet_volume_length(a, b, c, d)
    if measure >= WITH_ANGLES:
        return tet_bounded_quality(measure, a, b, c, d)
    return tet_other_quality(measure, a, b, c, d)


# Triangles ------------------------------------------------------------------------------


@kernel
def tri_angles(a, b, c):
    """Least and greatest angle in radians."""
    at_a = angle_between(minus(b, a), minus(c, a))
    at_b = angle_between(minus(c, b), minus(a, b))
    at_c = math.pi - at_a - at_b
    return min(at_a, at_b, at_c), max(at_a, at_b, at_c)


@kernel
def tri_other_quality(measure, a, b, c, area):
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
    h_min = min(ab, bc, ca)
    if measure == RADIUS_EDGE:
        return 4.0 / SQRT3 * area * h_min / (ab * bc * ca)
    return signed(h_min / max(ab, bc, ca), area)  # EDGE_RATIO


@inlined
def tri_aspect_ratio(a, b, c):
    """S / (alpha_2 h_max p), the inverse of (18.6)."""
    ab = minus(b, a)
    ac = minus(c, a)
    area = 0.5 * (ab.x * ac.y - ab.y * ac.x)
    e0 = norm(ab)
    e1 = norm(ac)
    e2 = norm(minus(c, b))
    return ratio(area, ALPHA_2 * max(e0, e1, e2) * 0.5 * (e0 + e1 + e2))


@kernel
def tri_quality(measure, a, b, c):
    """q of a triangle in the plane z = 0 by the measure with this code.

    `VOLUME_LENGTH` is S / (beta_2 h_s^2), the inverse of (18.8).
    """
    if measure == ASPECT_RATIO:
        return tri_aspect_ratio(a, b, c)
    ab = minus(b, a)
    ac = minus(c, a)
    bc = minus(c, b)
    area = 0.5 * (ab.x * ac.y - ab.y * ac.x)
    if measure == VOLUME_LENGTH:
        return ratio(area, BETA_2 * (dot(ab, ab) + dot(ac, ac) + dot(bc, bc)))
    return tri_other_quality(measure, a, b, c, area)


# Many cells -----------------------------------------------------------------------------


@entry
def measure_cells(measure, points, cells, out):
    """q of each cell of an (n, 3) or (n, 4) array, written to `out`."""
    if cells.shape[1] == 4:
        for i in range(cells.shape[0]):
            out[i] = tet_quality(
                measure,
                at(points, cells[i, 0]),
                at(points, cells[i, 1]),
                at(points, cells[i, 2]),
                at(points, cells[i, 3]),
            )
    else:
        for i in range(cells.shape[0]):
            out[i] = tri_quality(
                measure, at(points, cells[i, 0]), at(points, cells[i, 1]), at(points, cells[i, 2])
            )


@entry
def angle_range(points, cells):
    """Least and greatest (dihedral) angle over all cells, in radians; (inf, -inf) of none."""
    least = math.inf
    greatest = -math.inf
    for i in range(cells.shape[0]):
        a = at(points, cells[i, 0])
        b = at(points, cells[i, 1])
        c = at(points, cells[i, 2])
        if cells.shape[1] == 4:
            low, high = tet_angles(a, b, c, at(points, cells[i, 3]))
        else:
            low, high = tri_angles(a, b, c)
        least = min(least, low)
        greatest = max(greatest, high)
    return least, greatest


@entry
def angle_sums(points, cells, out):
    """Angle that the cells fill around each vertex, added to `out` (np,): 2 pi or 4 pi inside."""
    for i in range(cells.shape[0]):
        for k in range(cells.shape[1]):
            apex = at(points, cells[i, k])
            a = at(points, cells[i, (k + 1) % cells.shape[1]])
            b = at(points, cells[i, (k + 2) % cells.shape[1]])
            if cells.shape[1] == 4:
                out[cells[i, k]] += solid_angle(apex, a, b, at(points, cells[i, (k + 3) % 4]))
            else:
                out[cells[i, k]] += angle_between(minus(a, apex), minus(b, apex))
