"""What the volumes and areas of the cells of a study say about their shape."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh.facets import CellSet
from ..mesh.model import Array
from ..mesh.quads import corner_areas, quad_cases, signs_of
from . import geometry
from .study import Study


@dataclass(frozen=True)
class Shape:
    """What the volumes of the cells say: masks over the numbers of all cells."""

    inverted: Array
    partly: Array  # inverted at a corner, but positive on the whole
    flat: Array
    quads: Array  # int64: cases of Figure 18.5, as if none ran clockwise; 0 for flat ones too
    turned: bool  # the whole mesh has the other orientation
    has_upside: bool = False  # in the plane: cells that are to be seen from one side of it


def shape_of(study: Study) -> Shape:
    """What the volumes, or the areas, of all sound cells say."""
    inverted, partly, flat = np.zeros((3, study.n_cells), dtype=bool)
    quads = np.zeros(study.n_cells, dtype=np.int64)
    shape = Shape(inverted, partly, flat, quads, turned=False)
    if study.dimension == 3:
        return _shape_of_solids(study, shape)
    if study.plane is not None:
        return _shape_in_plane(study, shape)
    shape.flat[flat_in(study, study.cell_sets)] = True
    return shape


def flat_in(study: Study, cell_sets: list[CellSet]) -> Array:
    """Numbers of the faces in space that have no area, and of the lines that have no length."""
    found = [np.empty(0, np.int64)]
    for group in cell_sets:
        is_flat = geometry.flat_in_space(study.points, study.noise, group.cells)
        found.append(group.numbers[is_flat])
    return np.concatenate(found)


def _shape_of_solids(study: Study, shape: Shape) -> Shape:
    found = [
        geometry.corner_volumes(study.points, study.noise, group.cells, group.family)
        for group in study.cell_sets
    ]
    total = [np.where(flat, 0, volume).sum(axis=1) for volume, flat in found]
    turned = any((t < 0).any() for t in total) and not any((t > 0).any() for t in total)
    for group, (volume, flat), whole in zip(study.cell_sets, found, total, strict=True):
        sign = -1 if turned else 1
        negative = ((sign * volume < 0) & ~flat).any(axis=1)
        shape.inverted[group.numbers] = negative
        shape.partly[group.numbers] = negative & (sign * whole > 0)
        shape.flat[group.numbers] = flat.any(axis=1) & ~negative
    return replace(shape, turned=turned)


def _shape_in_plane(study: Study, shape: Shape) -> Shape:
    assert study.plane is not None
    points, noise, normal = study.plane
    found = [corner_areas(points, noise, group.cells, group.family) for group in study.cell_sets]
    families = {group.family for group in study.cell_sets if len(group.cells)}
    # A plane of triangles may be seen from either side; a quad that runs clockwise in the
    # plane of x and y is negative by definition (Figure 18.5).
    below = sum(float(area.sum()) for area, _ in found) < 0
    has_upside = normal == 2 and "quad" in families
    sign = -1 if below and not has_upside else 1
    for group, (area, flat) in zip(study.cell_sets, found, strict=True):
        n_negative, n_positive = signs_of(sign * area, flat)
        shape.inverted[group.numbers] = n_negative > n_positive
        shape.flat[group.numbers] = flat.all(axis=1)
        if group.family == "quad":
            # One that runs clockwise is inverted: what else there is of it, a mirror would show.
            seen = quad_cases(*np.sort([n_negative, n_positive], axis=0))
            shape.quads[group.numbers] = np.where(flat.all(axis=1), 0, seen)
    return replace(shape, has_upside=has_upside)
