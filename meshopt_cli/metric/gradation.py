"""How fast sizes may grow from one vertex to the next.

A metric that jumps cannot be met: cells of one size beside those of another are bad. Gradation by a
factor beta makes sizes smaller, nowhere larger, until along an edge with length 1 in the metric
they grow by this factor at most.

Sizes h obey it where the h-shock of every edge is at most beta (Borouchaki, Hecht, Frey 1998: Mesh
gradation control), the ratio of the sizes of its ends to the power of 1 / its length. As h is
linear along an edge e, that is |h1 - h0| <= |e| log(beta); the greatest such sizes below those
given are the least of h + log(beta) times the way, over all ways along edges.

Tensors obey the same in all directions: one of a vertex with the sizes h_i along its axes asks of
the other end of an edge e for sizes of h_i + |e| log(beta) along these at most, the growth in
physical space of Alauzet 2010 (Size gradation control of anisotropic meshes). An end that has
larger ones gets the intersection of both by simultaneous reduction. (Growth in the space of the
metric, or the mixed one, keeps thin tensors thin far off. Where their axes turn, as along a curved
front, their intersections then ask for several times the cells, and for sizes that nobody asked
for.)
"""

from __future__ import annotations

import math

import numpy as np

from ..mesh.adjacency import distinct
from ..mesh.model import Array
from ..mesh.sizes import chunks, norms
from .field import FLAT, Metric, components

# A tensor obeys where no eigenvalue of what is asked for is larger by more than this part, or by
# so many times what is rounded of its least one.
SLACK, ROUNDING = 1e-3, 64.0 * np.finfo(float).eps
# No eigenvalue becomes larger than so many times the greatest of all, so that this ends in any
# case: what is asked for in several directions in turn is finer than each. With thin tensors of
# all directions beside each other it was 1.3 times with a factor of 1.2, and 20 times with 1.01.
CEILING = 1e4
# Of what waits, all acts at once that asks for sizes of so many times the least.
STEP = 2.0


def graded(metric: Metric, points: Array, edges: Array, beta: float) -> Metric:
    """A metric whose sizes grow by a factor of `beta` at most along an edge of length 1.

    It is nowhere coarser than the given one. Graded once more it stays as it is, and it does not
    depend on how vertices are numbered: of several neighbours the one that asks for most comes
    first, and of those that ask for the same, the first by its coordinates. Tensors obey to
    `SLACK`, sizes to rounding.

    Parameters
    ----------
    points : (np, 3) float64
        In a plane z = const where the metric is one of the plane.
    edges : (n, 2) int64
        Each once.
    beta : float
        Above 1.
    """
    reach = norms(points[edges[:, 1]] - points[edges[:, 0]]) * math.log(beta)
    ways = _Ways(edges, reach, len(points))
    if metric.is_isotropic:
        return Metric(_sizes(metric.values[:, 0], ways)[:, None], metric.source)
    place = np.empty(len(points), dtype=np.int64)
    place[np.lexsort(points.T)] = np.arange(len(points))
    return Metric(_tensors(metric, ways, place), metric.source)


class _Ways:
    """The edges in both directions, by where they start."""

    def __init__(self, edges: Array, reach: Array, n: int) -> None:
        start = edges.T.ravel()
        order = np.argsort(start, kind="stable")
        self.start = start[order]
        self.end = edges[:, ::-1].T.ravel()[order]
        self.reach = np.tile(reach, 2)[order]
        self._first = np.searchsorted(self.start, np.arange(n + 1))

    def of(self, vertices: Array) -> Array:
        """Those that start at some vertices, each given once, (m,) int64."""
        first, n = self._first[vertices], np.diff(self._first)[vertices]
        skipped = np.cumsum(n) - n
        return np.repeat(first - skipped, n) + np.arange(n.sum())


def _sizes(sizes: Array, ways: _Ways) -> Array:
    """The greatest sizes, (np,), below those given that grow by no more than the ways reach."""
    sizes = sizes.copy()
    rows = np.arange(len(ways.start))
    while len(rows):
        most = sizes[ways.start[rows]] + ways.reach[rows]
        less = most < sizes[ways.end[rows]]
        changed = ways.end[rows[less]]
        np.minimum.at(sizes, changed, most[less])
        rows = ways.of(distinct(changed))
    return sizes


def _tensors(metric: Metric, ways: _Ways, place: Array) -> Array:
    """Components of tensors of which none asks a neighbour for more than it has.

    Each change of a tensor makes its determinant larger, by `SLACK` at least, and `CEILING` is a
    bound of it: this ends.

    Parameters
    ----------
    place : (np,) int64
        Of each vertex among all.
    """
    tensors = metric.matrices.copy()
    sizes, axes = _sizes_and_axes(tensors)
    least = sizes.min(initial=math.inf) / math.sqrt(CEILING)
    waiting = np.arange(len(ways.start))
    while len(waiting):
        # The finest act first: what coarse ones ask for changes when they are made finer.
        finest = sizes[ways.start[waiting], -1] + ways.reach[waiting]
        is_next = finest <= STEP * finest.min()
        rows, waiting = waiting[is_next], waiting[~is_next]
        asked = [_asking(rows[some], ways, sizes, axes) for some in chunks(len(rows))]
        rows, most = (np.concatenate(parts) for parts in zip(*asked, strict=True))
        # The first row of each end is what is asked for most.
        order = np.lexsort((place[ways.start[rows]], -most, ways.end[rows]))
        rows = rows[order]
        ends = ways.end[rows]
        is_first = np.ones(len(rows), dtype=bool)
        is_first[1:] = ends[1:] != ends[:-1]
        now, ends = rows[is_first], ends[is_first]
        finer = intersection(
            tensors[ends], sizes[ends], axes[ends], *_asked_for(now, ways, sizes, axes)
        )
        new_sizes, new_axes = _sizes_and_axes(finer)
        fits = new_sizes[:, -1] >= least
        fits &= (finer != tensors[ends]).any(axis=(1, 2))
        changed = ends[fits]
        tensors[changed], sizes[changed], axes[changed] = (
            finer[fits], new_sizes[fits], new_axes[fits],
        )  # fmt: skip
        waiting = distinct(np.concatenate([waiting, rows[~is_first], ways.of(changed)]))
    return components(tensors)


def _sizes_and_axes(tensors: Array) -> tuple[Array, Array]:
    """Sizes, (n, d), descending, and the axes that they are along, the columns of (n, d, d)."""
    values, axes = np.linalg.eigh(tensors)
    return np.maximum(values, FLAT * values[:, -1:]) ** -0.5, axes


def _asked_for(rows: Array, ways: _Ways, sizes: Array, axes: Array) -> tuple[Array, Array]:
    """Sizes and axes that some ways ask for where they end."""
    start = ways.start[rows]
    return sizes[start] + ways.reach[rows, None], axes[start]


def _asking(rows: Array, ways: _Ways, sizes: Array, axes: Array) -> tuple[Array, Array]:
    """Which of some ways ask more of their ends than these have, and how many times as much."""
    end = ways.end[rows]
    seen = _seen(sizes[end], axes[end], *_asked_for(rows, ways, sizes, axes))
    limit = 1.0 + SLACK + ROUNDING * (sizes[end, 0] / sizes[end, -1]) ** 2
    asks = ~_is_definite(limit[:, None, None] * np.eye(axes.shape[1]) - seen)
    return rows[asks], np.linalg.eigvalsh(seen[asks])[:, -1]


def _is_definite(tensors: Array) -> Array:
    """Which symmetric matrices are positive definite, by their leading minors: (n,) bool."""
    a, b, c = tensors[:, 0, 0], tensors[:, 0, 1], tensors[:, 1, 1]
    minor = a * c - b * b
    found = (a > 0.0) & (minor > 0.0)
    if tensors.shape[1] == 3:
        d, e, f = tensors[:, 0, 2], tensors[:, 1, 2], tensors[:, 2, 2]
        found &= f * minor - a * e * e + 2.0 * b * d * e - c * d * d > 0.0
    return found


def _seen(sizes: Array, axes: Array, others: Array, along: Array) -> Array:
    """Tensors as they are seen in those with other sizes and axes, which are 1 there, (n, d, d)."""
    half = sizes[:, :, None] * (axes.transpose(0, 2, 1) @ along) / others[:, None, :]
    return half @ half.transpose(0, 2, 1)


def intersection(tensors: Array, sizes: Array, axes: Array, others: Array, along: Array) -> Array:
    """Tensors whose sizes are, in every direction, those of neither of two or less, (n, d, d).

    Both have a diagonal in common axes, where the greater entries count (simultaneous reduction).

    Parameters
    ----------
    tensors : (n, d, d)
        The first of both, with `sizes` and `axes`.
    others, along : (n, d), (n, d, d)
        The sizes of the second, and the axes that they are along.
    """
    values, turned = np.linalg.eigh(_seen(sizes, axes, others, along))
    common = (axes / sizes[:, None, :]) @ turned
    # What the first lacks is added to it, so that where it lacks nothing it stays.
    more = common * np.sqrt(np.maximum(values - 1.0, 0.0))[:, None, :]
    return tensors + more @ more.transpose(0, 2, 1)
