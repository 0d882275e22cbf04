"""Meshes that cannot be optimized, as files."""

import numpy as np
import pytest

from support.broken import CORNER, MIDDLES
from support.files import write
from support.meshes import hex_grid, in_space, mesh, octahedron, quad_grid

# Meshes that are wrong, each in its own way: what is in them, the exit status, what is said.
BAD_MESHES = {
    "quads": (lambda: in_space(quad_grid(3)), 3, "quad"),
    "both_orders": (lambda: mesh([*CORNER, *MIDDLES, *(np.eye(4, 3) + 2)], tetra10=[range(10)],
                                 tetra=[[13, 10, 11, 12]]), 3, "tetra10"),
    "surface": (octahedron, 3, "plane"),
    "hexes_and_tets": (lambda: mesh([*hex_grid(1).points, *(np.eye(4, 3) + 2)],
                                    hexahedron=hex_grid(1).blocks[0].cells, tetra=[[11, 8, 9, 10]]),
                       3, "hexahedron"),
    "lines": (lambda: mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], line=[[0, 1], [1, 2]]), 1, "lines"),
    "points": (lambda: mesh([[0, 0, 0], [1, 0, 0]], vertex=[[0], [1]]), 1, "points"),
}  # fmt: skip
every_bad_mesh = pytest.mark.parametrize("name", BAD_MESHES)


def bad_mesh(folder, name):
    make, status, said = BAD_MESHES[name]
    return write(folder / f"{name}.vtu", make()), status, said
