"""Cells listed the other way round, or with their corners in another order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mesh.adjacency import same_direction
from ..mesh.model import Array, Mesh
from ..mesh.orientation import against_most, can_be_turned, turned
from ..mesh.sizes import contents
from ..validity.boundary import components
from ..validity.examination import Examination
from ..validity.study import Study
from .model import Mended
from .signs import has_one_sign

# Orders in which other programs list corners: rows of points, as pixels and voxels of VTK are, and
# both diagonals of a quad.
ORDERS = {
    "quad": ([0, 1, 3, 2], [0, 2, 1, 3]),
    "hexahedron": ([0, 1, 3, 2, 4, 5, 7, 6],),
}


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
    facet_sets = study.distinct_facets
    pairs = [facets.pairs() for facets in facet_sets]
    against = [
        same_direction(facets.rows[one], facets.rows[other])
        for facets, (one, other) in zip(facet_sets, pairs, strict=True)
    ]
    sides = zip(facet_sets, pairs, strict=True)
    ends = [(facets.owners[one], facets.owners[other]) for facets, (one, other) in sides]
    one, other = (np.concatenate(part) for part in zip(*ends, strict=True))
    size = _sizes(study)
    chosen = against_most(one, other, np.concatenate(against), size)
    across = np.zeros(len(size), bool)
    if study.dimension == 3 or study.plane is not None:
        across = _lie_across(chosen, components(len(size), one, other), size)
    mesh, n_turned, unable = _turned(study, chosen & ~across)
    left = [f"cells of type {kind} cannot be turned: {n:,}" for kind, n in unable.items()]
    if across.any():
        left.append(f"cells that lie across others: {int(across.sum()):,} left")
    return Mended(mesh, counts | {"cells turned": n_turned}, left=tuple(left))


def _lie_across(chosen: Array, part: Array, size: Array) -> Array:
    """Of cells to be turned, those of parts in which more cells are positive as they are.

    Neighbours that disagree although both are positive lie on the same side of their facet:
    turning makes them agree, and inverts them.

    Parameters
    ----------
    chosen : (n,) bool
    part : (n,) int64
        A number for each part of the mesh.
    size : (n,) float64
    """
    gain = np.bincount(part, np.where(chosen, -np.sign(size), 0.0), len(size))
    return chosen & (gain[part] < 0)


def _in_order(study: Examination) -> tuple[Mesh, int]:
    """Cells whose corners stand in the order of another program, in their own; how many."""
    mesh, n = study.mesh, 0
    doubtful = study.shape.inverted | (study.shape.quads > 0)
    for family, orders in ORDERS.items():
        for order in orders:
            if doubtful.any():
                mesh, n_more, doubtful = _reordered(study, mesh, doubtful, family, order)
                n += n_more
    return mesh, n


def _reordered(
    study: Examination, mesh: Mesh, doubtful: Array, family: str, order: list[int]
) -> tuple[Mesh, int, Array]:
    """Try another order for the doubtful cells of a family: they are to be valid by themselves,
    and to have no fewer facets in common with others."""
    blocks = []
    changed = np.zeros(study.n_cells, bool)
    for block, first in zip(mesh.blocks, study.offsets, strict=False):
        here = doubtful[first : first + len(block.cells)] & (block.type == family)
        rows = np.flatnonzero(here)
        if len(rows):
            other = block.cells[rows][:, order]
            rows = rows[has_one_sign(study, other, family)]
            changed[first + rows] = True
            cells = block.cells.copy()
            cells[rows] = cells[rows][:, order]
            blocks.append(replace(block, cells=cells))
        else:
            blocks.append(block)
    if not changed.any():
        return mesh, 0, doubtful
    tried = replace(mesh, blocks=blocks)
    changed &= _n_shared(tried) >= _n_shared(mesh)
    blocks = [
        replace(new, cells=np.where(changed[at : at + len(new.cells), None], new.cells, old.cells))
        for old, new, at in zip(mesh.blocks, tried.blocks, study.offsets, strict=False)
    ]
    return replace(mesh, blocks=blocks), int(changed.sum()), doubtful & ~changed


def _n_shared(mesh: Mesh) -> Array:
    """How many facets each cell has in common with others, (n_cells,) int64."""
    study = Study(mesh)
    result = np.zeros(study.n_cells, np.int64)
    for facets in study.facet_sets:
        count = np.empty(len(facets.rows), np.int64)
        count[facets.order] = np.repeat(facets.count, facets.count)
        np.add.at(result, facets.owners[count > 1], 1)
    return result


def _sizes(study: Examination) -> Array:
    """Volumes, or areas, of all cells, positive for those that are the right way round; of a
    surface the areas, which have no sign."""
    size = np.zeros(study.n_cells)
    for group in study.cell_sets if study.dimension > 1 else []:
        size[group.numbers] = contents(study.centred, group.cells, group.family)
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
