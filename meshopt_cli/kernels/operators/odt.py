"""Optimal Delaunay triangulation: vertices go to the mean of the circumcentres of their balls.

The mean is weighted by the measure of the cells times a density. That lowers the error with which
x² is interpolated over the mesh (Chen and Holst 2011), as Delaunay flips do, and makes cells
regular by what is all around them, where other relocations look at one ball only. Going beyond
the mean gets there several times faster.

The density keeps the sizes as they are. With sizes that grow in proportion to the distance, the
circumcentres of a ball balance where it is (size of a cell)^-(d + 1).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..gather.star import load_star
from ..guide import FREE
from ..shape.circumcentre import tet_circumcentre, tri_circumcentre
from ..types import APPLIED, INVALID, N_CELLS, NOT_BETTER, Scratch, SimplexMesh
from ..vectors import Vec, at, cross, minus, norm, square_distance
from .climb import RelocationPlan, apply_relocation, movable_ball
from .relocate import go_toward

# Twice the area of a triangle, and six times the volume of a tet, all of whose edges are 1.
TRI_UNIT = math.sqrt(3.0) / 2.0
TET_UNIT = math.sqrt(0.5)


class Pull(NamedTuple):
    """How vertices follow the circumcentres."""

    relaxation: float  # part of the way to go, above 1 beyond the mean
    rule: int
    floor: float


@inlined
def circumcentre(mesh: SimplexMesh, cell: int) -> tuple[Vec, float]:
    """Circumcentre of a cell, and d! times its measure."""
    a = at(mesh.points, mesh.cells[cell, 0])
    b = at(mesh.points, mesh.cells[cell, 1])
    c = at(mesh.points, mesh.cells[cell, 2])
    if mesh.cells.shape[1] == 3:
        return tri_circumcentre(a, b, c)
    return tet_circumcentre(a, b, c, at(mesh.points, mesh.cells[cell, 3]))


@kernel
def circumcentre_mean(mesh: SimplexMesh, ball: np.ndarray, n: int, density: np.ndarray) -> Vec:
    """Mean of the circumcentres of a ball, weighted by measure and density."""
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    for i in range(n):
        cell = ball[i] >> 2
        centre, measure = circumcentre(mesh, cell)
        weight = 0.0
        for k in range(mesh.cells.shape[1]):
            weight += density[mesh.cells[cell, k]]
        weight *= measure
        total += weight
        x += weight * centre.x
        y += weight * centre.y
        z += weight * centre.z
    return Vec(x / total, y / total, z / total)


@kernel
def simulate_pull(
    mesh: SimplexMesh, vertex: int, how: Pull, density: np.ndarray, scratch: Scratch
) -> RelocationPlan:
    """Move an internal vertex toward the mean of the circumcentres of its ball, and beyond."""
    ball = scratch.ball
    p = at(mesh.points, vertex)
    verdict, n, before = movable_ball(mesh, vertex, FREE, math.inf, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    if before <= 0.0:
        return RelocationPlan(INVALID, n, p, before)
    goal = circumcentre_mean(mesh, ball, n, density)
    far = square_distance(p, goal)
    if far == 0.0 or not math.isfinite(far):
        return RelocationPlan(NOT_BETTER, n, p, before)
    load_star(mesh, ball, n, scratch)
    return go_toward(mesh, n, p, goal, how.relaxation, how.rule, how.floor, before, scratch)


@entry(
    group="odt",
    example=lambda work: (
        work.mesh, work.order, Pull(0.0, 0, 0.0), work.vertex_values, work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_pull(
    mesh: SimplexMesh,
    order: np.ndarray,
    how: Pull,
    density: np.ndarray,
    scratch: Scratch,
    counts: np.ndarray,
) -> int:
    """Pull each vertex in turn; see `swap.sweep_swap`. It needs no room.

    Parameters
    ----------
    density : (np,) float64
    """
    for i in range(order.shape[0]):
        vertex = order[i]
        if mesh.vertex_cell[vertex] < 0:
            continue
        plan = simulate_pull(mesh, vertex, how, density, scratch)
        counts[plan.verdict] += 1
        if plan.verdict == APPLIED:
            apply_relocation(mesh, vertex, plan, scratch)
    return order.shape[0]


@inlined
def size_on_facet(mesh: SimplexMesh, cell: int, local: int) -> float:
    """d! times the measure of the regular simplex on a facet, from the facet's own measure."""
    width = mesh.cells.shape[1]
    a = at(mesh.points, mesh.cells[cell, (local + 1) % width])
    b = at(mesh.points, mesh.cells[cell, (local + 2) % width])
    if width == 3:
        return TRI_UNIT * square_distance(a, b)
    c = at(mesh.points, mesh.cells[cell, (local + 3) % width])
    square = norm(cross(minus(b, a), minus(c, a))) / TRI_UNIT  # of the edge
    return TET_UNIT * square * math.sqrt(square)


@inlined
def take_means(values: np.ndarray, totals: np.ndarray, weights: np.ndarray) -> None:
    """Put the weighted means where there are any."""
    for v in range(values.shape[0]):
        if weights[v] > 0.0:
            values[v] = totals[v] / weights[v]
        totals[v] = 0.0
        weights[v] = 0.0


@entry(
    group="odt",
    example=lambda work: (work.mesh, work.vertex_values, work.vertex_values, work.vertex_values),
)
def sizes_at(mesh: SimplexMesh, sizes: np.ndarray, totals: np.ndarray, weights: np.ndarray) -> None:
    """d! times the mean measure of the cells at each vertex.

    On the boundary it is what the facets there ask for: what lies behind them is not known.

    Parameters
    ----------
    sizes : (np,) float64
        Receives it; untouched where there are no cells.
    totals, weights : (np,) float64
        Working space, 0 before and after.
    """
    width = mesh.cells.shape[1]
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            _, measure = circumcentre(mesh, cell)
            for k in range(width):
                totals[mesh.cells[cell, k]] += measure
                weights[mesh.cells[cell, k]] += 1.0
    take_means(sizes, totals, weights)
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            for local in range(width):
                if mesh.neighbours[cell, local] < 0:
                    size = size_on_facet(mesh, cell, local)
                    for k in range(width):
                        if k != local:
                            totals[mesh.cells[cell, k]] += size
                            weights[mesh.cells[cell, k]] += 1.0
    take_means(sizes, totals, weights)


@entry(
    group="odt",
    example=lambda work: (work.mesh, work.vertex_values, work.vertex_values, work.vertex_values),
)
def smooth_values(
    mesh: SimplexMesh, values: np.ndarray, totals: np.ndarray, weights: np.ndarray
) -> None:
    """Give each vertex that is not fixed the mean of the cells around it, and them of theirs.

    Fixed ones keep theirs: a mean over one side of a boundary would draw vertices to it, or away.

    Parameters
    ----------
    values : (np,) float64
    totals, weights : (np,) float64
        Working space, 0 before and after.
    """
    width = mesh.cells.shape[1]
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            value = 0.0
            for k in range(width):
                value += values[mesh.cells[cell, k]] / width
            for k in range(width):
                v = mesh.cells[cell, k]
                if not mesh.fixed[v]:
                    totals[v] += value
                    weights[v] += 1.0
    take_means(values, totals, weights)
