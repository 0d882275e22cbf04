"""Search for boxes that overlap, whatever is in them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np

from ..mesh.adjacency import distinct_rows
from ..mesh.model import Array
from .geometry import Pairs

MOST_PAIRS = 200  # pairs of boxes to look at, for each box; sound meshes need a few


def bounding(points: Array, noise: Array, rows: Array, touch: float) -> Pairs:
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
    widths, grid = grid_widths(size)
    by_grid = np.argsort(grid, kind="stable")
    starts = np.flatnonzero(np.diff(grid[by_grid], prepend=-1))
    for start, end in pairwise([*starts.tolist(), len(grid)]):
        others = by_grid[start:end]
        width = widths[others[0]]
        near = (low <= other_high[others].max(axis=0)) & (other_low[others].min(axis=0) <= high)
        boxes = np.flatnonzero((near & (high - low <= width)).all(axis=1))
        at, key = _grid_cells(other_low[others], other_high[others], width)
        order = np.argsort(key, kind="stable")
        at, key = others[at[order]], key[order]
        rows, wanted = _grid_cells(low[boxes], high[boxes], width)
        first = np.searchsorted(key, wanted, "left")
        count = np.searchsorted(key, wanted, "right") - first
        for row, position in _expand(boxes[rows], first, count):
            left -= len(row)
            one, other = row, at[position]
            for axis in range(low.shape[1]):  # most pairs are apart along the first already
                keep = low[one, axis] <= other_high[other, axis]
                keep &= other_low[other, axis] <= high[one, axis]
                one, other = one[keep], other[keep]
            yield one, other
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
    """Width of the grid that each box is put in, (n, d), and the number of that grid, (n,).

    Boxes share a grid where the powers of 16 above their sizes are the same, since every grid
    costs a search for all boxes; it is little wider than the largest of them.
    """
    levels = np.frexp(np.maximum(size, 2.0**-45))[1] // 4
    grids, grid, _ = distinct_rows(levels)
    width = np.full(grids.shape, 2.0**-45)
    for axis in range(size.shape[1]):
        np.maximum.at(width[:, axis], grid, size[:, axis])
    return (1.0 + 2.0**-6) * width[grid], grid


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
