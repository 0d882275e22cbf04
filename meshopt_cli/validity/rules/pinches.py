"""Where the boundary of a mesh touches itself: for M206 and M212."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...mesh.adjacency import distinct, distinct_rows, first_of
from ...mesh.model import Array
from .. import boundary
from ..examination import Examination


@dataclass(frozen=True)
class Spots:
    """Numbers of cells, vertices of theirs, and cells on the other side where there are."""

    cells: Array
    points: Array
    others: Array


NONE = Spots(*(np.empty(0, np.int64) for _ in range(3)))


@dataclass(frozen=True)
class Pinches:
    """Edges and vertices where one part touches itself, vertices where two parts do."""

    edges: Spots
    tips: Spots
    joints: Spots


def open_sides(study: Examination) -> Spots:
    """Sides of an odd number of boundary facets, except where a finding says why."""
    skin, sides = study.domain.skin, study.domain.sides
    odd = np.flatnonzero(sides.count % 2 == 1)
    at = np.flatnonzero(np.isin(sides.side, odd))
    _, first = np.unique(sides.side[at], return_index=True)
    at = at[first]
    facet, vertex = sides.facet[at], skin.rows[sides.facet[at], sides.local[at]]
    clear = ~_moot(study)[vertex]
    return Spots(skin.owners[facet][clear], vertex[clear], np.full(int(clear.sum()), -1))


def pinches(study: Examination) -> Pinches:
    """Look for vertices and sides with more than one sheet of boundary."""
    skin, sides = study.domain.skin, study.domain.sides
    corner = 4 * sides.facet + sides.local
    vertex = skin.rows[sides.facet, sides.local]
    sheet = _sheets(study, sides.side)
    if not (sides.count > 2).any() and _is_single(vertex, sheet):
        return Pinches(NONE, NONE, NONE)
    part = boundary.parts(study)[skin.owners[sides.facet]]
    # Each part by itself: its facets may meet in pairs at a side where others meet too.
    _, own, _ = distinct_rows(np.stack([sides.side, part], axis=1))
    sheet = _sheets(study, own)
    moot = _moot(study)
    heavy = (np.bincount(own)[own] > 2) & (study.dimension == 3) & ~moot[vertex]
    edges = _first(np.flatnonzero(heavy), own[heavy], skin.owners[sides.facet], vertex)
    on_edge = np.zeros(study.n_points, dtype=bool)
    if heavy.any():
        following = (sides.local + 1) % skin.width[sides.facet]
        on_edge[vertex[heavy]] = True
        on_edge[skin.rows[sides.facet, following][heavy]] = True
    # Sheets of each part at each vertex, then parts at each vertex.
    clear = np.flatnonzero(~moot[vertex])
    rows = np.stack([vertex, part, sheet, corner], axis=1)[clear]
    rows = rows[np.lexsort(rows.T[::-1])]
    same_part = (np.diff(rows[:, :2], axis=0) == 0).all(axis=1)
    again = np.flatnonzero(same_part & (np.diff(rows[:, 2]) != 0)) + 1
    again = again[~on_edge[rows[again, 0]]]
    tips = _spots(skin, rows[again])
    other = np.flatnonzero((np.diff(rows[:, 0]) == 0) & (np.diff(rows[:, 1]) != 0))
    joined = np.stack([rows[other, 1], rows[other + 1, 1]], axis=1)
    _, first = np.unique(joined, axis=0, return_index=True)
    before, after = rows[other[first]], rows[other[first] + 1]
    joints = Spots(skin.owners[after[:, 3] // 4], after[:, 0], skin.owners[before[:, 3] // 4])
    return Pinches(edges, tips, joints)


def _spots(skin: boundary.Skin, rows: Array) -> Spots:
    _, first = np.unique(rows[:, 0], return_index=True)
    rows = rows[first]
    return Spots(skin.owners[rows[:, 3] // 4], rows[:, 0], np.full(len(rows), -1))


def _first(at: Array, key: Array, owners: Array, vertex: Array) -> Spots:
    """One spot for each key."""
    _, first = np.unique(key, return_index=True)
    at = at[first]
    return Spots(owners[at], vertex[at], np.full(len(at), -1))


def _sheets(study: Examination, side: Array) -> Array:
    """A number for each corner of a boundary facet, the same for those of one sheet."""
    skin, sides = study.domain.skin, study.domain.sides
    corner = 4 * sides.facet + sides.local
    order = np.argsort(side, kind="stable")
    count = np.bincount(side)
    start = (np.cumsum(count) - count)[count == 2]
    one, other = order[start], order[start + 1]
    if study.dimension == 2:
        first = first_of(4 * len(skin.rows), corner[one], corner[other])
        return first[corner]
    # An edge joins the corners at both of its ends.
    ends = [corner, 4 * sides.facet + (sides.local + 1) % skin.width[sides.facet]]
    vertex = [skin.rows.ravel()[end] for end in ends]
    flipped = vertex[0][one] != vertex[0][other]
    links = [
        (ends[0][one], np.where(flipped, ends[1][other], ends[0][other])),
        (ends[1][one], np.where(flipped, ends[0][other], ends[1][other])),
    ]
    first = first_of(
        4 * len(skin.rows),
        np.concatenate([a for a, _ in links]),
        np.concatenate([b for _, b in links]),
    )
    return first[corner]


def _is_single(vertex: Array, sheet: Array) -> bool:
    """Whether every vertex is in one sheet only."""
    pairs, _, _ = distinct_rows(np.stack([vertex, sheet], axis=1))
    return bool((np.diff(pairs[:, 0]) != 0).all())


def _moot(study: Examination) -> Array:
    """Mask of the points where other rules say already that cells do not fit together."""
    moot = study.first_points != np.arange(study.n_points)
    moot[study.first_points[moot]] = True
    vertices, owners = study.hanging
    moot[vertices] = True
    crowd = boundary.crowd_of(study)
    cells = np.concatenate([owners, *study.cracks, crowd.owners, *study.disagreeing])
    cells = np.concatenate([cells, np.flatnonzero(study.explained)])
    corners = study.corners_of(distinct(cells))
    moot[corners[corners >= 0]] = True
    return moot
