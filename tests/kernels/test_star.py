"""The star of a vertex: the same q as that of its cells, one by one."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.kernels.judge import measure_cells
from meshopt_cli.kernels.vectors import Vec
from meshopt_cli.quality.measures import OF_SIMPLICES
from support import drivers
from support.edits import shaken
from support.invariants import workspace
from support.meshes import fan, icosahedron, tet_grid, tri_grid

JUDGES = {name: measure.judge for name, measure in OF_SIMPLICES.items()}
# Of tets only: triangles have no dihedral angles.
TET_JUDGES = {
    **JUDGES,
    "with angles": JUDGES["aspect-ratio"]._replace(lenience=1.0),
    "lenient": JUDGES["aspect-ratio"]._replace(lenience=1.5),
    "by length, with angles": JUDGES["volume-length"]._replace(lenience=1.0),
}
# Numbers of cells that fill vector registers, and that do not.
BALLS = [
    *(fan(n) for n in (3, 4, 7, 8, 13)),
    icosahedron(),
    shaken(tri_grid(4), 1.0),
    shaken(tet_grid(3), 1.0),
]

CASES = [
    pytest.param(patch, judge, id=f"{patch.blocks[0].type}-{i}-{name}")
    for i, patch in enumerate(BALLS)
    for name, judge in (TET_JUDGES if patch.dimension() == 3 else JUDGES).items()
]


@pytest.mark.parametrize(("patch", "judge"), CASES)
def test_a_star_is_measured_as_its_cells(patch, judge):
    work = workspace(patch)
    work.judge_by(judge)
    mesh = work.mesh
    vertex = int(np.flatnonzero(~mesh.fixed)[0])
    generator = np.random.default_rng(0)
    # Some of these places are outside the ball, so that cells are inverted.
    for reach in (0.0, 0.1, 0.5, 2.0):
        place = mesh.points[vertex].copy()
        place[: work.dimension] += reach * generator.uniform(-1, 1, work.dimension)
        n, worst = drivers.measured_star(mesh, vertex, Vec(*map(float, place)), work.scratch)
        points = mesh.points.copy()
        points[vertex] = place
        cells = mesh.cells[[h >> 2 for h in work.scratch.ball[:n]]]
        assert np.all((cells == vertex).any(axis=1))
        expected = np.empty(n)
        measure_cells(judge, points, cells, expected)
        np.testing.assert_allclose(work.scratch.values[:n], expected, rtol=1e-9, atol=1e-12)
        assert worst == work.scratch.values[:n].min()
