"""Cells that are there twice, and declared facets that bound no cell."""

from __future__ import annotations

import numpy as np

from ..mesh.model import Array
from ..validity.examination import Examination
from ..validity.study import duplicates_in
from .edit import without_cells
from .model import Mended


def drop_duplicates(study: Examination) -> Mended:
    """Drop cells with the vertices of an earlier one (M201)."""
    later, earlier = (
        np.concatenate(numbers)
        for numbers in zip(
            study.duplicates, duplicates_in(study.lower.sets, study.n_points), strict=True
        )
    )
    if not len(later):
        return Mended(study.mesh, {"duplicate cells dropped": 0})
    region, notes = study.region, []
    if region is not None and (n := int((region[later] != region[earlier]).sum())):
        notes.append(f"duplicate cells that had other tags than the first: {n:,}")
    return Mended(
        without_cells(study.mesh, _mask(study, later)),
        {"duplicate cells dropped": len(later)},
        tuple(notes),
    )


def drop_lost_facets(study: Examination) -> Mended:
    """Drop facets that the file declares, and that bound no cell (M208)."""
    lost = study.lower.lost
    counts = {"facets dropped that bound no cell": len(lost)}
    return Mended(
        without_cells(study.mesh, _mask(study, lost)) if len(lost) else study.mesh, counts
    )


def _mask(study: Examination, numbers: Array) -> Array:
    mask = np.zeros(study.n_cells, bool)
    mask[numbers] = True
    return mask
