"""The metric that a mesh has by itself: in which its cells are unit and regular."""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from .field import Metric, components, exponential

# Cells that are flatter than this count for nothing: what they say of one direction is rounding.
FLATTEST = 1e-7


def implied(points: Array, cells: dict[str, Array], is_flat: bool) -> Metric:
    """The log-Euclidean mean, at each vertex, of the metrics of its cells.

    That of a triangle or tetrahedron is the one in which all its edges have length 1. Of other
    cells it is the log-Euclidean mean over their corners: at each, the one in which the edges there
    are those of the ideal cell. Cells without content count for nothing.

    Parameters
    ----------
    points : (np, 3) float64
    cells : dict of str to (n, k) int64
        By families, which are all of dimension 2 or all of dimension 3.
    is_flat : bool
        Whether faces lie in the plane of x and y; else each gives the mean of its sizes to the
        direction normal to it.

    Returns
    -------
    Metric
        With tensors; not a number at vertices without any cell that has content.
    """
    d = 2 if is_flat else 3
    k = d * (d + 1) // 2
    total, count = np.zeros((len(points), k)), np.zeros(len(points))
    for family, rows in cells.items():
        logarithms = _cell_logarithms(points, rows, family, is_flat)
        sound = np.isfinite(logarithms).all(axis=1)
        for corner in rows[sound].T:
            count += np.bincount(corner, minlength=len(points))
            for j in range(k):
                total[:, j] += np.bincount(corner, logarithms[sound, j], minlength=len(points))
    mean = np.divide(total, count[:, None], out=np.full_like(total, np.nan),
                     where=count[:, None] > 0.0)  # fmt: skip
    there = count > 0.0
    mean[there] = exponential(mean[there])
    return Metric(mean, "the mesh itself")


def _cell_logarithms(points: Array, cells: Array, family: str, is_flat: bool) -> Array:
    """Components of the logarithm of the metric of each cell, not a number of flat ones."""
    row = FAMILIES[family]
    dimension = row.dimension
    found = []
    for corner in row.corners:
        ideal = row.reference[corner[1:]] - row.reference[corner[:1]]
        edges = points[cells[:, corner[1:]]] - points[cells[:, corner[:1]]]
        if dimension == 2 and is_flat:
            ideal, edges = ideal[:, :2], edges[:, :, :2]
        elif dimension == 2:
            # The third edge is normal, as large as those in the plane are on average.
            normal = np.cross(edges[:, 0], edges[:, 1])
            area = np.sqrt(np.einsum("ni,ni->n", normal, normal))[:, None]
            least = np.linalg.norm(np.cross(ideal[0], ideal[1]))
            unit = np.divide(normal, area, out=np.zeros_like(normal), where=area > 0.0)
            edges = np.concatenate([edges, (unit * np.sqrt(area / least))[:, None]], axis=1)
            ideal = np.concatenate([ideal, [[0.0, 0.0, 1.0]]])
        found.append(_logarithms(edges, ideal))
    return np.mean(found, axis=0)


def _logarithms(edges: Array, ideal: Array) -> Array:
    """Of the metrics M in which some edges are as ideal ones: E M E^t = R R^t.

    Parameters
    ----------
    edges : (n, d, d)
        A row an edge.
    ideal : (d, d)
    """
    d = len(ideal)
    result = np.full((len(edges), d * (d + 1) // 2), np.nan)
    singular = np.linalg.svd(edges, compute_uv=False)
    sound = singular[:, -1] > FLATTEST * singular[:, 0]
    # M^-1 = (R^-1 E)^t (R^-1 E), whose singular values are the sizes.
    _, sizes, axes = np.linalg.svd(np.linalg.solve(ideal, edges[sound]))
    logarithms = (axes.transpose(0, 2, 1) * (-2.0 * np.log(sizes))[:, None, :]) @ axes
    result[sound] = components(logarithms)
    return result
