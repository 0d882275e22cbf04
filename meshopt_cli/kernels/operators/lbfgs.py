"""Minimization of an energy over all free vertices at once, by L-BFGS.

The product of the inverse Hessian and the gradient is built of the last few steps (Nocedal and
Wright 2006, Algorithm 7.4), from the stiffness of each vertex on. Steps fulfil the weak conditions
of Wolfe, found by doubling and halving (Lewis and Overton 2013).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, inlined, kernel
from ..shape.distortion import Body, Energy
from .foldover import energy_at, stiffness_at

ARMIJO = 1e-4  # part of the decrease that the slope promises
WOLFE = 0.9  # part of the slope that may be left
N_TRIALS = 30  # of a length of a step
CURVED = 1e-12  # least cosine between a step and the change of the gradient


class Memory(NamedTuple):
    """Working space of a minimization; its contents mean nothing between two calls."""

    steps: np.ndarray  # (m, nf, 3) float64: the last steps, in a ring, with room for the next
    changes: np.ndarray  # (m, nf, 3) float64: of the gradient along them
    products: np.ndarray  # (m,) float64: step times change
    weights: np.ndarray  # (m,) float64
    direction: np.ndarray  # (nf, 3) float64
    trial: np.ndarray  # (np, 3) float64: points
    gradient: np.ndarray  # (np, 3) float64
    other: np.ndarray  # (np, 3) float64: gradient at the trial
    stiffness: np.ndarray  # (np,) float64


@inlined
def copy(source: np.ndarray, target: np.ndarray) -> None:
    for v in range(source.shape[0]):
        for k in range(3):
            target[v, k] = source[v, k]


@inlined
def product(rows: np.ndarray, r: int, direction: np.ndarray) -> float:
    """Of (nf, 3) numbers in a ring and others."""
    total = 0.0
    for i in range(direction.shape[0]):
        for k in range(3):
            total += rows[r, i, k] * direction[i, k]
    return total


@inlined
def accumulate(direction: np.ndarray, t: float, rows: np.ndarray, r: int) -> None:
    """direction += t rows[r]."""
    for i in range(direction.shape[0]):
        for k in range(3):
            direction[i, k] += t * rows[r, i, k]


@inlined
def slope_along(gradient: np.ndarray, free: np.ndarray, direction: np.ndarray) -> float:
    """Derivative along a direction of the free vertices."""
    total = 0.0
    for i in range(free.shape[0]):
        v = free[i]
        for k in range(3):
            total += gradient[v, k] * direction[i, k]
    return total


@inlined
def scale_of_last(body: Body, memory: Memory, r: int) -> float:
    """By what the stiffness was too great along a step."""
    square = 0.0
    for i in range(body.free.shape[0]):
        for k in range(3):
            change = memory.changes[r, i, k]
            square += change * change / memory.stiffness[body.free[i]]
    return memory.products[r] / square


@kernel
def turn_downhill(body: Body, memory: Memory, n: int) -> None:
    """Put minus the product of the inverse Hessian and the gradient into `direction`.

    Parameters
    ----------
    n : int
        Steps remembered so far; the last m - 1 of them count.
    """
    direction = memory.direction
    m = memory.steps.shape[0]
    for i in range(body.free.shape[0]):
        for k in range(3):
            direction[i, k] = -memory.gradient[body.free[i], k]
    first = max(0, n - m + 1)
    for j in range(n - 1, first - 1, -1):
        r = j % m
        memory.weights[r] = product(memory.steps, r, direction) / memory.products[r]
        accumulate(direction, -memory.weights[r], memory.changes, r)
    unit = scale_of_last(body, memory, (n - 1) % m) if n > 0 else 1.0
    for i in range(body.free.shape[0]):
        for k in range(3):
            direction[i, k] *= unit / memory.stiffness[body.free[i]]
    for j in range(first, n):
        r = j % m
        weight = memory.weights[r] - product(memory.changes, r, direction) / memory.products[r]
        accumulate(direction, weight, memory.steps, r)


@inlined
def put_trial(body: Body, points: np.ndarray, memory: Memory, t: float) -> None:
    """Move the free vertices t times the direction, in `trial`."""
    for i in range(body.free.shape[0]):
        v = body.free[i]
        for k in range(3):
            memory.trial[v, k] = points[v, k] + t * memory.direction[i, k]


@kernel
def search_line(
    body: Body, points: np.ndarray, how: Energy, energy: float, slope: float, memory: Memory
) -> tuple[float, float]:
    """The length of a step and the energy there, with `trial` and `other`; 0 where there is none.

    Parameters
    ----------
    energy, slope : float
        At the points, along the direction.
    """
    low = 0.0
    high = math.inf
    t = 1.0
    for _ in range(N_TRIALS):
        put_trial(body, points, memory, t)
        found = energy_at(body, memory.trial, how, memory.other)
        if not found <= energy + ARMIJO * t * slope:
            high = t
        elif slope_along(memory.other, body.free, memory.direction) < WOLFE * slope:
            low = t
        else:
            return t, found
        t = 0.5 * (low + high) if high < math.inf else 2.0 * t
    if low == 0.0:
        return 0.0, energy
    put_trial(body, points, memory, low)
    return low, energy_at(body, memory.trial, how, memory.other)


@inlined
def remember(body: Body, memory: Memory, t: float, n: int) -> bool:
    """Keep the step just made as the n-th, unless the energy is not convex along it."""
    r = n % memory.steps.shape[0]
    along = 0.0
    steps = 0.0
    changes = 0.0
    for i in range(body.free.shape[0]):
        v = body.free[i]
        for k in range(3):
            step = t * memory.direction[i, k]
            change = memory.other[v, k] - memory.gradient[v, k]
            memory.steps[r, i, k] = step
            memory.changes[r, i, k] = change
            along += step * change
            steps += step * step
            changes += change * change
    memory.products[r] = along
    return along > CURVED * math.sqrt(steps * changes)


@entry(
    group="global",
    example=lambda work: (
        work.body, work.mesh.points, Energy(0.0, 0.0, 0.0, 0.0), 0.0, 0, work.memory,
    ),
)  # fmt: skip
def minimize(
    body: Body,
    points: np.ndarray,
    how: Energy,
    tolerance: float,
    max_steps: int,
    memory: Memory,
) -> tuple[float, int]:
    """Move the free vertices downhill until a step promises little.

    Parameters
    ----------
    points : (np, 3) float64
        Are moved.
    tolerance : float
        Least decrease that a step must promise, as a part of the energy.

    Returns
    -------
    energy : float
    n_steps : int
    """
    energy = energy_at(body, points, how, memory.gradient)
    if not energy < math.inf:
        return energy, 0
    stiffness_at(body, points, how, memory.stiffness)
    copy(points, memory.trial)
    n = 0
    n_steps = 0
    while n_steps < max_steps:
        turn_downhill(body, memory, n)
        slope = slope_along(memory.gradient, body.free, memory.direction)
        if slope >= -tolerance * energy:
            break
        t, found = search_line(body, points, how, energy, slope, memory)
        if t == 0.0:
            if n == 0:
                break
            n = 0  # what is remembered misleads: from here on anew
            stiffness_at(body, points, how, memory.stiffness)
            continue
        if remember(body, memory, t, n):
            n += 1
        copy(memory.trial, points)
        copy(memory.other, memory.gradient)
        energy = found
        n_steps += 1
    return energy, n_steps
