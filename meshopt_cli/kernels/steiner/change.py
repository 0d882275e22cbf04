"""Changes of a triangulation: flips, vertices that come, and Delaunay's edges.

A triangulation without obtuse angles is Delaunay's, constrained by its borders: so edges follow
from vertices, up to vertices on one circle, where what is obtuse decides.
"""

from __future__ import annotations

import math

from ...compiled.decorators import inlined, kernel
from ..shape.lack import RIGHT, extremes
from ..vectors import Vec, at, minus, norm
from .net import (
    ALIVE,
    BEYOND,
    BORDER,
    FREE_VERTEX,
    N_LOG,
    NO_BORDER,
    REGION,
    Goal,
    Net,
    has_room,
    new_cell,
    new_vertex,
    on_border,
    set_corners,
    set_edge,
    touch,
    turn_of,
)

COCIRCULAR = 1e-9  # sine of the angle by which two opposite ones may miss 180 degrees
MOST_STEPS = 64  # of a walk
NEAR = 1e-6  # part of an edge: what is nearer to it lies on it


@kernel
def flip(net: Net, handle: int) -> None:
    """Replace the edge between two triangles by the other diagonal."""
    t = handle >> 2
    i = handle & 3
    other = net.cells[t, BEYOND + i]
    u = other >> 2
    j = other & 3
    c = net.cells[t, i]
    a = net.cells[t, (i + 1) % 3]
    b = net.cells[t, (i + 2) % 3]
    d = net.cells[u, j]
    over_bc = net.cells[t, BEYOND + (i + 1) % 3]
    over_ca = net.cells[t, BEYOND + (i + 2) % 3]
    over_ad = net.cells[u, BEYOND + (j + 1) % 3]
    over_db = net.cells[u, BEYOND + (j + 2) % 3]
    on_bc = net.cells[t, BORDER + (i + 1) % 3]
    on_ca = net.cells[t, BORDER + (i + 2) % 3]
    on_ad = net.cells[u, BORDER + (j + 1) % 3]
    on_db = net.cells[u, BORDER + (j + 2) % 3]
    touch(net, t)
    touch(net, u)
    set_corners(net, t, c, a, d)
    set_corners(net, u, d, b, c)
    set_edge(net, t, 0, over_ad, on_ad)
    set_edge(net, t, 2, over_ca, on_ca)
    set_edge(net, u, 0, over_bc, on_bc)
    set_edge(net, u, 2, over_db, on_db)
    set_edge(net, t, 1, 4 * u + 1, NO_BORDER)
    set_edge(net, u, 1, 4 * t + 1, NO_BORDER)


@inlined
def is_inner(net: Net, handle: int) -> bool:
    """Whether an edge has a triangle on either side, and is no border."""
    t = handle >> 2
    i = handle & 3
    return net.cells[t, BEYOND + i] >= 0 and net.cells[t, BORDER + i] == NO_BORDER


@inlined
def diamond(net: Net, handle: int) -> tuple[Vec, Vec, Vec, Vec]:
    """The corner c across from an inner edge a b, its ends, and the corner d beyond it."""
    t = handle >> 2
    i = handle & 3
    other = net.cells[t, BEYOND + i]
    return (
        at(net.points, net.cells[t, i]),
        at(net.points, net.cells[t, (i + 1) % 3]),
        at(net.points, net.cells[t, (i + 2) % 3]),
        at(net.points, net.cells[other >> 2, other & 3]),
    )


@kernel
def can_flip(net: Net, handle: int) -> bool:
    """Whether an edge is no border, and both triangles are positive after its flip."""
    if not is_inner(net, handle):
        return False
    c, a, b, d = diamond(net, handle)
    size = norm(minus(a, b)) * norm(minus(c, d)) * 1e-9
    return turn_of(c, a, d) > size and turn_of(d, b, c) > size


@kernel
def wants_flip(net: Net, handle: int) -> bool:
    """Whether an edge is not Delaunay's, or fewer triangles are obtuse without it."""
    if not is_inner(net, handle):
        return False
    c, a, b, d = diamond(net, handle)
    sin_c = turn_of(c, a, b)
    cos_c = (a.x - c.x) * (b.x - c.x) + (a.y - c.y) * (b.y - c.y)
    sin_d = turn_of(d, b, a)
    cos_d = (a.x - d.x) * (b.x - d.x) + (a.y - d.y) * (b.y - d.y)
    both = sin_c * cos_d + cos_c * sin_d
    size = math.sqrt((sin_c * sin_c + cos_c * cos_c) * (sin_d * sin_d + cos_d * cos_d))
    if both > COCIRCULAR * size:
        return False
    if both >= -COCIRCULAR * size:
        n_now = int(extremes(c, a, b).greatest < RIGHT)
        n_now += extremes(d, b, a).greatest < RIGHT
        n_then = int(extremes(c, a, d).greatest < RIGHT)
        n_then += extremes(d, b, c).greatest < RIGHT
        return n_then < n_now and can_flip(net, handle)
    return can_flip(net, handle)


@kernel
def legalize(net: Net) -> None:
    """Flip what wants it among the edges of all cells in the log, until none does."""
    i = 0
    while i < net.state[N_LOG] and has_room(net):
        cell = net.log[i, 0]
        if net.cells[cell, ALIVE] == 1:
            for local in range(3):
                if wants_flip(net, 4 * cell + local):
                    flip(net, 4 * cell + local)
                    break
        i += 1


@kernel
def split_edge(net: Net, handle: int, p: Vec) -> int:
    """Put a new vertex on an edge, borders included; returns it."""
    t = handle >> 2
    i = handle & 3
    other = net.cells[t, BEYOND + i]
    border = net.cells[t, BORDER + i]
    c = net.cells[t, i]
    a = net.cells[t, (i + 1) % 3]
    b = net.cells[t, (i + 2) % 3]
    over_bc = net.cells[t, BEYOND + (i + 1) % 3]
    over_ca = net.cells[t, BEYOND + (i + 2) % 3]
    on_bc = net.cells[t, BORDER + (i + 1) % 3]
    on_ca = net.cells[t, BORDER + (i + 2) % 3]
    line = FREE_VERTEX if border == NO_BORDER else border
    touch(net, t)
    t2 = new_cell(net)
    net.cells[t2, REGION] = net.cells[t, REGION]
    new = new_vertex(net, p, line, t)
    set_corners(net, t, c, a, new)
    set_corners(net, t2, c, new, b)
    set_edge(net, t, 2, over_ca, on_ca)
    set_edge(net, t2, 1, over_bc, on_bc)
    set_edge(net, t, 1, 4 * t2 + 2, NO_BORDER)
    set_edge(net, t2, 2, 4 * t + 1, NO_BORDER)
    if other < 0:
        set_edge(net, t, 0, other, border)
        set_edge(net, t2, 0, other, border)
        return new
    u = other >> 2
    j = other & 3
    d = net.cells[u, j]
    over_ad = net.cells[u, BEYOND + (j + 1) % 3]
    over_db = net.cells[u, BEYOND + (j + 2) % 3]
    on_ad = net.cells[u, BORDER + (j + 1) % 3]
    on_db = net.cells[u, BORDER + (j + 2) % 3]
    touch(net, u)
    u2 = new_cell(net)
    net.cells[u2, REGION] = net.cells[u, REGION]
    set_corners(net, u, d, new, a)
    set_corners(net, u2, d, b, new)
    set_edge(net, u, 1, over_ad, on_ad)
    set_edge(net, u2, 2, over_db, on_db)
    set_edge(net, u, 2, 4 * u2 + 1, NO_BORDER)
    set_edge(net, u2, 1, 4 * u + 2, NO_BORDER)
    set_edge(net, t, 0, 4 * u, border)
    set_edge(net, u, 0, 4 * t, border)
    set_edge(net, t2, 0, 4 * u2, border)
    set_edge(net, u2, 0, 4 * t2, border)
    return new


@kernel
def split_triangle(net: Net, t0: int, p: Vec) -> int:
    """Put a new vertex into a triangle; returns it."""
    a = net.cells[t0, 0]
    b = net.cells[t0, 1]
    c = net.cells[t0, 2]
    over_b = net.cells[t0, BEYOND + 1]
    over_c = net.cells[t0, BEYOND + 2]
    on_b = net.cells[t0, BORDER + 1]
    on_c = net.cells[t0, BORDER + 2]
    touch(net, t0)
    t1 = new_cell(net)
    t2 = new_cell(net)
    net.cells[t1, REGION] = net.cells[t0, REGION]
    net.cells[t2, REGION] = net.cells[t0, REGION]
    new = new_vertex(net, p, FREE_VERTEX, t0)
    set_corners(net, t0, new, b, c)
    set_corners(net, t1, new, c, a)
    set_corners(net, t2, new, a, b)
    set_edge(net, t1, 0, over_b, on_b)
    set_edge(net, t2, 0, over_c, on_c)
    set_edge(net, t0, 1, 4 * t1 + 2, NO_BORDER)
    set_edge(net, t1, 2, 4 * t0 + 1, NO_BORDER)
    set_edge(net, t1, 1, 4 * t2 + 2, NO_BORDER)
    set_edge(net, t2, 2, 4 * t1 + 1, NO_BORDER)
    set_edge(net, t2, 1, 4 * t0 + 2, NO_BORDER)
    set_edge(net, t0, 2, 4 * t2 + 1, NO_BORDER)
    return new


@kernel
def split_border(net: Net, handle: int, p: Vec, goal: Goal) -> int:
    """Put a new vertex on a border, as near to a place as can be; -1 where it cannot be."""
    cell = handle >> 2
    local = handle & 3
    border = net.cells[cell, BORDER + local]
    if net.borders[border, 2] == 0:
        return -1
    a = at(net.points, net.cells[cell, (local + 1) % 3])
    b = at(net.points, net.cells[cell, (local + 2) % 3])
    q = on_border(net, border, p, goal)
    along = (q.x - a.x) * (b.x - a.x) + (q.y - a.y) * (b.y - a.y)
    whole = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y)
    if along < NEAR * whole or along > (1.0 - NEAR) * whole:
        return -1
    return split_edge(net, handle, q)


@kernel
def insert(net: Net, start: int, p: Vec, goal: Goal) -> int:
    """Put a new vertex in a place that is seen from a triangle, or on the border before it.

    Returns
    -------
    vertex : int
        -1 where it cannot be.
    """
    cell = start
    for _ in range(MOST_STEPS):
        way = -1
        on = -1
        for local in range(3):
            a = at(net.points, net.cells[cell, (local + 1) % 3])
            b = at(net.points, net.cells[cell, (local + 2) % 3])
            turn = turn_of(a, b, p)
            near = NEAR * ((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y))
            if turn < -near:
                way = local
            elif turn <= near:
                on = local
        if way < 0:
            if on < 0:
                return split_triangle(net, cell, p)
            if net.cells[cell, BORDER + on] != NO_BORDER:
                return split_border(net, 4 * cell + on, p, goal)
            a = at(net.points, net.cells[cell, (on + 1) % 3])
            b = at(net.points, net.cells[cell, (on + 2) % 3])
            if (p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y) <= 0.0 or (p.x - b.x) * (
                a.x - b.x
            ) + (p.y - b.y) * (a.y - b.y) <= 0.0:
                return -1
            return split_edge(net, 4 * cell + on, p)
        if net.cells[cell, BORDER + way] != NO_BORDER:
            return split_border(net, 4 * cell + way, p, goal)
        cell = net.cells[cell, BEYOND + way] >> 2
    return -1
