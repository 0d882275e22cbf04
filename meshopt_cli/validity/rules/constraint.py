"""Cells, edges and faces that the boundary constrains too much: M3xx (Definitions 18.8, 18.9)."""

from __future__ import annotations

import numpy as np

from ...cells import FAMILIES
from ...mesh.adjacency import distinct
from ...mesh.model import Array
from ..examination import Examination
from ..model import WARNING, Places, at_cells, rule

FIX = "Optimize with split, which adds a vertex inside, or mesh anew with more cells there."


@rule(
    "M301",
    WARNING,
    "over-constrained cell",
    explanation="A triangle has two edges in the boundary, or a tetrahedron three faces.",
    source="Definition 18.8",
    fix=FIX,
    on_request=True,
)
def find_constrained_cells(study: Examination) -> Places:
    count = np.bincount(study.domain.skin.owners, minlength=study.n_cells)
    simplex = np.zeros(study.n_cells, dtype=bool)
    for group in study.cell_sets:
        if FAMILIES[group.family].is_simplex:
            simplex[group.numbers] = True
    return at_cells(
        study, simplex & (count >= study.dimension), "the boundary has too many facets of the cell"
    )


@rule(
    "M302",
    WARNING,
    "over-constrained internal edge",
    explanation="An edge inside the mesh has both ends in the boundary.",
    source="Definition 18.9",
    fix=FIX,
    on_request=True,
)
def find_constrained_edges(study: Examination) -> Places:
    bound = _boundary_vertices(study)
    keys, owners, ends = [], [], []
    for group in study.cell_sets:
        for i, j in FAMILIES[group.family].edges:
            rows = np.flatnonzero(bound[group.cells[:, i]] & bound[group.cells[:, j]])
            pair = np.sort(group.cells[rows][:, [i, j]], axis=1)
            keys.append(pair[:, 0] * study.n_points + pair[:, 1])
            owners.append(group.numbers[rows])
            ends.append(pair)
    if not keys:
        return at_cells(study, np.empty(0, np.int64), "")
    key, first = np.unique(np.concatenate(keys), return_index=True)
    inside = ~np.isin(key, _boundary_edges(study))
    pair = np.concatenate(ends)[first[inside]]
    return Places(
        ("an edge inside, of this cell, has both ends in the boundary",),
        cells=study.cells_by(np.concatenate(owners)[first[inside]]),
        other_points=pair,
    )


@rule(
    "M303",
    WARNING,
    "over-constrained internal face",
    explanation="A face inside the mesh has all its vertices in the boundary.",
    source="Definition 18.9",
    fix=FIX,
    on_request=True,
)
def find_constrained_faces(study: Examination) -> Places:
    bound = _boundary_vertices(study)
    ones, others = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    if study.dimension == 3:
        for facets in study.facet_sets:
            one, other = facets.pairs()
            held = bound[facets.rows[one]].all(axis=1)
            ones.append(facets.owners[one[held]])
            others.append(facets.owners[other[held]])
    message = "the face between this cell and another has all its vertices in the boundary"
    return at_cells(study, np.concatenate(ones), message, others=np.concatenate(others)[:, None])


def _boundary_vertices(study: Examination) -> Array:
    bound = np.zeros(study.n_points, dtype=bool)
    rows = study.domain.skin.rows
    bound[rows[rows >= 0]] = True
    return bound


def _boundary_edges(study: Examination) -> Array:
    """Keys of the edges in the boundary: the least vertex times their number, and the other."""
    skin = study.domain.skin
    keys = [np.empty(0, np.int64)]
    for width in distinct(skin.width).tolist():
        rows = skin.rows[skin.width == width, :width]
        for k in range(width):
            pair = np.sort(rows[:, [k, (k + 1) % width]], axis=1)
            keys.append(pair[:, 0] * study.n_points + pair[:, 1])
    return distinct(np.concatenate(keys))
