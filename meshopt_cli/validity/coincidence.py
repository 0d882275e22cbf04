"""Which points of a study are in the same place."""

from __future__ import annotations

import numpy as np

from ..mesh.adjacency import first_of
from ..mesh.facets import CellSet
from ..mesh.model import Array
from ..mesh.sizes import norms
from . import geometry
from .study import Study, has_repeated


def first_points(study: Study) -> Array:
    """The first point in the same place as each point, itself if there is no other."""
    result = np.arange(study.n_points)
    present = np.flatnonzero(study.finite)
    points = study.points[present]
    if not study.used[present].any():
        return result
    extent = norm_of_extent(study.points[present[study.used[present]]])
    relative = study.tolerance or (1e-12 if study.eps < 1e-10 else 1e-7)
    distance = max(relative * extent, float(study.noise.max()) / 2)
    one, other = geometry.near_pairs(points, distance)
    apart = norms(points[one] - points[other])
    if apart.any():
        # Fine meshes of wide domains have short edges: coincident means much shorter.
        shortest = _shortest_edges(study, np.concatenate([present[one], present[other]]))
        limit = np.minimum(shortest[present[one]], shortest[present[other]]) / 10
        keep = (apart == 0) | (apart <= limit)
        one, other = one[keep], other[keep]
    first = first_of(len(present), one, other)
    # Stray points in one place are only unused, as long as no cell has a vertex there.
    matters = np.zeros(len(present), dtype=bool)
    matters[first[study.used[present]]] = True
    first = np.where(matters[first], first, np.arange(len(first)))
    result[present] = present[first]
    return result


def places_of(study: Study, first: Array) -> tuple[int, int]:
    """How many points the sound cells have, and in how many places these are.

    Parameters
    ----------
    first : (np,) int64
        The first point in the place of each.
    """
    is_corner, is_place = np.zeros((2, study.n_points), dtype=bool)
    for group in study.sound_sets:
        is_corner[group.cells.ravel()] = True
    is_place[first[is_corner]] = True
    return int(is_corner.sum()), int(is_place.sum())


def merged(study: Study, first: Array) -> list[CellSet]:
    """The sound cells as if points in one place were one, but for those that this would spoil."""
    found = []
    for group in study.sound_sets:
        cells = first[group.cells]
        spoiled = has_repeated(cells)
        cells[spoiled] = group.cells[spoiled]
        found.append(CellSet(group.family, cells, group.numbers))
    return found


def _shortest_edges(study: Study, wanted: Array) -> Array:
    """Least distance of points to a vertex of a cell they are in, infinite for the rest."""
    result = np.full(study.n_points, np.inf)
    is_wanted = np.zeros(study.n_points, dtype=bool)
    is_wanted[wanted] = True
    for group in study.sound_sets:
        cells = group.cells[is_wanted[group.cells].any(axis=1)]
        for i in range(cells.shape[1]):
            for j in range(i):
                length = norms(study.points[cells[:, i]] - study.points[cells[:, j]])
                np.minimum.at(result, cells[:, i], length)
                np.minimum.at(result, cells[:, j], length)
    return result


def norm_of_extent(points: Array) -> float:
    """Diagonal of the bounding box."""
    return float(norms(np.ptp(points, axis=0)))
