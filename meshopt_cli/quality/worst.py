"""The worst cells of a mesh, one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ..cells import FAMILIES
from ..kernels.shape.classify import TYPES, classify_cells
from ..mesh.cast import Simplices
from ..mesh.model import Array

N_WORST = 10


@dataclass(frozen=True)
class WorstCell:
    """One of the worst cells.

    Attributes
    ----------
    family : str
    number : int
        Among the cells of its family, in the order of the mesh, from 0.
    where : (float, float, float)
        Its centre.
    quality : float
        Its Q, infinite where it is flat or inverted.
    type : str
        Of a triangle or tetrahedron, see `kernels.shape.classify`; empty for other cells.
    cell : str
        What its file calls it, as "element 12"; empty where that is not known.
    """

    family: str
    number: int
    where: tuple[float, ...]
    quality: float
    type: str = ""
    cell: str = ""


def worst_cells(
    degradation: Array,
    points: Array,
    cells: Array,
    family: str,
    centres: Callable[[Array], Array],
) -> tuple[WorstCell, ...]:
    """The worst cells of a family, the very worst first; of equals the first of the mesh.

    Parameters
    ----------
    degradation : (n,) float64
        The Q of all its cells.
    points, cells : (np, 3) float64, (n, k) int64
        As they are measured, which may be in a plane.
    centres : function of rows
        Where some of them are in space.
    """
    q = np.where(np.isnan(degradation), math.inf, degradation)
    rows = np.arange(len(q))
    if len(q) > N_WORST:
        least = np.partition(q, len(q) - N_WORST)[len(q) - N_WORST]
        # Ties at the limit may be many, and so come last and in order.
        above, equal = np.flatnonzero(q > least), np.flatnonzero(q == least)
        rows = np.concatenate([above, equal[: N_WORST - len(above)]])
    rows = rows[np.argsort(-q[rows], kind="stable")]
    corners = np.ascontiguousarray(cells[rows])
    types = [""] * len(rows)
    if FAMILIES[family].is_simplex:
        kinds = np.empty(len(rows), dtype=np.int64)
        classify_cells(points, corners, kinds)
        types = [TYPES[cells.shape[1] - 1](kind).name.lower() for kind in kinds.tolist()]
    columns = rows.tolist(), centres(rows).tolist(), q[rows].tolist(), types
    return tuple(
        WorstCell(family, row, tuple(centre), value, kind)
        for row, centre, value, kind in zip(*columns, strict=True)
    )


def in_space(simplices: Simplices, rows: Array) -> Array:
    """Centres of some triangles or tetrahedra, (n, 3), those of a plane in space."""
    centres = simplices.points[simplices.cells[rows]].mean(axis=1)
    frame = simplices.frame
    return centres if frame is None else frame.origin + centres[:, :2] @ frame.axes[:2]


def worst_of(parts: Iterable[Iterable[WorstCell]]) -> tuple[WorstCell, ...]:
    """The worst of those of several families."""
    return tuple(sorted(chain.from_iterable(parts), key=lambda one: -one.quality)[:N_WORST])
