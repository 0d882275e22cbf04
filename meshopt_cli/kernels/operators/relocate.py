"""Node relocation (18.4.1): where a vertex should go, and how far it can.

The methods give an auxiliary point P* (18.21); the vertex moves to (1 - w) P + w P*
(18.22), w being halved while the result is refused (Remark 18.11). `optimize` instead
climbs the worst quality of the ball (Remark 18.12).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..accept import MEAN, gained, is_accepted, mean_falls
from ..gather.ball import (
    gather_ball,
    longest_edge_at,
    next_stamp,
    quality_at,
    sum_of,
    touch,
    worst_of,
)
from ..gather.star import (
    ideal_point,
    load_star,
    measure_star,
    star_heights,
    star_quality,
    sum_of_star,
)
from ..journal import keep
from ..types import APPLIED, FIXED, INVALID, NOT_BETTER, TOO_LARGE
from ..vectors import (
    FREE,
    Guide,
    Vec,
    along,
    at,
    distance,
    dot,
    guided,
    minus,
    norm,
    square_distance,
    toward,
)

LAPLACE, WEIGHTED, QUALITY, OPTIMIZE = range(4)
UNIFORM, WORST, DEGRADATION, DEGRADATION2 = range(4)

# A degradation Q runs to infinity on flat cells: as a weight it is capped here.
MAX_WEIGHT = 1e4
N_HALVINGS = 5
STILL = 1e-18  # a step whose square is less than this part of an edge's is none

# Optimization of a ball.
MAX_STEPS = 20
ACTIVE = 0.02  # cells whose q is within this of the worst steer the direction
HULL_STEPS = 24
PROBE = 1e-6  # of the size of the ball: the step of difference quotients
STEP_GAIN = 1e-3  # least gain of a step, as a part of the worst q
SHORTEST = 1e-4  # of the size of the ball: a shorter step ends the search


class Relocation(NamedTuple):
    """How to look for the new position of a vertex."""

    method: int
    weight: int
    relaxation: float
    rule: int
    floor: float
    below: float  # only balls whose worst q is less than this


class RelocationPlan(NamedTuple):
    """A simulated relocation. The ball is in `scratch.ball`."""

    verdict: int
    n: int  # cells of the ball
    position: Vec
    worst: float


@inlined
def single(x):
    """The number rounded to single precision."""
    return np.float64(np.float32(x))


@inlined
def rounded(mesh, p):
    """The point as it will be stored."""
    if mesh.single:
        return Vec(single(p.x), single(p.y), single(p.z))
    return p


@kernel
def neighbour_mean(mesh, vertex, ball, n, weighted, scratch):
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
def ideal_mean(mesh, ball, n, weight, scratch):
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
def gradient_at(mesh, i, p, value, h, scratch):
    """Gradient of the q of cell i of the star, `value` at p, by differences of step h."""
    gx = (star_quality(mesh, i, Vec(p.x + h, p.y, p.z), scratch) - value) / h
    gy = (star_quality(mesh, i, Vec(p.x, p.y + h, p.z), scratch) - value) / h
    gz = 0.0
    if mesh.cells.shape[1] == 4:
        gz = (star_quality(mesh, i, Vec(p.x, p.y, p.z + h), scratch) - value) / h
    return Vec(gx, gy, gz)


@kernel
def ascent_direction(gradients, n):
    """Point of least norm in the convex hull of the gradients (Gilbert's algorithm).

    All active cells improve along it; where it vanishes the worst q has a maximum.
    """
    d = at(gradients, 0)
    for _ in range(HULL_STEPS):
        least = math.inf
        nearest = 0
        for i in range(n):
            s = dot(d, at(gradients, i))
            if s < least:
                least = s
                nearest = i
        square = dot(d, d)
        if square - least <= 1e-3 * square:
            break
        g = at(gradients, nearest)
        towards = Vec(g.x - d.x, g.y - d.y, g.z - d.z)
        d = along(d, towards, min(1.0, -dot(d, towards) / dot(towards, towards)))
    return d


@kernel
def climb(mesh, handles, n, p, guide, scratch):
    """Move p uphill on the worst q of its star until no step helps, as far as a guide allows.

    Parameters
    ----------
    handles : (n,) int64
        The facets of the star.

    Returns
    -------
    p : Vec
    worst : float
        Worst q of the star at p, at least what it was.
    """
    load_star(mesh, handles, n, scratch)
    size = longest_edge_at(mesh, handles, n, p)
    values = scratch.values
    worst = measure_star(mesh, n, p, scratch)
    step = 0.2 * size
    for _ in range(MAX_STEPS):
        n_active = 0
        for i in range(n):
            if values[i] <= worst + ACTIVE:
                slope = gradient_at(mesh, i, p, values[i], PROBE * size, scratch)
                g = guided(guide, slope)
                scratch.gradients[n_active, 0] = g.x
                scratch.gradients[n_active, 1] = g.y
                scratch.gradients[n_active, 2] = g.z
                n_active += 1
        d = ascent_direction(scratch.gradients, n_active)
        length = norm(d)
        if length * size < 1e-3:
            break
        moved = False
        while step > SHORTEST * size:
            q = rounded(mesh, along(p, d, step / length))
            after = measure_star(mesh, n, q, scratch)
            if after > worst + STEP_GAIN * abs(worst):
                # A longer stride may do better still.
                p = q
                worst = after
                moved = True
                break
            step *= 0.5
        if not moved:
            break
        step *= 1.6
    return p, worst


@inlined
def guide_of(mesh, vertex):
    """Where a vertex of the boundary may move; everywhere for one inside."""
    if not mesh.slides:
        return FREE
    g = mesh.guide
    return Guide(g[vertex, 0], Vec(g[vertex, 1], g[vertex, 2], g[vertex, 3]))


@kernel
def movable_ball(mesh, vertex, guide, below, scratch):
    """Gather the ball of a vertex into `scratch.ball`.

    Returns
    -------
    verdict : int
        APPLIED where the vertex may move, else FIXED or TOO_LARGE; NOT_BETTER where the ball is
        no worse than `below`.
    n : int
        Cells of the ball.
    before : float
        Worst q of the ball.
    """
    if mesh.fixed[vertex] and guide.kind == 0.0:
        return FIXED, 0, 0.0
    n, closed = gather_ball(mesh, vertex, scratch.ball, scratch)
    if n < 0:
        return TOO_LARGE, 0, 0.0
    if not closed and guide.kind == 0.0:
        return FIXED, 0, 0.0
    before = worst_of(mesh, scratch.ball, n)
    return APPLIED if before < below else NOT_BETTER, n, before


@kernel
def simulate_climb(mesh, vertex, below, scratch):
    """Look for where the ball of a vertex is best, if it is worse than `below` (Remark 18.12)."""
    ball = scratch.ball
    p = at(mesh.points, vertex)
    guide = guide_of(mesh, vertex)
    verdict, n, before = movable_ball(mesh, vertex, guide, below, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    q, worst = climb(mesh, ball, n, p, guide, scratch)
    verdict = APPLIED if worst > gained(before) else NOT_BETTER
    return RelocationPlan(verdict, n, q, worst)


@kernel
def simulate_relocation(mesh, vertex, how, scratch):
    """Look for a better position of a vertex inside its ball."""
    if how.method == OPTIMIZE:
        return simulate_climb(mesh, vertex, how.below, scratch)
    ball = scratch.ball
    p = at(mesh.points, vertex)
    guide = guide_of(mesh, vertex)
    verdict, n, before = movable_ball(mesh, vertex, guide, how.below, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    load_star(mesh, ball, n, scratch)
    if how.method == QUALITY:
        goal = ideal_mean(mesh, ball, n, how.weight, scratch)
    else:
        goal = neighbour_mean(mesh, vertex, ball, n, how.method == WEIGHTED, scratch)
    if guide.kind > 0.0:
        goal = along(p, guided(guide, minus(goal, p)), 1.0)
    neighbour = mesh.cells[ball[0] >> 2, 0 if ball[0] & 3 else 1]
    if square_distance(p, goal) <= STILL * square_distance(p, at(mesh.points, neighbour)):
        return RelocationPlan(NOT_BETTER, n, p, before)
    sum_before = sum_of(mesh, ball, n) if how.rule == MEAN else 0.0
    t = how.relaxation
    worst = before
    for _ in range(N_HALVINGS):
        q = rounded(mesh, toward(p, goal, t))
        worst = measure_star(mesh, n, q, scratch)
        if is_accepted(how.rule, how.floor, before, worst) and (
            how.rule != MEAN or mean_falls(sum_before, sum_of_star(n, scratch))
        ):
            return RelocationPlan(APPLIED, n, q, worst)
        t *= 0.5
    return RelocationPlan(NOT_BETTER if worst > 0.0 else INVALID, n, p, worst)


@kernel
def apply_relocation(mesh, vertex, plan, scratch):
    """Carry out a simulated relocation."""
    for i in range(plan.n):
        keep(mesh, scratch.ball[i] >> 2, scratch)
    mesh.points[vertex, 0] = plan.position.x
    mesh.points[vertex, 1] = plan.position.y
    mesh.points[vertex, 2] = plan.position.z
    for i in range(plan.n):
        handle = scratch.ball[i]
        mesh.quality[handle >> 2] = quality_at(mesh, handle, plan.position)
        touch(mesh, handle >> 2)


@entry
def sweep_relocation(mesh, order, how, scratch, counts):
    """Try each vertex in turn; `counts` (N_VERDICTS,) is raised at each verdict."""
    for i in range(order.shape[0]):
        vertex = order[i]
        if mesh.vertex_cell[vertex] < 0:
            continue
        plan = simulate_relocation(mesh, vertex, how, scratch)
        counts[plan.verdict] += 1
        if plan.verdict == APPLIED:
            apply_relocation(mesh, vertex, plan, scratch)
