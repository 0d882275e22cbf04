"""Self-centered tets (18.4.3): the tets around a vertex, or an edge, come to contain their
circumcentres.

A tet lacks what the least of the heights of its circumcentre over its faces is short of a margin,
in circumradii. The sum of it leads vertices on where no tet changes sides yet: VanderZee, Hirani,
Guoy and Ramos (2010) go down on powers of the same heights.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...cells import TET_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import FLAT
from ..cavity import has_room
from ..gather.ball import longest_edge_at
from ..gather.shell import gather_shell_of, is_required
from ..gather.star import corner, load_star, measure_star
from ..guide import guide_of, guided, held
from ..judge import q_of_row, q_of_tet
from ..shape.obtuse import centring
from ..types import APPLIED, MAX_SHELL, N_CELLS, NOT_BETTER, Scratch, SimplexMesh
from ..vectors import Vec, along, at, norm
from .climb import RelocationPlan, apply_relocation, movable_ball
from .ring import collect_ring, put
from .swap import SwapPlan, apply_swap, around

MARGIN = 0.05  # height of a circumcentre, in circumradii, from which on a tet lacks nothing
WIDTH = 0.4  # so much below the margin it lacks all
WEIGHT = 0.5  # of what a tet lacks, beside 1 where it is not self-centered
MAX_RING = 10  # edges with more tets around are left
MAX_STEPS = 6
N_HALVINGS = 7
FIRST_STEP = 0.25  # of the longest edge at a vertex
PROBE = 1e-5  # of it, for differences
LEAST_GAIN = 1e-4


class Lack(NamedTuple):
    """What some tets are short of."""

    n_off: int  # tets that are not self-centered
    cost: float  # their number, and what is missing besides


@inlined
def shortfall(a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[int, float]:
    """Whether a tet is not self-centered, 1 or 0, and what it lacks, from 0 to 1."""
    found = centring(a, b, c, d)
    short = min(1.0, max(0.0, (MARGIN - found.least) / WIDTH))
    return (0 if found.is_centred else 1), short


@inlined
def with_tet(lack: Lack, a: Vec, b: Vec, c: Vec, d: Vec) -> Lack:
    """The same with one tet more."""
    off, short = shortfall(a, b, c, d)
    return Lack(lack.n_off + off, lack.cost + off + WEIGHT * short)


@inlined
def is_less(one: Lack, other: Lack) -> bool:
    """Whether tets lack less than others did, of which no more are not self-centered."""
    return one.n_off <= other.n_off and one.cost < other.cost - LEAST_GAIN


@kernel
def lack_of_star(n: int, p: Vec, scratch: Scratch) -> Lack:
    """What the tets of a star lack with their vertex at p."""
    lack = Lack(0, 0.0)
    star = scratch.star
    for i in range(n):
        lack = with_tet(lack, corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p)
    return lack


@kernel
def short_of_star(n: int, p: Vec, scratch: Scratch) -> float:
    """The part of it that has a slope."""
    total = 0.0
    star = scratch.star
    for i in range(n):
        _, short = shortfall(corner(star, 0, i), corner(star, 1, i), corner(star, 2, i), p)
        total += short
    return total


@kernel
def simulate_centring(
    mesh: SimplexMesh, vertex: int, least: float, scratch: Scratch
) -> RelocationPlan:
    """Look for a place where the tets around a vertex lack less, downhill by differences.

    Parameters
    ----------
    least : float
        No tet comes to have less q, where none had.
    """
    p = at(mesh.points, vertex)
    guide = guide_of(mesh, vertex)
    verdict, n, before = movable_ball(mesh, vertex, guide, math.inf, scratch)
    if verdict != APPLIED:
        return RelocationPlan(verdict, n, p, before)
    load_star(mesh, scratch.ball, n, scratch)
    lack = lack_of_star(n, p, scratch)
    floor = max(FLAT, min(before, least))
    size = longest_edge_at(mesh, scratch.ball, n, p)
    h = PROBE * size
    best = p
    worst = before
    step = FIRST_STEP * size
    for _ in range(MAX_STEPS):
        value = short_of_star(n, best, scratch)
        if value == 0.0:
            break
        slope = Vec(
            value - short_of_star(n, Vec(best.x + h, best.y, best.z), scratch),
            value - short_of_star(n, Vec(best.x, best.y + h, best.z), scratch),
            value - short_of_star(n, Vec(best.x, best.y, best.z + h), scratch),
        )
        d = guided(guide, slope)
        length = norm(d)
        if length == 0.0:
            break
        moved = False
        for _ in range(N_HALVINGS):
            q = held(mesh, guide, best, along(best, d, step / length))
            there = lack_of_star(n, q, scratch)
            if is_less(there, lack):
                quality = measure_star(mesh, n, q, scratch)
                if quality >= floor:
                    best = q
                    worst = quality
                    lack = there
                    moved = True
                    break
            step *= 0.5
        if not moved:
            break
        step *= 1.5
    is_there = best.x == p.x and best.y == p.y and best.z == p.z
    return RelocationPlan(NOT_BETTER if is_there else APPLIED, n, best, worst)


@kernel
def lack_of_row(mesh: SimplexMesh, rows: np.ndarray, i: int, lack: Lack) -> Lack:
    """With a tet of some rows of vertices more."""
    p = mesh.points
    return with_tet(
        lack, at(p, rows[i, 0]), at(p, rows[i, 1]), at(p, rows[i, 2]), at(p, rows[i, 3])
    )


@kernel
def cost_of(mesh: SimplexMesh, a: int, b: int, c: int, d: int) -> float:
    """The cost of one tet by its vertices."""
    p = mesh.points
    return with_tet(Lack(0, 0.0), at(p, a), at(p, b), at(p, c), at(p, d)).cost


@kernel
def lack_of_shell(mesh: SimplexMesh, n: int, scratch: Scratch) -> tuple[Lack, float]:
    """What the tets of `scratch.shell` lack, and their worst q."""
    lack = Lack(0, 0.0)
    worst = math.inf
    for i in range(n):
        lack = lack_of_row(mesh, mesh.cells, scratch.shell[i], lack)
        worst = min(worst, mesh.quality[scratch.shell[i]])
    return lack, worst


@kernel
def lack_of_created(mesh: SimplexMesh, n: int, scratch: Scratch) -> Lack:
    """What those of `scratch.created` lack."""
    lack = Lack(0, 0.0)
    for i in range(n):
        lack = lack_of_row(mesh, scratch.created, i, lack)
    return lack


@kernel
def triangulate_for_least(
    mesh: SimplexMesh, a: int, b: int, n: int, floor: float, scratch: Scratch
) -> float:
    """As `ring.triangulate_ring`, by the sum of the costs, where no tet has less q than a floor."""
    ring = scratch.ring
    table = scratch.table
    split = scratch.split
    for i in range(n - 1):
        table[i, i + 1] = 0.0
    for width in range(2, n):
        for i in range(n - width):
            j = i + width
            best = math.inf
            best_k = -1
            for k in range(i + 1, j):
                cost = table[i, k] + table[k, j]
                if (
                    cost >= best
                    or q_of_tet(mesh, ring[i], ring[k], ring[j], b) < floor
                    or q_of_tet(mesh, ring[i], ring[j], ring[k], a) < floor
                ):
                    continue
                cost += cost_of(mesh, ring[i], ring[k], ring[j], b)
                cost += cost_of(mesh, ring[i], ring[j], ring[k], a)
                if cost < best:
                    best = cost
                    best_k = k
            table[i, j] = best
            split[i, j] = best_k
    return table[0, n - 1]


@kernel
def remove_edge(mesh: SimplexMesh, cell: int, edge: int, least: float, scratch: Scratch) -> bool:
    """Replace the tets around an edge by others without it, where these lack less."""
    cell, a, b, c, d = around(mesh, 8 * cell + edge)
    n = gather_shell_of(mesh, cell, a, b, c, d, scratch)
    if n < 3 or n > MAX_RING or is_required(mesh, a, b):
        return False
    before, worst = lack_of_shell(mesh, n, scratch)
    floor = max(FLAT, min(worst, least))
    if triangulate_for_least(mesh, a, b, n, floor, scratch) >= before.cost - LEAST_GAIN:
        return False
    n_new = collect_ring(a, b, n, scratch)
    if not is_less(lack_of_created(mesh, n_new, scratch), before):
        return False
    apply_swap(mesh, SwapPlan(APPLIED, n, n_new, 0.0), scratch)
    return True


@kernel
def remove_face(mesh: SimplexMesh, cell: int, local: int, least: float, scratch: Scratch) -> bool:
    """Replace the two tets at a face by three around an edge, where these lack less."""
    beyond = mesh.neighbours[cell, local]
    if beyond < 0:
        return False
    a = mesh.cells[cell, TET_FACETS[local, 0]]
    b = mesh.cells[cell, TET_FACETS[local, 1]]
    c = mesh.cells[cell, TET_FACETS[local, 2]]
    d = mesh.cells[cell, local]
    e = mesh.cells[beyond >> 2, beyond & 3]
    scratch.shell[0] = cell
    scratch.shell[1] = beyond >> 2
    before, worst = lack_of_shell(mesh, 2, scratch)
    floor = max(FLAT, min(worst, least))
    put(scratch.created, 0, e, a, b, d)
    put(scratch.created, 1, e, b, c, d)
    put(scratch.created, 2, e, c, a, d)
    for i in range(3):
        if q_of_row(mesh, scratch.created, i) < floor:
            return False
    if not is_less(lack_of_created(mesh, 3, scratch), before):
        return False
    apply_swap(mesh, SwapPlan(APPLIED, 2, 3, 0.0), scratch)
    return True


@kernel
def centre_cell(mesh: SimplexMesh, cell: int, least: float, scratch: Scratch) -> bool:
    """Swap an edge or a face of a tet, or else move its vertices."""
    for edge in range(6):
        if remove_edge(mesh, cell, edge, least, scratch):
            return True
    for local in range(4):
        if remove_face(mesh, cell, local, least, scratch):
            return True
    moved = False
    for local in range(4):
        vertex = mesh.cells[cell, local]
        plan = simulate_centring(mesh, vertex, least, scratch)
        if plan.verdict == APPLIED:
            apply_relocation(mesh, vertex, plan, scratch)
            moved = True
    return moved


@entry(
    group="nonobtuse",
    example=lambda work: (work.mesh, work.order, 0.0, work.scratch, work.counts),
)
def sweep_centre(
    mesh: SimplexMesh, order: np.ndarray, least: float, scratch: Scratch, counts: np.ndarray
) -> int:
    """Let tets come to be self-centered.

    Parameters
    ----------
    order : (n,) int64
        Tets to visit.
    least : float
        No tet comes to have less q, where none had.

    Returns
    -------
    done : int
        How many were visited; fewer than all where there is no room for cells.
    """
    for i in range(order.shape[0]):
        cell = order[i]
        if not mesh.alive[cell]:
            continue
        if not has_room(mesh, MAX_SHELL):
            return i
        counts[APPLIED if centre_cell(mesh, cell, least, scratch) else NOT_BETTER] += 1
    return order.shape[0]


@entry(group="nonobtuse", example=lambda work: (work.mesh, work.order))
def not_centred(mesh: SimplexMesh, out: np.ndarray) -> tuple[int, int]:
    """Tets that lack something.

    Parameters
    ----------
    out : (n,) int64
        Gets the rows of as many of them as it has room for.

    Returns
    -------
    n_off, n : int
        How many are not self-centered, and how many lack something.
    """
    n = 0
    n_off = 0
    for cell in range(mesh.state[N_CELLS]):
        if mesh.alive[cell]:
            lack = lack_of_row(mesh, mesh.cells, cell, Lack(0, 0.0))
            n_off += lack.n_off
            if lack.cost > 0.0:
                if n < out.shape[0]:
                    out[n] = cell
                n += 1
    return n_off, n
