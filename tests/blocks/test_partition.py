"""Which vertices and cells are in which block."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.blocks import partition
from meshopt_cli.blocks.cut import Shells
from meshopt_cli.handles import RIM
from meshopt_cli.kernels.blocks import ON_RIM
from support.edits import shaken
from support.invariants import assert_whole, snapshot, workspace
from support.meshes import tet_grid, tri_grid

pytestmark = pytest.mark.usefixtures("_small_blocks")
MESHES = {2: shaken(tri_grid(40)), 3: shaken(tet_grid(10))}


@pytest.fixture(params=MESHES)
def work(request):
    return workspace(MESHES[request.param])


@pytest.mark.parametrize("frames", partition.FRAMES.values(), ids=str)
def test_frames_are_of_unit_vectors_at_right_angles(frames):
    assert len(frames) == partition.N_TURNS
    for frame in frames:
        np.testing.assert_allclose(np.inner(frame, frame), np.eye(len(frame)), atol=1e-15)


def test_blocks_have_as_many_vertices(work):
    found = partition.partition_of(work)
    assert found.n_blocks == (8 if work.dimension == 2 else 16)
    for label in found.labels:
        sizes = np.bincount(label)
        assert len(sizes) == found.n_blocks
        assert sizes.max() - sizes.min() <= 1


def test_equal_places_go_by_their_rows():
    points = np.zeros((6, 3))
    label = partition.bisected(points, np.array([0, 2, 3, 5]), partition.FRAMES[3][1], 1)
    assert label.tolist() == [0, 0, 0, 1, 0, 1]


def test_a_vertex_is_at_home_where_all_its_cells_are(work):
    label = partition.partition_of(work).labels[1]
    found, home = partition.homes(work, label)
    cells = work.corners(work.living())
    owner = label[cells].min(axis=1)
    assert found[work.living()].tolist() == owner.tolist()
    for vertex in range(0, work.n_points, 7):
        owners = np.unique(owner[(cells == vertex).any(axis=1)])
        assert home[vertex] == (owners[0] if len(owners) == 1 else ON_RIM)


def test_few_vertices_are_on_the_rims_of_both_turns(monkeypatch):
    monkeypatch.setattr(partition, "BLOCK_CELLS", 1500)
    for width, mesh in MESHES.items():
        work = workspace(mesh)
        labels = partition.partition_of(work).labels
        on_rim = [partition.homes(work, label)[1] == ON_RIM for label in labels]
        assert on_rim[0].mean() < (0.1 if width == 2 else 0.35)
        assert np.mean(on_rim[0] & on_rim[1]) < 0.5 * on_rim[0].mean()


def test_new_vertices_ask_for_another_partition(work):
    found = partition.partition_of(work)
    assert partition.partition_of(work) is found
    work.reserve_points(work.n_points + 1)
    work.mesh.state[3] += 1
    again = partition.partition_of(work)
    assert again is not found
    assert len(again.labels[0]) == len(work.mesh.points)


def test_a_mesh_that_was_cut_and_sewn_is_as_it_was(work):
    for _ in range(4):
        work.grow()
    before, found = snapshot(work), partition.partition_of(work)
    parts = Shells(work, found.labels[0], found.n_blocks, work.living())
    borders = work.mesh.neighbours[work.living()]
    on_rims = borders[borders <= RIM]
    assert len(on_rims) == 2 * len(np.unique(on_rims)) > 0
    parts.close()
    after = snapshot(work)
    assert {name for name in before if before[name] != after[name]} <= {"vertex_cell"}
    assert_whole(work)
    assert np.all(work.mesh.neighbours > RIM)


def test_blocks_share_no_cell_and_no_row(work):
    found = partition.partition_of(work)
    parts = Shells(work, found.labels[0], found.n_blocks, work.living())
    visited = np.concatenate([share.order for share in parts.shares])
    assert len(np.unique(visited)) == len(visited) > 0.2 * work.n_cells
    rows = [share.mesh.free[: share.mesh.state[1]] for share in parts.shares]
    assert all(len(one) >= 32 for one in rows)
    rows = np.concatenate(rows)
    assert len(np.unique(rows)) == len(rows)
    assert not work.mesh.alive[rows].any()
    parts.close()
