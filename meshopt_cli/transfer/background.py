"""The metric of the input, wherever vertices of the work come to be (18.3)."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..kernels.search.locate import Grid
from ..mesh.cast import Simplices
from ..mesh.model import Array
from ..metric.field import Metric, components, exponential, matrices
from ..metric.formula import Formula
from .places import cells_at, control_grid


class MetricOfInput:
    """A metric between the vertices of the input, as a working mesh takes it.

    Sizes are linear in each cell, and so are the logarithms of tensors. Sizes by a formula are
    those of the formula everywhere. Tensors are rows (xx, xy, yy, xz, yz, zz), in the plane of a
    planar mesh with zz = 1.

    Parameters
    ----------
    part : Simplices
        The input.
    metric : Metric
        A row for each of its points, as `metric.field.fitted` makes it.
    formula : Formula, optional
        Of sizes, which `metric` has the values of.
    """

    def __init__(self, part: Simplices, metric: Metric, formula: Formula | None = None) -> None:
        self._part = part
        self._formula = formula
        self._is_isotropic = metric.is_isotropic
        self._dimension = part.cells.shape[1] - 1
        self._values = metric.values
        if not metric.is_isotropic:
            self._values = self._in_frame(metric)

    @cached_property
    def is_isotropic(self) -> bool:
        """Whether it is the same in all directions everywhere."""
        if self._is_isotropic:
            return True
        whole = matrices(self._values)
        return bool((whole == whole[:, :1, :1] * np.eye(whole.shape[1])).all())

    @property
    def at_points(self) -> Array:
        """The metric at the points of the input, (np, 6)."""
        return self._rows(self._values)

    def at(self, points: Array, region: Array) -> Array:
        """The metric in some places, (n, 3) as `Simplices.points` are, of regions: (n, 6)."""
        return self._rows(self.values_at(points, region))

    def values_at(self, points: Array, region: Array) -> Array:
        """The same with the components of `metric.field.Metric`: (n, 1), (n, 3) or (n, 6)."""
        if self._formula is not None:
            return self._formula.at(self._in_space(points))[:, None]
        cells, weights = cells_at(self._part, points, region, self._grid)
        corners = self._part.cells[cells]
        if self._is_isotropic:
            return np.einsum("nk,nki->ni", weights, self._values[corners])
        return exponential(np.einsum("nk,nki->ni", weights, self._logarithms[corners]))

    @cached_property
    def _grid(self) -> Grid:
        return control_grid(self._part)

    @cached_property
    def _logarithms(self) -> Array:
        return Metric(self._values, "").logarithms

    def _in_space(self, points: Array) -> Array:
        frame = self._part.frame
        return points if frame is None else frame.origin + points[:, :2] @ frame.axes[:2]

    def _in_frame(self, metric: Metric) -> Array:
        """Tensors as the frame of a plane sees them."""
        frame = self._part.frame
        if frame is None:
            return metric.values
        whole = np.tile(np.eye(3), (len(metric.values), 1, 1))
        whole[:, : metric.width, : metric.width] = metric.matrices
        return components((frame.axes @ whole @ frame.axes.T)[:, :2, :2])

    def _rows(self, values: Array) -> Array:
        k = values.shape[1]
        if k == 6:
            return values
        rows = np.zeros((len(values), 6))
        if k == 3:
            rows[:, :3], rows[:, 5] = values, 1.0
        else:
            rows[:, [0, 2, 5]] = 1.0 / values**2
            if self._dimension == 2:
                rows[:, 5] = 1.0
        return rows
