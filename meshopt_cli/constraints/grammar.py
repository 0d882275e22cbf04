"""What vertices are to keep off, as it is written: WHAT:DISTANCE."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ConfigError

Point = tuple[float, float, float]

AXES = "xyz"
BOUNDARY, GROUP, PLANE = "boundary", "group", "plane"
# Figures by their corners, and how many they have.
CORNERS = {"point": 1, "edge": 2, "face": 3}
# What can be written, and what it means: for the help and the README.
FORMS = {
    "x=C, y=C or z=C": "the plane that is normal to an axis",
    "plane=P/N": "the plane through a point P with a normal N",
    "point=P": "a point",
    "edge=P/P": "the straight edge from one point to another",
    "face=P/P/P": "a triangle",
    "boundary": "where the mesh ends",
    "group=NAME": "the cells of a physical group, or of a region, by its name or number",
}


@dataclass(frozen=True)
class KeepOff:
    """What vertices are to keep off, and how far.

    Attributes
    ----------
    text : str
        As it was written.
    kind : str
        `PLANE`, a key of `CORNERS`, `BOUNDARY` or `GROUP`.
    points : tuple
        A point and the normal of a plane; corners.
    name : str
        Of a group.
    distance : float
        Above 0.
    """

    text: str
    kind: str
    points: tuple[Point, ...]
    name: str
    distance: float


def keep_offs(texts: Sequence[str]) -> tuple[KeepOff, ...]:
    """What several texts say.

    Raises
    ------
    ConfigError
        One of them is not of the grammar: the message names it and says what is wrong.
    """
    return tuple(map(keep_off, texts))


def keep_off(text: str) -> KeepOff:
    """What a text says; errors as `keep_offs` has them."""
    try:
        return _parsed(text)
    except ValueError as error:
        raise ConfigError(f"--keep-off {text:.80}: {error}") from None


def _parsed(text: str) -> KeepOff:
    what, colon, far = text.rpartition(":")
    if not colon or not what:
        raise ValueError("it must be WHAT:DISTANCE, such as x=0.5:0.02")
    distance = _number(far)
    if distance <= 0.0:
        raise ValueError(f"the distance {far} must be above 0")
    kind, equals, value = what.partition("=")
    if kind == BOUNDARY and not equals:
        return KeepOff(text, BOUNDARY, (), "", distance)
    if kind == GROUP and value:
        return KeepOff(text, GROUP, (), value, distance)
    if kind in tuple(AXES) and equals:
        axis = AXES.index(kind)
        normal = _on_axis(axis, 1.0)
        return KeepOff(text, PLANE, (_on_axis(axis, _number(value)), normal), "", distance)
    count = 2 if kind == PLANE else CORNERS.get(kind, 0)
    if not count or not equals:
        known = "x=, y=, z=, plane=, point=, edge=, face=, boundary or group="
        raise ValueError(f"{what!r} is none of {known}")
    points = tuple(_point(part) for part in value.split("/"))
    if len(points) != count:
        wanted = "a point and a normal" if kind == PLANE else f"{count} points"
        raise ValueError(f"{kind}= takes {wanted}, parted by /, not {len(points)}")
    if kind == PLANE and not any(points[1]):
        raise ValueError("the normal of the plane is 0")
    return KeepOff(text, kind, points, "", distance)


def _on_axis(axis: int, value: float) -> Point:
    x, y, z = (value if k == axis else 0.0 for k in range(3))
    return x, y, z


def _point(text: str) -> Point:
    parts = text.split(",")
    if len(parts) not in (2, 3):
        raise ValueError(f"{text!r} is no point X,Y or X,Y,Z")
    x, y, z = (*map(_number, parts), 0.0)[:3]
    return x, y, z


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        raise ValueError(f"{text!r} is not a number")
    return value
