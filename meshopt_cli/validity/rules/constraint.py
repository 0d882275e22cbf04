"""Cells, edges and faces that the boundary constrains too much: M3xx (Definitions 18.8, 18.9)."""

from __future__ import annotations

import numpy as np

from ...mesh.adjacency import distinct
from ...mesh.constrained import (
    are_constrained,
    between_bound,
    bound_vertices,
    constrained_edges,
    constrained_facets,
)
from ...mesh.model import Array
from ..examination import Examination
from ..model import WARNING, Places, at_cells, rule

FIX = "Optimize with split, which adds a vertex inside, or mesh anew with more cells there."


@rule(
    "M301",
    WARNING,
    "over-constrained cell",
    explanation="A triangle has two edges in the boundary, a tetrahedron three faces, or a cell of "
    "another family all its facets but one.",
    source="Definition 18.8",
    fix=FIX,
    on_request=True,
)
def find_constrained_cells(study: Examination) -> Places:
    count = np.bincount(study.domain.skin.owners, minlength=study.n_cells)
    found = np.zeros(study.n_cells, dtype=bool)
    for group in study.cell_sets:
        found[group.numbers] = are_constrained(count[group.numbers], group.family)
    return at_cells(study, found, "the boundary has too many facets of the cell")


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
    boundary = _boundary(study)
    keys, owners = between_bound(study.cell_sets, bound_vertices(boundary, study.n_points))
    inside = constrained_edges(keys, boundary, study.n_points)
    order = np.argsort(keys, kind="stable")
    first = order[np.searchsorted(keys, inside, sorter=order)]
    return Places(
        ("an edge inside, of this cell, has both ends in the boundary",),
        cells=study.cells_by(owners[first]),
        other_points=np.stack([inside // study.n_points, inside % study.n_points], axis=1),
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
    bound = bound_vertices(_boundary(study), study.n_points)
    ones, others = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    if study.dimension == 3:
        for facets in study.facet_sets:
            one, other = facets.pairs()
            held = constrained_facets(facets.rows[one], bound)
            ones.append(facets.owners[one[held]])
            others.append(facets.owners[other[held]])
    message = "the face between this cell and another has all its vertices in the boundary"
    return at_cells(study, np.concatenate(ones), message, others=np.concatenate(others)[:, None])


def _boundary(study: Examination) -> list[Array]:
    """The facets of the boundary, by their number of vertices."""
    skin = study.domain.skin
    return [skin.rows[skin.width == width, :width] for width in distinct(skin.width).tolist()]
