"""Node relocation (18.4.1) in a mesh of any cells: see `relocate` for what the methods are.

The worst q of a vertex is that of its corners in space, and of its cells in the plane.
"""

from __future__ import annotations

import math

import numpy as np

from ...cells import TET_FACETS
from ...compiled.decorators import entry, inlined, kernel
from ..accept import gained
from ..gather.ball import next_stamp, worst_of
from ..gather.rows import (
    gather_rows,
    load_rows,
    longest_from,
    touch_row,
    vertex_of,
)
from ..gather.star import measure_star
from ..guide import guide_of, guided, held, led, limited
from ..shape.ideal import tet_ideal_height, tet_ideal_point
from ..types import (
    APPLIED,
    FACES,
    FIXED,
    NOT_BETTER,
    TOO_LARGE,
    CellMesh,
    Scratch,
)
from ..vectors import (
    Vec,
    along,
    at,
    cross,
    distance,
    minus,
    norm,
    set_point,
    square_distance,
)
from .climb import RelocationPlan, climb_star
from .descend import descend_star
from .relocate import (
    DEGRADATION2,
    DESCENT,
    LIMITS,
    MAX_WEIGHT,
    OPTIMIZE,
    QUALITY,
    STILL,
    UNIFORM,
    WEIGHTED,
    WORST,
    Relocation,
    go_toward,
)


@inlined
def is_neighbour(mesh: CellMesh, row: int, local: int, k: int) -> bool:
    """Whether an edge of the cell joins the vertices `local` and k of a row.

    The edges of a row of space go out from its first vertex; those of a tetrahedron, which is a
    row as it is, from all.
    """
    if k == local:
        return False
    if mesh.judge.form == FACES:
        return mesh.fourth[row] < 0 or (k - local) % 2 != 0
    return local == 0 or k == 0 or mesh.shape[row] == 0


@kernel
def mean_around(mesh: CellMesh, vertex: int, n: int, weighted: bool, scratch: Scratch) -> Vec:
    """Mean of the neighbours of a vertex (18.21), weighted by their distance for (18.23)."""
    stamp = next_stamp(scratch)
    p = at(mesh.points, vertex)
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    for i in range(n):
        row = scratch.ball[i] >> 2
        local = scratch.ball[i] & 3
        width = mesh.cells.shape[1] + (1 if mesh.fourth[row] >= 0 else 0)
        for k in range(width):
            v = vertex_of(mesh, row, k)
            if is_neighbour(mesh, row, local, k) and scratch.vertex_mark[v] != stamp:
                scratch.vertex_mark[v] = stamp
                q = at(mesh.points, v)
                w = distance(p, q) if weighted else 1.0
                total += w
                x += w * q.x
                y += w * q.y
                z += w * q.z
    return Vec(x / total, y / total, z / total) if total > 0.0 else p


@inlined
def upon_edge(a: Vec, b: Vec, height: float) -> Vec:
    """The point over the middle of an edge of the plane, so many of its lengths to its left."""
    return Vec(
        0.5 * (a.x + b.x) - height * (b.y - a.y), 0.5 * (a.y + b.y) + height * (b.x - a.x), 0.0
    )


@kernel
def ideal_corner(mesh: CellMesh, i: int, scratch: Scratch) -> tuple[Vec, bool]:
    """Where the vertex of the i-th row of the ball makes its corner ideal, and whether it has one.

    A triangle is to be equilateral, the corner of a quad to be half a square on the diagonal
    (unit edges, sqrt(2) diagonals). In space the corner of a cell that is no tetrahedron is over
    the middle of its three neighbours, as high as their triangle is large.
    """
    row = scratch.ball[i] >> 2
    local = scratch.ball[i] & 3
    star = scratch.star
    if mesh.judge.form == FACES:
        a = Vec(star[0, i], star[1, i], 0.0)
        b = Vec(star[3, i], star[4, i], 0.0)
        return upon_edge(a, b, 0.5 if mesh.fourth[row] >= 0 else 0.5 * math.sqrt(3.0)), True
    if local != 0 and mesh.shape[row] != 0:
        return Vec(0.0, 0.0, 0.0), False
    # Turned so that the vertex is above the other three.
    a = at(mesh.points, mesh.cells[row, TET_FACETS[local, 0]])
    b = at(mesh.points, mesh.cells[row, TET_FACETS[local, 1]])
    c = at(mesh.points, mesh.cells[row, TET_FACETS[local, 2]])
    if mesh.shape[row] == 0:
        return tet_ideal_point(a, b, c, tet_ideal_height(a, b, c)), True
    normal = cross(minus(b, a), minus(c, a))
    middle = Vec((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0, (a.z + b.z + c.z) / 3.0)
    length = norm(normal)
    if length == 0.0:
        return middle, True
    return along(middle, normal, mesh.stretch[mesh.shape[row], 3, 0] / math.sqrt(length)), True


@kernel
def mean_of_ideals(mesh: CellMesh, vertex: int, n: int, weight: int, scratch: Scratch) -> Vec:
    """Weighted mean of the ideal points of the corners (18.24)."""
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    worst = worst_of(mesh, scratch.ball, n)
    for i in range(n):
        ideal, there = ideal_corner(mesh, i, scratch)
        q = mesh.quality[scratch.ball[i] >> 2]
        if not there or (weight == WORST and q > worst):
            continue
        w = 1.0
        if weight not in (UNIFORM, WORST):
            w = min(1.0 / q, MAX_WEIGHT) if q > 0.0 else MAX_WEIGHT
            if weight == DEGRADATION2:
                w *= w
        total += w
        x += w * ideal.x
        y += w * ideal.y
        z += w * ideal.z
    return Vec(x / total, y / total, z / total) if total > 0.0 else at(mesh.points, vertex)


@kernel
def simulate_place(
    mesh: CellMesh, vertex: int, how: Relocation, scratch: Scratch
) -> RelocationPlan:
    """Look for a better position of a vertex among its cells."""
    p = at(mesh.points, vertex)
    guide = guide_of(mesh, vertex)
    if mesh.fixed[vertex] and guide.kind == 0.0:
        return RelocationPlan(FIXED, 0, p, 0.0)
    n = gather_rows(mesh, vertex, scratch)
    if n < 0:
        return RelocationPlan(TOO_LARGE, 0, p, 0.0)
    before = worst_of(mesh, scratch.ball, n)
    if n == 0 or before >= how.below:
        return RelocationPlan(NOT_BETTER, n, p, before)
    load_rows(mesh, n, scratch)
    size = longest_from(mesh, n, p, scratch)
    if how.method == OPTIMIZE:
        q, worst = climb_star(mesh, n, p, size, guide, scratch)
        return RelocationPlan(APPLIED if worst > gained(before) else NOT_BETTER, n, q, worst)
    if how.method == DESCENT:
        q, worst = descend_star(mesh, n, p, size, guide, how.rule, how.floor, before, scratch)
        moved = square_distance(p, q) > 0.0
        return RelocationPlan(APPLIED if moved else NOT_BETTER, n, q, worst)
    if how.method == LIMITS:
        goal = limited(mesh.limits, guide, p, led(mesh.limits, guide, p))
    elif how.method == QUALITY:
        goal = mean_of_ideals(mesh, vertex, n, how.weight, scratch)
    else:
        goal = mean_around(mesh, vertex, n, how.method == WEIGHTED, scratch)
    if guide.kind > 0.0 and how.method != LIMITS:
        goal = held(mesh, guide, p, along(p, guided(guide, minus(goal, p)), 1.0))
    if square_distance(p, goal) <= STILL * size * size:
        return RelocationPlan(NOT_BETTER, n, p, before)
    return go_toward(mesh, n, p, goal, how.relaxation, how.rule, how.floor, before, scratch)


@entry(
    group="cells",
    example=lambda work: (
        work.cell_mesh, work.order, Relocation(0, 0, 0.0, 0, 0.0, 0.0), work.scratch, work.counts,
    ),
)  # fmt: skip
def sweep_places(
    mesh: CellMesh, order: np.ndarray, how: Relocation, scratch: Scratch, counts: np.ndarray
) -> int:
    """Try each vertex in turn; see `relocate.sweep_relocation`."""
    for i in range(order.shape[0]):
        vertex = order[i]
        plan = simulate_place(mesh, vertex, how, scratch)
        counts[plan.verdict] += 1
        if plan.verdict == APPLIED:
            set_point(mesh.points, vertex, plan.position)
            measure_star(mesh, plan.n, plan.position, scratch)
            for k in range(plan.n):
                row = scratch.ball[k] >> 2
                mesh.quality[row] = scratch.values[k]
                touch_row(mesh, row)
    return order.shape[0]


@entry(
    group="cells",
    example=lambda work: (work.cell_mesh, work.scratch, work.cell_mesh.quality),
)
def measure_rows(mesh: CellMesh, scratch: Scratch, out: np.ndarray) -> None:
    """q of each row, written to `out`, (nr,) float64."""
    for row in range(mesh.cells.shape[0]):
        scratch.ball[0] = 4 * row
        load_rows(mesh, 1, scratch)
        out[row] = measure_star(mesh, 1, at(mesh.points, mesh.cells[row, 0]), scratch)
