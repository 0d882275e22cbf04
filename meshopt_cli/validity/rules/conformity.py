"""How cells fit together: M201 to M207."""

from __future__ import annotations

import numpy as np

from ...mesh.facets import FacetSet
from ...mesh.model import Array
from ..examination import Examination
from ..model import ERROR, WARNING, Places, at_cells, rule
from ..study import duplicates_in

MOST_OTHERS = 3  # related cells that a finding names at most


@rule(
    "M201",
    ERROR,
    "duplicate cell",
    explanation="Two cells of the same type have the same vertices.",
    calls=("repair --duplicates",),
    fix="Often a file was joined with itself.",
)
def find_duplicates(study: Examination) -> Places:
    found = zip(study.duplicates, duplicates_in(study.lower.sets, study.n_points), strict=True)
    later, earlier = (np.concatenate(numbers) for numbers in found)
    return at_cells(study, later, "the cell has the vertices of another", others=earlier[:, None])


@rule(
    "M202",
    ERROR,
    "coincident points",
    explanation="Two points, at least one of them in use, are in the same place.",
    calls=("repair --merge",),
    fix="Cracks and contacts have such points, and so has the output of discontinuous methods.",
    can_be_meant=True,
)
def find_coincident(study: Examination) -> Places:
    later = np.flatnonzero(study.first_points != np.arange(study.n_points))
    if study.is_in_pieces:
        n_points, n_places = study.places
        alone = (
            "no two cells share a vertex" if study.shares_nothing else "cells share few vertices"
        )
        message = (
            f"{alone}: {n_points:,} points in {n_places:,} places; the other rules take those in "
            "one place for one"
        )
        return Places((message,), cells=np.full((1, 2), -1))
    return Places(
        ("the point is in the place of another",),
        points=later,
        other_points=study.first_points[later][:, None],
    )


@rule(
    "M203",
    WARNING,
    "unused point",
    explanation="A point is no vertex of any cell, or only of one of type vertex.",
    calls=("repair --unused",),
    fix="Nothing needs to be done; some solvers refuse such points.",
)
def find_unused(study: Examination) -> Places:
    return Places(("the point is not used by any cell",), points=np.flatnonzero(~study.used))


@rule(
    "M204",
    ERROR,
    "facet shared by more than two cells",
    explanation="Three or more cells have a facet in common, so two overlap; not in a surface.",
    source="18.7.1",
    calls=("repair --duplicates",),
    fix="Where no cell is there twice, remove the one that does not belong there.",
)
def find_crowded(study: Examination) -> Places:
    cells, _ = crowded([] if study.may_branch else study.facet_sets)
    message = "a facet of the cell is shared by more than two cells"
    return at_cells(study, cells[:, 0], message, others=cells[:, 1:])


def crowded(facet_sets: list[FacetSet]) -> tuple[Array, Array]:
    """Facets of more than two cells: the numbers of these, and the first two vertices.

    Returns
    -------
    cells : (n, MOST_OTHERS + 1) int64
        The last cell first, since it came last, and -1 where there are fewer.
    ends : (n, 2) int64
    """
    cells = [np.empty((0, MOST_OTHERS + 1), dtype=np.int64)]
    ends = [np.empty((0, 2), dtype=np.int64)]
    for facets in facet_sets:
        several = facets.count > 2
        start, count = facets.start[several, None], facets.count[several, None]
        step = np.arange(MOST_OTHERS + 1)[None]
        row = facets.order[np.minimum(start + step, start + count - 1)]
        cells.append(-np.sort(-np.where(step < count, facets.owners[row], -1), axis=1))
        ends.append(facets.rows[row[:, 0], :2])
    order = np.argsort(np.concatenate(cells)[:, 0], kind="stable")
    return np.concatenate(cells)[order], np.concatenate(ends)[order]


@rule(
    "M205",
    ERROR,
    "hanging node or crack",
    explanation="A vertex lies on a facet that does not have it, or two facets coincide.",
    source="18.7.1",
    calls=("repair --merge",),
    fix="Points of a crack are merged; a cell with a hanging node is to be split there.",
    can_be_meant=True,
)
def find_hanging(study: Examination) -> Places:
    vertices, owners = study.hanging
    later, earlier = study.cracks
    return Places(
        ("a vertex lies on a facet of the cell", "a facet of the cell coincides with another"),
        cells=study.cells_by(np.concatenate([owners, later])),
        points=np.concatenate([vertices, np.full(len(later), -1)]),
        kinds=np.repeat([0, 1], [len(owners), len(later)]),
        other_cells=study.cells_by(np.concatenate([np.full(len(owners), -1), earlier]))[:, None],
    )
