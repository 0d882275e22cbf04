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


def worst_rows(degradation: Array, n: int) -> Array:
    """Rows of the n greatest of some values, (n,), the greatest first; of equals the first rows.

    Parameters
    ----------
    degradation : (m,) float64
        All of them numbers, infinite ones too.
    """
    rows = np.arange(len(degradation))
    if len(degradation) > n:
        least = np.partition(degradation, len(degradation) - n)[len(degradation) - n]
        # Ties at the limit may be many, and so come last and in order.
        above, equal = np.flatnonzero(degradation > least), np.flatnonzero(degradation == least)
        rows = np.concatenate([above, equal[: n - len(above)]])
    return rows[np.argsort(-degradation[rows], kind="stable")]


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
    rows = worst_rows(q, N_WORST)
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
