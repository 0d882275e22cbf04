"""The triangulation that the search for Steiner points changes, and how changes are undone.

Other than a `SimplexMesh` it knows what lies beyond a border, so that both sides of an interface
are split at once; and whatever is written is logged, so that all of it can be undone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import inlined, kernel
from ..shape.lack import RIGHT, extremes
from ..shape.simplex import tri_quality
from ..types import Judge
from ..vectors import Vec, at, set_point, single

# Columns of Net.cells: three vertices, and for the edge opposite each of them the handle of what
# is beyond (OUTER where the mesh ends) and the border that it lies on, or NO_BORDER.
BEYOND = 3
BORDER = 6
REGION = 9
ALIVE = 10  # 1; 0: it was taken away since the log was opened; -1: a row to be used again
PLACE = 11  # in `bad`, -1 where it is not
WIDTH = 12
NO_BORDER = -1

# Columns of Net.vertices.
LINE = 0  # the border that it may slide on, FREE_VERTEX or FIXED_VERTEX
CELL = 1  # one of its ball
VERTEX_ALIVE = 2  # as ALIVE
OWN = 3  # 1 for a vertex of the input, which may move but not vanish
FREE_VERTEX = -1
FIXED_VERTEX = -2

# Places in Net.state.
N_ROWS = 0  # rows of cells in use, and how many of them wait to be used again
N_SPARE = 1
N_POINTS = 2  # the same of vertices
N_SPARE_POINTS = 3
N_BAD = 4
N_LOG = 5
N_POINT_LOG = 6
N_VERTICES = 7  # living ones
RANDOM = 8
BEGIN = 9  # where the four counts and that of vertices, as they were when the log was opened, begin
FAILED = 14  # 1 where a change ran out of room
N_INPUT = 15  # rows of vertices that came with the mesh
N_STATE = 16

INVALID_COST = 1e6  # of a triangle that must not come to be
FLATTEST = 1e-6  # sine of its least angle


class Goal(NamedTuple):
    """What the search is after."""

    judge: Judge
    least_q: float  # no triangle may have less
    floor: float  # sine of an angle, below which none may come to be
    least: float  # sine of an angle, below which it costs something
    sharp: float  # how much
    price: float  # of a vertex; an obtuse triangle costs 1 and the cosine
    most: int  # vertices
    single: bool  # points are stored in single precision


class Net(NamedTuple):
    """Triangles of a plane with both sides of every border."""

    points: np.ndarray  # (np, 3) float64
    vertices: np.ndarray  # (np, 4) int64
    cells: np.ndarray  # (capacity, WIDTH) int64
    cost: np.ndarray  # (capacity,) float64
    bad: (
        np.ndarray
    )  # (capacity,) int64: rows of triangles that are obtuse or worse than they may be
    spare: np.ndarray  # (capacity,) int64: rows to be used again
    spare_points: np.ndarray  # (np,) int64
    borders: np.ndarray  # (nb, 3) int64: the two ends, and 1 where it may be split
    log: np.ndarray  # (n, WIDTH + 1) int64: row, and what it was
    log_cost: np.ndarray  # (n,) float64
    point_log: np.ndarray  # (m, 5) int64: vertex, and what it was
    log_points: np.ndarray  # (m, 3) float64
    state: np.ndarray  # (N_STATE,) int64
    total: np.ndarray  # (2,) float64: cost of all triangles, now and when the log was opened


class Schedule(NamedTuple):
    """How long the search goes on, how hot it is, and the best that was found."""

    first: int  # the next try
    until: int  # the tries of this call end
    last: int  # of so many in all
    hot: float  # temperature at the beginning, in the unit of the cost
    cold: float  # and at the end
    focus: float  # this part of the tries is made at bad triangles, while there are some
    best_bad: int
    best_vertices: int


# Random numbers ---------------------------------------------------------------------------------


@inlined
def uniform(net: Net) -> float:
    """A random number in (0, 1), by the generator of Park and Miller."""
    net.state[RANDOM] = net.state[RANDOM] * 48271 % 2147483647
    return net.state[RANDOM] / 2147483647.0


@inlined
def below(net: Net, n: int) -> int:
    """A random integer in [0, n)."""
    return min(int(uniform(net) * n), n - 1)


@kernel
def gaussian(net: Net) -> float:
    """A random number of the normal distribution."""
    return math.sqrt(-2.0 * math.log(uniform(net))) * math.cos(2.0 * math.pi * uniform(net))


# The log ----------------------------------------------------------------------------------------


@kernel
def open_log(net: Net) -> None:
    """From here on changes can be undone."""
    state = net.state
    state[N_LOG] = 0
    state[N_POINT_LOG] = 0
    state[FAILED] = 0
    for k in range(4):
        state[BEGIN + k] = state[k]
    state[BEGIN + 4] = state[N_VERTICES]
    net.total[1] = net.total[0]


@kernel
def set_bad(net: Net, cell: int, is_bad: bool) -> None:
    """Take a cell into the list of bad ones, or out of it."""
    place = net.cells[cell, PLACE]
    if is_bad and place < 0:
        net.bad[net.state[N_BAD]] = cell
        net.cells[cell, PLACE] = net.state[N_BAD]
        net.state[N_BAD] += 1
    elif place >= 0 and not is_bad:
        net.state[N_BAD] -= 1
        last = net.bad[net.state[N_BAD]]
        net.bad[place] = last
        net.cells[last, PLACE] = place
        net.cells[cell, PLACE] = -1


@kernel
def undo(net: Net) -> None:
    """Put everything back that was changed since the log was opened."""
    state = net.state
    for i in range(state[N_LOG] - 1, -1, -1):
        cell = net.log[i, 0]
        for k in range(PLACE):
            net.cells[cell, k] = net.log[i, 1 + k]
        net.cost[cell] = net.log_cost[i]
        set_bad(net, cell, net.cells[cell, ALIVE] == 1 and net.log[i, 1 + PLACE] >= 0)
    for i in range(state[N_POINT_LOG] - 1, -1, -1):
        vertex = net.point_log[i, 0]
        for k in range(4):
            net.vertices[vertex, k] = net.point_log[i, 1 + k]
        set_point(net.points, vertex, at(net.log_points, i))
    for k in range(4):
        state[k] = state[BEGIN + k]
    state[N_VERTICES] = state[BEGIN + 4]
    net.total[0] = net.total[1]


@kernel
def keep(net: Net) -> None:
    """Keep what was changed since the log was opened."""
    state = net.state
    for i in range(state[N_LOG]):
        cell = net.log[i, 0]
        if net.cells[cell, ALIVE] == 0:
            net.cells[cell, ALIVE] = -1
            net.spare[state[N_SPARE]] = cell
            state[N_SPARE] += 1
    for i in range(state[N_POINT_LOG]):
        vertex = net.point_log[i, 0]
        if net.vertices[vertex, VERTEX_ALIVE] == 0:
            net.vertices[vertex, VERTEX_ALIVE] = -1
            net.spare_points[state[N_SPARE_POINTS]] = vertex
            state[N_SPARE_POINTS] += 1


@inlined
def has_room(net: Net) -> bool:
    """Whether there is for one more change of a few rows; else it failed."""
    state = net.state
    if (
        state[N_LOG] + 32 >= net.log.shape[0]
        or state[N_POINT_LOG] + 8 >= net.point_log.shape[0]
        or state[N_ROWS] + 8 >= net.cells.shape[0]
        or state[N_POINTS] + 4 >= net.points.shape[0]
    ):
        state[FAILED] = 1
    return state[FAILED] == 0


@kernel
def touch(net: Net, cell: int) -> None:
    """Log a cell before it is written."""
    i = net.state[N_LOG]
    net.log[i, 0] = cell
    for k in range(WIDTH):
        net.log[i, 1 + k] = net.cells[cell, k]
    net.log_cost[i] = net.cost[cell]
    net.state[N_LOG] += 1


@kernel
def touch_vertex(net: Net, vertex: int) -> None:
    """Log a vertex before it is written."""
    i = net.state[N_POINT_LOG]
    net.point_log[i, 0] = vertex
    for k in range(4):
        net.point_log[i, 1 + k] = net.vertices[vertex, k]
    set_point(net.log_points, i, at(net.points, vertex))
    net.state[N_POINT_LOG] += 1


# Cells and vertices -----------------------------------------------------------------------------


@kernel
def cost_of(net: Net, cell: int, goal: Goal) -> tuple[float, bool, bool]:
    """What a triangle costs, whether it is obtuse, and whether it is worse than it may be."""
    a = at(net.points, net.cells[cell, 0])
    b = at(net.points, net.cells[cell, 1])
    c = at(net.points, net.cells[cell, 2])
    angles = extremes(a, b, c)
    if not angles.least >= FLATTEST:
        return INVALID_COST, True, True
    cost = goal.sharp * max(0.0, goal.least - angles.least)
    is_obtuse = angles.greatest < RIGHT
    if is_obtuse:
        cost += 1.0 - angles.greatest
    lack = max(
        1.0 - angles.least / goal.floor, 1.0 - tri_quality(goal.judge, a, b, c) / goal.least_q
    )
    if lack > 0.0:
        cost += 1.0 + lack
    return cost, is_obtuse, lack > 0.0


@kernel
def measure(net: Net, cell: int, goal: Goal) -> None:
    """Find anew what a logged cell costs."""
    net.total[0] -= net.cost[cell]
    cost, is_obtuse, is_worse = cost_of(net, cell, goal)
    net.cost[cell] = cost
    net.total[0] += cost
    set_bad(net, cell, is_obtuse or is_worse)


@kernel
def new_cell(net: Net) -> int:
    """A row for a new cell, logged."""
    state = net.state
    if state[N_SPARE] > 0:
        state[N_SPARE] -= 1
        cell = net.spare[state[N_SPARE]]
    else:
        cell = state[N_ROWS]
        state[N_ROWS] += 1
        net.cells[cell, ALIVE] = -1
        net.cells[cell, PLACE] = -1
        net.cost[cell] = 0.0
    touch(net, cell)
    net.cells[cell, ALIVE] = 1
    return cell


@kernel
def kill_cell(net: Net, cell: int) -> None:
    """Take a logged cell away."""
    net.cells[cell, ALIVE] = 0
    net.total[0] -= net.cost[cell]
    net.cost[cell] = 0.0
    set_bad(net, cell, False)


@kernel
def new_vertex(net: Net, p: Vec, line: int, cell: int) -> int:
    """A row for a new vertex, logged."""
    state = net.state
    if state[N_SPARE_POINTS] > 0:
        state[N_SPARE_POINTS] -= 1
        vertex = net.spare_points[state[N_SPARE_POINTS]]
    else:
        vertex = state[N_POINTS]
        state[N_POINTS] += 1
        net.vertices[vertex, VERTEX_ALIVE] = -1
    touch_vertex(net, vertex)
    net.vertices[vertex, LINE] = line
    net.vertices[vertex, CELL] = cell
    net.vertices[vertex, VERTEX_ALIVE] = 1
    net.vertices[vertex, OWN] = 0
    set_point(net.points, vertex, p)
    state[N_VERTICES] += 1
    return vertex


@kernel
def kill_vertex(net: Net, vertex: int) -> None:
    """Take a vertex away."""
    touch_vertex(net, vertex)
    net.vertices[vertex, VERTEX_ALIVE] = 0
    net.state[N_VERTICES] -= 1


@kernel
def set_edge(net: Net, cell: int, local: int, beyond: int, border: int) -> None:
    """Say what lies beyond an edge of a logged cell, there too."""
    net.cells[cell, BEYOND + local] = beyond
    net.cells[cell, BORDER + local] = border
    if beyond >= 0:
        other = beyond >> 2
        if net.cells[other, BEYOND + (beyond & 3)] != 4 * cell + local:
            touch(net, other)
            net.cells[other, BEYOND + (beyond & 3)] = 4 * cell + local


@inlined
def set_corners(net: Net, cell: int, a: int, b: int, c: int) -> None:
    """Write the vertices of a logged cell."""
    net.cells[cell, 0] = a
    net.cells[cell, 1] = b
    net.cells[cell, 2] = c
    for k in range(3):
        vertex = net.cells[cell, k]
        if net.vertices[vertex, CELL] != cell:
            touch_vertex(net, vertex)
            net.vertices[vertex, CELL] = cell


@inlined
def local_of(net: Net, cell: int, vertex: int) -> int:
    """Where in a cell a vertex is."""
    if net.cells[cell, 0] == vertex:
        return 0
    return 1 if net.cells[cell, 1] == vertex else 2


@inlined
def turn_of(a: Vec, b: Vec, c: Vec) -> float:
    """Twice the signed area of a triangle."""
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)


@inlined
def stored(goal: Goal, x: float, y: float) -> Vec:
    """A point as it will be stored."""
    if goal.single:
        return Vec(single(x), single(y), 0.0)
    return Vec(x, y, 0.0)


@kernel
def on_border(net: Net, border: int, p: Vec, goal: Goal) -> Vec:
    """The place on the line of a border that is nearest to a point."""
    a = at(net.points, net.borders[border, 0])
    b = at(net.points, net.borders[border, 1])
    dx = b.x - a.x
    dy = b.y - a.y
    t = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy)
    if dx == 0.0:
        return stored(goal, a.x, a.y + t * dy)
    if dy == 0.0:
        return stored(goal, a.x + t * dx, a.y)
    return stored(goal, a.x + t * dx, a.y + t * dy)
