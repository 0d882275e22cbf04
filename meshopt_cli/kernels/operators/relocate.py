"""Node relocation (18.4.1): where a vertex should go, and how far it can.

The methods give an auxiliary point P* (18.21); the vertex moves to (1 - w) P + w P*
(18.22), w being halved while the result is refused (Remark 18.11). `optimize` instead
climbs the worst quality of the ball (Remark 18.12): see `climb`; and `descent` goes downhill on
the sum of the Q² of the ball: see `descend`. By LIMITS a vertex goes into the half-spaces that it
was told to stay in.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, kernel
from ..accept import MEAN, is_accepted, mean_falls
from ..gather.ball import next_stamp, sum_of, worst_of
from ..gather.star import ideal_point, load_star, measure_star, star_heights, sum_of_star
from ..guide import guide_of, guided, held, led, limited
from ..types import APPLIED, INVALID, NOT_BETTER, AnyMesh, Scratch, SimplexMesh
from ..vectors import Vec, along, at, distance, minus, rounded, square_distance, toward
from .climb import RelocationPlan, apply_relocation, movable_ball, simulate_climb
from .descend import descend

LAPLACE, WEIGHTED, QUALITY, OPTIMIZE, DESCENT, LIMITS = range(6)
UNIFORM, WORST, DEGRADATION, DEGRADATION2 = range(4)

# A degradation Q runs to infinity on flat cells: as a weight it is capped here.
MAX_WEIGHT = 1e4
N_HALVINGS = 5
STILL = 1e-18  # a step whose square is less than this part of an edge's is none


class Relocation(NamedTuple):
    """How to look for the new position of a vertex."""

    method: int
    weight: int
    relaxation: float
    rule: int
    floor: float
    below: float  # only balls whose worst q is less than this


@kernel
def neighbour_mean(
    mesh: SimplexMesh, vertex: int, ball: np.ndarray, n: int, weighted: bool, scratch: Scratch
) -> Vec:
    """Mean of the vertices of the ball (18.21); weighted by their distance for (18.23)."""
    stamp = next_stamp(scratch)
    p = at(mesh.points, vertex)
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    for i in range(n):
        cell = ball[i] >> 2
        for k in range(mesh.cells.shape[1]):
            v = mesh.cells[cell, k]
            if v != vertex and scratch.vertex_mark[v] != stamp:
                scratch.vertex_mark[v] = stamp
                q = at(mesh.points, v)
                w = distance(p, q) if weighted else 1.0
                total += w
                x += w * q.x
                y += w * q.y
                z += w * q.z
    return Vec(x / total, y / total, z / total)


@kernel
def ideal_mean(mesh: SimplexMesh, ball: np.ndarray, n: int, weight: int, scratch: Scratch) -> Vec:
    """Weighted mean of the ideal points of the ball (18.24), whose star is loaded."""
    star_heights(mesh, n, scratch)
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    worst = worst_of(mesh, ball, n)
    for i in range(n):
        q = mesh.quality[ball[i] >> 2]
        w = 1.0
        if weight == WORST:
            if q > worst:
                continue
        elif weight != UNIFORM:
            w = min(1.0 / q, MAX_WEIGHT) if q > 0.0 else MAX_WEIGHT
            if weight == DEGRADATION2:
                w *= w
        ideal = ideal_point(mesh, i, scratch)
        total += w
        x += w * ideal.x
        y += w * ideal.y
        z += w * ideal.z
    return Vec(x / total, y / total, z / total)


@kernel
def go_toward(
    mesh: AnyMesh,
    n: int,
    p: Vec,
    goal: Vec,
    relaxation: float,
    rule: int,
    floor: float,
    before: float,
    scratch: Scratch,
) -> RelocationPlan:
    """Go from p part of the way to a goal, and half of that while it is refused.

    Parameters
    ----------
    n : int
        Cells of the ball in `scratch.ball`, whose star is loaded.
    before : float
        Worst q of the ball.
    """
    sum_before = sum_of(mesh, scratch.ball, n) if rule == MEAN else 0.0
    t = relaxation
    worst = before
    for _ in range(N_HALVINGS):
        q = rounded(mesh, toward(p, goal, t))
        worst = measure_star(mesh, n, q, scratch)
        if is_accepted(rule, floor, before, worst) and (
            rule != MEAN or mean_falls(sum_before, sum_of_star(n, scratch))
        ):
            return RelocationPlan(APPLIED, n, q, worst)
        t *= 0.5
    return RelocationPlan(NOT_BETTER if worst > 0.0 else INVALID, n, p, worst)


@kernel
def simulate_relocation(
    mesh: SimplexMesh, vertex: int, how: Relocation, scratch: Scratch
) -> RelocationPlan:
    """Look for a better position of a vertex inside its ball."""
    if how.method == OPTIMIZE:
        return simulate_climb(mesh, vertex, how.below, scratch)
    ball = scratch.ball
    p = at(mesh.points, vertex)
    guide = guide_of(mesh, vertex)
    verdict, n, before = movable_ball(mesh, vertex, guide, how.below, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    if how.method == DESCENT:
        q, worst = descend(mesh, ball, n, p, guide, how.rule, how.floor, before, scratch)
        moved = square_distance(p, q) > 0.0
        return RelocationPlan(APPLIED if moved else NOT_BETTER, n, q, worst)
    load_star(mesh, ball, n, scratch)
    if how.method == LIMITS:
        goal = limited(mesh.limits, guide, p, led(mesh.limits, guide, p))
    elif how.method == QUALITY:
        goal = ideal_mean(mesh, ball, n, how.weight, scratch)
    else:
        goal = neighbour_mean(mesh, vertex, ball, n, how.method == WEIGHTED, scratch)
    if guide.kind > 0.0 and how.method != LIMITS:
        goal = held(mesh, guide, p, along(p, guided(guide, minus(goal, p)), 1.0))
    neighbour = mesh.cells[ball[0] >> 2, 0 if ball[0] & 3 else 1]
    if square_distance(p, goal) <= STILL * square_distance(p, at(mesh.points, neighbour)):
        return RelocationPlan(NOT_BETTER, n, p, before)
    return go_toward(mesh, n, p, goal, how.relaxation, how.rule, how.floor, before, scratch)


@entry(
    group="relocation",
    example=lambda work: (
        work.mesh, work.order, Relocation(0, 0, 0.0, 0, 0.0, 0.0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_relocation(
    mesh: SimplexMesh, order: np.ndarray, how: Relocation, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try each vertex in turn; see `swap.sweep_swap`. It needs no room."""
    for i in range(order.shape[0]):
        vertex = order[i]
        if mesh.vertex_cell[vertex] < 0:
            continue
        plan = simulate_relocation(mesh, vertex, how, scratch)
        counts[plan.verdict] += 1
        if plan.verdict == APPLIED:
            apply_relocation(mesh, vertex, plan, scratch)
    return order.shape[0]
