"""Where a working mesh takes its metric from."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..kernels.types import SimplexMesh

Array = np.ndarray


class Background(Protocol):
    """A metric everywhere in the domain, which does not change while the mesh does.

    Tensors are rows (xx, xy, yy, xz, yz, zz); those of the plane have 1 as zz.
    """

    @property
    def is_isotropic(self) -> bool:
        """Whether it is the same in all directions, so that no shape looks different in it."""

    @property
    def at_points(self) -> Array:
        """The metric at the points of the input, (np, 6) float64."""

    def at(self, points: Array, region: Array) -> Array:
        """The metric in some places, (n, 3), of regions, (n,): (n, 6) float64."""


def take_anew(mesh: SimplexMesh, background: Background, taken: Array) -> Array:
    """Give vertices that moved, or are new, the metric where they are; returns which, (np,) bool.

    Parameters
    ----------
    taken : (n, 3) float64
        Where the vertices were when they were given one, those that were there then.
    """
    moved = mesh.vertex_cell >= 0
    moved[: len(taken)] &= np.any(mesh.points[: len(taken), :3] != taken, axis=1)
    rows = np.flatnonzero(moved)
    if len(rows):
        region = mesh.region[mesh.vertex_cell[rows]]
        mesh.points[rows, 3:] = background.at(mesh.points[rows, :3], region)
    return moved
