"""Where a point may go: everywhere, along a line, or in a plane, and not out of half-spaces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compiled.decorators import inlined, kernel
from .metric import Upper, across, mapped
from .types import AnyMesh
from .vectors import ZERO, Vec, along, dot, minus, norm, rounded

# The first column of `SimplexMesh.guide`; those of vertices that were told where to stay, which do
# not vanish, are TOLD more. A vertex that was told, and is free but for its half-spaces, is SPACE.
STAYS, LINE, PLANE, SPACE = 0.0, 1.0, 2.0, 3.0
TOLD = 4.0

ROUNDS = 4  # over the half-spaces of a point that is led back into all of them
# Of the part of a normal that a guide allows, squared: the rest of it is at right angles to it.
NOTHING = 1e-12


class Guide(NamedTuple):
    """What a point may move along, and the half-spaces that it does not leave."""

    kind: float
    direction: Vec  # of the line, or normal of the plane
    first: int  # of the rows of `limits` that are its half-spaces
    stop: int


FREE = Guide(STAYS, ZERO, 0, 0)


@inlined
def guided(guide: Guide, v: Vec) -> Vec:
    """The part of a vector that a guide allows."""
    if guide.kind in (STAYS, SPACE):
        return v
    part = dot(v, guide.direction)
    if guide.kind == LINE:
        return Vec(part * guide.direction.x, part * guide.direction.y, part * guide.direction.z)
    return along(v, guide.direction, -part)


@inlined
def guide_of(mesh: AnyMesh, vertex: int) -> Guide:
    """Where a vertex may move that stays by itself; everywhere for one that is free."""
    if mesh.guide.shape[0] == 0:
        return FREE
    g = mesh.guide
    kind = g[vertex, 0]
    if kind > TOLD:
        kind -= TOLD
    direction = Vec(g[vertex, 1], g[vertex, 2], g[vertex, 3])
    return Guide(kind, direction, int(g[vertex, 4]), int(g[vertex, 5]))


@inlined
def slack_of(limits: np.ndarray, i: int, p: Vec) -> float:
    """How far inside its i-th half-space a point is; negative outside."""
    return limits[i, 0] * p.x + limits[i, 1] * p.y + limits[i, 2] * p.z - limits[i, 3]


@kernel
def led(limits: np.ndarray, guide: Guide, q: Vec) -> Vec:
    """A goal q led into the half-spaces, as the guide allows."""
    for _ in range(ROUNDS):
        inside = True
        for i in range(guide.first, guide.stop):
            lacking = -slack_of(limits, i, q)
            if lacking > 0.0:
                n = guided(guide, Vec(limits[i, 0], limits[i, 1], limits[i, 2]))
                square = dot(n, n)
                if square > NOTHING:
                    q = along(q, n, lacking / square)
                    inside = False
        if inside:
            break
    return q


@kernel
def limited(limits: np.ndarray, guide: Guide, p: Vec, q: Vec) -> Vec:
    """A goal q led and cut back so that on the way from p no half-space is left.

    What p is out of, it does not leave farther. The set is convex: every point on the way does.
    """
    q = led(limits, guide, q)
    t = 1.0
    for i in range(guide.first, guide.stop):
        before = slack_of(limits, i, p)
        after = slack_of(limits, i, q)
        if after < before and after < 0.0:
            t = min(t, max(before, 0.0) / (before - after))
    return q if t == 1.0 else along(p, minus(q, p), t)


@inlined
def held(mesh: AnyMesh, guide: Guide, p: Vec, q: Vec) -> Vec:
    """Where a point goes that is to go from p to q, as its half-spaces and the file allow."""
    if guide.stop > guide.first:
        q = limited(mesh.limits, guide, p, q)
    return rounded(mesh, q)


@inlined
def guide_in(guide: Guide, t: Upper) -> Guide:
    """The guide as a map to the usual space sees it; half-spaces go with no metric."""
    if guide.kind in (STAYS, SPACE):
        return guide
    d = mapped(t, guide.direction) if guide.kind == LINE else across(t, guide.direction)
    size = norm(d)
    return Guide(guide.kind, Vec(d.x / size, d.y / size, d.z / size), 0, 0)
