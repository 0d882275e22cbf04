"""The shape of single cells: M1xx."""

from __future__ import annotations

import numpy as np

from ..examination import Examination
from ..jacobian import KINDS, not_positive
from ..model import ERROR, Places, at_cells, rule
from ..shape import flat_in


@rule(
    "M101",
    ERROR,
    "inverted cell",
    explanation="A cell, or a corner of it, has a negative volume, or area in the plane.",
    source="18.1.1, 18.1.2",
    calls=("repair --orientation", "optimize"),
    fix="Cells that are listed the other way round are turned, others untangled.",
)
def find_inverted(study: Examination) -> Places:
    numbers = np.flatnonzero(study.shape.inverted)
    is_quad = np.zeros(study.n_cells, dtype=bool)
    for group in study.cell_sets:
        is_quad[group.numbers] = group.family == "quad"
    is_quad, is_listed = is_quad[numbers], study.reversed[numbers]
    kinds = np.select(
        [study.shape.partly[numbers], is_quad & is_listed, is_quad, is_listed], [1, 4, 3, 2], 0
    )
    return at_cells(
        study,
        numbers,
        "the cell is inverted",
        "the cell is inverted at a corner",
        "the cell is listed the other way round than its neighbours: turning it mends that",
        "the quad is negative",
        "the quad is negative, listed the other way round: turning it mends that",
        kinds=kinds,
    )


@rule(
    "M102",
    ERROR,
    "flat cell",
    explanation="A cell, or a corner of a 3-D cell, has no volume, area or length for its size.",
    source="Remark 18.3",
    calls=("repair --flat", "optimize"),
    fix="Flat cells at the boundary are dropped; swaps and collapses remove those between others.",
)
def find_flat(study: Examination) -> Places:
    flat = study.shape.flat.copy()
    flat[flat_in(study, study.lower.sets)] = True
    flat &= ~study.repeated_lower
    return at_cells(study, flat, "the cell is flat")


@rule(
    "M103",
    ERROR,
    "the whole mesh has the other orientation",
    explanation="Every cell has a negative volume: the vertices are listed the other way round.",
    source="18.1.2",
    calls=("repair --orientation",),
    fix="Or change the order of vertices where the file is written.",
)
def find_turned(study: Examination) -> Places:
    n = 1 if study.shape.turned else 0
    return Places(("every cell has the other orientation",), cells=np.full((n, 2), -1))


@rule(
    "M104",
    ERROR,
    "quad not convex",
    explanation="A quad in the plane is not convex, intersects itself, or is degenerate.",
    source="18.1.3, Figure 18.5",
    calls=("repair --orientation",),
    fix="Corners in another order are put in theirs; else split the quad in two triangles.",
)
def find_bad_quads(study: Examination) -> Places:
    numbers = np.flatnonzero(study.shape.quads)
    return at_cells(
        study,
        numbers,
        "the quad is degenerate: two consecutive sides are aligned",
        "the quad is not convex",
        "the quad intersects itself",
        kinds=study.shape.quads[numbers] - 1,
    )


@rule(
    "M105",
    ERROR,
    "cell whose Jacobian is not positive",
    explanation="The Jacobian of a cell falls to zero or below, though its corners are in order.",
    source="Johnen, Remacle, Geuzaine 2013",
    calls=("optimize",),
    fix="Move middle nodes towards the middles of their edges, or list nodes in the order of the "
    "format; straighten cells of first order. Cells with quarter points, meant: --ignore M105.",
)
def find_jacobians(study: Examination) -> Places:
    found = not_positive(study, study.explained)
    said = [KINDS[kind].format(ratio) for kind, ratio in zip(*found[1:], strict=True)]
    messages, kinds = np.unique(np.array(said, dtype=object), return_inverse=True)
    return at_cells(study, found.numbers, *messages.tolist(), kinds=kinds)
