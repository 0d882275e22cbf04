"""In which cell of a mesh a point lies, and where in it (18.1.3)."""

from __future__ import annotations

import numpy as np

from ..kernels.search.locate import Grid, locate
from ..mesh.cast import Simplices
from ..mesh.model import Array

CELLS_PER_BOX = 4  # of the control grid, on the average


def cells_at(
    before: Simplices, queries: Array, region: Array, grid: Grid | None = None
) -> tuple[Array, Array]:
    """Find the cells of a mesh in which points lie.

    Parameters
    ----------
    queries : (n, 3) float64
        In the plane of a planar mesh, as `Simplices.points` are.
    region : (n,) int64
        The region to look in for each.
    grid : Grid, optional
        What `control_grid` gives for the mesh, where it is asked more than once.

    Returns
    -------
    cells : (n,) int64
        -1 where there is no such region.
    weights : (n, d + 1) float64
        Barycentric coordinates, of sum 1; those of the nearest place for points outside.
    """
    found = np.empty(len(queries), np.int64)
    weights = np.empty((len(queries), before.cells.shape[1]))
    if len(queries):
        locate(
            before.points, before.cells, before.neighbours, before.region,
            control_grid(before) if grid is None else grid,
            np.ascontiguousarray(queries), np.ascontiguousarray(region), found, weights,
        )  # fmt: skip
    return found, weights


def control_grid(mesh: Simplices) -> Grid:
    """Sort the cells of a mesh into boxes by their centres."""
    centres = mesh.points[mesh.cells].mean(axis=1)
    low, extent = centres.min(axis=0), np.ptp(centres, axis=0)
    longest = float(extent.max()) or 1.0
    # A flat mesh has one layer of boxes, and no direction more boxes than there are cells.
    wide = extent > 1e-3 * longest
    n_boxes = max(len(centres) / CELLS_PER_BOX, 1.0)
    share = float(np.prod(extent[wide] / longest)) / n_boxes
    step = longest * max(share ** (1.0 / max(int(wide.sum()), 1)), 1.0 / n_boxes)
    shape = (extent / step).astype(np.int64) + 1
    place = np.minimum(((centres - low) / step).astype(np.int64), shape - 1)
    box = (place[:, 0] * shape[1] + place[:, 1]) * shape[2] + place[:, 2]
    first = np.concatenate([[0], np.cumsum(np.bincount(box, minlength=int(np.prod(shape))))])
    return Grid(low, step, shape, first, np.argsort(box, kind="stable"))
