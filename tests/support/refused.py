"""Meshes that cannot be optimized, as files."""

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from support.broken import CORNER, MIDDLES
from support.files import write
from support.meshes import hex_grid, mesh, octahedron


def box_of_quads():
    """The surface of a cube."""
    cube = hex_grid(1)
    return mesh(cube.points, quad=cube.blocks[0].cells[0][FAMILIES["hexahedron"].facets[0]])


# Meshes that are wrong, each in its own way: what is in them, the exit status, what is said.
BAD_MESHES = {
    "quads": (box_of_quads, 3, "plane"),
    "both_orders": (lambda: mesh([*CORNER, *MIDDLES, *(np.eye(4, 3) + 2)], tetra10=[range(10)],
                                 tetra=[[13, 10, 11, 12]]), 3, "tetra10"),
    "surface": (octahedron, 3, "plane"),
    "lines": (lambda: mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], line=[[0, 1], [1, 2]]), 1, "lines"),
    "points": (lambda: mesh([[0, 0, 0], [1, 0, 0]], vertex=[[0], [1]]), 1, "points"),
}  # fmt: skip
every_bad_mesh = pytest.mark.parametrize("name", BAD_MESHES)


def bad_mesh(folder, name):
    make, status, said = BAD_MESHES[name]
    return write(folder / f"{name}.vtu", make()), status, said
