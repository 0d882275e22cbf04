"""Where a mesh touches itself although its cells share nothing there, for the rules of `check`.

A valid mesh is conforming: its boundary facets meet other cells in vertices, edges and faces
that they share with them. So it is enough to look around the boundary facets.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np

from ..mesh.adjacency import row_ids
from ..mesh.model import Array
from . import geometry
from .geometry import Pairs

if TYPE_CHECKING:
    from .study import FacetSet, Study

MOST_PAIRS = 200  # pairs of boxes to look at, for each box; sound meshes need a few


def hanging_nodes(study: Study) -> Pairs:
    """Vertices that lie on a boundary facet without being one of its vertices.

    Returns
    -------
    vertices : (n,) int64
        Each once, in order.
    owners : (n,) int64
        Numbers of the cells of the facets.
    """
    found = []
    boundary = boundary_vertices(study)
    for facets in study.facet_sets:
        # Whatever lies in the plane of a flat cell may lie on its facets.
        sides, owners = boundary_facets(study, facets, study.shape.flat)
        if sides.shape[1] == 4:
            sides, owners = sides[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3), np.repeat(owners, 2)
        low, high = boxes(study.points, study.noise, sides, study.touch)
        for vertex, side in around(study.points[boundary], low, high):
            on = lies_on(study.points, study.noise, boundary[vertex], sides[side], study.touch)
            found.append((boundary[vertex[on]], owners[side[on]]))
    vertices, owners = _joined(found)
    corners = study.corners_of(owners)
    corners = np.where(corners < 0, -1, study.first_points[corners])
    # The vertex opposite lies on the facet, or nearly so, if the cell is very thin.
    foreign = (corners != vertices[:, None]).all(axis=1)
    vertices, first = np.unique(vertices[foreign], return_index=True)
    return vertices, owners[foreign][first]


def cracks(study: Study) -> Pairs:
    """Numbers of the cells of boundary facets that coincide, the later and the earlier ones."""
    found = []
    for facets in study.facet_sets:
        rows = facets.alone()
        ids = row_ids(study.first_points[facets.rows[rows]], study.n_points)
        _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
        again = np.flatnonzero(first[inverse] != np.arange(len(ids)))
        one, other = facets.owners[rows[again]], facets.owners[rows[first[inverse[again]]]]
        found.append((np.maximum(one, other), np.minimum(one, other)))
    found.append(_halves(study))
    return _joined(found)


def _halves(study: Study) -> Pairs:
    """Cells of boundary quads and of boundary triangles that are halves of them."""
    sides = {facets.rows.shape[1]: facets for facets in study.facet_sets}
    if not {3, 4} <= set(sides):
        return _joined([])
    rows = {width: facets.alone() for width, facets in sides.items()}
    quads = study.first_points[sides[4].rows[rows[4]]]
    halves = quads[:, [[0, 1, 2], [1, 2, 3], [2, 3, 0], [3, 0, 1]]].reshape(-1, 3)
    triangles = study.first_points[sides[3].rows[rows[3]]]
    ids = row_ids(np.concatenate([halves, triangles]), study.n_points)
    order = np.argsort(ids[: len(halves)], kind="stable")
    at = np.searchsorted(ids[order], ids[len(halves) :])
    at = order[np.minimum(at, len(order) - 1)] if len(order) else at
    same = np.flatnonzero(ids[at] == ids[len(halves) :]) if len(order) else at[:0]
    one = sides[3].owners[rows[3][same]]
    other = sides[4].owners[rows[4][at[same] // 4]]
    return np.maximum(one, other), np.minimum(one, other)


def boundary_vertices(study: Study) -> Array:
    """Vertices of the facets that bound one cell only, one for each place."""
    rows = [study.first_points[facets.rows[facets.alone()]].ravel() for facets in study.facet_sets]
    return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *rows]))


def boundary_facets(study: Study, facets: FacetSet, dropped: Array) -> Pairs:
    """Facets that bound one cell only, one for each place, and the numbers of their cells.

    Parameters
    ----------
    dropped : (n_cells,) bool
        Cells whose facets are left out.
    """
    rows = facets.alone()
    rows = rows[~dropped[facets.owners[rows]]]
    ids = row_ids(study.first_points[facets.rows[rows]], study.n_points)
    rows = rows[np.unique(ids, return_index=True)[1]]
    return facets.rows[rows], facets.owners[rows]


def _joined(found: list[Pairs]) -> Pairs:
    none = np.empty(0, dtype=np.int64)
    return (
        np.concatenate([none, *(one for one, _ in found)]),
        np.concatenate([none, *(other for _, other in found)]),
    )


def boxes(points: Array, noise: Array, rows: Array, touch: float) -> Pairs:
    """Least and greatest coordinates of edges, faces or cells, as wide as their tolerance."""
    low, high = extents(points, rows)
    margin = 2 * touch * (high - low).max(axis=1, initial=0.0)
    margin += 2 * np.maximum.reduce([noise[rows[:, k]] for k in range(rows.shape[1])])
    return low - margin[:, None], high + margin[:, None]


def extents(points: Array, rows: Array) -> Pairs:
    """Least and greatest coordinates of edges, faces or cells, (n, d) each."""
    low = high = points[rows[:, 0]]
    for k in range(1, rows.shape[1]):
        corner = points[rows[:, k]]
        low, high = np.minimum(low, corner), np.maximum(high, corner)
    return low, high


def around(points: Array, low: Array, high: Array) -> Iterator[Pairs]:
    """Points (n, d) that are in boxes (m, d), with these boxes."""
    size = high - low
    # Not too many shapes of grids: flat boxes are welcome, but not flat to the last digit.
    size = np.maximum(size, size.max(axis=1, keepdims=True, initial=0.0) * 2.0**-16)
    return overlapping(points, points, low, high, size)


def overlapping(
    low: Array, high: Array, other_low: Array, other_high: Array, size: Array
) -> Iterator[Pairs]:
    """Boxes that overlap, those of one set with those of another.

    The others are put in uniform grids, one for each rounded size, so that a box is in few
    cells of a grid and large ones do not crowd the grid of the small. The search ends after
    `MOST_PAIRS`, which only meshes reach whose cells lie across each other everywhere.

    Parameters
    ----------
    low, high : (n, d) float64
    other_low, other_high : (m, d) float64
    size : (m, d) float64
        Of the others, at least; the boxes larger than that are left out.
    """
    left = MOST_PAIRS * (len(low) + len(other_low) + 1000)
    levels = grid_widths(size)[1]
    code = levels @ np.array([1, 256, 65536][: levels.shape[1]])
    by_code = np.argsort(code, kind="stable")
    starts = np.flatnonzero(np.diff(code[by_code], prepend=np.iinfo(code.dtype).min))
    for start, end in pairwise([*starts.tolist(), len(code)]):
        others = by_code[start:end]
        width = 2.0 ** levels[others[0]]
        near = (low <= other_high[others].max(axis=0)) & (other_low[others].min(axis=0) <= high)
        boxes = np.flatnonzero((near & (high - low <= width)).all(axis=1))
        at, key = _grid_cells(other_low[others], other_high[others], width)
        order = np.argsort(key, kind="stable")
        at, key = others[at[order]], key[order]
        rows, wanted = _grid_cells(low[boxes], high[boxes], width)
        first = np.searchsorted(key, wanted, "left")
        count = np.searchsorted(key, wanted, "right") - first
        for one, position in _expand(boxes[rows], first, count):
            other = at[position]
            meet = (low[one] <= other_high[other]) & (other_low[other] <= high[one])
            keep = meet.all(axis=1)
            yield one[keep], other[keep]
            left -= len(one)
            if left < 0:
                return


def near_any(low: Array, high: Array, cell_low: Array, cell_high: Array) -> Array:
    """Rows of cells that share a cube of a coarse grid with a boundary facet."""
    if len(cell_low) < 1000 or not len(low):
        return np.arange(len(cell_low))
    least, greatest = cell_low.min(axis=0), cell_high.max(axis=0)
    n = 64 if low.shape[1] == 3 else 256
    width = np.maximum((greatest - least).max() / n, 1e-300)
    shape = np.floor((greatest - least) / width).astype(np.int64) + 1
    used = np.zeros(shape, dtype=bool)
    first = np.clip(np.floor((low - least) / width).astype(np.int64), 0, shape - 1)
    last = np.clip(np.floor((high - least) / width).astype(np.int64), 0, shape - 1)
    # A running sum over corners of boxes says in one pass which cubes the boxes cover.
    count = np.zeros(shape + 1, dtype=np.int64)
    for corner in product((0, 1), repeat=low.shape[1]):
        at = np.where(np.array(corner) == 1, last + 1, first)
        np.add.at(count, tuple(at.T), (-1) ** sum(corner))
    for axis in range(low.shape[1]):
        count = np.cumsum(count, axis=axis)
    used = count[tuple(slice(0, k) for k in shape)] > 0
    total = np.zeros(shape + 1, dtype=np.int64)
    total[tuple(slice(1, None) for _ in shape)] = used
    for axis in range(low.shape[1]):
        total = np.cumsum(total, axis=axis)
    first = np.clip(np.floor((cell_low - least) / width).astype(np.int64), 0, shape - 1)
    last = np.clip(np.floor((cell_high - least) / width).astype(np.int64), 0, shape - 1)
    inside = np.zeros(len(cell_low), dtype=np.int64)
    for corner in product((0, 1), repeat=low.shape[1]):
        at = np.where(np.array(corner) == 1, first, last + 1)
        inside += (-1) ** sum(corner) * total[tuple(at.T)]
    return np.flatnonzero(inside > 0)


def grid_widths(size: Array) -> Pairs:
    """Width of the grid that boxes are put in, (n,), and its logarithm along each axis (n, d).

    Powers of 16, since every size of the grid costs a search for all boxes.
    """
    levels = np.frexp(np.maximum(size, 2.0**-45))[1] // 4 * 4 + 3
    return 2.0 ** levels.min(axis=1, initial=1024), levels


def _grid_cells(low: Array, high: Array, width: Array) -> Pairs:
    """Rows of boxes and keys of the grid cells they are in; no box exceeds a cell."""
    first = np.floor(low / width).astype(np.int64)
    last = np.floor(high / width).astype(np.int64)
    rows, keys = [], []
    factors = np.array([73856093, 19349663, 83492791][: low.shape[1]])
    for step in product((0, 1), repeat=low.shape[1]):
        cell = first + np.array(step)
        row = np.flatnonzero((cell <= last).all(axis=1))
        rows.append(row)
        # Two cells with one key cost time, not truth: the boxes are compared afterwards.
        keys.append((cell[row] * factors).sum(axis=1))
    return np.concatenate(rows), np.concatenate(keys)


def _expand(rows: Array, first: Array, count: Array) -> Iterator[Pairs]:
    """Each row with the positions `first, ..., first + count - 1`, many at a time."""
    rows, first, count = rows[count > 0], first[count > 0], count[count > 0]
    total = np.cumsum(count)
    begin = 0
    while begin < len(rows):
        done = total[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + (1 << 19), "right")))
        n = count[begin:end]
        step = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
        yield np.repeat(rows[begin:end], n), np.repeat(first[begin:end], n) + step
        begin = end


def lies_on(points: Array, noise: Array, vertices: Array, facets: Array, touch: float) -> Array:
    """Whether vertices lie on edges or triangles, but at no corner of them.

    Parameters
    ----------
    points : (np, d) float64
    noise : (np,) float64
    vertices : (n,) int64
    facets : (n, 2) or (n, 3) int64
    touch : float
        Part of the longest edge of the facet.
    """
    corners = points[facets]
    away = points[vertices][:, None] - corners
    longest = geometry.norms(np.roll(corners, -1, axis=1) - corners).max(axis=1, initial=0.0)
    margin = touch * longest + noise[facets].max(axis=1, initial=0.0)
    a = corners[:, 1] - corners[:, 0]
    if facets.shape[1] == 2:
        along = np.einsum("ij,ij->i", away[:, 0], a) / np.einsum("ij,ij->i", a, a)
        inside = (along > 0) & (along < 1)
        distance = geometry.norms(away[:, 0] - along[:, None] * a)
    else:
        normal = np.cross(a, corners[:, 2] - corners[:, 0])
        area = geometry.norms(normal)
        unit = normal / area[:, None]
        distance = np.abs(np.einsum("ij,ij->i", away[:, 0], unit))
        # Distance to each side, towards the inside.
        sides = np.roll(corners, -1, axis=1) - corners
        inward = np.einsum("ijk,ik->ij", np.cross(sides, away), unit) / geometry.norms(sides)
        inside = (inward >= -margin[:, None]).all(axis=1)
    return inside & (distance <= margin) & (geometry.norms(away) > margin[:, None]).all(axis=1)
