"""How cells fit together: M201 to M207."""

from __future__ import annotations

import numpy as np

from ..examination import Examination
from ..model import ERROR, WARNING, Places, at_cells, rule

MOST_OTHERS = 3  # related cells that a finding names at most


@rule(
    "M201",
    ERROR,
    "duplicate cell",
    explanation="Two cells of the same type have the same vertices.",
    fix="Remove the later one; often a file was joined with itself.",
)
def find_duplicates(study: Examination) -> Places:
    later, earlier = study.duplicates
    return at_cells(study, later, "the cell has the vertices of another", others=earlier[:, None])


@rule(
    "M202",
    ERROR,
    "coincident points",
    explanation="Two points, at least one of them in use, are in the same place.",
    fix="Merge them in the program that made the mesh.",
)
def find_coincident(study: Examination) -> Places:
    later = np.flatnonzero(study.first_points != np.arange(study.n_points))
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
    fix="Nothing needs to be done; some solvers refuse such points.",
)
def find_unused(study: Examination) -> Places:
    return Places(("the point is not used by any cell",), points=np.flatnonzero(~study.used))


@rule(
    "M204",
    ERROR,
    "facet shared by more than two cells",
    explanation="Three or more cells have a facet in common, so that two of them overlap.",
    source="18.7.1",
    fix="Remove the cell that does not belong there.",
)
def find_crowded(study: Examination) -> Places:
    found = [np.empty((0, MOST_OTHERS + 1), dtype=np.int64)]
    for facets in study.facet_sets:
        crowded = facets.count > 2
        start, count = facets.start[crowded, None], facets.count[crowded, None]
        step = np.arange(MOST_OTHERS + 1)[None]
        row = facets.order[np.minimum(start + step, start + count - 1)]
        found.append(np.where(step < count, facets.owners[row], -1))
    # The last of the cells came last; the ones before are named with it.
    cells = -np.sort(-np.concatenate(found), axis=1)
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    message = "a facet of the cell is shared by more than two cells"
    return at_cells(study, cells[:, 0], message, others=cells[:, 1:])


@rule(
    "M205",
    ERROR,
    "hanging node or crack",
    explanation="A vertex lies on a facet that does not have it, or two facets coincide.",
    source="18.7.1",
    fix="Merge the points of a crack; split the cell at a hanging node.",
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
