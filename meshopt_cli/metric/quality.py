"""Cells in a metric: contents, Q by (18.13) to (18.18), unit and optimal cells."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from ..mesh.sizes import chunks, contents
from ..quality.measures import Measure
from .domain import Domain
from .field import Metric
from .lengths import edge_lengths, gauss, mapped, shares

N_GAUSS = 4  # points in each direction of a simplex


def metric_quality(
    points: Array, cells: Array, family: str, metric: Metric, measure: Measure
) -> Array:
    """Q of cells in a metric, (n,), whichever their orientation.

    Q of a cell is the worst over its vertices (18.13), of what the metric there, as one of the
    whole cell, makes of it (18.14): T of the vertex, with T^t T = M, takes the cell to the usual
    space, where it is measured plainly. Of a triangle by its aspect ratio that is (18.18), where
    the root is of det M alone: the area of the cell stands outside. So every measure is one in a
    metric. Sizes change no shape.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
    family : str
        A key of `measure.ways`.
    """
    if metric.is_isotropic:
        return measure.of(points, cells, family)
    found = [np.empty(0)]
    for rows in chunks(len(cells)):
        some = cells[rows]
        edges = points[some] - points[some[:, :1]]
        alone = np.arange(some.size).reshape(some.shape)
        worst = np.zeros(len(some))
        for vertex in some.T:
            image = np.einsum("nij,nkj->nki", metric.maps[vertex], edges)
            worst = np.maximum(worst, measure.of(image.reshape(-1, 3), alone, family))
        found.append(worst)
    return np.concatenate(found)


def metric_contents(points: Array, cells: Array, family: str, metric: Metric) -> Array:
    """Areas or volumes of cells in a metric, (n,): the integral of sqrt(det M), never negative.

    Sizes are linear in a simplex, logarithms of tensors too, as along edges. It is integrated by
    products of Gauss points; other cells by the simplices of their first partition. Where faces of
    a surface have tensors of space, these are taken in the plane of each.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
    """
    total = np.zeros(len(cells))
    for simplex in FAMILIES[family].partitions[0]:
        parts = [_simplex_contents(points, cells[rows][:, simplex], metric)
                 for rows in chunks(len(cells))]  # fmt: skip
        total += np.concatenate([np.empty(0), *parts])
    return total


def _simplex_contents(points: Array, cells: Array, metric: Metric) -> Array:
    d = cells.shape[1] - 1
    places, weights = rule(d)
    if d == 2 and not metric.is_isotropic and metric.width == 3:
        vectors = points[cells[:, 1:]] - points[cells[:, :1]]
        total = np.zeros(len(cells))
        logarithms = metric.logarithms[cells]
        for place, weight in zip(places, weights, strict=True):
            a, b = mapped(np.einsum("k,nkj->nj", place, logarithms), vectors).transpose(1, 0, 2)
            total += weight * np.linalg.norm(np.cross(a, b), axis=1) / 2.0
        return total
    plain = np.abs(contents(points, cells, "triangle" if d == 2 else "tetra"))
    if metric.is_isotropic:
        return plain * ((metric.values[cells, 0] @ places.T) ** -d @ weights)
    # sqrt(det M) = exp(trace(log M) / 2)
    diagonal = metric.logarithms[:, [0, 2] if metric.width == 2 else [0, 2, 5]]
    return plain * (np.exp(diagonal.sum(axis=1)[cells] @ places.T / 2.0) @ weights)


def rule(d: int) -> tuple[Array, Array]:
    """Points and weights on a simplex: barycentric coordinates (n, d + 1), weights (n,) of sum 1.

    Products of Gauss points on the cube, which is pressed together to the simplex.
    """
    ones, weights = gauss(N_GAUSS)
    places, of = [], []
    for indices in product(range(N_GAUSS), repeat=d):
        rest, weight, coordinates = 1.0, 1.0, []
        for k, i in enumerate(indices):
            coordinates.append(rest * ones[i])
            # of the volume element: rest of this coordinate to the power of those to come
            weight *= weights[i] * (1.0 - ones[i]) ** (d - 1 - k) * (d - k)
            rest *= 1.0 - ones[i]
        places.append([rest, *coordinates])
        of.append(weight)
    return np.array(places), np.array(of)


def unit_content(family: str) -> float:
    """Area or volume of the ideal cell with edges of length 1: sqrt(3) / 4, sqrt(2) / 12, ..."""
    row = FAMILIES[family]
    return float(contents(row.reference, np.arange(row.n_corners)[None], family)[0])


def unit_shares(domain: Domain, lengths: Array) -> dict[str, Array]:
    """How near each cell is to a unit cell (Definition 18.3), by families: (n,) in [0, 1].

    The least e of (18.12) over its edges: 1 if all have length 1.

    Parameters
    ----------
    lengths : (n_edges,) float64
        Those of `domain.edges`.
    """
    found = shares(lengths)
    return {f: found[edges].min(axis=1) for f, edges in domain.edges_of_cells.items()}


def optimal_shares(
    domain: Domain, metric: Metric, lengths: Array, sizes: dict[str, Array]
) -> dict[str, Array]:
    """How near each cell is to an optimal one (Definition 18.4), by families: (n,) in [0, 1].

    The least of that of `unit_shares`, and of e of the edge of an ideal cell with the same content
    in the metric; of quads, and of quad faces, also that of diagonals next to sqrt(2) (18.3.2).

    Parameters
    ----------
    sizes : dict of str to (n,)
        Contents in the metric.
    """
    result = {}
    for family, near in unit_shares(domain, lengths).items():
        d = FAMILIES[family].dimension
        edge = (sizes[family] / unit_content(family)) ** (1.0 / d)
        result[family] = np.minimum(near, shares(edge))
        for diagonal in diagonals_of(family):
            ends = domain.cells[family][:, diagonal]
            across = edge_lengths(domain.points, metric, ends) / np.sqrt(2.0)
            result[family] = np.minimum(result[family], shares(across))
    return result


def diagonals_of(family: str) -> list[list[int]]:
    """Local ends of the diagonals of a quad, or of the quad faces of a solid."""
    row = FAMILIES[family]
    if row.dimension == 2:
        faces = [list(range(row.n_corners))]
    else:
        faces = [face for table in row.facets for face in table.tolist()]
    return [[f[i], f[i + 2]] for f in faces if len(f) == 4 for i in range(2)]
