"""The search for Steiner points: simulated annealing around obtuse triangles (Remark 18.18).

A change that costs more is kept with a probability that falls with what it costs and as the search
cools down. An obtuse triangle costs more than a vertex, which is what the search ends with.
"""

from __future__ import annotations

import math

from ...compiled.decorators import entry, kernel
from .change import legalize
from .net import (
    ALIVE,
    CELL,
    FAILED,
    INVALID_COST,
    N_BAD,
    N_INPUT,
    N_LOG,
    N_POINTS,
    N_ROWS,
    N_VERTICES,
    VERTEX_ALIVE,
    Goal,
    Net,
    Schedule,
    below,
    cost_of,
    keep,
    measure,
    open_log,
    undo,
    uniform,
)
from .propose import propose

COOLING = 64  # tries at one temperature


@kernel
def choose(net: Net, focus: float) -> int:
    """A cell to try something at: an obtuse one, or one at a new vertex; -1 for none."""
    state = net.state
    if state[N_BAD] > 0 and uniform(net) < focus:
        return net.bad[below(net, state[N_BAD])]
    n_new = state[N_POINTS] - state[N_INPUT]
    if n_new > 0:
        vertex = state[N_INPUT] + below(net, n_new)
        if net.vertices[vertex, VERTEX_ALIVE] == 1:
            return net.vertices[vertex, CELL]
    return -1


@kernel
def attempt(net: Net, cell: int, heat: float, goal: Goal) -> bool:
    """Change something at a cell and keep it, or undo it; whether it was kept."""
    open_log(net)
    n_before = net.state[N_VERTICES]
    if propose(net, cell, goal):
        legalize(net)
        for i in range(net.state[N_LOG]):
            if net.cells[net.log[i, 0], ALIVE] == 1:
                measure(net, net.log[i, 0], goal)
        change = net.total[0] - net.total[1] + goal.price * (net.state[N_VERTICES] - n_before)
        if (
            net.state[FAILED] == 0
            and change < 0.5 * INVALID_COST
            and (change <= 0.0 or uniform(net) < math.exp(-change / heat))
        ):
            keep(net)
            return True
    undo(net)
    return False


@kernel
def is_sound(net: Net, goal: Goal) -> bool:
    """Whether no triangle is worse than it may be."""
    for i in range(net.state[N_BAD]):
        _, _, is_worse = cost_of(net, net.bad[i], goal)
        if is_worse:
            return False
    return True


@entry(
    group="steiner",
    example=lambda work: (work.net, work.goal, Schedule(0, 0, 0, 0.0, 0.0, 0.0, 0, 0)),
)
def anneal(net: Net, goal: Goal, schedule: Schedule) -> tuple[int, int, bool]:
    """Search on, until the schedule ends or a better triangulation than the best is found.

    Returns
    -------
    done : int
        Tries.
    kept : int
        Changes that were kept.
    is_better : bool
        Whether what there is now is better than the best was.
    """
    heat = schedule.hot
    kept = 0
    for i in range(schedule.first, schedule.until):
        if i % COOLING == 0 or i == schedule.first:
            part = i / schedule.last
            heat = schedule.hot * math.pow(schedule.cold / schedule.hot, part)
        cell = choose(net, schedule.focus)
        if cell >= 0 and attempt(net, cell, heat, goal):
            kept += 1
            n = net.state[N_BAD]
            is_better = n < schedule.best_bad or (
                n == schedule.best_bad and net.state[N_VERTICES] < schedule.best_vertices
            )
            if is_better and is_sound(net, goal):
                return i + 1 - schedule.first, kept, True
    return schedule.until - schedule.first, kept, False


@entry(group="steiner", example=lambda work: (work.net, work.goal))
def measure_all(net: Net, goal: Goal) -> None:
    """Find what each triangle costs, and which are obtuse."""
    for cell in range(net.state[N_ROWS]):
        if net.cells[cell, ALIVE] == 1:
            measure(net, cell, goal)
