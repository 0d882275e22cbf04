"""Edge swapping in the plane (18.4.2): the other diagonal of two triangles."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TRI_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import MEAN, is_accepted, mean_falls
from ..cavity import link
from ..gather.ball import touch
from ..gather.shell import is_required
from ..journal import keep
from ..judge import q_of_triangle
from ..types import APPLIED, FIXED, INVALID, NOT_BETTER, Scratch, SimplexMesh
from ..vectors import Vec, at, cross, dot, minus
from .swap import Swapping


class FlipPlan(NamedTuple):
    """A simulated flip: triangles (a, b, c) and (b, a, d) become (a, d, c) and (d, b, c)."""

    verdict: int
    one: int  # handle of the edge in the first triangle
    other: int  # and in the second
    q_one: float
    q_other: float


@kernel
def simulate_flip(mesh: SimplexMesh, handle: int, rule: int, floor: float) -> FlipPlan:
    """Put the edge between the apexes of two triangles in place of their common one."""
    cell = handle >> 2
    local = handle & 3
    beyond = mesh.neighbours[cell, local]
    if beyond < 0:
        return FlipPlan(FIXED, handle, beyond, 0.0, 0.0)
    a = mesh.cells[cell, (local + 1) % 3]
    b = mesh.cells[cell, (local + 2) % 3]
    if is_required(mesh, a, b):
        return FlipPlan(FIXED, handle, beyond, 0.0, 0.0)
    c = mesh.cells[cell, local]
    d = mesh.cells[beyond >> 2, beyond & 3]
    q_one = q_of_triangle(mesh, a, d, c)
    q_other = q_of_triangle(mesh, d, b, c)
    before = min(mesh.quality[cell], mesh.quality[beyond >> 2])
    after = min(q_one, q_other)
    verdict = APPLIED
    if after <= 0.0:
        verdict = INVALID
    elif not is_accepted(rule, floor, before, after) or (
        rule == MEAN
        and not mean_falls(
            1.0 / mesh.quality[cell] + 1.0 / mesh.quality[beyond >> 2], 1.0 / q_one + 1.0 / q_other
        )
    ):
        verdict = NOT_BETTER
    return FlipPlan(verdict, handle, beyond, q_one, q_other)


@kernel
def apply_flip(mesh: SimplexMesh, plan: FlipPlan, scratch: Scratch) -> None:
    """Carry out a simulated flip."""
    one = plan.one >> 2
    other = plan.other >> 2
    for cell in (one, other):
        keep(mesh, cell, scratch)
        for k in range(3):
            if mesh.neighbours[cell, k] >= 0:
                keep(mesh, mesh.neighbours[cell, k] >> 2, scratch)
    i = plan.one & 3
    j = plan.other & 3
    a = mesh.cells[one, (i + 1) % 3]
    b = mesh.cells[one, (i + 2) % 3]
    c = mesh.cells[one, i]
    d = mesh.cells[other, j]
    beyond_bc = mesh.neighbours[one, (i + 1) % 3]
    beyond_ca = mesh.neighbours[one, (i + 2) % 3]
    beyond_ad = mesh.neighbours[other, (j + 1) % 3]
    beyond_db = mesh.neighbours[other, (j + 2) % 3]
    mesh.cells[one, 0] = a
    mesh.cells[one, 1] = d
    mesh.cells[one, 2] = c
    mesh.cells[other, 0] = d
    mesh.cells[other, 1] = b
    mesh.cells[other, 2] = c
    mesh.neighbours[one, 0] = 4 * other + 1
    mesh.neighbours[other, 1] = 4 * one
    link(mesh, 4 * one + 1, beyond_ca)
    link(mesh, 4 * one + 2, beyond_ad)
    link(mesh, 4 * other, beyond_bc)
    link(mesh, 4 * other + 2, beyond_db)
    mesh.vertex_cell[a] = one
    mesh.vertex_cell[b] = other
    mesh.vertex_cell[c] = one
    mesh.vertex_cell[d] = one
    mesh.quality[one] = plan.q_one
    mesh.quality[other] = plan.q_other
    touch(mesh, one)
    touch(mesh, other)


@entry(
    group="swap",
    example=lambda work: (
        work.mesh,
        work.order,
        Swapping(0, 0.0, False, 0),
        work.scratch,
        work.counts,
    ),
)
def sweep_flip(
    mesh: SimplexMesh, order: np.ndarray, how: Swapping, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try the three edges of each triangle in turn; see `swap.sweep_swap`. It needs no room."""
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        best = -1
        best_worst = -math.inf
        for local in range(3):
            if (
                mesh.vertex_clock[mesh.cells[cell, TRI_FACETS[local, 0]]] <= how.since
                or mesh.vertex_clock[mesh.cells[cell, TRI_FACETS[local, 1]]] <= how.since
            ):
                continue
            plan = simulate_flip(mesh, 4 * cell + local, how.rule, how.floor)
            counts[plan.verdict] += plan.verdict != APPLIED
            worst = min(plan.q_one, plan.q_other)
            if plan.verdict == APPLIED and worst > best_worst:
                best = local
                best_worst = worst
                if not how.pick_best:
                    break
        if best >= 0:
            plan = simulate_flip(mesh, 4 * cell + best, how.rule, how.floor)
            apply_flip(mesh, plan, scratch)
            counts[APPLIED] += 1
    return order.shape[0]


# Two edges are as good as each other where the cotangents of the angles opposite one of them add up
# to 0 but for this.
COCIRCULAR = 1e-9


@inlined
def is_delaunay(a: Vec, b: Vec, c: Vec, d: Vec) -> bool:
    """Whether d is outside the circumcircle of (a, b, c), or on it, beyond the edge a b.

    That is where the angles at c and d add up to pi at most.
    """
    cot_c = dot(minus(a, c), minus(b, c)) / cross(minus(a, c), minus(b, c)).z
    cot_d = dot(minus(b, d), minus(a, d)) / cross(minus(b, d), minus(a, d)).z
    return cot_c + cot_d >= -COCIRCULAR * (1.0 + abs(cot_c))


@entry(
    group="odt",
    example=lambda work: (
        work.mesh, work.order, Swapping(0, 0.0, False, 0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_delaunay(
    mesh: SimplexMesh, order: np.ndarray, how: Swapping, scratch: Scratch, counts: np.ndarray
) -> int:
    """Flip the edges of each triangle that are not Delaunay; see `swap.sweep_swap`.

    Only what is flipped, or refused, counts as an attempt.
    """
    p = mesh.points
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        for local in range(3):
            beyond = mesh.neighbours[cell, local]
            if beyond < 0:
                continue
            a = at(p, mesh.cells[cell, (local + 1) % 3])
            b = at(p, mesh.cells[cell, (local + 2) % 3])
            c = at(p, mesh.cells[cell, local])
            if is_delaunay(a, b, c, at(p, mesh.cells[beyond >> 2, beyond & 3])):
                continue
            plan = simulate_flip(mesh, 4 * cell + local, how.rule, how.floor)
            counts[plan.verdict] += 1
            if plan.verdict == APPLIED:
                apply_flip(mesh, plan, scratch)
                break
    return order.shape[0]
