"""Simplices with obtuse angles, and those that contain their circumcentre (18.4.3)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..vectors import Vec, at, dot, minus, norm, square_distance
from .angles import tet_normals

RIGHT = 90.0 + 1e-6  # degrees: as much as rounding may make of a right angle
COS_RIGHT = math.cos(math.radians(RIGHT))
OUTSIDE = 1e-8  # a barycentric coordinate of a circumcentre that is less than 0 by rounding only


@kernel
def triangle_kind(a: Vec, b: Vec, c: Vec) -> tuple[bool, bool]:
    """Whether an angle is obtuse, and whether the triangle contains its circumcentre.

    One is the contrary of the other, but for a triangle with two vertices in one place.
    """
    ab = square_distance(a, b)
    bc = square_distance(b, c)
    ca = square_distance(c, a)
    shortest = min(ab, bc, ca)
    longest = max(ab, bc, ca)
    middle = max(min(ab, bc), min(max(ab, bc), ca))
    if shortest == 0.0:
        return False, False
    # The greatest angle is opposite the longest edge.
    cosine = shortest + middle - longest  # times twice the sides
    is_obtuse = cosine < 2.0 * COS_RIGHT * math.sqrt(shortest) * math.sqrt(middle)
    return is_obtuse, not is_obtuse


class Centring(NamedTuple):
    """Where the circumcentre of a tet is."""

    is_centred: bool  # inside or on the surface
    least: float  # the least of its signed heights over the faces, in circumradii; -1 if flat


@inlined
def centring(a: Vec, b: Vec, c: Vec, d: Vec) -> Centring:
    """Where the circumcentre of a tet of either orientation is; 1/3 high in a regular one."""
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    # It is a + p / (2 volume), in units of six times that of the tet; its barycentric
    # coordinates follow from the normals.
    volume = dot(minus(b, a), n1)
    if volume == 0.0:
        return Centring(False, -1.0)
    wb = square_distance(a, b)
    wc = square_distance(a, c)
    wd = square_distance(a, d)
    p = Vec(
        wb * n1.x + wc * n2.x + wd * n3.x,
        wb * n1.y + wc * n2.y + wd * n3.y,
        wb * n1.z + wc * n2.z + wd * n3.z,
    )
    whole = 2.0 * volume * volume
    at_b = dot(p, n1)
    at_c = dot(p, n2)
    at_d = dot(p, n3)
    at_a = whole - at_b - at_c - at_d
    least = min(at_a / norm(n0), at_b / norm(n1), at_c / norm(n2), at_d / norm(n3))
    return Centring(min(at_a, at_b, at_c, at_d) >= -OUTSIDE * whole, least / norm(p))


@kernel
def tet_kind(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[bool, bool]:
    """Whether a dihedral angle is obtuse, and whether the tet contains its circumcentre.

    Neither follows from the other. A flat tet contains none.
    """
    n0, n1, n2, n3 = tet_normals(a, b, c, d)
    normals = (n0, n1, n2, n3)
    is_obtuse = False
    for i in range(4):
        for j in range(i):
            # Inward normals: the angle is pi less than that between them.
            cosine = -dot(normals[i], normals[j])
            is_obtuse = is_obtuse or cosine < COS_RIGHT * norm(normals[i]) * norm(normals[j])
    return is_obtuse, centring(a, b, c, d).is_centred


@entry(group="basic", example=lambda work: (work.mesh.points, work.mesh.cells, work.order))
def count_obtuse(points: np.ndarray, cells: np.ndarray, counts: np.ndarray) -> None:
    """Count the simplices with an obtuse (dihedral) angle, and the self-centered ones.

    Parameters
    ----------
    points : (np, 3) float64
        In a plane or in space.
    cells : (n, 3) or (n, 4) int64
        Of either orientation.
    counts : (2,) int64
        Both numbers are added.
    """
    for i in range(cells.shape[0]):
        a = at(points, cells[i, 0])
        b = at(points, cells[i, 1])
        c = at(points, cells[i, 2])
        if cells.shape[1] == 4:
            is_obtuse, is_centred = tet_kind(a, b, c, at(points, cells[i, 3]))
        else:
            is_obtuse, is_centred = triangle_kind(a, b, c)
        counts[0] += is_obtuse
        counts[1] += is_centred
