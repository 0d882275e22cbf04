"""Climbing (Remark 18.12): a vertex goes uphill on the worst quality of its ball.

The worst of several qualities has kinks, where cells take turns to be the worst: the direction
is one in which all cells that are nearly the worst improve.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import kernel
from ..accept import gained
from ..gather.ball import gather_ball, longest_edge_at, touch, worst_of
from ..gather.star import load_star, longest_in_star, measure_star, star_quality, straighten
from ..guide import Guide, guide_in, guide_of, guided, held
from ..journal import keep
from ..judge import q_with
from ..metric import mapped, unmapped
from ..types import (
    APPLIED,
    FIXED,
    MAPPED,
    NOT_BETTER,
    TOO_LARGE,
    AnyMesh,
    Scratch,
    SimplexMesh,
)
from ..vectors import Vec, along, at, dot, norm, rounded, set_point

MAX_STEPS = 20
ACTIVE = 0.02  # cells whose q is within this of the worst steer the direction
HULL_STEPS = 24
PROBE = 1e-6  # of the size of the ball: the step of difference quotients
STEP_GAIN = 1e-3  # least gain of a step, as a part of the worst q
SHORTEST = 1e-4  # of the size of the ball: a shorter step ends the search


class RelocationPlan(NamedTuple):
    """A simulated relocation. The ball is in `scratch.ball`."""

    verdict: int
    n: int  # cells of the ball
    position: Vec
    worst: float


@kernel
def gradient_at(mesh: AnyMesh, i: int, p: Vec, value: float, h: float, scratch: Scratch) -> Vec:
    """Gradient of the q of cell i of the star, `value` at p, by differences of step h."""
    gx = (star_quality(mesh, i, Vec(p.x + h, p.y, p.z), scratch) - value) / h
    gy = (star_quality(mesh, i, Vec(p.x, p.y + h, p.z), scratch) - value) / h
    gz = 0.0
    if mesh.cells.shape[1] == 4:
        gz = (star_quality(mesh, i, Vec(p.x, p.y, p.z + h), scratch) - value) / h
    return Vec(gx, gy, gz)


@kernel
def ascent_direction(gradients: np.ndarray, n: int) -> Vec:
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
def climb(
    mesh: SimplexMesh, handles: np.ndarray, n: int, p: Vec, guide: Guide, scratch: Scratch
) -> tuple[Vec, float]:
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
    if mesh.judge.form == MAPPED:
        return climb_in_metric(mesh, n, p, guide, scratch)
    return climb_star(mesh, n, p, longest_edge_at(mesh, handles, n, p), guide, scratch)


@kernel
def climb_in_metric(
    mesh: SimplexMesh, n: int, p: Vec, guide: Guide, scratch: Scratch
) -> tuple[Vec, float]:
    """The same of a star that is loaded, in a metric, where steps have lengths in it."""
    t = straighten(mesh, n, scratch)
    start = mapped(t, p)
    size = longest_in_star(mesh, n, start, scratch)
    q, worst = climb_star(mesh, n, start, size, guide_in(guide, t), scratch)
    back = rounded(mesh, unmapped(t, q))
    if mesh.single:
        worst = measure_star(mesh, n, mapped(t, back), scratch)
    return back, worst


@kernel
def climb_star(
    mesh: AnyMesh, n: int, p: Vec, size: float, guide: Guide, scratch: Scratch
) -> tuple[Vec, float]:
    """The same of a star that is loaded.

    Parameters
    ----------
    size : float
        Longest edge from p.
    """
    values = scratch.values
    worst = measure_star(mesh, n, p, scratch)
    step = 0.2 * size
    for _ in range(MAX_STEPS):
        n_active = 0
        for i in range(n):
            if values[i] <= worst + ACTIVE:
                slope = gradient_at(mesh, i, p, values[i], PROBE * size, scratch)
                g = guided(guide, slope)
                set_point(scratch.gradients, n_active, g)
                n_active += 1
        d = ascent_direction(scratch.gradients, n_active)
        length = norm(d)
        if length * size < 1e-3:
            break
        moved = False
        while step > SHORTEST * size:
            q = held(mesh, guide, p, along(p, d, step / length))
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


@kernel
def movable_ball(
    mesh: SimplexMesh, vertex: int, guide: Guide, below: float, scratch: Scratch
) -> tuple[int, int, float]:
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
def simulate_climb(
    mesh: SimplexMesh, vertex: int, below: float, scratch: Scratch
) -> RelocationPlan:
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
def apply_relocation(
    mesh: SimplexMesh, vertex: int, plan: RelocationPlan, scratch: Scratch
) -> None:
    """Carry out a simulated relocation."""
    for i in range(plan.n):
        keep(mesh, scratch.ball[i] >> 2, scratch)
    set_point(mesh.points, vertex, plan.position)
    for i in range(plan.n):
        handle = scratch.ball[i]
        mesh.quality[handle >> 2] = q_with(mesh, handle, plan.position)
        touch(mesh, handle >> 2)
