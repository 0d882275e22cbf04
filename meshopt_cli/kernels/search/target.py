"""The best tetrahedron that a given triangle allows (the row `target` of Table 18.3)."""

from __future__ import annotations

import math

import numpy as np

from ...cells import TET_FACETS
from ...compiled.decorators import entry, kernel
from ..shape.ideal import TET_HEIGHT
from ..shape.simplex import tet_quality
from ..types import Judge, SimplexMesh
from ..vectors import Vec, along, at, cross, distance, minus, norm

N_HEIGHTS = 24
N_DIRECTIONS = 26
N_TURNS = 8  # of the pattern, none of which finds better, before it shrinks
SHORTEST = 1e-5  # of the longest edge: a shorter step ends the search


@kernel
def direction(i: int, turn: float) -> Vec:
    """One of the 26 directions to the neighbours of a cube's centre, turned about two axes."""
    k = i if i < 13 else i + 1
    x = float(k % 3 - 1)
    y = float((k // 3) % 3 - 1)
    z = float(k // 9 - 1)
    c = math.cos(turn)
    s = math.sin(turn)
    u = c * x - s * y
    v = s * x + c * y
    return Vec(u, c * v - s * z, s * v + c * z)


@kernel
def scan_heights(judge: Judge, a: Vec, b: Vec, c: Vec) -> tuple[float, Vec]:
    """Best q over apexes above the centroid, and the apex that has it."""
    centre = Vec((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0, (a.z + b.z + c.z) / 3.0)
    normal = cross(minus(b, a), minus(c, a))
    length = norm(normal)
    best = 0.0
    apex = centre
    if length > 0.0:
        edge = (distance(a, b) + distance(b, c) + distance(c, a)) / 3.0
        for i in range(N_HEIGHTS):
            p = along(centre, normal, TET_HEIGHT * edge * (0.1 + 0.08 * i) / length)
            q = tet_quality(judge, a, b, c, p)
            if q > best:
                best = q
                apex = p
    return best, apex


@entry(
    group="basic",
    example=lambda work: (work.mesh.judge, work.mesh.points, work.facets, work.mesh.quality),
)
def estimate_targets(judge: Judge, points: np.ndarray, faces: np.ndarray, out: np.ndarray) -> None:
    """A lower bound of the best q over each face, from apexes above its centroid.

    Parameters
    ----------
    faces : (n, 3) int64
    out : (n,) float64
    """
    for i in range(faces.shape[0]):
        q, _ = scan_heights(
            judge, at(points, faces[i, 0]), at(points, faces[i, 1]), at(points, faces[i, 2])
        )
        out[i] = q


@entry(group="mend", example=lambda work: (work.mesh, work.order, work.mesh.quality))
def facet_bounds(mesh: SimplexMesh, cells: np.ndarray, out: np.ndarray) -> None:
    """The q that the boundary facets of tetrahedra allow, from apexes above their centroids.

    It is at most 3 % less than what `best_over_face` finds.

    Parameters
    ----------
    cells : (n,) int64
    out : (n,) float64
        1 for those without such facets.
    """
    for i in range(cells.shape[0]):
        cell = cells[i]
        out[i] = 1.0
        for local in range(4):
            if mesh.neighbours[cell, local] < 0:
                a = at(mesh.points, mesh.cells[cell, TET_FACETS[local, 0]])
                b = at(mesh.points, mesh.cells[cell, TET_FACETS[local, 1]])
                c = at(mesh.points, mesh.cells[cell, TET_FACETS[local, 2]])
                q, _ = scan_heights(mesh.judge, a, b, c)
                out[i] = min(out[i], q)


@entry(group="basic", example=lambda work: (work.mesh.judge, work.mesh.points, 0, 1, 2))
def best_over_face(judge: Judge, points: np.ndarray, i: int, j: int, k: int) -> float:
    """Best q of a tet on the face i j k, by a pattern search over the apex.

    The measures have kinks where another edge becomes the longest: the pattern is turned
    after each round of the search, so that it does not stall on one.
    """
    a = at(points, i)
    b = at(points, j)
    c = at(points, k)
    best, apex = scan_heights(judge, a, b, c)
    size = max(distance(a, b), distance(b, c), distance(c, a))
    step = 0.25 * size
    turn = 0.0
    failures = 0
    while step > SHORTEST * size:
        found = best
        target = apex
        for n in range(N_DIRECTIONS):
            p = along(apex, direction(n, turn), step)
            q = tet_quality(judge, a, b, c, p)
            if q > found:
                found = q
                target = p
        turn += 0.7
        if found > best:
            best = found
            apex = target
            failures = 0
        else:
            failures += 1
            if failures == N_TURNS:
                step *= 0.7
                failures = 0
    return best
