"""Angles of cells (Definitions 18.1 and 18.2), of one and of many, and what they say of quality."""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..vectors import Vec, at, cross, dot, minus, norm, ratio

REGULAR_ANGLE_2 = math.pi / 3.0
REGULAR_ANGLE_3 = math.acos(1.0 / 3.0)
REGULAR_SOLID_ANGLE = 3.0 * REGULAR_ANGLE_3 - math.pi
# Dihedral angles of LEAST_ANGLE and GREATEST_ANGLE degrees count as bad as Q = ANGLE_Q; an
# angle of 0 or 180 degrees as 1 / ANGLE_WEIGHT times that, so that a bad Q goes first.
LEAST_ANGLE = 30.0
GREATEST_ANGLE = 130.0
ANGLE_Q = 1.84
ANGLE_WEIGHT = 0.25
LEAST_SINE = math.sin(math.radians(LEAST_ANGLE / 2.0))
LEAST_COSINE = math.cos(math.radians(GREATEST_ANGLE / 2.0))


@kernel
def angle_between(u: Vec, v: Vec) -> float:
    """Angle of two vectors in [0, pi], accurate near 0 and pi too."""
    return math.atan2(norm(cross(u, v)), dot(u, v))


# Tetrahedra -----------------------------------------------------------------------------


@inlined
def tet_normals(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[Vec, Vec, Vec, Vec]:
    """Inward normals of the faces opposite a, b, c, d, twice their areas long."""
    ab = minus(b, a)
    ac = minus(c, a)
    ad = minus(d, a)
    bc = minus(c, b)
    bd = minus(d, b)
    return cross(bd, bc), cross(ac, ad), cross(ad, ab), cross(ab, ac)


@kernel
def tet_dihedral_angle(n1: Vec, n2: Vec) -> float:
    """Angle inside the cell between two faces, from their inward normals (Definition 18.1)."""
    return math.pi - angle_between(n1, n2)


@kernel
def tet_angles(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[float, float]:
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
def solid_angle(apex: Vec, a: Vec, b: Vec, c: Vec) -> float:
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
def inverse_length(a: Vec) -> float:
    """1 over the length of a vector; 0 for one that vanishes."""
    return ratio(1.0, norm(a))


@inlined
def tet_angle_bound(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
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


# Triangles ------------------------------------------------------------------------------


@kernel
def tri_angles(a: Vec, b: Vec, c: Vec) -> tuple[float, float]:
    """Least and greatest angle in radians."""
    at_a = angle_between(minus(b, a), minus(c, a))
    at_b = angle_between(minus(c, b), minus(a, b))
    at_c = math.pi - at_a - at_b
    return min(at_a, at_b, at_c), max(at_a, at_b, at_c)


# Many cells -----------------------------------------------------------------------------


@entry(group="basic", example=lambda work: (work.mesh.points, work.mesh.cells))
def angle_range(points: np.ndarray, cells: np.ndarray) -> tuple[float, float]:
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


@entry(group="basic", example=lambda work: (work.mesh.points, work.mesh.cells, work.vertex_values))
def angle_sums(points: np.ndarray, cells: np.ndarray, out: np.ndarray) -> None:
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
