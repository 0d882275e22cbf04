"""The domain that all cells together fill: M206 to M213."""

from __future__ import annotations

import numpy as np

from ...mesh.adjacency import distinct
from .. import boundary
from ..examination import Examination
from ..model import ERROR, SEARCH, WARNING, Places, at_cells, rule
from ..overlap import overlapping_cells
from .pinches import open_sides, pinches

MOST_OTHERS = 3  # related cells that a finding names at most
VOLUME = 1e-9  # of the sum of all volumes: what rounding may add to it


def _nowhere() -> Places:
    return Places(("",), cells=np.empty((0, 2), np.int64))


@rule(
    "M206",
    ERROR,
    "boundary open or not manifold",
    explanation="Boundary facets of one part meet in an edge, or a point, otherwise than in pairs.",
    source="18.7.1",
    fix="Give each sheet of the boundary points of its own, or add the cells that are missing.",
    can_be_meant=True,
)
def find_not_manifold(study: Examination) -> Places:
    if not study.is_whole or not len(study.domain.skin.rows):
        return _nowhere()
    found = pinches(study)
    kinds = (open_sides(study), found.edges)
    return Places(
        (
            "the boundary is open at the cell",
            "more than two boundary facets of one part meet in an edge of the cell",
        ),
        cells=study.cells_by(np.concatenate([one.cells for one in kinds])),
        points=np.concatenate([one.points for one in kinds]),
        kinds=np.repeat([0, 1], [len(one.cells) for one in kinds]),
    )


@rule(
    "M207",
    ERROR,
    "neighbours disagree in orientation",
    explanation="Two cells run round their common facet in the same direction.",
    source="18.7.1",
    calls=("repair --orientation",),
    fix="Cells of a surface are turned; solids and cells in a plane that stay lie across others.",
)
def find_disagreeing(study: Examination) -> Places:
    one, other = study.disagreeing
    doubtful = study.explained.copy()
    doubtful[study.duplicates[0]] = True
    keep = ~(doubtful[one] | doubtful[other]) & (not study.shape.turned) & ~study.sheets.is_seam
    one, other = one[keep], other[keep]
    # Of the two, the one that disagrees with more of its neighbours is more likely wrong.
    times = np.bincount(np.concatenate([one, other]), minlength=study.n_cells)
    swap = (times[one] > times[other]) | ((times[one] == times[other]) & (one > other))
    cells, first = np.unique(np.where(swap, one, other), return_index=True)
    others = np.where(swap, other, one)[first]
    message = "the cell and a neighbour disagree in orientation"
    return at_cells(study, cells, message, others=others[:, None])


@rule(
    "M208",
    ERROR,
    "declared facet that bounds no cell",
    explanation="A facet that the file lists is a facet of no cell, between vertices of the cells.",
    source="18.7.1",
    calls=("repair --facets",),
    fix="Or add the cell that it bounds; often that was deleted.",
    can_be_meant=True,
)
def find_unbound(study: Examination) -> Places:
    return at_cells(study, study.lower.lost, "the facet bounds no cell")


@rule(
    "M209",
    ERROR,
    "cells overlap",
    explanation="Two cells have points inside in common.",
    source="18.7.1",
    fix="Remove one of the overlapping cells, or mend the geometry that was meshed.",
    cost=SEARCH,
    can_be_meant=True,
)
def find_overlapping(study: Examination) -> Places:
    later, earlier = overlapping_cells(study)
    cells, first, count = np.unique(later, return_index=True, return_counts=True)
    step = np.arange(MOST_OTHERS)[None]
    others = earlier[np.minimum(first[:, None] + step, len(earlier) - 1)]
    others = np.where(step < count[:, None], others, -1)
    return at_cells(study, cells, "the cell overlaps another", others=others)


@rule(
    "M210",
    ERROR,
    "volumes do not add up to what the boundary encloses",
    explanation="The cells have more or less volume, or area, together than their boundary holds.",
    source="18.1.1",
    calls=("optimize",),
    fix="Look at the cells that disagree (M207) or overlap (M209): some lie across others.",
)
def find_excess(study: Examination) -> Places:
    if not study.is_whole or not (study.dimension == 3 or study.plane is not None):
        return _nowhere()
    # Cells that are turned over, one by one, say so themselves; a boundary with edges in common
    # to an odd number of facets encloses nothing.
    skin, domain = boundary.skin_of(study), study.domain
    sides = boundary.sides_of(skin, study.n_points, study.dimension)
    crowded = any((facets.count > 2).any() for facets in study.distinct_facets)
    if not len(skin.rows) or crowded or study.explained.any():
        return _nowhere()
    if not boundary.is_consistent(sides):
        return _nowhere()
    total = sum(float(np.abs(content).sum()) for content in study.contents)
    inside = domain.sign * boundary.enclosed(study, skin)
    if abs(total - inside) <= VOLUME * total:
        return _nowhere()
    what = "volumes" if study.dimension == 3 else "areas"
    # As the file has it; infinite where no number is large enough.
    total, inside = np.ldexp([total, inside], study.dimension * study.exponent).tolist()
    message = f"the {what} add up to {total:.9g}, the boundary encloses {inside:.9g}"
    return Places((message,), cells=np.full((1, 2), -1))


@rule(
    "M211",
    ERROR,
    "missing cell",
    explanation="The mesh has a closed void that one cell would fill.",
    source="18.7.1",
    calls=("repair --fill",),
    fix="Or leave it out of the boundary on purpose, by a finer mesh around it.",
    can_be_meant=True,
)
def find_missing(study: Examination) -> Places:
    if not study.is_whole or not study.domain.missing:
        return _nowhere()
    cells = np.full((len(study.domain.missing), 4), -1)
    for row, around in enumerate(study.domain.missing):
        near = distinct(around)[:4]
        cells[row, : len(near)] = near
    message = "a cell is missing in the void that the cell bounds"
    return at_cells(study, cells[:, 0], message, others=cells[:, 1:])


@rule(
    "M212",
    WARNING,
    "parts joined by a vertex or an edge only",
    explanation="Two parts of the mesh, or two ends of one, have a vertex in common, but no facet.",
    source="18.7.1",
    fix="Give each part points of its own if they move apart, or join them by a facet.",
)
def find_touching(study: Examination) -> Places:
    if not study.is_whole or not len(study.domain.skin.rows):
        return _nowhere()
    found = pinches(study)
    kinds = (found.joints, found.tips)
    return Places(
        (
            "the part of the cell hangs on another by a vertex or an edge only",
            "the part of the cell touches itself in a vertex only",
        ),
        cells=study.cells_by(np.concatenate([one.cells for one in kinds])),
        points=np.concatenate([one.points for one in kinds]),
        kinds=np.repeat([0, 1], [len(one.cells) for one in kinds]),
        other_cells=study.cells_by(np.concatenate([one.others for one in kinds]))[:, None],
    )


@rule(
    "M213",
    WARNING,
    "region not connected",
    explanation="The cells with one combination of tags make several parts.",
    source="18.7.1",
    fix="Give the parts tags of their own, if they are not one region on purpose.",
)
def find_scattered(study: Examination) -> Places:
    region = study.region
    if region is None or not study.is_whole:
        return _nowhere()
    label = boundary.parts(study, region)
    kept = np.concatenate([group.numbers for group in study.distinct_sets])
    piece, first = np.unique(label[kept], return_index=True)
    home = region[kept[first]]
    order = np.lexsort((piece, home))
    count = np.bincount(home)
    start = np.cumsum(count) - count
    several = np.flatnonzero(count > 1)
    second = order[start[several] + 1]
    messages, kinds = np.unique(count[several], return_inverse=True)
    return at_cells(
        study,
        kept[first[second]],
        *(f"the region of the cell has {n:,} parts; this one is not the first" for n in messages),
        kinds=kinds,
        others=kept[first[order[start[several]]]][:, None],
    )
