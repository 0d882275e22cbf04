"""The star of a point: the cells between it and some facets, laid out to be measured at once.

A ball is measured again and again while its vertex looks for a better place, and its facets are
all over the arrays of the mesh. They are copied into columns of `scratch.star`, the same
coordinate of neighbouring facets side by side.

The star has two forms. In the plain one the columns hold the corners of the facets; the measures
that pipelines go by have a loop each, which the compiler makes measure several cells with one
instruction. In the general one the three edges from the point at p to the corners are
`c + t p`, with a vector c and a number t an edge: what is linear in an edge, as the map to a
reference shape or a metric, changes c and t and nothing else. The corners are the c of t = -1, so
that the general form is the plain one with three rows more.

Faces of the plane have a form of their own: the corners before, after and across from the point,
and whether there is one across.
"""

from __future__ import annotations

import math

import numpy as np

from ...cells import TET_FACETS, TRI_FACETS
from ...compiled.decorators import inlined, kernel
from ..judge import q_of_edges
from ..shape.faces import quad_quality
from ..shape.ideal import tet_ideal_height, tet_ideal_point, tri_ideal_point
from ..shape.simplex import (
    ASPECT_RATIO,
    tet_aspect_ratio,
    tet_bounded_aspect_ratio,
    tet_bounded_quality,
    tri_aspect_ratio,
    tri_quality,
)
from ..types import CORNERS, FACES, SIMPLICES, AnyMesh, Judge, Scratch, SimplexMesh
from ..vectors import Vec, cross, dot, norm, ratio

FACTORS = 9  # the first of the three rows of `scratch.star` that hold t
JACOBIAN = 12  # 1 / the scaled Jacobian of an ideal corner where it is to be judged by it, else 0


@inlined
def is_plain(judge: Judge) -> bool:
    """Whether the plain form of a star is enough to measure it."""
    return judge.code == ASPECT_RATIO and judge.form == SIMPLICES


@kernel
def load_star(mesh: SimplexMesh, handles: np.ndarray, n: int, scratch: Scratch) -> None:
    """Copy the facets opposite the vertices of the handles into `scratch.star`."""
    star = scratch.star
    width = mesh.cells.shape[1]
    for i in range(n):
        cell = handles[i] >> 2
        local = handles[i] & 3
        for k in range(width - 1):
            v = mesh.cells[cell, TET_FACETS[local, k] if width == 4 else TRI_FACETS[local, k]]
            star[3 * k, i] = mesh.points[v, 0]
            star[3 * k + 1, i] = mesh.points[v, 1]
            star[3 * k + 2, i] = mesh.points[v, 2]
    if not is_plain(mesh.judge):
        for k in range(width - 1):
            for i in range(n):
                star[FACTORS + k, i] = -1.0


@inlined
def corner(star: np.ndarray, k: int, i: int) -> Vec:
    """Vertex k of facet i."""
    return Vec(star[3 * k, i], star[3 * k + 1, i], star[3 * k + 2, i])


@inlined
def edge_to(star: np.ndarray, k: int, i: int, p: Vec) -> Vec:
    """Edge k of cell i of the star in its general form, with the point at p."""
    t = star[FACTORS + k, i]
    return Vec(star[3 * k, i] + t * p.x, star[3 * k + 1, i] + t * p.y, star[3 * k + 2, i] + t * p.z)


@kernel
def general_quality(mesh: AnyMesh, i: int, p: Vec, scratch: Scratch) -> float:
    """q of the i-th cell of the star, by any measure, with its point at p."""
    star = scratch.star
    width = mesh.cells.shape[1]
    if mesh.judge.form == FACES:
        following, last = corner(star, 0, i), corner(star, 1, i)
        if star[FACTORS, i] == 0.0:
            return tri_quality(mesh.judge, p, following, last)
        return quad_quality(mesh.judge, p, following, corner(star, 2, i), last)
    # A triangle has no third edge: the row is there, and is not looked at.
    third = edge_to(star, 2, i, p)
    if mesh.judge.form == CORNERS and star[JACOBIAN, i] > 0.0:
        # The second edge stands first.
        sine = sine_of(edge_to(star, 1, i, p), edge_to(star, 0, i, p), third)
        return min(1.0, star[JACOBIAN, i] * sine)
    return q_of_edges(mesh.judge, width, edge_to(star, 0, i, p), edge_to(star, 1, i, p), third)


@inlined
def sine_of(a: Vec, b: Vec, c: Vec) -> float:
    """The volume that three vectors span by the product of their lengths, 0 beside one without."""
    return ratio(dot(a, cross(b, c)), norm(a) * norm(b) * norm(c))


@inlined
def star_quality(mesh: AnyMesh, i: int, p: Vec, scratch: Scratch) -> float:
    """q of the i-th cell of the star with its point at p."""
    star = scratch.star
    if not is_plain(mesh.judge):
        return general_quality(mesh, i, p, scratch)
    if mesh.cells.shape[1] == 3:
        return tri_aspect_ratio(corner(star, 0, i), corner(star, 1, i), p)
    a = corner(star, 0, i)
    b = corner(star, 1, i)
    c = corner(star, 2, i)
    if mesh.judge.lenience > 0.0:
        return tet_bounded_quality(mesh.judge, a, b, c, p)
    return tet_aspect_ratio(a, b, c, p)


@kernel
def measure_star(mesh: AnyMesh, n: int, p: Vec, scratch: Scratch) -> float:
    """Measure all cells of the star with its point at p, into `scratch.values`.

    Returns
    -------
    worst : float
        The least of their q.
    """
    star = scratch.star
    values = scratch.values
    times = mesh.judge.lenience
    if not is_plain(mesh.judge):
        for i in range(n):
            values[i] = general_quality(mesh, i, p, scratch)
    elif mesh.cells.shape[1] == 3:
        for i in range(n):
            values[i] = tri_aspect_ratio(corner(star, 0, i), corner(star, 1, i), p)
    elif times > 0.0:
        for i in range(n):
            values[i] = tet_bounded_aspect_ratio(
                times, corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p
            )
    else:
        for i in range(n):
            values[i] = tet_aspect_ratio(
                corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p
            )
    worst = math.inf
    for i in range(n):
        worst = min(worst, values[i])
    return worst


@inlined
def sum_of_star(n: int, scratch: Scratch) -> float:
    """Sum of the Q of the cells of the star as they were measured."""
    total = 0.0
    for i in range(n):
        total += 1.0 / scratch.values[i]
    return total


@kernel
def star_heights(mesh: SimplexMesh, n: int, scratch: Scratch) -> None:
    """Put into `scratch.values` what `ideal_point` needs of each tet of the star."""
    star = scratch.star
    if mesh.cells.shape[1] == 4:
        for i in range(n):
            scratch.values[i] = tet_ideal_height(
                corner(star, 0, i), corner(star, 1, i), corner(star, 2, i)
            )


@inlined
def ideal_point(mesh: SimplexMesh, i: int, scratch: Scratch) -> Vec:
    """The point that makes the best cell with facet i (18.24), after `star_heights`."""
    star = scratch.star
    if mesh.cells.shape[1] == 4:
        return tet_ideal_point(
            corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), scratch.values[i]
        )
    return tri_ideal_point(corner(star, 0, i), corner(star, 1, i))
