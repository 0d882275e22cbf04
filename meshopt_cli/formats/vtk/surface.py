"""The cells of VTK's surfaces (PolyData): vertices, lines, polygons and strips, in this order."""

from __future__ import annotations

import numpy as np

from ...mesh.model import Array
from .cells import EMPTY, NUMBERS, POLY_LINE, POLY_VERTEX, POLYGON, STRIP, Cells, checked

# Of the cells of a surface, by their section: the type of those of 1, 2, ... vertices.
SURFACE = {
    "vertices": {1: NUMBERS["vertex"], 0: POLY_VERTEX},
    "lines": {2: NUMBERS["line"], 0: POLY_LINE},
    "polygons": {3: NUMBERS["triangle"], 4: NUMBERS["quad"], 0: POLYGON},
    "triangle_strips": {0: STRIP},
}
# Connectivity and offsets of a section without cells.
NO_CELLS = (np.empty(0, np.int64), np.zeros(1, np.int64))


def surface(sections: list[tuple[Array, Array]]) -> Cells:
    """The cells of a surface: vertices, lines, polygons and strips, each with its offsets."""
    vertices, offsets, types = [], [np.zeros(1, np.int64)], []
    n = 0
    for (connectivity, starts), by_size in zip(sections, SURFACE.values(), strict=True):
        part = checked(connectivity, starts, np.full(len(starts) - 1, EMPTY, np.uint8))
        sizes = np.diff(part.offsets)
        kinds = np.full(len(sizes), by_size[0], np.uint8)
        for size, number in by_size.items():
            if size:
                kinds[sizes == size] = number
        vertices.append(connectivity[part.offsets[0] : part.offsets[-1]])
        offsets.append(part.offsets[1:] - part.offsets[0] + n)
        n += len(vertices[-1])
        types.append(kinds)
    return Cells(np.concatenate(vertices), np.concatenate(offsets), np.concatenate(types))
