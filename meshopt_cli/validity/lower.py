"""Cells of lower dimension: which stand by themselves, and which bound no cell though they ought.

A file lists facets of its cells to say something of the boundary. It may also hold beams and
shells that are parts of the model. A facet whose vertices all belong to cells that hang together,
and that is a facet of none of them, has lost its cell; one with a vertex of its own has not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES
from ..mesh.adjacency import first_of, row_ids
from ..mesh.facets import CellSet, joined
from ..mesh.model import Array
from .boundary import components
from .lost import closing_one_cell
from .study import Study


@dataclass(frozen=True)
class Lower:
    """Cells of lower dimension that bound no cell.

    Attributes
    ----------
    sets : list of CellSet
        Those that stand by themselves.
    parts : list of (n,) int64
        A number for each cell of `sets`, the same for those that hang together.
    lost : (n,) int64
        Numbers of the facets that ought to bound a cell, ascending.
    """

    sets: list[CellSet]
    parts: list[Array]
    lost: Array


def lower_of(study: Study, first: Array | None = None) -> Lower:
    """Find the cells of lower dimension that bound no cell.

    Cells stand by themselves where they have a vertex that no cell of the top dimension has, or
    join cells that do not hang together; so do those that hang on them by a side. Lines that
    bound no face of a surface in space do, and faces of a form that no cell has. What is left of
    one cell that is gone does not (see `lost`).

    Parameters
    ----------
    first : (np,) int64, optional
        The point that stands for each, where points in one place count as one.
    """
    none = Lower([], [], np.empty(0, np.int64))
    if not study.is_whole:
        return none
    taken = np.zeros(study.n_points, dtype=bool)
    for group in study.cell_sets:
        taken[group.cells.ravel()] = True
    listed = _lower_sets(study, first)
    sets, free = [], []
    for group in listed:
        unbound, alone = _unbound(study, group, taken)
        sets.append(CellSet(group.family, group.cells[unbound], group.numbers[unbound]))
        free.append(alone[unbound])
    if not sum(len(alone) for alone in free):
        return none
    ends = np.cumsum([len(group.numbers) for group in sets])[:-1]
    part = _hanging_together(study, sets, taken)
    parts = np.split(part, ends)
    stands = np.zeros(len(part), dtype=bool)
    stands[part[np.concatenate(free)]] = True
    if not stands[part].all():
        stands[part[_joins_bodies(study, sets)]] = True
    facets = [k for k, group in enumerate(sets) if _is_as_wide(study, group)]
    closing = closing_one_cell(study, listed, [sets[k] for k in facets], [parts[k] for k in facets])
    stands[closing] = False
    stand = np.split(stands[part], ends)
    lost = [none.lost, *(sets[k].numbers[~stand[k]] for k in facets)]
    kept = [k for k, mask in enumerate(stand) if mask.any()]
    return Lower(
        [CellSet(sets[k].family, sets[k].cells[stand[k]], sets[k].numbers[stand[k]]) for k in kept],
        [parts[k][stand[k]] for k in kept],
        np.sort(np.concatenate(lost)),
    )


def _is_as_wide(study: Study, group: CellSet) -> bool:
    """Whether cells have the dimension of facets."""
    return FAMILIES[group.family].dimension == study.dimension - 1


def _lower_sets(study: Study, first: Array | None) -> list[CellSet]:
    """The cells of one dimension less than the top, and of two, by their family."""
    found: dict[str, list[tuple[Array, Array]]] = {}
    for dimension in (study.dimension - 1, study.dimension - 2):
        for family, rows, numbers in study.blocks_of(dimension):
            sound = ~study.out_of_range[numbers]
            cells = rows[sound, : family.n_corners]
            cells = cells if first is None else first[cells]
            found.setdefault(family.name, []).append((cells, numbers[sound]))
    return [CellSet(family, *joined(rows)) for family, rows in found.items()]


def _unbound(study: Study, group: CellSet, taken: Array) -> tuple[Array, Array]:
    """Which cells bound no cell, and which of them stand by themselves for sure: two masks.

    Of lines in a mesh of solids, only those with a vertex of their own are looked at.

    Parameters
    ----------
    taken : (np,) bool
        Vertices of cells of the top dimension.
    """
    alone = ~taken[group.cells].all(axis=1)
    unbound = alone.copy()
    if not _is_as_wide(study, group):
        return unbound, alone
    rest = np.flatnonzero(~alone)
    unbound[rest] = ~_is_facet(study, group.cells[rest])
    widths = {facets.rows.shape[1] for facets in study.facet_sets}
    has_no_kin = study.may_branch or group.cells.shape[1] not in widths
    return unbound, unbound if has_no_kin else alone


def _is_facet(study: Study, rows: Array) -> Array:
    """Which rows of vertices are a facet of a cell."""
    width = rows.shape[1]
    named = np.zeros(study.n_points, dtype=bool)
    named[rows.ravel()] = True
    known = [np.empty((0, width), np.int64)]
    for facets in study.facet_sets:
        if facets.rows.shape[1] == width:
            known.append(facets.rows[named[facets.rows].all(axis=1)])
    ids = row_ids(np.concatenate([rows, *known]), study.n_points)
    return np.isin(ids[: len(rows)], ids[len(rows) :])


def _hanging_together(study: Study, sets: list[CellSet], taken: Array) -> Array:
    """For each cell of some sets the least one that it hangs together with, (n,) int64.

    Faces hang together by edges, and all cells by vertices that no others have; lines in a mesh
    of faces by any vertex.
    """
    keys, items = [], []
    start = 0
    for group in sets:
        number = start + np.arange(len(group.numbers))
        start += len(number)
        for column in group.cells.T:
            own = ~taken[column] if study.dimension == 3 else np.ones(len(column), dtype=bool)
            keys.append(column[own])
            items.append(number[own])
        if study.dimension == 3:
            for i, j in FAMILIES[group.family].edges.tolist():
                ends = np.sort(group.cells[:, [i, j]], axis=1)
                keys.append((ends[:, 0] + 1) * study.n_points + ends[:, 1])
                items.append(number)
    key, item = np.concatenate(keys), np.concatenate(items)
    order = np.argsort(key, kind="stable")
    key, item = key[order], item[order]
    same = np.flatnonzero(key[1:] == key[:-1])
    return first_of(start, item[same], item[same + 1])


def _joins_bodies(study: Study, sets: list[CellSet]) -> Array:
    """Which cells have vertices of cells that do not hang together, not even by vertices."""
    one = [np.repeat(group.cells[:, 0], group.cells.shape[1] - 1) for group in study.cell_sets]
    other = [group.cells[:, 1:].ravel() for group in study.cell_sets]
    body = components(study.n_points, np.concatenate(one), np.concatenate(other))
    joins = [(body[group.cells] != body[group.cells[:, :1]]).any(axis=1) for group in sets]
    return np.concatenate(joins)
