"""Which meshes are taken, and how they are turned."""

import numpy as np
import pytest

from meshopt_cli.errors import BadMeshError, UnsupportedMeshError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block
from support.edits import turned_over
from support.encodings import ints
from support.invariants import volumes
from support.meshes import in_space, mesh, octahedron, quad_grid, tet_grid, tri_grid
from support.places import cells_of
from support.runs import optimized


def test_a_bent_sheet_and_a_closed_surface_are_refused():
    bent = in_space(tri_grid(4))
    bent.points[:, 2] = 1e-3 * bent.points[:, 0] ** 2
    for surface in (bent, octahedron()):
        with pytest.raises(UnsupportedMeshError):
            cast(surface)


def test_other_cells_are_refused():
    with pytest.raises(UnsupportedMeshError, match="quad"):
        cast(quad_grid(2))
    both = tri_grid(2)
    both.blocks.append(Block("quad", ints([0, 1, 4, 3])))
    with pytest.raises(UnsupportedMeshError, match="quad"):
        cast(both)
    with pytest.raises(BadMeshError):
        cast(mesh([[0, 0], [1, 0]], line=[[0, 1]]))


def test_tets_of_the_other_orientation_are_turned():
    grid = tet_grid(2)
    assert not cast(grid).turned
    before = cast(turned_over(grid))
    assert before.turned
    assert np.all(volumes(before.points, before.cells) > 0)
    result = optimized(turned_over(grid))
    assert np.all(volumes(result.points, cells_of(result, "tetra")) > 0)
