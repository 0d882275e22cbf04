"""Obtuse triangles (Definition 18.10): what the angles of some triangles lack.

Over an edge a b, a third vertex makes no obtuse angle where it lies between the two lines that are
orthogonal to a b at its ends, and outside the circle with the diameter a b (Figure 18.13). The
cosine of the greatest angle says the same, and how far it is from there.
"""

from __future__ import annotations

from typing import NamedTuple

from ...compiled.decorators import inlined
from ..vectors import Vec, dot, minus, norm
from .obtuse import COS_RIGHT

# An angle is obtuse where its cosine is below this: a tenth of what rounding may make of a right
# one where they are counted, since there is more of it on the way to the file.
RIGHT = 0.1 * COS_RIGHT
# Least fall of the cost that counts: less would go on for ever.
LEAST_GAIN = 1e-6


class Wants(NamedTuple):
    """What is wanted of triangles."""

    least: float  # sine of the least angle, at most 60 degrees
    margin: float  # cosine of the greatest angle that costs nothing, at least 0
    q: float  # no cell comes to have less


class Lack(NamedTuple):
    """What some triangles lack: that fewer are obtuse comes first, then that fewer are sharp."""

    n_obtuse: int
    n_sharp: int  # with an angle below the least one
    cost: float  # sum of the squares of what cosines and sines lack


NONE = Lack(0, 0, 0.0)


class Extremes(NamedTuple):
    """The greatest and the least angle of a triangle; not finite where two vertices coincide."""

    greatest: float  # its cosine
    least: float  # its sine, negative in an inverted triangle


@inlined
def extremes(a: Vec, b: Vec, c: Vec) -> Extremes:
    """The greatest and the least angle of a triangle in the plane."""
    u = minus(b, a)
    v = minus(c, b)
    w = minus(a, c)
    lu = norm(u)
    lv = norm(v)
    lw = norm(w)
    at_a = -dot(w, u) / (lw * lu)
    at_b = -dot(u, v) / (lu * lv)
    at_c = -dot(v, w) / (lv * lw)
    area = u.x * v.y - u.y * v.x  # twice
    return Extremes(min(at_a, at_b, at_c), area * min(lu, lv, lw) / (lu * lv * lw))


@inlined
def added(lack: Lack, angles: Extremes, wants: Wants) -> Lack:
    """What some triangles lack together with one more that has these angles."""
    obtuse = max(0.0, wants.margin - angles.greatest)
    sharp = max(0.0, wants.least * (1.0 + wants.margin) - angles.least)
    return Lack(
        lack.n_obtuse + (1 if angles.greatest < RIGHT else 0),
        lack.n_sharp + (1 if angles.least < wants.least else 0),
        lack.cost + obtuse * obtuse + sharp * sharp,
    )


@inlined
def is_less(one: Lack, other: Lack) -> bool:
    """Whether one lacks less than another, by more than rounding."""
    if one.n_obtuse != other.n_obtuse:
        return one.n_obtuse < other.n_obtuse
    if one.n_sharp != other.n_sharp:
        return one.n_sharp < other.n_sharp
    return one.cost < other.cost - LEAST_GAIN
