"""Non-obtuse triangles in the plane (18.4.3): vertices go where the triangles around them are.

Each edge of the outline of its ball leaves a vertex the region between two lines and outside a
circle (Figure 18.13). The vertex looks for the place where its triangles lack least, which is well
inside of what all edges leave where there is such a place; and edges flip by the same. See `clear`
for what is done where neither helps.
"""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..accept import FLAT, VALID
from ..gather.ball import longest_edge_at
from ..gather.star import corner, load_star, measure_star
from ..guide import FREE
from ..shape.lack import NONE, Extremes, Lack, Wants, added, extremes, is_less
from ..types import APPLIED, N_CELLS, NOT_BETTER, Scratch, SimplexMesh
from ..vectors import Vec, at, rounded
from .climb import RelocationPlan, apply_relocation, movable_ball
from .flip import apply_flip, simulate_flip

# The pattern search, in parts of the longest edge of the ball: its first step, and when it ends.
# To 2e-3: twice the time for nothing.
FIRST_STEP = 0.3
SHORTEST_STEP = 1e-2
# Unit vectors of its eight directions.
DIAGONAL = math.sqrt(0.5)
DIRECTIONS = (
    (1.0, 0.0), (DIAGONAL, DIAGONAL), (0.0, 1.0), (-DIAGONAL, DIAGONAL),
    (-1.0, 0.0), (-DIAGONAL, -DIAGONAL), (0.0, -1.0), (DIAGONAL, -DIAGONAL),
)  # fmt: skip


@inlined
def extremes_of(mesh: SimplexMesh, a: int, b: int, c: int) -> Extremes:
    """The greatest and the least angle of a triangle between vertices of the mesh."""
    return extremes(at(mesh.points, a), at(mesh.points, b), at(mesh.points, c))


@kernel
def lack_of_cell(mesh: SimplexMesh, cell: int, wants: Wants) -> Lack:
    """What a triangle of the mesh lacks."""
    c = mesh.cells
    return added(NONE, extremes_of(mesh, c[cell, 0], c[cell, 1], c[cell, 2]), wants)


@kernel
def lack_of_star(n: int, p: Vec, wants: Wants, scratch: Scratch) -> tuple[Lack, float]:
    """What the triangles of a star lack with its point at p, and the sine of their least angle."""
    lack = NONE
    least = math.inf
    for i in range(n):
        angles = extremes(corner(scratch.star, 0, i), corner(scratch.star, 1, i), p)
        lack = added(lack, angles, wants)
        least = min(least, angles.least)
    return lack, least


@kernel
def simulate_placing(
    mesh: SimplexMesh, vertex: int, wants: Wants, scratch: Scratch
) -> RelocationPlan:
    """Look for where the triangles around a vertex lack least."""
    p = at(mesh.points, vertex)
    verdict, n, before = movable_ball(mesh, vertex, FREE, math.inf, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    load_star(mesh, scratch.ball, n, scratch)
    lack, sharpest = lack_of_star(n, p, wants, scratch)
    least = min(sharpest, wants.least)
    floor = max(FLAT, min(before, wants.q))
    size = longest_edge_at(mesh, scratch.ball, n, p)
    best = p
    worst = before
    step = FIRST_STEP
    while step > SHORTEST_STEP and lack.cost > 0.0:
        start = best
        moved = False
        for x, y in DIRECTIONS:
            q = rounded(mesh, Vec(start.x + step * size * x, start.y + step * size * y, start.z))
            there, sharpest = lack_of_star(n, q, wants, scratch)
            if sharpest >= least and is_less(there, lack):
                quality = measure_star(mesh, n, q, scratch)
                if quality >= floor:
                    best = q
                    worst = quality
                    lack = there
                    moved = True
        if not moved:
            step *= 0.5
    moved = best.x != p.x or best.y != p.y
    return RelocationPlan(APPLIED if moved else NOT_BETTER, n, best, worst)


@kernel
def place(mesh: SimplexMesh, vertex: int, wants: Wants, scratch: Scratch) -> bool:
    """Move a vertex to where the triangles around it lack least; whether it moved."""
    plan = simulate_placing(mesh, vertex, wants, scratch)
    if plan.verdict == APPLIED:
        apply_relocation(mesh, vertex, plan, scratch)
    return plan.verdict == APPLIED


@kernel
def turn(mesh: SimplexMesh, cell: int, local: int, wants: Wants, scratch: Scratch) -> bool:
    """Flip an edge of a triangle if the two lack less then; whether it was."""
    plan = simulate_flip(mesh, 4 * cell + local, VALID, 0.0)
    if plan.verdict != APPLIED:
        return False
    beyond = plan.other >> 2
    a = mesh.cells[cell, (local + 1) % 3]
    b = mesh.cells[cell, (local + 2) % 3]
    c = mesh.cells[cell, local]
    d = mesh.cells[beyond, plan.other & 3]
    one = extremes_of(mesh, a, b, c)
    other = extremes_of(mesh, b, a, d)
    new_one = extremes_of(mesh, a, d, c)
    new_other = extremes_of(mesh, d, b, c)
    before = added(added(NONE, one, wants), other, wants)
    after = added(added(NONE, new_one, wants), new_other, wants)
    floor = max(FLAT, min(mesh.quality[cell], mesh.quality[beyond], wants.q))
    if (
        not is_less(after, before)
        or min(new_one.least, new_other.least) < min(one.least, other.least, wants.least)
        or min(plan.q_one, plan.q_other) < floor
    ):
        return False
    apply_flip(mesh, plan, scratch)
    return True


@kernel
def ease(mesh: SimplexMesh, cell: int, wants: Wants, scratch: Scratch) -> bool:
    """Flip an edge of a triangle, or else move its vertices; whether anything changed."""
    for local in range(3):
        if turn(mesh, cell, local, wants, scratch):
            return True
    moved = False
    for local in range(3):
        moved = place(mesh, mesh.cells[cell, local], wants, scratch) or moved
    return moved


@entry(
    group="nonobtuse",
    example=lambda work: (work.mesh, work.order, Wants(0.0, 0.0, 0.0), work.scratch, work.counts),
)
def sweep_ease(
    mesh: SimplexMesh, order: np.ndarray, wants: Wants, scratch: Scratch, counts: np.ndarray
) -> int:
    """Ease each triangle in turn that lacks anything; see `swap.sweep_swap`. It needs no room."""
    for i in range(order.shape[0]):
        cell = order[i]
        if mesh.alive[cell] and lack_of_cell(mesh, cell, wants).cost > 0.0:
            counts[APPLIED if ease(mesh, cell, wants, scratch) else NOT_BETTER] += 1
    return order.shape[0]


@entry(group="nonobtuse", example=lambda work: (work.mesh, Wants(0.0, 0.0, 0.0), work.order))
def lacking(mesh: SimplexMesh, wants: Wants, out: np.ndarray) -> tuple[int, int]:
    """Find the triangles that are obtuse or sharp.

    Parameters
    ----------
    out : (n,) int64
        Receives their rows, ascending, as many as it holds.

    Returns
    -------
    n_obtuse : int
    n : int
        How many are obtuse, or sharp, or both.
    """
    n = 0
    n_obtuse = 0
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            lack = lack_of_cell(mesh, cell, wants)
            n_obtuse += lack.n_obtuse
            if lack.n_obtuse + lack.n_sharp > 0:
                if n < out.shape[0]:
                    out[n] = cell
                n += 1
    return n_obtuse, n
