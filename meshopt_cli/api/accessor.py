"""`grid.meshopt`: what pyvista's grids and surfaces can do once this package is installed.

pyvista finds it by an entry point, and imports it at its first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pyvista

from .calls import check, optimize, report

if TYPE_CHECKING:
    from .results import Appraisal, Report


@pyvista.register_dataset_accessor("meshopt", pyvista.UnstructuredGrid)
@pyvista.register_dataset_accessor("meshopt", pyvista.PolyData)
class Accessor:
    """A data set, to be optimized, checked and measured."""

    def __init__(self, data: pyvista.DataSet) -> None:
        self._data = data

    def optimize(self, **options: Any) -> pyvista.DataSet:
        """A better data set of the same kind; options are those of `meshopt_cli.optimize`."""
        return optimize(self._data, **options).mesh

    def check(self, **options: Any) -> Report:
        """What makes it invalid; options are those of `meshopt_cli.check`."""
        return check(self._data, **options)

    def report(self, **options: Any) -> Appraisal:
        """What it is worth; options are those of `meshopt_cli.report`."""
        return report(self._data, **options)

    def quality(self, measure: str = "aspect-ratio") -> np.ndarray:
        """A measure of each cell, (n,) float64, not a number for cells that do not have it.

        Parameters
        ----------
        measure : str
            See `meshopt list measures`.

        Raises
        ------
        ConfigError
            There is no such measure.
        ReadError, BadMeshError
            There are no cells to measure.
        """
        values = report(self._data, measure=measure).quality()
        left_out = self._data.n_cells - len(values)  # such as poly-lines, at the end
        return np.pad(values, (0, left_out), constant_values=np.nan)
