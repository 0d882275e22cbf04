"""Collapses in plane meshes of triangles and quads (18.4.2): two vertices become one.

A quad goes where two opposite corners of it meet, so that both its sides stay faces; two triangles
go with the edge that they share. Where a triangle and a quad share the edge, the triangle takes the
place that the quad is left with.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..mesh import adjacency
from ..mesh.sizes import norms
from .faces import counted, pairs_of

Array = np.ndarray

# By how many edges a vertex has less than both had that became it.
OF_A_QUAD, OF_A_PAIR, OF_TRIANGLES = 2, 3, 4
HALF_WAY = 0.5  # where two free vertices may meet besides


class Meeting(NamedTuple):
    """Pairs of vertices that may become one, and what goes with them.

    Attributes
    ----------
    goes, onto : (n,) int64
        Vertices: the first vanishes into the other.
    part : (n,) float64
        How far from `onto` to `goes` they meet.
    gone : (n, 2) int64
        Rows of the faces that vanish; the same twice of a quad.
    into, reduced : (n,) int64
        Row of the quad that a triangle is left of, and of the triangle that becomes it; else -1.
    beside : (n, 2) int64
        Vertices that lose an edge; -1 for none.
    loses : (n,) int64
        By how many edges the one that is left has less than both had.
    """

    goes: Array
    onto: Array
    part: Array
    gone: Array
    into: Array
    reduced: Array
    beside: Array
    loses: Array

    def chosen(self, rows: Array) -> Meeting:
        return Meeting(*(column[rows] for column in self))


class Merge(NamedTuple):
    """What pairs of vertices are that become one, with the faces around them.

    Attributes
    ----------
    meeting : Meeting
    place : (n, 3) float64
        Where they meet.
    start : (n + 1,) int64
        Which of the rows and faces are of which.
    rows : (m,) int64
        Of the faces that change.
    faces : (m, 4) int64
        What becomes of them, by the vertices that stay.
    before, after : (n,) float64
        Worst q of all that changes.
    mean_before, mean_after : (n,) float64
        Their mean Q, infinite where one is not positive.
    growth : (n,) float64
        Longest side of what changes, over the longest side or diagonal that it had.
    """

    meeting: Meeting
    place: Array
    start: Array
    rows: Array
    faces: Array
    before: Array
    after: Array
    mean_before: Array
    mean_after: Array
    growth: Array

    def kinds(self, rows: Array) -> dict[str, int]:
        """What some of them take away, or how many of which faces: a quad alone or pairs."""
        loses = self.meeting.loses[rows]
        alone = {"quad": int(np.count_nonzero(loses == OF_A_QUAD))}
        pairs = loses[loses != OF_A_QUAD]
        return alone | counted(np.where(pairs == OF_A_PAIR, 1, 0))

    def vertices(self, k: int) -> Array:
        """All vertices of what changes in one of them."""
        meeting = self.meeting
        ends = [meeting.goes[k], meeting.onto[k], *meeting.beside[k]]
        around = np.append(self.faces[self.start[k] : self.start[k + 1]], ends)
        return around[around >= 0]


def meetings(
    faces: Array,
    fixed: Array,
    may_meet: Callable[[Array, Array, Array], Array],
    n_points: int,
    wanted: Array,
) -> Meeting:
    """Which pairs of vertices could become one.

    Parameters
    ----------
    faces : (nf, 4) int64
        Corners, anticlockwise; the fourth of a triangle is -1.
    fixed : (np,) bool
        Vertices that neither move nor vanish.
    may_meet : function of rows of faces, (n,) each, and the edges between them, (n, 2)
        Which of them may become others.
    wanted : (np,) bool
        Vertices around which there is something to gain.
    """
    quads = np.flatnonzero(faces[:, 3] >= 0)
    corner = faces[quads]
    parts = [_meeting(corner[:, k], corner[:, k + 2], np.stack([quads, quads], axis=1),
                      corner[:, [k + 1, (k + 3) % 4]], OF_A_QUAD) for k in (0, 1)]  # fmt: skip
    for kind in ((3, 3), (3, 4)):
        pairs = pairs_of(faces, kind, may_meet, n_points)
        row, side = pairs[:, 0], pairs[:, 1]
        a, b, c = (faces[row, (side + k) % 3] for k in range(3))
        if kind[1] == 3:
            across = faces[pairs[:, 2], (pairs[:, 3] + 2) % 3]
            one = _meeting(a, b, pairs[:, [0, 2]], np.stack([c, across], axis=1), OF_TRIANGLES)
        else:
            none = np.full(len(pairs), -1)
            one = _meeting(
                a, b, np.stack([pairs[:, 2]] * 2, axis=1), np.stack([c, none], axis=1), OF_A_PAIR
            )
            one = one._replace(into=pairs[:, 2], reduced=row)
        parts.append(one)
    found = _joined(parts)
    turned = found._replace(goes=found.onto, onto=found.goes)
    found = _joined([found, turned])
    found = found.chosen(
        np.flatnonzero(~fixed[found.goes] & (wanted[found.goes] | wanted[found.onto]))
    )
    between = found.chosen(np.flatnonzero((found.goes < found.onto) & ~fixed[found.onto]))
    return _joined([found, between._replace(part=np.full(len(between.goes), HALF_WAY))])


def _meeting(goes: Array, onto: Array, gone: Array, beside: Array, loses: int) -> Meeting:
    n = len(goes)
    none = np.full(n, -1)
    return Meeting(goes, onto, np.zeros(n), gone, none, none, beside, np.full(n, loses))


def _joined(parts: list[Meeting]) -> Meeting:
    return Meeting(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def merges(
    found: Meeting,
    faces: Array,
    points: Array,
    quality: Array,
    balls: tuple[Array, Array],
    measure: Callable[[Array, Array], Array],
    single: bool,
) -> Merge:
    """What comes of pairs of vertices that become one, those left out where too much meets.

    Parameters
    ----------
    balls : (np + 1,) int64 and (n,) int64
        Where the rows at each vertex begin, and all of them.
    measure : function of faces and points
        Gives q.
    single : bool
        Whether points are stored in single precision.
    """
    found = found.chosen(np.flatnonzero(_meet_once(found, faces, balls, len(points))))
    n = len(found.goes)
    place = points[found.onto] + found.part[:, None] * (points[found.goes] - points[found.onto])
    if single:
        place = place.astype(np.float32).astype(np.float64)
    # Who stays where it is keeps its own faces.
    moves = found.part > 0.0
    owner, row = _entries(found.goes, balls)
    more, other = _entries(found.onto, balls)
    owner = np.concatenate([owner, more[moves[more]]])
    row = np.concatenate([row, other[moves[more]]])
    stays = (row[:, None] != found.gone[owner]).all(axis=1) & (row != found.reduced[owner])
    is_left = found.into >= 0
    touched, was = _touched(owner, row, found, is_left)
    # What is left of a quad stands in the row of the triangle.
    left = np.flatnonzero(is_left)
    owner = np.concatenate([owner[stays], left])
    target = np.concatenate([row[stays], found.reduced[left]])
    new = faces[np.concatenate([row[stays], found.into[left]])]
    new = np.where(new == found.goes[owner, None], found.onto[owner, None], new)
    new[len(new) - len(left) :] = _without_double(new[len(new) - len(left) :])
    order = np.argsort(owner, kind="stable")
    owner, target, new = owner[order], target[order], new[order]
    where = np.where(new == found.onto[owner, None], len(points) + owner[:, None], new)
    there = np.concatenate([points, place])
    q = measure(where, there)
    start = np.searchsorted(owner, np.arange(n + 1))
    before, after = np.full((2, n), np.inf)
    np.minimum.at(before, touched, quality[was])
    np.minimum.at(after, owner, q)
    longest = np.zeros((2, n))
    np.maximum.at(longest[0], touched, _longest(faces[was], points, (1, 2)))
    np.maximum.at(longest[1], owner, _longest(where, there, (1,)))
    return Merge(
        found, place, start, target, new, before, after,
        _mean(touched, quality[was], n), _mean(owner, q, n), longest[1] / longest[0],
    )  # fmt: skip


def _entries(vertices: Array, balls: tuple[Array, Array]) -> tuple[Array, Array]:
    """The rows at some vertices: for each the place of its vertex, and itself."""
    start, rows = balls
    n = start[vertices + 1] - start[vertices]
    owner = np.repeat(np.arange(len(vertices)), n)
    within = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
    return owner, rows[start[vertices][owner] + within]


def _touched(owner: Array, row: Array, found: Meeting, is_left: Array) -> tuple[Array, Array]:
    """All faces that change or go, each once."""
    n = len(found.goes)
    owner = np.concatenate([owner, np.arange(n), np.arange(n), np.flatnonzero(is_left)])
    row = np.concatenate([row, found.gone[:, 0], found.gone[:, 1], found.reduced[is_left]])
    width = row.max(initial=0) + 1
    keys = adjacency.distinct(owner * width + row)
    return keys // width, keys % width


def _meet_once(found: Meeting, faces: Array, balls: tuple[Array, Array], n_points: int) -> Array:
    """Whether the faces around both vertices have nothing in common but what goes with them.

    Else they close around others, or two come to have more than an edge in common.
    """
    sides = []
    for vertices in (found.goes, found.onto):
        owner, row = _entries(vertices, balls)
        of = faces[row]
        stays = (row[:, None] != found.gone[owner]).all(axis=1) & (row != found.reduced[owner])
        known = (of == found.goes[owner, None]) & (vertices[owner] == found.goes[owner])[:, None]
        known |= (of == found.onto[owner, None]) & (vertices[owner] == found.onto[owner])[:, None]
        known |= (of[:, :, None] == found.beside[owner, None]).any(axis=2) | (of < 0)
        take = stays[:, None] & ~known
        sides.append((owner[:, None] * n_points + of)[take])
    shared = np.intersect1d(*sides) // n_points
    once = np.ones(len(found.goes), dtype=bool)
    once[shared] = False
    return once


def _without_double(quads: Array) -> Array:
    """Triangles out of quads of which two corners that follow each other are one."""
    same = np.argmax(quads == np.roll(quads, -1, axis=1), axis=1)
    kept = np.take_along_axis(quads, (same[:, None] + 1 + np.arange(3)) % 4, axis=1)
    return np.column_stack([kept, np.full(len(quads), -1)])


def _longest(faces: Array, points: Array, apart: tuple[int, ...]) -> Array:
    """The longest way between corners of faces that are so many apart."""
    corners = points[np.where(faces < 0, faces[:, [2]], faces)]
    ways = [norms(corners - np.roll(corners, -k, axis=1)) for k in apart]
    return np.concatenate(ways, axis=1).max(axis=1, initial=0.0)


def _mean(owner: Array, q: Array, n: int) -> Array:
    """Mean Q of the faces of each."""
    with np.errstate(divide="ignore", invalid="ignore"):
        total = np.bincount(owner, np.where(q > 0.0, 1.0 / q, np.inf), minlength=n)
        return total / np.bincount(owner, minlength=n)
