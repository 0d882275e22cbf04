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

In a metric the map of each cell has rows of its own, and takes the edges to the usual space: it is
that of the cell as it is, whose vertices keep their metrics while one of them looks for a place.

Faces of the plane have a form of their own: the corners before, after and across from the point,
and whether there is one across.
"""

from __future__ import annotations

import math

import numpy as np

from ...cells import TET_FACETS, TRI_FACETS
from ...compiled.decorators import inlined, kernel
from ..judge import q_mapped, q_of_edges
from ..metric import Upper, after, map_of_row, mapped, unmapped
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
from ..types import CORNERS, FACES, MAPPED, SIMPLICES, AnyMesh, Judge, Scratch, SimplexMesh
from ..vectors import ZERO, Vec, cross, dot, norm, ratio, square_distance

FACTORS = 9  # the first of the three rows of `scratch.star` that hold t
JACOBIAN = 12  # 1 / the scaled Jacobian of an ideal corner where it is to be judged by it, else 0
MAP = 13  # the first of the six rows with the map of a cell to the usual space


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
    if mesh.judge.form == MAPPED:
        for i in range(n):
            set_map(star, i, map_of_row(mesh.points, mesh.cells, handles[i] >> 2))


@inlined
def set_map(star: np.ndarray, i: int, t: Upper) -> None:
    """Note the map of cell i."""
    star[MAP, i] = t.a
    star[MAP + 1, i] = t.b
    star[MAP + 2, i] = t.c
    star[MAP + 3, i] = t.d
    star[MAP + 4, i] = t.e
    star[MAP + 5, i] = t.f


@inlined
def map_at(star: np.ndarray, i: int) -> Upper:
    """The map of cell i."""
    return Upper(
        star[MAP, i], star[MAP + 1, i], star[MAP + 2, i], star[MAP + 3, i], star[MAP + 4, i],
        star[MAP + 5, i],
    )  # fmt: skip


@kernel
def straighten(mesh: SimplexMesh, n: int, scratch: Scratch) -> Upper:
    """Take a star in a metric to where its first cell is measured plainly; returns the map.

    There directions and distances count alike, and whoever looks for a place goes no longer way
    than in a star without a metric.
    """
    star = scratch.star
    t = map_at(star, 0)
    for i in range(n):
        set_map(star, i, after(map_at(star, i), t))
        for k in range(mesh.cells.shape[1] - 1):
            p = mapped(t, corner(star, k, i))
            star[3 * k, i] = p.x
            star[3 * k + 1, i] = p.y
            star[3 * k + 2, i] = p.z
    return t


@kernel
def longest_in_star(mesh: SimplexMesh, n: int, p: Vec, scratch: Scratch) -> float:
    """Length of the longest edge from p to the corners of the star."""
    longest = 0.0
    for i in range(n):
        for k in range(mesh.cells.shape[1] - 1):
            longest = max(longest, square_distance(p, corner(scratch.star, k, i)))
    return math.sqrt(longest)


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
    if mesh.judge.form == MAPPED:
        first, second = edge_to(star, 0, i, p), edge_to(star, 1, i, p)
        return q_mapped(mesh.judge, width, map_at(star, i), first, second, third)
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
def measure_in_metric(width: int, n: int, p: Vec, star: np.ndarray, values: np.ndarray) -> None:
    """The aspect ratios of a star in a metric; see `measure_star`, and `general_quality`."""
    if width == 3:
        for i in range(n):
            t = map_at(star, i)
            values[i] = tri_aspect_ratio(
                mapped(t, edge_to(star, 0, i, p)), mapped(t, edge_to(star, 1, i, p)), ZERO
            )
    else:
        for i in range(n):
            t = map_at(star, i)
            values[i] = tet_aspect_ratio(
                mapped(t, edge_to(star, 0, i, p)),
                mapped(t, edge_to(star, 1, i, p)),
                mapped(t, edge_to(star, 2, i, p)),
                ZERO,
            )


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
        if mesh.judge.form == MAPPED and mesh.judge.code == ASPECT_RATIO and times == 0.0:
            measure_in_metric(mesh.cells.shape[1], n, p, star, values)
        else:
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
    if mesh.cells.shape[1] == 4 and mesh.judge.form != MAPPED:
        for i in range(n):
            scratch.values[i] = tet_ideal_height(
                corner(star, 0, i), corner(star, 1, i), corner(star, 2, i)
            )


@inlined
def ideal_point(mesh: SimplexMesh, i: int, scratch: Scratch) -> Vec:
    """The point that makes the best cell with facet i (18.24), after `star_heights`."""
    star = scratch.star
    if mesh.judge.form == MAPPED:
        return ideal_in_metric(mesh.cells.shape[1], i, star)
    if mesh.cells.shape[1] == 4:
        return tet_ideal_point(
            corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), scratch.values[i]
        )
    return tri_ideal_point(corner(star, 0, i), corner(star, 1, i))


@kernel
def ideal_in_metric(width: int, i: int, star: np.ndarray) -> Vec:
    """`ideal_point` in the metric of a cell: that of its image, taken back."""
    t = map_at(star, i)
    a = mapped(t, corner(star, 0, i))
    b = mapped(t, corner(star, 1, i))
    if width == 3:
        return unmapped(t, tri_ideal_point(a, b))
    c = mapped(t, corner(star, 2, i))
    return unmapped(t, tet_ideal_point(a, b, c, tet_ideal_height(a, b, c)))
