"""Lengths of edges in a metric: looked for again where the mesh has changed only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..kernels.types import CLOCK, EDITION, SimplexMesh

Array = np.ndarray


class Lengths(NamedTuple):
    """Of each row of cells the shortest and the longest edge, and what its edges lack.

    Replaced, never written into.
    """

    values: Array  # (3, n) float64
    edition: int  # of the mesh
    clock: int  # the sweep in which they were looked for; 0: never


UNKNOWN = Lengths(np.zeros((3, 0)), 0, 0)


def lengths_of(mesh: SimplexMesh, known: Lengths) -> Lengths:
    """The lengths of a mesh, some of which may be known from an earlier state of it."""
    from ..kernels.operators.edges import extreme_lengths  # of a metric only

    edition, clock = int(mesh.state[EDITION]), int(mesh.state[CLOCK])
    if known.clock and known.edition == edition:
        return known
    values = np.zeros((3, len(mesh.cells)))
    values[:, : known.values.shape[1]] = known.values
    extreme_lengths(mesh, values[0], values[1], values[2], known.clock)
    return Lengths(values, edition, clock)
