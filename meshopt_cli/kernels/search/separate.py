"""Whether convex cells lie on different sides of a plane, pair by pair."""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import entry, inlined


@inlined
def reach_along(
    points: np.ndarray, one: np.ndarray, other: np.ndarray, pair: int, x: float, y: float, z: float
) -> float:
    """How far two cells reach into each other along a direction, infinite without one."""
    length = math.sqrt(x * x + y * y + z * z)
    origin = one[pair, 0]
    ox, oy, oz = points[origin, 0], points[origin, 1], points[origin, 2]
    low, high = math.inf, -math.inf
    for k in range(one.shape[1]):
        v = one[pair, k]
        at = (points[v, 0] - ox) * x + (points[v, 1] - oy) * y + (points[v, 2] - oz) * z
        low, high = min(low, at), max(high, at)
    other_low, other_high = math.inf, -math.inf
    for k in range(other.shape[1]):
        v = other[pair, k]
        at = (points[v, 0] - ox) * x + (points[v, 1] - oy) * y + (points[v, 2] - oz) * z
        other_low, other_high = min(other_low, at), max(other_high, at)
    # A direction that is nothing but rounding says nothing.
    if not (length > 0.0 and max(high - low, other_high - other_low) > 0.0):
        return math.inf
    return min(high - other_low, other_high - low) / length


@inlined
def reach_across(
    points: np.ndarray,
    one: np.ndarray,
    other: np.ndarray,
    pair: int,
    a: int,
    b: int,
    c: int,
    d: int,
) -> float:
    """The same along the normal of two edges, a to b and c to d."""
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    vx, vy = points[d, 0] - points[c, 0], points[d, 1] - points[c, 1]
    uz, vz = points[b, 2] - points[a, 2], points[d, 2] - points[c, 2]
    return reach_along(
        points, one, other, pair, uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    )


@entry(
    group="check",
    example=lambda work: (
        work.mesh.points, work.mesh.cells, work.mesh.cells, work.mesh.quality,
        work.facets, work.facets, work.facets, work.facets, work.mesh.quality,
    ),
)  # fmt: skip
def depths(
    points: np.ndarray,
    one: np.ndarray,
    other: np.ndarray,
    limit: np.ndarray,
    facets: np.ndarray,
    other_facets: np.ndarray,
    edges: np.ndarray,
    other_edges: np.ndarray,
    depth: np.ndarray,
) -> None:
    """How deep cells reach into each other, as far as it matters.

    Parameters
    ----------
    points : (np, 3) float64
    one, other : (n, k) int64
        Corners of the cells of each pair.
    limit : (n,) float64
        The search for a smaller depth ends at the first that is no larger than this.
    facets, other_facets : (m, 3) int64
        Local corners of triangles that facets lie in.
    edges, other_edges : (m, 2) int64
        Local ends of edges.
    depth : (n,) float64
        Written: the least depth over the directions that were tried.
    """
    for pair in range(len(limit)):
        least = math.inf
        for side in range(2):
            table = facets if side == 0 else other_facets
            cells = one if side == 0 else other
            for row in range(len(table)):
                if least > limit[pair]:
                    a = cells[pair, table[row, 0]]
                    b, c = cells[pair, table[row, 1]], cells[pair, table[row, 2]]
                    least = min(least, reach_across(points, one, other, pair, a, b, a, c))
        for row in range(len(edges)):
            for column in range(len(other_edges)):
                if least > limit[pair]:
                    a, b = one[pair, edges[row, 0]], one[pair, edges[row, 1]]
                    c, d = other[pair, other_edges[column, 0]], other[pair, other_edges[column, 1]]
                    least = min(least, reach_across(points, one, other, pair, a, b, c, d))
        depth[pair] = least
