"""How far a simplex is from its reference, as an energy with derivatives, folded over or not.

A simplex with edges E from its apex is the image of its reference W under J = E W^-1. With

    chi = (det + sqrt(eps² + det²)) / 2,

which is positive even where det = det J is not, its energy is

    f = (1 - a) |J|² / chi^(2/d) + a d |J1| |J2| |J3| / chi + theta (det² + 1) / chi:

finite everywhere as long as eps is not 0, and a barrier against folding over as eps vanishes
(Garanzha, Kaporin, Kudryavtseva, Protais, Ray and Sokolov 2021, "Foldover-free maps in 50 lines of
code", with a = 0). The first term is least, d, where lengths and angles are in the proportions of
the reference; the second where the axes of the reference stay at right angles, however long: it is
d over the scaled Jacobian of a corner of a quad or hexahedron. The third is least where the
measure is that of the reference.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import inlined
from ..vectors import Vec, at, cross, dot, minus, ratio


class Body(NamedTuple):
    """Simplices with their references: what an energy is the sum over."""

    simplices: np.ndarray  # (ns, d + 1) int64, apex first
    shapes: np.ndarray  # (k, d, d) float64: W^-1, the columns of W being edges from the apex
    shape: np.ndarray  # (ns,) int64: which of them
    right: np.ndarray  # (k,) float64: 1 where the edges of W are at right angles, else 0
    scale: np.ndarray  # (ns,) float64: one over the size of the reference, by which W^-1 grows
    free: np.ndarray  # (nf,) int64: vertices that may move, each of some simplex


class Energy(NamedTuple):
    """Which energy."""

    eps: float  # 0: infinite for what is not positive
    theta: float  # weight of the measure
    angular: float  # a for right references; it is 0 for others, whose angles are not independent
    limit: float  # that no simplex may reach: near it, it counts ever more; inf for none


class Slopes(NamedTuple):
    """An energy and its derivatives by the columns of J, as multiples of these and by det."""

    value: float
    by_first: float
    by_second: float
    by_third: float
    by_det: float


class Term(NamedTuple):
    """The energy of a simplex and its derivatives by the edges from the apex."""

    value: float
    stiffness: float  # about d²f/dJ², in any direction
    d1: Vec
    d2: Vec
    d3: Vec  # 0 in the plane


@inlined
def combined(a: Vec, r: float, b: Vec, s: float) -> Vec:
    """The vector r a + s b."""
    return Vec(r * a.x + s * b.x, r * a.y + s * b.y, r * a.z + s * b.z)


@inlined
def combined3(a: Vec, r: float, b: Vec, s: float, c: Vec, t: float) -> Vec:
    """The vector r a + s b + t c."""
    return Vec(
        r * a.x + s * b.x + t * c.x, r * a.y + s * b.y + t * c.y, r * a.z + s * b.z + t * c.z
    )


@inlined
def regularized(det: float, eps: float) -> float:
    """chi, by what does not cancel where det is negative."""
    root = math.sqrt(eps * eps + det * det)
    if det >= 0.0:
        return 0.5 * (det + root)
    return 0.5 * eps * eps / (root - det)


@inlined
def power(x: float, d: float) -> float:
    """x^(2/d)."""
    return x if d == 2.0 else x ** (2.0 / 3.0)


@inlined
def stiffened(value: float, limit: float) -> tuple[float, float]:
    """f / (1 - f / limit), and its derivative."""
    if limit == math.inf:
        return value, 1.0
    left = 1.0 - value / limit
    if not left > 0.0:
        return math.inf, 0.0
    return value / left, 1.0 / (left * left)


@inlined
def slopes(
    s1: float, s2: float, s3: float, det: float, d: float, angular: float, how: Energy
) -> Slopes:
    """The energy of a J whose columns have these squares; the third is 1 in the plane."""
    root = math.sqrt(how.eps * how.eps + det * det)
    chi = regularized(det, how.eps)
    if not chi > 0.0:
        return Slopes(math.inf, 0.0, 0.0, 0.0, 0.0)
    by_square = (1.0 - angular) / power(chi, d)
    conformal = by_square * (s1 + s2 + (s3 if d == 3.0 else 0.0))
    corner = angular * d * math.sqrt(s1 * s2 * s3) / chi
    content = how.theta * (det * det + 1.0) / chi
    value, outer = stiffened(conformal + corner + content, how.limit)
    # chi grows by chi / root for each det.
    by_det = how.theta * 2.0 * det / chi - (2.0 / d * conformal + corner + content) / root
    return Slopes(
        value,
        outer * (2.0 * by_square + ratio(corner, s1)),
        outer * (2.0 * by_square + ratio(corner, s2)),
        outer * (2.0 * by_square + ratio(corner, s3)),
        outer * by_det,
    )


@inlined
def tri_jacobian(body: Body, points: np.ndarray, i: int) -> tuple[Vec, Vec]:
    """Columns of J of a triangle."""
    a = at(points, body.simplices[i, 0])
    e1 = minus(at(points, body.simplices[i, 1]), a)
    e2 = minus(at(points, body.simplices[i, 2]), a)
    s = body.scale[i]
    b = body.shapes
    k = body.shape[i]
    return (
        combined(e1, s * b[k, 0, 0], e2, s * b[k, 1, 0]),
        combined(e1, s * b[k, 0, 1], e2, s * b[k, 1, 1]),
    )


@inlined
def tet_jacobian(body: Body, points: np.ndarray, i: int) -> tuple[Vec, Vec, Vec]:
    """Columns of J of a tet."""
    a = at(points, body.simplices[i, 0])
    e1 = minus(at(points, body.simplices[i, 1]), a)
    e2 = minus(at(points, body.simplices[i, 2]), a)
    e3 = minus(at(points, body.simplices[i, 3]), a)
    s = body.scale[i]
    b = body.shapes
    k = body.shape[i]
    return (
        combined3(e1, s * b[k, 0, 0], e2, s * b[k, 1, 0], e3, s * b[k, 2, 0]),
        combined3(e1, s * b[k, 0, 1], e2, s * b[k, 1, 1], e3, s * b[k, 2, 1]),
        combined3(e1, s * b[k, 0, 2], e2, s * b[k, 1, 2], e3, s * b[k, 2, 2]),
    )


@inlined
def tri_term(body: Body, points: np.ndarray, i: int, how: Energy) -> Term:
    """The energy of a triangle."""
    j1, j2 = tri_jacobian(body, points, i)
    det = j1.x * j2.y - j1.y * j2.x
    angular = how.angular * body.right[body.shape[i]]
    by = slopes(dot(j1, j1), dot(j2, j2), 1.0, det, 2.0, angular, how)
    g1 = combined(j1, by.by_first, Vec(j2.y, -j2.x, 0.0), by.by_det)
    g2 = combined(j2, by.by_second, Vec(-j1.y, j1.x, 0.0), by.by_det)
    s = body.scale[i]
    b = body.shapes
    k = body.shape[i]
    return Term(
        by.value,
        (by.by_first + by.by_second) / 2.0,
        combined(g1, s * b[k, 0, 0], g2, s * b[k, 0, 1]),
        combined(g1, s * b[k, 1, 0], g2, s * b[k, 1, 1]),
        Vec(0.0, 0.0, 0.0),
    )


@inlined
def tet_term(body: Body, points: np.ndarray, i: int, how: Energy) -> Term:
    """The energy of a tet."""
    j1, j2, j3 = tet_jacobian(body, points, i)
    c1 = cross(j2, j3)
    angular = how.angular * body.right[body.shape[i]]
    by = slopes(dot(j1, j1), dot(j2, j2), dot(j3, j3), dot(j1, c1), 3.0, angular, how)
    g1 = combined(j1, by.by_first, c1, by.by_det)
    g2 = combined(j2, by.by_second, cross(j3, j1), by.by_det)
    g3 = combined(j3, by.by_third, cross(j1, j2), by.by_det)
    s = body.scale[i]
    b = body.shapes
    k = body.shape[i]
    return Term(
        by.value,
        (by.by_first + by.by_second + by.by_third) / 3.0,
        combined3(g1, s * b[k, 0, 0], g2, s * b[k, 0, 1], g3, s * b[k, 0, 2]),
        combined3(g1, s * b[k, 1, 0], g2, s * b[k, 1, 1], g3, s * b[k, 1, 2]),
        combined3(g1, s * b[k, 2, 0], g2, s * b[k, 2, 1], g3, s * b[k, 2, 2]),
    )


@inlined
def term_of(body: Body, points: np.ndarray, i: int, how: Energy) -> Term:
    """The energy of a simplex."""
    if body.simplices.shape[1] == 3:
        return tri_term(body, points, i, how)
    return tet_term(body, points, i, how)


@inlined
def determinant(body: Body, points: np.ndarray, i: int) -> float:
    """det J of a simplex: its measure as a part of that of the reference."""
    if body.simplices.shape[1] == 3:
        j1, j2 = tri_jacobian(body, points, i)
        return j1.x * j2.y - j1.y * j2.x
    k1, k2, k3 = tet_jacobian(body, points, i)
    return dot(k1, cross(k2, k3))


@inlined
def signed_quality(s1: float, s2: float, s3: float, det: float, d: float, right: bool) -> float:
    """In [-1, 1]: the scaled Jacobian of a right corner, d |det|^(2/d) / |J|² of others."""
    if right:
        return ratio(det, math.sqrt(s1 * s2 * s3))
    q = ratio(d * power(abs(det), d), s1 + s2 + (s3 if d == 3.0 else 0.0))
    return q if det > 0.0 else -q


@inlined
def corner_quality(body: Body, points: np.ndarray, i: int) -> float:
    """`signed_quality` of a simplex."""
    right = body.right[body.shape[i]] == 1.0
    det = determinant(body, points, i)
    if body.simplices.shape[1] == 3:
        j1, j2 = tri_jacobian(body, points, i)
        return signed_quality(dot(j1, j1), dot(j2, j2), 1.0, det, 2.0, right)
    k1, k2, k3 = tet_jacobian(body, points, i)
    return signed_quality(dot(k1, k1), dot(k2, k2), dot(k3, k3), det, 3.0, right)
