"""Cells that are there twice, declared facets that bound no cell, and cells listed the other way
round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..cells import FAMILIES
from ..mesh.adjacency import same_direction
from ..mesh.model import Array, Mesh
from ..mesh.orientation import against_most, can_be_turned, turned
from ..validity.examination import Examination
from ..validity.geometry import corner_areas, corner_volumes
from ..validity.study import duplicates_in
from .edit import without_cells
from .model import Mended

# Orders in which other programs list corners: rows of points, as pixels and voxels of VTK are, and
# both diagonals of a quad.
ORDERS = {
    "quad": ([0, 1, 3, 2], [0, 2, 1, 3]),
    "hexahedron": ([0, 1, 3, 2, 4, 5, 7, 6],),
}


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


def turn(study: Examination) -> Mended:
    """Put corners in the order of their family, and turn cells until neighbours see their facet
    from both sides (M101, M103, M104, M207, M215).

    Most of the volume, or of the area, of what hangs together says which way round is right.
    """
    mesh, n_ordered = _in_order(study)
    if n_ordered:
        study = Examination(mesh, tolerance=study.tolerance)
    counts = {"cells whose corners were put in order": n_ordered, "cells turned": 0}
    if not (study.shape.inverted.any() or study.shape.turned or len(study.disagreeing[0])):
        return Mended(mesh, counts)
    pairs = [facets.pairs() for facets in study.facet_sets]
    against = [
        same_direction(facets.rows[one], facets.rows[other])
        for facets, (one, other) in zip(study.facet_sets, pairs, strict=True)
    ]
    sides = zip(study.facet_sets, pairs, strict=True)
    ends = [(facets.owners[one], facets.owners[other]) for facets, (one, other) in sides]
    one, other = (np.concatenate(part) for part in zip(*ends, strict=True))
    chosen = against_most(one, other, np.concatenate(against), _sizes(study))
    mesh, n_turned, unable = _turned(study, chosen)
    notes = tuple(f"cells of type {kind} cannot be turned: {n:,}" for kind, n in unable.items())
    return Mended(mesh, counts | {"cells turned": n_turned}, notes)


def _in_order(study: Examination) -> tuple[Mesh, int]:
    """Cells whose corners stand in the order of another program, in their own; how many."""
    blocks, n = [], 0
    doubtful = study.shape.inverted | (study.shape.quads > 0)
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        cells = block.cells
        for order in ORDERS.get(block.type, ()):
            rows = np.flatnonzero(doubtful[first : first + len(cells)])
            if len(rows):
                other = cells[rows][:, order]
                valid = _is_valid(study, other, block.type) & ~_is_valid(
                    study, cells[rows], block.type
                )
                cells = cells.copy()
                cells[rows[valid]] = other[valid]
                n += int(valid.sum())
        blocks.append(block if cells is block.cells else replace(block, cells=cells))
    return (replace(study.mesh, blocks=blocks) if n else study.mesh), n


def _is_valid(study: Examination, cells: Array, family: str) -> Array:
    """Which cells have the same sign at all corners, so that turning is all that they may need."""
    if FAMILIES[family].dimension == 3:
        volume, flat = corner_volumes(study.points, study.noise, cells, family)
    else:
        assert study.plane is not None
        volume, flat = corner_areas(*study.plane[:2], cells, family)
    alike = (np.sign(volume) == np.sign(volume[:, :1])).all(axis=1)
    return alike & ~flat.any(axis=1)


def _sizes(study: Examination) -> Array:
    """Volumes, or areas, of all cells, positive for those that are the right way round."""
    size = np.zeros(study.n_cells)
    for group, contents in zip(study.distinct_sets, study.contents, strict=True):
        size[group.numbers] = contents
    # A plane of triangles may be seen from either side, one of quads in x and y may not.
    if study.plane is not None and not study.shape.has_upside and size.sum() < 0:
        return -size
    return size


def _turned(study: Examination, chosen: Array) -> tuple[Mesh, int, dict[str, int]]:
    """The mesh with some cells turned, how many, and how many could not be, by type."""
    blocks, n = [], 0
    unable: dict[str, int] = {}
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        here = chosen[first : first + len(block.cells)]
        if not here.any():
            blocks.append(block)
        elif can_be_turned(block.type):
            cells = np.where(here[:, None], turned(block.cells, block.type), block.cells)
            blocks.append(replace(block, cells=cells))
            n += int(here.sum())
        else:
            blocks.append(block)
            unable[block.type] = unable.get(block.type, 0) + int(here.sum())
    return (replace(study.mesh, blocks=blocks) if n else study.mesh), n, unable


def _mask(study: Examination, numbers: Array) -> Array:
    mask = np.zeros(study.n_cells, bool)
    mask[numbers] = True
    return mask
