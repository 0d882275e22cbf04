"""A metric at the vertices (18.3): lengths in it, and the maps that take cells to the usual space.

Beside its coordinates a vertex then has a symmetric positive definite tensor M: rows of the points
have nine columns, x y z and (xx, xy, yy, xz, yz, zz), where the plane has zz = 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled.decorators import inlined, kernel
from .vectors import Vec

FIRST = 3  # column of the points that the tensor begins in
N_COMPONENTS = 6
LEAST = 1e-300  # of the square of a diagonal entry: what is left of it by rounding is not negative


class Tensor(NamedTuple):
    """A symmetric matrix."""

    xx: float
    xy: float
    yy: float
    xz: float
    yz: float
    zz: float


class Upper(NamedTuple):
    """An upper triangular matrix T: T^t T = M is a metric, in which |T e| is the length of e."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float


NO_TENSOR = Tensor(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def plus(m: Tensor, points: np.ndarray, i: int, part: float) -> Tensor:
    """A tensor, and a part of that of a vertex."""
    return Tensor(
        m.xx + part * points[i, 3],
        m.xy + part * points[i, 4],
        m.yy + part * points[i, 5],
        m.xz + part * points[i, 6],
        m.yz + part * points[i, 7],
        m.zz + part * points[i, 8],
    )


@inlined
def root(m: Tensor) -> Upper:
    """T with T^t T = M, by Cholesky."""
    a = math.sqrt(m.xx)
    b = m.xy / a
    c = m.xz / a
    d = math.sqrt(max(m.yy - b * b, LEAST))
    e = (m.yz - b * c) / d
    return Upper(a, b, c, d, e, math.sqrt(max(m.zz - c * c - e * e, LEAST)))


@inlined
def mapped(t: Upper, v: Vec) -> Vec:
    """T v."""
    return Vec(t.a * v.x + t.b * v.y + t.c * v.z, t.d * v.y + t.e * v.z, t.f * v.z)


@inlined
def unmapped(t: Upper, v: Vec) -> Vec:
    """T^-1 v."""
    z = v.z / t.f
    y = (v.y - t.e * z) / t.d
    return Vec((v.x - t.b * y - t.c * z) / t.a, y, z)


@inlined
def after(s: Upper, t: Upper) -> Upper:
    """S T^-1: what S does to what T has mapped."""
    a = s.a / t.a
    b = (s.b - a * t.b) / t.d
    d = s.d / t.d
    return Upper(a, b, (s.c - a * t.c - b * t.e) / t.f, d, (s.e - d * t.e) / t.f, s.f / t.f)


@inlined
def across(t: Upper, n: Vec) -> Vec:
    """T^-t n: the normal of a plane that T maps, of no certain length."""
    x = n.x / t.a
    y = (n.y - t.b * x) / t.d
    return Vec(x, y, (n.z - t.c * x - t.e * y) / t.f)


@kernel
def map_of_row(points: np.ndarray, rows: np.ndarray, i: int) -> Upper:
    """The map of a cell, by the mean of the metrics of its vertices.

    That is nearest to what is worst over the vertices (18.13), where the smallest sizes count.
    """
    width = rows.shape[1]
    m = NO_TENSOR
    for k in range(width):
        m = plus(m, points, rows[i, k], 1.0 / width)
    return root(m)


@inlined
def square_in(points: np.ndarray, i: int, e: Vec) -> float:
    """e^t M e with the metric M of a vertex."""
    return (
        points[i, 3] * e.x * e.x
        + points[i, 5] * e.y * e.y
        + points[i, 8] * e.z * e.z
        + 2.0 * (points[i, 4] * e.x * e.y + points[i, 6] * e.x * e.z + points[i, 7] * e.y * e.z)
    )


@inlined
def mean_length(one: float, other: float) -> float:
    """The length of an edge from its lengths by the metrics of both ends, whose squares are given.

    The mean (a - b) / log(a / b), exact where sizes grow by the same factor on every part.
    """
    a = math.sqrt(one)
    b = math.sqrt(other)
    if abs(a - b) <= 1e-3 * a:
        return 0.5 * (a + b)
    return (a - b) / math.log(a / b)


@kernel
def length_from(points: np.ndarray, i: int, j: int, p: Vec) -> float:
    """Length in the metric of the edge from vertex i, were it at p, to vertex j."""
    e = Vec(points[j, 0] - p.x, points[j, 1] - p.y, points[j, 2] - p.z)
    return mean_length(square_in(points, i, e), square_in(points, j, e))


@kernel
def length(points: np.ndarray, i: int, j: int) -> float:
    """Length of an edge in the metric."""
    return length_from(points, i, j, Vec(points[i, 0], points[i, 1], points[i, 2]))


@kernel
def set_mean(points: np.ndarray, vertex: int, rows: np.ndarray, i: int) -> None:
    """Give a vertex the mean of the metrics of the vertices in a row."""
    width = rows.shape[1]
    for k in range(FIRST, FIRST + N_COMPONENTS):
        total = 0.0
        for j in range(width):
            total += points[rows[i, j], k]
        points[vertex, k] = total / width


@kernel
def set_between(points: np.ndarray, vertex: int, a: int, b: int, t: float) -> None:
    """Give a vertex on an edge the metric there, (1 - t) of that of a and t of that of b."""
    for k in range(FIRST, FIRST + N_COMPONENTS):
        points[vertex, k] = (1.0 - t) * points[a, k] + t * points[b, k]
