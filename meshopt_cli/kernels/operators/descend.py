"""Descent: a vertex goes downhill on the sum of the Q² of its ball.

What the mean of the ideal points approaches, this does: the mean Q of the ball falls, and that of
its bad cells most.
"""

from __future__ import annotations

import numpy as np

from ...compiled.decorators import inlined, kernel
from ..accept import MEAN, mean_falls, threshold
from ..gather.ball import longest_edge_at
from ..gather.star import load_star, longest_in_star, measure_star, straighten, sum_of_star
from ..guide import Guide, guide_in, guided, held
from ..metric import mapped, unmapped
from ..types import MAPPED, AnyMesh, Scratch, SimplexMesh
from ..vectors import Vec, along, norm, rounded

MAX_STEPS = 3
N_HALVINGS = 8
FIRST_STEP = 0.15  # of the size of the ball
PROBE = 1e-6  # of the size of the ball: the step of difference quotients
STEP_GAIN = 1e-3  # least gain of a step, as a part of the sum


@inlined
def sum_of_squares(n: int, scratch: Scratch) -> float:
    """Sum of the Q² of the cells of the star as they were measured."""
    total = 0.0
    for i in range(n):
        total += 1.0 / (scratch.values[i] * scratch.values[i])
    return total


@kernel
def descend(
    mesh: SimplexMesh,
    handles: np.ndarray,
    n: int,
    p: Vec,
    guide: Guide,
    rule: int,
    floor: float,
    before: float,
    scratch: Scratch,
) -> tuple[Vec, float]:
    """Move p downhill, as far as a guide allows and a rule accepts what comes of it.

    Parameters
    ----------
    handles : (n,) int64
        The facets of the star.
    before : float
        Worst q of the star at p.

    Returns
    -------
    p : Vec
    worst : float
        Worst q of the star at p; `before` where p did not move.
    """
    load_star(mesh, handles, n, scratch)
    if mesh.judge.form == MAPPED:
        return descend_in_metric(mesh, n, p, guide, rule, floor, before, scratch)
    size = longest_edge_at(mesh, handles, n, p)
    return descend_star(mesh, n, p, size, guide, rule, floor, before, scratch)


@kernel
def descend_in_metric(
    mesh: SimplexMesh,
    n: int,
    p: Vec,
    guide: Guide,
    rule: int,
    floor: float,
    before: float,
    scratch: Scratch,
) -> tuple[Vec, float]:
    """The same of a star that is loaded, in a metric, where steps have lengths in it."""
    t = straighten(mesh, n, scratch)
    start = mapped(t, p)
    size = longest_in_star(mesh, n, start, scratch)
    q, worst = descend_star(mesh, n, start, size, guide_in(guide, t), rule, floor, before, scratch)
    if q.x == start.x and q.y == start.y and q.z == start.z:
        return p, before
    back = rounded(mesh, unmapped(t, q))
    if mesh.single:
        worst = measure_star(mesh, n, mapped(t, back), scratch)
        if worst <= threshold(rule, floor, before):
            return p, before
    return back, worst


@kernel
def descend_star(
    mesh: AnyMesh,
    n: int,
    p: Vec,
    size: float,
    guide: Guide,
    rule: int,
    floor: float,
    before: float,
    scratch: Scratch,
) -> tuple[Vec, float]:
    """The same of a star that is loaded.

    Parameters
    ----------
    size : float
        Longest edge from p.
    """
    least = threshold(rule, floor, before)
    h = PROBE * size
    worst = measure_star(mesh, n, p, scratch)
    if worst <= 0.0:
        return p, before
    value = sum_of_squares(n, scratch)
    sum_before = sum_of_star(n, scratch)
    found = p
    found_worst = before
    step = FIRST_STEP * size
    for _ in range(MAX_STEPS):
        # A probe that turns a cell over gives no slope.
        if measure_star(mesh, n, Vec(p.x + h, p.y, p.z), scratch) <= 0.0:
            break
        gx = value - sum_of_squares(n, scratch)
        if measure_star(mesh, n, Vec(p.x, p.y + h, p.z), scratch) <= 0.0:
            break
        gy = value - sum_of_squares(n, scratch)
        gz = 0.0
        if mesh.cells.shape[1] == 4:
            if measure_star(mesh, n, Vec(p.x, p.y, p.z + h), scratch) <= 0.0:
                break
            gz = value - sum_of_squares(n, scratch)
        d = guided(guide, Vec(gx, gy, gz))
        length = norm(d)
        if length == 0.0:
            break
        moved = False
        for _ in range(N_HALVINGS):
            q = held(mesh, guide, p, along(p, d, step / length))
            after = measure_star(mesh, n, q, scratch)
            if after > least:
                squares = sum_of_squares(n, scratch)
                if squares < value - STEP_GAIN * value:
                    p = q
                    value = squares
                    moved = True
                    if rule != MEAN or mean_falls(sum_before, sum_of_star(n, scratch)):
                        found = q
                        found_worst = after
                    break
            step *= 0.5
        if not moved:
            break
    return found, found_worst
