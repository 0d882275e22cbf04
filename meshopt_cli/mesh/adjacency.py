"""Neighbours, boundary, edges and degrees of simplicial meshes, vectorised in numpy.

Everything here takes cells as an (ne, d + 1) array and knows nothing of files or kernels.
"""

from __future__ import annotations

import numpy as np

from ..cells import TET_EDGES, TET_FACETS, TRI_EDGES, TRI_FACETS
from ..handles import DECLARED, INTERFACE, OUTER

Array = np.ndarray

# Rows that are numbered at a time: what is made for them stays in the cache of the processor.
SOME = 1 << 14


def facet_table(cells: Array) -> Array:
    """Local vertices of the facets of a triangle or a tet, by the width of the cells."""
    return TET_FACETS if cells.shape[1] == 4 else TRI_FACETS


def edge_table(cells: Array) -> Array:
    """Local ends of the edges of a triangle or a tet, (n_edges, 2)."""
    return (TET_EDGES if cells.shape[1] == 4 else TRI_EDGES)[:, :2]


def row_keys(rows: Array, n_points: int) -> Array:
    """One sortable int64 a row of vertex numbers, the same whatever their order.

    Parameters
    ----------
    rows : (n, k) int64
        Vertices in [0, n_points); n_points to the power of k must fit.
    """
    keys = np.zeros(len(rows), dtype=np.int64)
    for first in range(0, len(rows), SOME):
        key = keys[first : first + SOME]
        for column in _ascending(rows[first : first + SOME]):
            key *= n_points
            key += column
    return keys


def _ascending(rows: Array) -> list[Array]:
    """The columns of rows in each of which numbers ascend: of up to three with no sort."""
    if rows.shape[1] not in (2, 3):
        return list(np.sort(rows, axis=1).T)
    least = np.minimum(rows[:, 0], rows[:, 1])
    most = np.maximum(rows[:, 0], rows[:, 1])
    if rows.shape[1] == 2:
        return [least, most]
    last = rows[:, 2]
    middle = np.maximum(least, np.minimum(most, last))
    return [np.minimum(least, last), middle, np.maximum(most, last)]


def _fits(n_points: int, width: int) -> bool:
    """Whether `row_keys` of so many vertices are one word."""
    return n_points**width < 2**62


def row_ids(rows: Array, n_points: int) -> Array:
    """A number a row, equal for rows with the same vertices; works for any count of points."""
    if _fits(n_points, rows.shape[1]):
        return row_keys(rows, n_points)
    # Too many points for one word: number the leading pairs first.
    rows = np.sort(rows, axis=1)
    head = rows[:, 0].astype(np.int64) * n_points + rows[:, 1]
    for k in range(2, rows.shape[1]):
        _, head = np.unique(head, return_inverse=True)
        head = head * n_points + rows[:, k]
    return head


def places_in(known: Array, rows: Array, n_points: int) -> Array:
    """The row of `known` with the same vertices as each of some rows, -1 where there is none.

    Parameters
    ----------
    known : (m, k) int64
        Of equal ones the first counts.
    rows : (n, k) int64
    """
    ids = row_ids(np.concatenate([known, rows]), n_points)
    ids, wanted = ids[: len(known)], ids[len(known) :]
    if not len(known):
        return np.full(len(rows), -1)
    order = np.argsort(ids, kind="stable")
    place = order[np.minimum(np.searchsorted(ids, wanted, sorter=order), len(known) - 1)]
    return np.where(ids[place] == wanted, place, -1)


def canonical(rows: Array, n_points: int) -> Array:
    """The rows as a set: equal for the same rows in any order, turned in any way."""
    if n_points ** rows.shape[1] < 2**62:
        return np.sort(row_keys(rows, n_points))
    return distinct_rows(np.sort(rows, axis=1))[0]


def distinct(values: Array) -> Array:
    """Each integer once, ascending: `np.unique`, which hashes by now, in a tenth of the time."""
    ordered = np.sort(values, axis=None)
    is_new = np.ones(len(ordered), dtype=bool)
    is_new[1:] = ordered[1:] != ordered[:-1]
    return ordered[is_new]


def ascending(values: Array) -> Array:
    """Rows in which numbers of 0 and more ascend, equal ones in their order.

    `np.argsort` does the same: to sort words that hold the number and the row takes a quarter of
    the time, where they fit.
    """
    n_bits = len(values).bit_length()
    if int(values.max(initial=0)).bit_length() + n_bits > 63:
        return np.argsort(values, kind="stable")
    words = (values << n_bits) | np.arange(len(values))
    words.sort()
    return words & ((1 << n_bits) - 1)


def distinct_rows(rows: Array) -> tuple[Array, Array, Array]:
    """Each row once, in the order of their first columns, then of the next.

    `np.unique` does the same along an axis, in several times the time.

    Parameters
    ----------
    rows : (n, k)

    Returns
    -------
    distinct : (m, k)
    number : (n,) int64
        Place of each row in `distinct`.
    count : (m,) int64
        How often each is there.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    start = np.flatnonzero(is_new)
    return ordered[start], number, np.diff(start, append=len(rows))


def first_of(n: int, one: Array, other: Array) -> Array:
    """For each of `n` items the least one that pairs link it to, itself included."""
    first = np.arange(n)
    while True:
        least = np.minimum(first[one], first[other])
        before = first.copy()
        for ends in (one, other, before[one], before[other]):
            np.minimum.at(first, ends, least)
        first = first[first]
        if np.array_equal(first, before):
            return first


def same_direction(one: Array, other: Array) -> Array:
    """Whether two facets with the same vertices run round in the same direction.

    Parameters
    ----------
    one, other : (n, w) int64
    """
    width = one.shape[1]
    start = np.argmax(other == one[:, :1], axis=1)
    following = other[np.arange(len(other)), (start + 1) % width]
    # An edge has no direction round, only one along.
    return start == 0 if width == 2 else following == one[:, 1]


def is_used(cells: Array, n_points: int) -> Array:
    """Whether each point is a vertex of a cell, (np,)."""
    used = np.zeros(n_points, dtype=bool)
    used[cells.ravel()] = True
    return used


def facets(cells: Array) -> Array:
    """All facets, (ne * (d + 1), d): facet k of cell i is row `i * (d + 1) + k`."""
    table = facet_table(cells)
    # By `take`, whose rows come one after the other in memory; those of an index do not.
    return np.take(cells, table, axis=1).reshape(-1, table.shape[1])


def neighbours(cells: Array, region: Array, n_points: int, cuts: Array | None = None) -> Array:
    """What lies beyond each facet, as packed handles.

    Parameters
    ----------
    region : (ne,) int64
        Cells of different regions are no neighbours.
    cuts : (n, d) int64, optional
        Facets that count as boundary although they lie inside.

    Returns
    -------
    neighbours : (ne, d + 1) int64
        `4 * cell + local` of the facet on the other side, or what is in its place (see
        `handles`): OUTER, INTERFACE between two regions and where more than two cells share the
        facet, DECLARED where one of the cuts lies inside a region.
    """
    n_cells, width = cells.shape
    ids, cut_ids = _facet_ids(cells, np.empty((0, width - 1), np.int64) if cuts is None else cuts,
                              n_points)  # fmt: skip
    # Which of two equal facets comes first does not matter: they become each other's neighbour.
    order = np.argsort(ids)
    ids = ids[order]
    same = np.concatenate([[False], ids[1:] == ids[:-1], [False]])
    # A pair is a run of exactly two equal ids; in a longer one, cells crowd at the facet.
    is_pair = same[1:-1] & ~same[:-2] & ~same[2:]
    crowd = np.flatnonzero(same[1:-1] & ~is_pair)
    first = np.flatnonzero(is_pair)
    one, other = order[first], order[first + 1]
    is_inside = region[one // width] == region[other // width]
    result = np.full(n_cells * width, OUTER, dtype=np.int64)
    for rows in (order[crowd], order[crowd + 1], one[~is_inside], other[~is_inside]):
        result[rows] = INTERFACE
    one, other, ids = one[is_inside], other[is_inside], ids[first][is_inside]
    result[one] = 4 * (other // width) + other % width
    result[other] = 4 * (one // width) + one % width
    if len(cut_ids):
        is_cut = np.isin(ids, cut_ids)
        result[one[is_cut]] = result[other[is_cut]] = DECLARED
    return result.reshape(n_cells, width)


def _facet_ids(cells: Array, cuts: Array, n_points: int) -> tuple[Array, Array]:
    """Numbers of the facets of cells, in their order, and of other facets: see `row_ids`."""
    n_facets = cells.size
    if not _fits(n_points, cuts.shape[1]):
        ids = row_ids(np.concatenate([facets(cells), cuts]), n_points)
        return ids[:n_facets], ids[n_facets:]
    ids = np.empty(n_facets, dtype=np.int64)
    for first in range(0, len(cells), SOME):
        some = cells[first : first + SOME]
        ids[first * cells.shape[1] :][: some.size] = row_keys(facets(some), n_points)
    return ids, row_keys(cuts, n_points)


def n_fans(cells: Array, n_points: int) -> Array:
    """In how many parts that hang together by facets the cells at each vertex fall, (np,) int64.

    One in a mesh whose parts do not meet in a vertex, or an edge, only.
    """
    n_cells, width = cells.shape
    beyond = neighbours(cells, np.zeros(n_cells, np.int64), n_points).ravel()
    one = np.flatnonzero(beyond >= 0)
    shared = facets(cells)[one]
    sides = one // width, beyond[one] // 4
    # A vertex of a cell is an item, linked to the same vertex of a neighbour.
    links: list[list[Array]] = [[], []]
    for k in range(width - 1):
        for side, items in zip(sides, links, strict=True):
            items.append(width * side + np.argmax(cells[side] == shared[:, [k]], axis=1))
    part = first_of(cells.size, *(np.concatenate(items) for items in links))
    return np.bincount(cells.ravel()[distinct(part)], minlength=n_points)


def boundary_facets(cells: Array, beyond: Array) -> Array:
    """Facets without a neighbour, (n, d), turned as their cells turn them."""
    return facets_at(cells, beyond < 0)


def facets_at(cells: Array, chosen: Array) -> Array:
    """The facets that a mask (ne, d + 1) chooses, (n, d), in the order of `facets`."""
    cell, local = np.nonzero(chosen)
    return cells[cell[:, None], facet_table(cells)[local]]


def edges_of_triangles(triangles: Array) -> Array:
    """The three edges of each triangle, (3 n, 2), those of a mesh twice."""
    return triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


def edges(cells: Array, n_points: int) -> Array:
    """Every edge once, (n, 2), sorted."""
    ends = np.take(cells, edge_table(cells), axis=1).reshape(-1, 2)
    key = distinct(row_keys(ends, n_points))
    return np.stack([key // n_points, key % n_points], axis=1)


def degrees(cells: Array, n_points: int) -> Array:
    """Number of edges at each vertex, (np,) int64 (Definition 18.7)."""
    return np.bincount(edges(cells, n_points).ravel(), minlength=n_points)
