"""Cells that share no points: one finding says so, and the time does not explode."""

import time

import numpy as np
import pytest

from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from support.edits import at, moved, transformed, turned, without
from support.kinds import apart
from support.meshes import hex_grid, large_grid, octahedron, quad_grid, tet_grid, tri_grid

GRIDS = {"tets": tet_grid(3), "hexahedra": hex_grid(3), "quads": quad_grid(4), "triangles":
         tri_grid(4), "surface": octahedron()}  # fmt: skip


def shrunk(of, factor=0.8):
    """Each cell by itself, smaller around its middle."""
    far = apart(of)
    points = far.points.copy()
    for block in far.blocks:
        middle = points[block.cells].mean(axis=1, keepdims=True)
        points[block.cells] = middle + factor * (points[block.cells] - middle)
    return Mesh(points, far.blocks)


def in_pairs(of):
    """Two cells after each other share their points, and no others do."""
    cells = of.blocks[0].cells
    pair = np.arange(len(cells)) // 2
    places, number = np.unique(pair[:, None] * len(of.points) + cells, return_inverse=True)
    return Mesh(of.points[places % len(of.points)],
                [Block(of.blocks[0].type, number.reshape(cells.shape))])  # fmt: skip


@pytest.mark.parametrize("name", GRIDS)
def test_one_finding_says_what_the_mesh_is(name):
    of = apart(GRIDS[name])
    (group,) = check(of).groups
    (found,) = group.findings(of)
    assert group.code == "M202"
    assert "no two cells share a vertex" in found.message
    assert f"{len(of.points):,} points in {len(GRIDS[name].points):,} places" in found.message
    assert (found.cell, found.point) == (None, None)
    assert check(of, ignore=["M202"]).codes == ()


def test_some_may_share_theirs():
    of = in_pairs(tet_grid(3))
    (group,) = check(of).groups
    assert group.findings(of)[0].message.startswith("cells share few vertices: ")


def test_what_else_is_wrong_is_found_as_in_the_twin():
    spoiled = {
        "M201": Mesh(GRIDS["tets"].points, [Block("tetra", np.concatenate(
            [GRIDS["tets"].blocks[0].cells, GRIDS["tets"].blocks[0].cells[:1]]))]),
        "M101": turned(GRIDS["tets"], 7),
        "M207": turned(GRIDS["surface"], 3),
        "M104": moved(GRIDS["quads"], 12, [0.26, 0.26]),
        "M211": without(GRIDS["triangles"], at(GRIDS["triangles"], 0.4, 0.3)),
    }  # fmt: skip
    for code, of in spoiled.items():
        assert code in check(of).codes
        assert check(apart(of)).codes == tuple(sorted({*check(of).codes, "M202"}))


def test_a_cell_that_is_spoiled_by_merging_is_flat():
    of = apart(GRIDS["tets"])
    cell = of.blocks[0].cells[5]
    of.points[cell[0]] = of.points[cell[1]]
    assert set(check(of).codes) >= {"M102", "M202"}


def test_a_hanging_node_is_one_all_the_same():
    fine, coarse = hex_grid(2), hex_grid(1)
    both = [apart(fine), apart(transformed(coarse, lambda p: p + np.array([1, 0, 0])))]
    n = len(both[0].points)
    of = Mesh(np.concatenate([one.points for one in both]), [both[0].blocks[0],
              Block("hexahedron", both[1].blocks[0].cells + n)])  # fmt: skip
    assert check(of).codes == ("M202", "M205")


def test_cells_with_gaps_between_them_are_valid():
    for of in GRIDS.values():
        assert check(shrunk(of)).codes == ()


def test_one_of_many_cells_with_gaps_that_overlaps_is_found():
    of = shrunk(tet_grid(6))
    cells = of.blocks[0].cells
    of.points[cells[700]] += of.points[cells[300]].mean(axis=0) - of.points[cells[700]].mean(axis=0)
    (group,) = check(of, select=["M209"]).groups
    (found,) = group.findings(of)
    assert found.cell == 700
    assert (0, 300) in found.other_cells


def seconds(of):
    start = time.process_time()
    check(of)
    return time.process_time() - start


@pytest.mark.parametrize("make", [apart, in_pairs])
def test_the_time_is_near_that_of_the_twin(make):
    of = large_grid(12)
    of.points /= 12
    check(tet_grid(1))
    twin, own = (min(seconds(one) for _ in range(2)) for one in (of, make(of)))
    # Twenty times as long at this size where each facet is compared with all that are near.
    assert own < 3 * twin + 0.5


def test_layers_with_points_of_their_own_take_no_longer():
    n = 40
    of = tri_grid(n)
    cells = of.blocks[0].cells
    layer = np.floor(of.points[cells].mean(axis=1)[:, 0] * n).astype(np.int64)
    places, number = np.unique(layer[:, None] * len(of.points) + cells, return_inverse=True)
    own = Mesh(of.points[places % len(of.points)], [Block("triangle", number.reshape(-1, 3))])
    report = check(own)
    counts = {group.code: len(group) for group in report.groups}
    assert counts == {"M202": (n - 1) * (n + 1), "M205": (n - 1) * n}
    assert seconds(own) < 4 * seconds(of) + 0.5
