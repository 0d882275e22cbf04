"""Who gets what lies around points that several pieces have."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.mesh.adjacency import edges
from meshopt_cli.pieces.layers import GIVEN, given_by, near, taken_by
from meshopt_cli.pieces.shared import faces_among, shared_by
from support.meshes import tet_grid, tri_grid

GRIDS = {"tets": tet_grid(6), "triangles": tri_grid(12)}
on_grids = pytest.mark.parametrize("name", GRIDS)


def steps_from(mesh, start):
    """Edges on the way from some points to each point."""
    away = np.full(len(mesh.points), np.inf)
    away[start] = 0
    ends = edges(mesh.blocks[0].cells, len(mesh.points))
    for _ in mesh.points:
        before = away.copy()
        np.minimum.at(away, ends[:, 0], before[ends[:, 1]] + 1)
        np.minimum.at(away, ends[:, 1], before[ends[:, 0]] + 1)
        if np.array_equal(away, before):
            break
    return away


@on_grids
@pytest.mark.parametrize("layers", [1, 2, 3])
def test_layers_are_counted_in_cells(name, layers):
    mesh = GRIDS[name]
    marked = mesh.points[:, 0] == 0
    (found,) = near(mesh, marked, layers)
    away = steps_from(mesh, np.flatnonzero(marked))
    wanted = away[mesh.blocks[0].cells].min(axis=1) < layers
    np.testing.assert_array_equal(found, wanted)


@on_grids
def test_the_nearest_owner_gets_a_cell_and_of_two_the_first(name):
    mesh = GRIDS[name]
    owner = np.where(mesh.points[:, 0] == 0, 5, np.where(mesh.points[:, 0] == 1, 2, -1))
    (found,) = taken_by(mesh, owner)
    away = [steps_from(mesh, np.flatnonzero(owner == k))[mesh.blocks[0].cells].min(axis=1)
            for k in (2, 5)]  # fmt: skip
    wanted = np.where(np.minimum(*away) >= GIVEN, -1, np.where(away[0] <= away[1], 2, 5))
    np.testing.assert_array_equal(found, wanted)


@on_grids
def test_a_piece_keeps_half_of_its_cells(name):
    mesh = GRIDS[name]
    for owner in (np.full(len(mesh.points), 1), np.where(mesh.points[:, 0] == 0, 1, -1)):
        (found,) = given_by(mesh, 0, owner)
        assert np.count_nonzero(found == 1) <= len(found) // 2


def test_shared_points_are_those_of_several_borders():
    borders = [np.array([1, 4, 9]), np.array([4, 5]), np.array([4, 9]), np.array([], np.int64)]
    shared = shared_by(borders)
    assert shared.ids.tolist() == [4, 9]
    assert shared.n_again == 3
    asked = np.array([9, 1, 4, 100, 5])
    assert shared.owners(asked, 0).tolist() == [0, -1, 0, -1, -1]
    assert shared.owners(asked, 1).tolist() == [2, -1, 2, -1, -1]
    for turn in range(2, 9):
        owners = shared.owners(asked, turn)
        assert owners[0] in (0, 2)
        assert owners[2] in (0, 1, 2)
        assert (owners[[1, 3, 4]] == -1).all()
    few = shared.among(np.array([9, 77]))
    assert few.ids.tolist() == [9]
    assert few.owners(asked, 1).tolist() == [2, -1, -1, -1, -1]
    assert shared_by(borders[:1]).owners(asked, 0).tolist() == [-1] * 5


def test_every_piece_is_an_owner_in_turn():
    borders = [np.array([7])] * 5
    shared = shared_by(borders)
    assert {int(shared.owners(np.array([7]), turn)[0]) for turn in range(40)} == set(range(5))


def test_faces_of_several_pieces_are_told():
    one, other = np.array([[1, 2, 3], [2, 3, 4]]), np.array([[2, 3, 4], [5, 6, 7]])
    assert [found.tolist() for found in faces_among([one, other])] == [[[2, 3, 4]]] * 2
