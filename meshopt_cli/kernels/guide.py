"""Where a point may go: everywhere, along a line, or in a plane."""

from __future__ import annotations

from typing import NamedTuple

from ..compiled.decorators import inlined
from .metric import Upper, across, mapped
from .types import SimplexMesh
from .vectors import ZERO, Vec, along, dot, norm


class Guide(NamedTuple):
    """What a point may move along: everything (0), a line (1) or a plane (2)."""

    kind: float
    direction: Vec  # of the line, or normal of the plane


FREE = Guide(0.0, ZERO)


@inlined
def guided(guide: Guide, v: Vec) -> Vec:
    """The part of a vector that a guide allows."""
    if guide.kind == 0.0:
        return v
    part = dot(v, guide.direction)
    if guide.kind == 1.0:
        return Vec(part * guide.direction.x, part * guide.direction.y, part * guide.direction.z)
    return along(v, guide.direction, -part)


@inlined
def guide_of(mesh: SimplexMesh, vertex: int) -> Guide:
    """Where a vertex of the boundary may move; everywhere for one inside."""
    if not mesh.slides:
        return FREE
    g = mesh.guide
    return Guide(g[vertex, 0], Vec(g[vertex, 1], g[vertex, 2], g[vertex, 3]))


@inlined
def guide_in(guide: Guide, t: Upper) -> Guide:
    """The guide as a map to the usual space sees it."""
    if guide.kind == 0.0:
        return guide
    d = mapped(t, guide.direction) if guide.kind == 1.0 else across(t, guide.direction)
    size = norm(d)
    return Guide(guide.kind, Vec(d.x / size, d.y / size, d.z / size))
