"""Global smoothing (18.4.1): the energy of all simplices, by the coordinates of all vertices.

What a simplex contributes is in `distortion`, how the sum is made least in `lbfgs`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..shape.distortion import Body, Energy, combined3, corner_quality, determinant, term_of
from ..vectors import Vec, at, distance


class Survey(NamedTuple):
    """What an energy says of all simplices."""

    energy: float
    greatest: float  # of a simplex, without what a limit adds
    least_det: float
    n_bad: int  # not positive


@inlined
def add(rows: np.ndarray, v: int, d: Vec) -> None:
    """Add a vector to a row."""
    rows[v, 0] += d.x
    rows[v, 1] += d.y
    rows[v, 2] += d.z


@kernel
def energy_at(body: Body, points: np.ndarray, how: Energy, gradient: np.ndarray) -> float:
    """The energy, and its derivatives by all coordinates, those of fixed vertices too.

    Parameters
    ----------
    gradient : (np, 3) float64
        Receives them; it is not whole where the energy is infinite.
    """
    for v in range(gradient.shape[0]):
        for k in range(3):
            gradient[v, k] = 0.0
    total = 0.0
    for i in range(body.simplices.shape[0]):
        term = term_of(body, points, i, how)
        if not term.value < math.inf:
            return math.inf
        total += term.value
        whole = combined3(term.d1, -1.0, term.d2, -1.0, term.d3, -1.0)
        add(gradient, body.simplices[i, 0], whole)
        add(gradient, body.simplices[i, 1], term.d1)
        add(gradient, body.simplices[i, 2], term.d2)
        if body.simplices.shape[1] == 4:
            add(gradient, body.simplices[i, 3], term.d3)
    return total


@kernel
def stiffness_at(body: Body, points: np.ndarray, how: Energy, stiffness: np.ndarray) -> None:
    """About the second derivative by any coordinate of each vertex: what a step is measured by.

    Parameters
    ----------
    stiffness : (np,) float64
        Receives it.
    """
    for v in range(stiffness.shape[0]):
        stiffness[v] = 0.0
    d = body.simplices.shape[1] - 1
    b = body.shapes
    for i in range(body.simplices.shape[0]):
        s = body.shape[i]
        k = term_of(body, points, i, how).stiffness * body.scale[i] * body.scale[i]
        for column in range(d):
            apex = 0.0
            for row in range(d):
                stiffness[body.simplices[i, row + 1]] += k * b[s, row, column] * b[s, row, column]
                apex += b[s, row, column]
            stiffness[body.simplices[i, 0]] += k * apex * apex


@entry(
    group="global", example=lambda work: (work.body, work.mesh.points, Energy(0.0, 0.0, 0.0, 0.0))
)
def survey(body: Body, points: np.ndarray, how: Energy) -> Survey:
    """Look at all simplices."""
    free_of_limit = Energy(how.eps, how.theta, how.angular, math.inf)
    energy = 0.0
    greatest = 0.0
    least = math.inf
    n_bad = 0
    for i in range(body.simplices.shape[0]):
        energy += term_of(body, points, i, how).value
        greatest = max(greatest, term_of(body, points, i, free_of_limit).value)
        det = determinant(body, points, i)
        least = min(least, det)
        if not det > 0.0:
            n_bad += 1
    return Survey(energy, greatest, least, n_bad)


@entry(group="global", example=lambda work: (work.body, work.mesh.points, work.mesh.fixed))
def find_bad(body: Body, points: np.ndarray, bad: np.ndarray) -> int:
    """How many simplices are not positive.

    Parameters
    ----------
    bad : (ns,) bool
        Receives which ones.
    """
    n_bad = 0
    for i in range(body.simplices.shape[0]):
        bad[i] = not determinant(body, points, i) > 0.0
        if bad[i]:
            n_bad += 1
    return n_bad


@entry(
    group="global",
    example=lambda work: (work.body, work.mesh.points, work.order, work.vertex_values),
)
def corner_qualities(
    body: Body, points: np.ndarray, cell: np.ndarray, worst: np.ndarray
) -> tuple[float, float]:
    """The least `corner_quality` of all, and the mean of the least of each cell.

    Parameters
    ----------
    cell : (ns,) int64
        Of which cell a simplex is.
    worst : (nc,) float64
        Receives the least of each cell, 1 of one that has no simplex.
    """
    for c in range(worst.shape[0]):
        worst[c] = 1.0
    for i in range(body.simplices.shape[0]):
        worst[cell[i]] = min(worst[cell[i]], corner_quality(body, points, i))
    least = 1.0
    total = 0.0
    for c in range(worst.shape[0]):
        least = min(least, worst[c])
        total += worst[c]
    return least, total / max(worst.shape[0], 1)


@inlined
def log_length(points: np.ndarray, a: int, b: int, reference: float) -> float:
    """Logarithm of the length of an edge, as a part of that of the reference."""
    return math.log(distance(at(points, a), at(points, b)) / reference)


@entry(
    group="global",
    example=lambda work: (
        work.body, work.mesh.points, work.mesh.fixed, work.body.shapes, work.vertex_values,
        work.vertex_values,
    ),
)  # fmt: skip
def sizes_of_fixed(
    body: Body,
    points: np.ndarray,
    fixed: np.ndarray,
    lengths: np.ndarray,
    totals: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Sum up the logarithms of the edges between fixed vertices, as parts of their references.

    Parameters
    ----------
    fixed : (np,) bool
    lengths : (k, d + 1, d + 1) float64
        Between the vertices of each reference.
    totals, weights : (np,) float64
        Receive the sum and the number of edges at each vertex; those of no length do not count.
    """
    width = body.simplices.shape[1]
    for i in range(body.simplices.shape[0]):
        for j in range(width):
            a = body.simplices[i, j]
            for k in range(j):
                b = body.simplices[i, k]
                if fixed[a] and fixed[b] and distance(at(points, a), at(points, b)) > 0.0:
                    size = log_length(points, a, b, lengths[body.shape[i], j, k])
                    totals[a] += size
                    totals[b] += size
                    weights[a] += 1.0
                    weights[b] += 1.0


@entry(
    group="global",
    example=lambda work: (
        work.body, work.mesh.fixed, work.vertex_values, work.mesh.fixed, work.vertex_values,
        work.vertex_values,
    ),
)  # fmt: skip
def spread_sizes(
    body: Body,
    kept: np.ndarray,
    values: np.ndarray,
    known: np.ndarray,
    totals: np.ndarray,
    weights: np.ndarray,
) -> int:
    """Give each vertex that does not keep its value the mean of those around it that have one.

    Parameters
    ----------
    kept, known : (np,) bool
        Those that keep their value, and those that have one: these become more.
    values : (np,) float64
    totals, weights : (np,) float64
        Working space, 0 before and after.

    Returns
    -------
    n_new : int
        Vertices that had no value.
    """
    width = body.simplices.shape[1]
    for i in range(body.simplices.shape[0]):
        total = 0.0
        weight = 0.0
        for j in range(width):
            v = body.simplices[i, j]
            if known[v]:
                total += values[v]
                weight += 1.0
        for j in range(width):
            v = body.simplices[i, j]
            totals[v] += total
            weights[v] += weight
    n_new = 0
    for v in range(values.shape[0]):
        if weights[v] > 0.0 and not kept[v]:
            values[v] = totals[v] / weights[v]
            n_new += 0 if known[v] else 1
            known[v] = True
        totals[v] = 0.0
        weights[v] = 0.0
    return n_new
