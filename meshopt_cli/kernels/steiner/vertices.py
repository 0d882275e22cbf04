"""Changes of a triangulation: vertices that go or move."""

from __future__ import annotations

from ...compiled.decorators import kernel
from ..vectors import Vec, at, set_point
from .change import can_flip, flip
from .net import (
    BEYOND,
    BORDER,
    CELL,
    NO_BORDER,
    Net,
    has_room,
    kill_cell,
    kill_vertex,
    local_of,
    set_corners,
    set_edge,
    touch,
    touch_vertex,
    turn_of,
)

MOST_BALL = 64  # cells around a vertex that may vanish or move


@kernel
def merge_across(net: Net, vertex: int, cell: int) -> bool:
    """Make one triangle of a cell and the next around a vertex, and one of the two beyond.

    The cell (vertex, a, c) and the next (vertex, c, b) become (a, c, b); whether they could.
    """
    i = local_of(net, cell, vertex)
    there = net.cells[cell, BEYOND + (i + 1) % 3]
    if there < 0:
        return False
    after = there >> 2
    j = local_of(net, after, vertex)
    a = net.cells[cell, (i + 1) % 3]
    b = net.cells[after, (j + 2) % 3]
    c = net.cells[cell, (i + 2) % 3]
    p = at(net.points, a)
    q = at(net.points, b)
    if turn_of(p, at(net.points, c), q) <= 0.0:
        return False
    beyond_a = net.cells[cell, BEYOND + (i + 2) % 3]
    beyond_b = net.cells[after, BEYOND + (j + 1) % 3]
    border = net.cells[cell, BORDER + (i + 2) % 3]
    if (beyond_a < 0) != (beyond_b < 0):
        return False
    one = beyond_a >> 2
    two = beyond_b >> 2
    k = 0
    m = 0
    d = -1
    if beyond_a >= 0:
        k = local_of(net, one, vertex)
        m = local_of(net, two, vertex)
        d = net.cells[one, (k + 1) % 3]
        if net.cells[two, (m + 2) % 3] != d or turn_of(p, q, at(net.points, d)) <= 0.0:
            return False
    over_ac = net.cells[cell, BEYOND + i]
    on_ac = net.cells[cell, BORDER + i]
    over_cb = net.cells[after, BEYOND + j]
    on_cb = net.cells[after, BORDER + j]
    touch(net, cell)
    touch(net, after)
    set_corners(net, cell, c, b, a)
    set_edge(net, cell, 2, over_cb, on_cb)
    set_edge(net, cell, 1, over_ac, on_ac)
    kill_cell(net, after)
    if beyond_a < 0:
        set_edge(net, cell, 0, beyond_a, border)
        return True
    over_da = net.cells[one, BEYOND + k]
    on_da = net.cells[one, BORDER + k]
    over_bd = net.cells[two, BEYOND + m]
    on_bd = net.cells[two, BORDER + m]
    touch(net, one)
    touch(net, two)
    set_corners(net, one, d, a, b)
    set_edge(net, one, 2, over_da, on_da)
    set_edge(net, one, 1, over_bd, on_bd)
    kill_cell(net, two)
    set_edge(net, cell, 0, 4 * one, border)
    set_edge(net, one, 0, 4 * cell, border)
    return True


@kernel
def first_around(net: Net, vertex: int) -> int:
    """A cell at a vertex, the first in the positive sense where a border passes through it."""
    start = net.vertices[vertex, CELL]
    cell = start
    for _ in range(MOST_BALL):
        i = local_of(net, cell, vertex)
        over = net.cells[cell, BEYOND + (i + 2) % 3]
        if net.cells[cell, BORDER + (i + 2) % 3] != NO_BORDER or over < 0:
            return cell
        cell = over >> 2
        if cell == start:
            return start
    return -1


@kernel
def count_around(net: Net, vertex: int, start: int) -> tuple[int, int]:
    """Cells around a vertex from one on, up to a border, and that border's edge or -1."""
    n = 0
    cell = start
    while n < MOST_BALL:
        n += 1
        i = local_of(net, cell, vertex)
        if net.cells[cell, BORDER + (i + 1) % 3] != NO_BORDER:
            return n, 4 * cell + (i + 1) % 3
        cell = net.cells[cell, BEYOND + (i + 1) % 3] >> 2
        if cell == start:
            return n, -1
    return n, -1


@kernel
def thin_out(net: Net, vertex: int, start: int, fewest: int) -> tuple[int, int]:
    """Flip edges at a vertex away, from a cell on up to a border.

    Returns
    -------
    start : int
        The cell that is the first now.
    n : int
        How many are left: `fewest`, where that can be.
    """
    cell = start
    n, _ = count_around(net, vertex, start)
    idle = 0
    while n > fewest and idle <= n and has_room(net):
        i = local_of(net, cell, vertex)
        ahead = (i + 1) % 3  # the edge to the next cell
        after = net.cells[cell, BEYOND + ahead] >> 2
        if can_flip(net, 4 * cell + ahead):
            flip(net, 4 * cell + ahead)
            if cell == start:
                start = after
            cell = after  # which has the vertex still
            n -= 1
            idle = 0
        else:
            idle += 1
            cell = start if net.cells[cell, BORDER + ahead] != NO_BORDER else after
    return start, n


@kernel
def remove(net: Net, vertex: int) -> bool:
    """Take a vertex away that is free or may slide; whether it could be."""
    start = first_around(net, vertex)
    if start < 0:
        return False
    n, edge = count_around(net, vertex, start)
    if n >= MOST_BALL:
        return False
    if edge < 0:  # no border
        start, n = thin_out(net, vertex, start, 3)
        if n == 3:
            merge_three(net, vertex, start)
        elif n != 4 or not merge_across(net, vertex, start):
            if n != 4:
                return False
            i = local_of(net, start, vertex)
            if not merge_across(net, vertex, net.cells[start, BEYOND + (i + 1) % 3] >> 2):
                return False
        kill_vertex(net, vertex)
        return True
    other = net.cells[edge >> 2, BEYOND + (edge & 3)]
    start, n = thin_out(net, vertex, start, 2)
    if n != 2:
        return False
    if other >= 0:
        _, n = thin_out(net, vertex, other >> 2, 2)
        if n != 2:
            return False
    if not merge_across(net, vertex, start):
        return False
    kill_vertex(net, vertex)
    return True


@kernel
def merge_three(net: Net, vertex: int, one: int) -> None:
    """Make one triangle of the three around a vertex."""
    i = local_of(net, one, vertex)
    two = net.cells[one, BEYOND + (i + 1) % 3] >> 2
    j = local_of(net, two, vertex)
    three = net.cells[two, BEYOND + (j + 1) % 3] >> 2
    k = local_of(net, three, vertex)
    a = net.cells[one, (i + 1) % 3]
    b = net.cells[one, (i + 2) % 3]
    c = net.cells[two, (j + 2) % 3]
    over_ab = net.cells[one, BEYOND + i]
    on_ab = net.cells[one, BORDER + i]
    over_bc = net.cells[two, BEYOND + j]
    on_bc = net.cells[two, BORDER + j]
    over_ca = net.cells[three, BEYOND + k]
    on_ca = net.cells[three, BORDER + k]
    touch(net, one)
    touch(net, two)
    touch(net, three)
    set_corners(net, one, a, b, c)
    kill_cell(net, two)
    kill_cell(net, three)
    set_edge(net, one, 2, over_ab, on_ab)
    set_edge(net, one, 0, over_bc, on_bc)
    set_edge(net, one, 1, over_ca, on_ca)


@kernel
def move(net: Net, vertex: int, p: Vec) -> bool:
    """Put a vertex elsewhere, if the triangles around it stay positive; logs these.

    Its ball must not be cut by more than the border that it slides on.
    """
    start = first_around(net, vertex)
    if start < 0:
        return False
    cell = start
    for _ in range(2 * MOST_BALL):
        i = local_of(net, cell, vertex)
        a = at(net.points, net.cells[cell, (i + 1) % 3])
        b = at(net.points, net.cells[cell, (i + 2) % 3])
        if turn_of(p, a, b) <= 0.0 or not has_room(net):
            return False
        touch(net, cell)
        after = net.cells[cell, BEYOND + (i + 1) % 3]
        if after < 0 or after >> 2 == start:
            break
        cell = after >> 2
    touch_vertex(net, vertex)
    set_point(net.points, vertex, p)
    return True
