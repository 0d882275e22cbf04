"""What is tried at a triangle of the search for Steiner points: vertices that come, move and go.

Places where angles are just right come from feet of altitudes, and from lines that are orthogonal
to edges in their ends (Figure 18.13); others are random.
"""

from __future__ import annotations

import math

from ...compiled.decorators import kernel
from ..vectors import Vec, at, distance, square_distance
from .change import insert, split_border, split_edge
from .net import (
    BEYOND,
    BORDER,
    FIXED_VERTEX,
    FREE_VERTEX,
    LINE,
    N_VERTICES,
    NO_BORDER,
    OWN,
    Goal,
    Net,
    below,
    gaussian,
    has_room,
    local_of,
    on_border,
    stored,
    uniform,
)
from .vertices import MOST_BALL, first_around, move, remove

FOOT = 1e-7  # cosine of the angle by which a foot may miss 90 degrees
FAR = 4.0  # times the longest edge: farther places are not tried
# How many of the tries begin in each way: by the foot of an altitude, the circumcentre, a random
# place, a right angle, a foot on a border; by a move to a random place, to a right angle, along a
# border; by a vertex that vanishes, or that does so and comes back elsewhere.
WAYS = (3, 1, 1, 2, 1, 3, 2, 1, 2, 1)


@kernel
def centre_of(net: Net, cell: int) -> Vec:
    """The centroid of a triangle."""
    a = at(net.points, net.cells[cell, 0])
    b = at(net.points, net.cells[cell, 1])
    c = at(net.points, net.cells[cell, 2])
    return Vec((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0, 0.0)


@kernel
def longest_edge(net: Net, cell: int) -> tuple[int, float]:
    """The longest edge of a triangle, by the vertex opposite, and its length."""
    longest = 0
    most = 0.0
    for i in range(3):
        a = at(net.points, net.cells[cell, (i + 1) % 3])
        b = at(net.points, net.cells[cell, (i + 2) % 3])
        length = square_distance(a, b)
        if length > most:
            most = length
            longest = i
    return longest, math.sqrt(most)


@kernel
def near(net: Net, cell: int) -> int:
    """A random cell among those around one, no border between them."""
    for _ in range(below(net, 4)):
        local = below(net, 3)
        if net.cells[cell, BORDER + local] == NO_BORDER and net.cells[cell, BEYOND + local] >= 0:
            cell = net.cells[cell, BEYOND + local] >> 2
    return cell


@kernel
def random_place(net: Net, cell: int, goal: Goal) -> Vec:
    """A random place in and around a triangle."""
    centre = centre_of(net, cell)
    _, size = longest_edge(net, cell)
    return stored(
        goal, centre.x + 0.4 * size * gaussian(net), centre.y + 0.4 * size * gaussian(net)
    )


@kernel
def right_place(net: Net, cell: int, goal: Goal) -> Vec:
    """Where two lines meet that are orthogonal to edges in their ends, or one and an edge.

    The triangle over such an edge has a right angle there. Not finite where there is none.
    """
    one = near(net, cell)
    two = near(net, cell)
    i = below(net, 3)
    j = below(net, 3)
    flipped = below(net, 4)
    u = at(net.points, net.cells[one, (i + 1 + (flipped & 1)) % 3])
    v = at(net.points, net.cells[one, (i + 2 - (flipped & 1)) % 3])
    w = at(net.points, net.cells[two, (j + 1 + (flipped >> 1)) % 3])
    x = at(net.points, net.cells[two, (j + 2 - (flipped >> 1)) % 3])
    nx = v.x - u.x
    ny = v.y - u.y
    mx = x.x - w.x
    my = x.y - w.y
    if below(net, 4) == 0:  # the line of the second edge itself
        mx, my = -my, mx
    across = nx * my - ny * mx
    if abs(across) < 1e-6 * math.sqrt((nx * nx + ny * ny) * (mx * mx + my * my)):
        return Vec(math.nan, math.nan, 0.0)
    t = (mx * (w.x - u.x) + my * (w.y - u.y)) / across
    p = stored(goal, u.x - t * ny, u.y + t * nx)
    _, size = longest_edge(net, cell)
    if square_distance(p, centre_of(net, cell)) > (FAR * size) ** 2:
        return Vec(math.nan, math.nan, 0.0)
    return p


@kernel
def circumcentre_of(net: Net, cell: int, goal: Goal) -> Vec:
    """The circumcentre of a triangle."""
    a = at(net.points, net.cells[cell, 0])
    b = at(net.points, net.cells[cell, 1])
    c = at(net.points, net.cells[cell, 2])
    bx = b.x - a.x
    by = b.y - a.y
    cx = c.x - a.x
    cy = c.y - a.y
    d = 2.0 * (bx * cy - by * cx)
    b2 = bx * bx + by * by
    c2 = cx * cx + cy * cy
    return stored(goal, a.x + (cy * b2 - by * c2) / d, a.y + (bx * c2 - cx * b2) / d)


@kernel
def move_with_feet(net: Net, vertex: int, p: Vec, goal: Goal) -> bool:
    """Put a vertex elsewhere, and with it its feet on borders; whether that could be."""
    before = at(net.points, vertex)
    start = first_around(net, vertex)
    if start < 0 or not move(net, vertex, p):
        return False
    if net.vertices[vertex, LINE] != FREE_VERTEX:
        return True
    cell = start
    for _ in range(MOST_BALL):
        i = local_of(net, cell, vertex)
        foot = net.cells[cell, (i + 1) % 3]
        line = net.vertices[foot, LINE]
        if line >= 0:
            f = at(net.points, foot)
            a = at(net.points, net.borders[line, 0])
            b = at(net.points, net.borders[line, 1])
            off = (before.x - f.x) * (b.x - a.x) + (before.y - f.y) * (b.y - a.y)
            is_foot = abs(off) <= FOOT * distance(before, f) * distance(a, b)
            if is_foot and not move(net, foot, on_border(net, line, p, goal)):
                return False
        cell = net.cells[cell, BEYOND + (i + 1) % 3] >> 2
        if cell == start:
            return True
    return False


@kernel
def split_foot(net: Net, handle: int, p: Vec, goal: Goal) -> bool:
    """Split an edge in the foot of a place over it; whether that could be."""
    cell = handle >> 2
    local = handle & 3
    if net.cells[cell, BORDER + local] != NO_BORDER:
        return split_border(net, handle, p, goal) >= 0
    a = at(net.points, net.cells[cell, (local + 1) % 3])
    b = at(net.points, net.cells[cell, (local + 2) % 3])
    dx = b.x - a.x
    dy = b.y - a.y
    t = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy)
    if t < 1e-3 or t > 1.0 - 1e-3:
        return False
    split_edge(net, handle, stored(goal, a.x + t * dx, a.y + t * dy))
    return True


@kernel
def move_one(net: Net, cell: int, way: int, goal: Goal) -> bool:
    """Move a random vertex of a triangle; whether that could be.

    Parameters
    ----------
    way : int
        5 to a random place, 6 to a right angle, 7 to the foot of another vertex around.
    """
    vertex = net.cells[cell, below(net, 3)]
    line = net.vertices[vertex, LINE]
    if line == FIXED_VERTEX:
        return False
    p = at(net.points, vertex)
    if way == 5:
        _, size = longest_edge(net, cell)
        size *= 0.5 * math.pow(10.0, -2.0 * uniform(net))
        p = stored(goal, p.x + size * gaussian(net), p.y + size * gaussian(net))
    elif way == 6:
        p = right_place(net, cell, goal)
    else:
        p = at(net.points, net.cells[near(net, net.vertices[vertex, 1]), below(net, 3)])
        if line == FREE_VERTEX:
            return False
    if not math.isfinite(p.x):
        return False
    if line >= 0:
        p = on_border(net, line, p, goal)
    return move_with_feet(net, vertex, p, goal)


@kernel
def remove_one(net: Net, cell: int) -> bool:
    """Take a random vertex of a triangle away; whether that could be."""
    vertex = net.cells[cell, below(net, 3)]
    if net.vertices[vertex, LINE] == FIXED_VERTEX or net.vertices[vertex, OWN] == 1:
        return False
    return remove(net, vertex)


@kernel
def propose(net: Net, cell: int, goal: Goal) -> bool:
    """Try something random at a triangle; whether it could be done. Edges are as they come."""
    if not has_room(net):
        return False
    pick = below(net, 17)
    way = 0
    while pick >= WAYS[way]:
        pick -= WAYS[way]
        way += 1
    if way in (5, 6, 7):
        return move_one(net, cell, way, goal)
    if way == 8:
        return remove_one(net, cell)
    if way < 5 and net.state[N_VERTICES] >= goal.most:
        return False
    if way == 0:
        local, _ = longest_edge(net, cell)
        return split_foot(net, 4 * cell + local, at(net.points, net.cells[cell, local]), goal)
    if way == 4:
        cell = near(net, cell)
        local = below(net, 3)
        if net.cells[cell, BORDER + local] == NO_BORDER:
            return False
        p = at(net.points, net.cells[cell, local])
        return split_border(net, 4 * cell + local, p, goal) >= 0
    p = circumcentre_of(net, cell, goal)
    if way != 1:
        p = right_place(net, cell, goal) if uniform(net) < 0.5 else random_place(net, cell, goal)
    if not math.isfinite(p.x):
        return False
    if way == 9:
        # A cell that stays: the one beyond may not be there any more.
        vertex = net.cells[cell, below(net, 3)]
        if net.vertices[vertex, LINE] == FIXED_VERTEX or net.vertices[vertex, OWN] == 1:
            return False
        other = net.cells[cell, (local_of(net, cell, vertex) + 1) % 3]
        if not remove(net, vertex) or not has_room(net):
            return False
        cell = net.vertices[other, 1]
    return insert(net, cell, p, goal) >= 0
