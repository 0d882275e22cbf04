"""Functions for the compiler, with arguments and results of every kind."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from meshopt_cli.compiled import decorators

# Groups of kernels that no pass names: those of some kinds of meshes.
WITHOUT_PASS = {"blocks", "cells", "global"}


def at(place):
    """What `cache.folders` returns where there is one folder."""
    return lambda: (place, [place])


class Inner(NamedTuple):
    """A part of `Outer`."""

    values: np.ndarray
    factor: float


class Outer(NamedTuple):
    """Arguments of every kind that an entry may take."""

    grid: np.ndarray
    flags: np.ndarray
    inner: Inner
    on: bool
    number: int


class Part(NamedTuple):
    """A part of `Found`."""

    value: float


class Found(NamedTuple):
    """Results of every kind that an entry may have."""

    is_positive: bool
    number: int
    rest: tuple[float, Part]


@decorators.inlined
def half(value):
    return 0.5 * value


@decorators.kernel
def weighted(inner, i):
    return half(inner.values[i]) * inner.factor


def total(outer, shift):
    """Reads every argument, and writes to one."""
    count = outer.number
    sum_ = shift
    for i in range(outer.grid.shape[0]):
        for j in range(outer.grid.shape[1]):
            if outer.flags[j] == outer.on:
                count += outer.grid[i, j]
        sum_ += weighted(outer.inner, i)
        outer.inner.values[i] = -1.0
    return count, sum_


def twice(values):
    for i in range(len(values)):
        values[i] *= 2


def described(values):
    """Results of every kind."""
    return Found(values[0] > 0.0, len(values), (values[0], Part(values[0] + 1.0)))


def scaled(x, n):
    """Its code needs a function that only numba has."""
    return math.ldexp(x, n)


def quotient(x, y):
    """Infinity or nan where y is 0, as in numpy; Python raises an error."""
    return x / y


def first(values):
    return values[0]


def array(values):
    return values


def outer():
    return Outer(
        np.arange(6, dtype=np.int64).reshape(2, 3),
        np.array([True, False, True]),
        Inner(np.array([3.0, -5.0]), 0.1),
        True,
        -(2**40),
    )
