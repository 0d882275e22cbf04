"""What cells and points are made of: M0xx."""

from __future__ import annotations

import numpy as np

from ..examination import Examination
from ..model import ERROR, Places, at_cells, rule


@rule(
    "M001",
    ERROR,
    "coordinate not finite",
    explanation="A coordinate of a point is infinite or not a number.",
    calls=("repair --unused",),
    fix="Only a point that no cell has is dropped; else find out what wrote it: most often a "
    "division by zero or a failed export.",
)
def find_not_finite(study: Examination) -> Places:
    return Places(("a coordinate is not finite",), points=np.flatnonzero(~study.finite))


@rule(
    "M002",
    ERROR,
    "vertex number out of range",
    explanation="A cell names a point that the file does not hold.",
    fix="Write the file again; check whether its vertices are counted from 0 or from 1.",
)
def find_out_of_range(study: Examination) -> Places:
    return at_cells(study, study.out_of_range, "a vertex number is out of range")


@rule(
    "M003",
    ERROR,
    "vertex repeated in a cell",
    explanation="A cell has the same vertex at two of its corners.",
    calls=("repair --flat",),
    fix="Where the cell is no simpler one either, write it anew.",
)
def find_repeated(study: Examination) -> Places:
    repeated = (study.repeated & ~study.out_of_range) | study.repeated_lower
    return at_cells(study, repeated, "a vertex is repeated in the cell")
