"""What of a mesh is seen in a metric: its cells by their corners, and its boundary."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..cells import FAMILIES
from ..mesh import adjacency
from ..mesh.borders import of_mesh
from ..mesh.model import Array, Mesh
from ..mesh.plane import flatness, precision_of, with_depth


@dataclass(frozen=True)
class Domain:
    """The cells of greatest dimension of a mesh.

    Attributes
    ----------
    points : (np, 3) float64
        All points of the file, where they are in space; with z = 0 if the mesh `is_flat`.
    cells : dict of str to (n, k) int64
        Corners by families, in the order of the file.
    bound : (np,) bool
        Which points are vertices of the boundary, interfaces and declared facets included.
    is_flat : bool
        Whether the cells are faces that lie in a plane z = const.
    """

    points: Array
    cells: dict[str, Array]
    bound: Array
    is_flat: bool

    @property
    def dimension(self) -> int:
        return max(FAMILIES[family].dimension for family in self.cells)

    @cached_property
    def used(self) -> Array:
        """Which points are corners of cells, (np,) bool."""
        used = np.zeros(len(self.points), dtype=bool)
        for cells in self.cells.values():
            used[cells.ravel()] = True
        return used

    @cached_property
    def edges(self) -> Array:
        """Every edge once, (n, 2), sorted."""
        n = len(self.points)
        keys = adjacency.distinct(
            np.concatenate([adjacency.row_keys(ends, n) for ends in self._ends.values()])
        )
        return np.stack([keys // n, keys % n], axis=1)

    @cached_property
    def edges_of_cells(self) -> dict[str, Array]:
        """Rows of `edges`, by families: (n, edges of a cell)."""
        n = len(self.points)
        keys = self.edges[:, 0] * n + self.edges[:, 1]
        return {
            family: np.searchsorted(keys, adjacency.row_keys(ends, n)).reshape(
                len(self.cells[family]), -1
            )
            for family, ends in self._ends.items()
        }

    @cached_property
    def _ends(self) -> dict[str, Array]:
        return {
            family: np.take(cells, FAMILIES[family].edges, axis=1).reshape(-1, 2)
            for family, cells in self.cells.items()
        }

    @property
    def is_inner(self) -> Array:
        """Which edges have an end off the boundary, (n,) bool."""
        return ~self.bound[self.edges].all(axis=1)


def domain_of(mesh: Mesh) -> Domain:
    """The cells of a mesh, whose vertex numbers are in range."""
    bordered = of_mesh(mesh)
    groups = bordered.cell_sets
    cells = {
        family: np.concatenate([group.cells for group in groups if group.family == family])
        for family in FAMILIES
        if any(group.family == family for group in groups)
    }
    points = with_depth(mesh.points)
    domain = Domain(points, cells, bordered.bound, False)
    corners = points[domain.used]
    extent = np.ptp(corners, axis=0)
    # Scaled as numbers of the file are rounded, so that a plane stays one.
    limit = flatness(corners, precision_of(mesh.points)) * extent.max()
    if domain.dimension != 2 or extent[2] > limit:
        return domain
    return Domain(points * np.array([1.0, 1.0, 0.0]), cells, bordered.bound, True)
