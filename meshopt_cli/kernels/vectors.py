"""Vectors of space and points, as the kernels compute with them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiled.decorators import inlined
from .types import AnyMesh

SQRT3 = math.sqrt(3.0)


class Vec(NamedTuple):
    """A point or vector of space; z = 0 in planar meshes."""

    x: float
    y: float
    z: float


ZERO = Vec(0.0, 0.0, 0.0)


@inlined
def at(points: np.ndarray, i: int) -> Vec:
    """Point i of an (n, 3) array."""
    return Vec(points[i, 0], points[i, 1], points[i, 2])


@inlined
def ratio(numerator: float, denominator: float) -> float:
    """The quotient, and 0 for what shrank to a point or a line."""
    return numerator / denominator if denominator > 0.0 else 0.0


@inlined
def minus(a: Vec, b: Vec) -> Vec:
    return Vec(a.x - b.x, a.y - b.y, a.z - b.z)


@inlined
def toward(a: Vec, b: Vec, t: float) -> Vec:
    """The point a + t (b - a)."""
    return Vec(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z))


@inlined
def along(a: Vec, d: Vec, t: float) -> Vec:
    """The point a + t d."""
    return Vec(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z)


@inlined
def dot(a: Vec, b: Vec) -> float:
    return a.x * b.x + a.y * b.y + a.z * b.z


@inlined
def cross(a: Vec, b: Vec) -> Vec:
    return Vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@inlined
def norm(a: Vec) -> float:
    return math.sqrt(dot(a, a))


@inlined
def square_distance(a: Vec, b: Vec) -> float:
    d = minus(a, b)
    return dot(d, d)


@inlined
def distance(a: Vec, b: Vec) -> float:
    return math.sqrt(square_distance(a, b))


@inlined
def set_point(points: np.ndarray, i: int, p: Vec) -> None:
    """Put point i of an (n, 3) array at p."""
    points[i, 0] = p.x
    points[i, 1] = p.y
    points[i, 2] = p.z


@inlined
def single(x: float) -> float:
    """The number rounded to single precision."""
    return np.float64(np.float32(x))


@inlined
def rounded(mesh: AnyMesh, p: Vec) -> Vec:
    """The point as it will be stored."""
    if mesh.single:
        return Vec(single(p.x), single(p.y), single(p.z))
    return p
