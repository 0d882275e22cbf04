"""The star of a point: the facets opposite it, laid out so that many cells are measured at once.

A ball is measured again and again while its vertex looks for a better place, and its facets are
all over the arrays of the mesh. Copied into columns of `scratch.star`, the same coordinate of
neighbouring facets side by side, the compiler measures several cells with one instruction.
"""

from __future__ import annotations

import math

from ...cells import TET_FACETS, TRI_FACETS
from ...compiled.decorators import inlined, kernel
from ..shape.simplex import (
    ASPECT_RATIO,
    WITH_ANGLES,
    lenience,
    tet_aspect_ratio,
    tet_bounded_aspect_ratio,
    tet_quality,
    tri_aspect_ratio,
    tri_quality,
)
from ..vectors import Vec, tet_ideal_height, tet_ideal_point, tri_ideal_point


@kernel
def load_star(mesh, handles, n, scratch):
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


@inlined
def corner(star, k, i):
    """Vertex k of facet i."""
    return Vec(star[3 * k, i], star[3 * k + 1, i], star[3 * k + 2, i])


@inlined
def star_quality(mesh, i, p, scratch):
    """q of the i-th cell of the star with its point at p."""
    star = scratch.star
    if mesh.cells.shape[1] == 4:
        return tet_quality(
            mesh.measure, corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p
        )
    return tri_quality(mesh.measure, corner(star, 0, i), corner(star, 1, i), p)


@kernel
def measure_star(mesh, n, p, scratch):
    """Measure all cells of the star with its point at p, into `scratch.values`.

    Returns
    -------
    worst : float
        The least of their q.
    """
    star = scratch.star
    values = scratch.values
    # The measures that every pipeline goes by have loops of their own, which vectorize.
    if mesh.cells.shape[1] == 4 and mesh.measure == ASPECT_RATIO:
        for i in range(n):
            values[i] = tet_aspect_ratio(
                corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p
            )
    elif mesh.cells.shape[1] == 4 and mesh.measure % WITH_ANGLES == ASPECT_RATIO:
        times = lenience(mesh.measure)
        for i in range(n):
            values[i] = tet_bounded_aspect_ratio(
                times, corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p
            )
    elif mesh.cells.shape[1] == 3 and mesh.measure == ASPECT_RATIO:
        for i in range(n):
            values[i] = tri_aspect_ratio(corner(star, 0, i), corner(star, 1, i), p)
    else:
        for i in range(n):
            values[i] = star_quality(mesh, i, p, scratch)
    worst = math.inf
    for i in range(n):
        worst = min(worst, values[i])
    return worst


@inlined
def sum_of_star(n, scratch):
    """Sum of the Q of the cells of the star as they were measured."""
    total = 0.0
    for i in range(n):
        total += 1.0 / scratch.values[i]
    return total


@kernel
def star_heights(mesh, n, scratch):
    """Put into `scratch.values` what `ideal_point` needs of each tet of the star."""
    star = scratch.star
    if mesh.cells.shape[1] == 4:
        for i in range(n):
            scratch.values[i] = tet_ideal_height(
                corner(star, 0, i), corner(star, 1, i), corner(star, 2, i)
            )


@inlined
def ideal_point(mesh, i, scratch):
    """The point that makes the best cell with facet i (18.24), after `star_heights`."""
    star = scratch.star
    if mesh.cells.shape[1] == 4:
        return tet_ideal_point(
            corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), scratch.values[i]
        )
    return tri_ideal_point(corner(star, 0, i), corner(star, 1, i))
