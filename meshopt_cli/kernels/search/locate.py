"""Point location: the walk by signed volumes (18.1.3), from the cells of a control grid.

A point lies in a cell when its volumes with all facets are positive; through a facet of a
negative one leads the way. Where the boundary of a region is in the way (Remark 18.2), the
walk starts again from other cells near the point.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled.decorators import entry, kernel
from ..vectors import Vec, at, cross, distance, dot, minus

MAX_STEPS = 1000  # of one walk
MAX_STRAIGHT = 64  # steps by the most negative volume: it may go in circles
MAX_SEEDS = 32  # walks, before every cell of the region is looked at
INSIDE = -1e-12  # the least weight of a point inside
NEARLY = -1e-6  # the same where no cell is better: in flat cells all weights are inexact


class Grid(NamedTuple):
    """The control grid: in which box the centre of each cell lies."""

    low: np.ndarray  # (3,) float64 corner
    step: float  # side of a box
    shape: np.ndarray  # (3,) int64 boxes in each direction
    first: np.ndarray  # (n_boxes + 1,) int64 where each box starts in `members`
    members: np.ndarray  # (ne,) int64 cells, box by box


@kernel
def weigh(
    points: np.ndarray, cells: np.ndarray, cell: int, p: Vec, weights: np.ndarray, row: int
) -> float:
    """Write the barycentric coordinates of p in a cell into a row; returns the least.

    They are volumes over that of the cell (18.3), improved by what they leave of p, so that
    they give p back to rounding in flat cells too. The least is -inf in a cell of volume 0.
    """
    width = cells.shape[1]
    o = at(points, cells[cell, 0])
    a = minus(at(points, cells[cell, 1]), o)
    b = minus(at(points, cells[cell, 2]), o)
    c = minus(at(points, cells[cell, 3]), o) if width == 4 else Vec(0.0, 0.0, 1.0)
    bc = cross(b, c)
    ca = cross(c, a)
    ab = cross(a, b)
    volume = dot(a, bc)
    if not abs(volume) > 0.0:
        return -math.inf
    whole = minus(p, o)
    rest = whole
    u = 0.0
    v = 0.0
    w = 0.0
    for _ in range(3):
        u += dot(rest, bc) / volume
        v += dot(rest, ca) / volume
        w += dot(rest, ab) / volume
        rest = Vec(
            whole.x - u * a.x - v * b.x - w * c.x,
            whole.y - u * a.y - v * b.y - w * c.y,
            whole.z - u * a.z - v * b.z - w * c.z,
        )
    weights[row, 1] = u
    weights[row, 2] = v
    least = min(u, v)
    if width == 4:
        weights[row, 3] = w
        least = min(least, w)
    else:
        w = 0.0
    weights[row, 0] = 1.0 - u - v - w
    return min(least, weights[row, 0])


@kernel
def walk(
    points: np.ndarray,
    cells: np.ndarray,
    neighbours: np.ndarray,
    start: int,
    p: Vec,
    weights: np.ndarray,
    row: int,
) -> tuple[int, float]:
    """Walk from cell to cell towards p, inside the region of the first.

    Returns
    -------
    cell : int
        The cell that holds p, or the one that came nearest to it.
    least : float
        The least weight of p there.
    """
    width = cells.shape[1]
    cell = start
    nearest = start
    best = -math.inf
    for step in range(MAX_STEPS):
        least = weigh(points, cells, cell, p, weights, row)
        if least > best:
            best = least
            nearest = cell
        if least >= INSIDE:
            break
        onward = -1
        lowest = 0.0
        for i in range(width):
            k = (i + step) % width
            if weights[row, k] < lowest and neighbours[cell, k] >= 0:
                onward = neighbours[cell, k] >> 2
                lowest = weights[row, k]
                if step > MAX_STRAIGHT:
                    break
        if onward < 0:
            break
        cell = onward
    return nearest, best


@kernel
def nearest_of_all(
    points: np.ndarray,
    cells: np.ndarray,
    region: np.ndarray,
    wanted: int,
    p: Vec,
    weights: np.ndarray,
    row: int,
) -> int:
    """The cell of a region that comes nearest to p, with weights in it that are not negative."""
    width = cells.shape[1]
    nearest = -1
    shortest = math.inf
    for cell in range(cells.shape[0]):
        if region[cell] == wanted:
            away = clamp(points, cells, cell, p, weights, row)
            if away < shortest:
                shortest = away
                nearest = cell
    if nearest >= 0:
        clamp(points, cells, nearest, p, weights, row)
    for k in range(width):
        if nearest < 0:
            weights[row, k] = 0.0
    return nearest


@kernel
def clamp(
    points: np.ndarray, cells: np.ndarray, cell: int, p: Vec, weights: np.ndarray, row: int
) -> float:
    """Write weights of p that are not negative, and return how far off they lie."""
    width = cells.shape[1]
    if weigh(points, cells, cell, p, weights, row) == -math.inf:
        return math.inf
    total = 0.0
    for k in range(width):
        weights[row, k] = max(weights[row, k], 0.0)
        total += weights[row, k]
    x = 0.0
    y = 0.0
    z = 0.0
    for k in range(width):
        weights[row, k] /= total
        x += weights[row, k] * points[cells[cell, k], 0]
        y += weights[row, k] * points[cells[cell, k], 1]
        z += weights[row, k] * points[cells[cell, k], 2]
    return distance(Vec(x, y, z), p)


@kernel
def box_along(grid: Grid, x: float, axis: int) -> int:
    """The number of the box along an axis that a coordinate falls in, or the one next to it."""
    place = (x - grid.low[axis]) / grid.step
    return int(min(max(place, 0.0), grid.shape[axis] - 1.0))


@kernel
def search(
    points: np.ndarray,
    cells: np.ndarray,
    neighbours: np.ndarray,
    region: np.ndarray,
    grid: Grid,
    p: Vec,
    wanted: int,
    weights: np.ndarray,
    row: int,
) -> tuple[int, float]:
    """Find the cell of a region that holds p: walks from the boxes around it, ring by ring."""
    i = box_along(grid, p.x, 0)
    j = box_along(grid, p.y, 1)
    k = box_along(grid, p.z, 2)
    nearest = -1
    best = -math.inf
    n_seeds = 0
    for ring in range(max(grid.shape[0], grid.shape[1], grid.shape[2])):
        for x in range(max(i - ring, 0), min(i + ring + 1, grid.shape[0])):
            for y in range(max(j - ring, 0), min(j + ring + 1, grid.shape[1])):
                on_shell = abs(x - i) == ring or abs(y - j) == ring
                for z in range(max(k - ring, 0), min(k + ring + 1, grid.shape[2])):
                    if not on_shell and abs(z - k) != ring:
                        continue
                    box = (x * grid.shape[1] + y) * grid.shape[2] + z
                    for m in range(grid.first[box], grid.first[box + 1]):
                        seed = grid.members[m]
                        if region[seed] != wanted:
                            continue
                        cell, least = walk(points, cells, neighbours, seed, p, weights, row)
                        if least > best:
                            best = least
                            nearest = cell
                        n_seeds += 1
                        if best >= NEARLY or n_seeds == MAX_SEEDS:
                            return nearest, best
    return nearest, best


@entry(
    group="basic",
    example=lambda work: (
        work.mesh.points, work.mesh.cells, work.mesh.neighbours, work.mesh.region,
        Grid(work.mesh.points[0], 1.0, work.order, work.order, work.order),
        work.mesh.points, work.order, work.order, work.mesh.guide,
    ),
)  # fmt: skip
def locate(
    points: np.ndarray,
    cells: np.ndarray,
    neighbours: np.ndarray,
    region: np.ndarray,
    grid: Grid,
    queries: np.ndarray,
    wanted: np.ndarray,
    found: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Find the cell that holds each of some points.

    Parameters
    ----------
    points, cells : (np, 3) float64, (ne, d + 1) int64
    neighbours : (ne, d + 1) int64
        None beyond the facets of a region.
    region : (ne,) int64
    grid : Grid
    queries : (n, 3) float64
    wanted : (n,) int64
        Region of each; where there is none of that number, no cell is found.
    found : (n,) int64
        Filled with cells, -1 for none.
    weights : (n, d + 1) float64
        Filled with barycentric coordinates. A point outside its region gets those of
        the nearest place in it.
    """
    for n in range(queries.shape[0]):
        p = at(queries, n)
        cell, least = search(points, cells, neighbours, region, grid, p, wanted[n], weights, n)
        if least >= NEARLY:
            weigh(points, cells, cell, p, weights, n)
        else:
            cell = nearest_of_all(points, cells, region, wanted[n], p, weights, n)
        found[n] = cell
