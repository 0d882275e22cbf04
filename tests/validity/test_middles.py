"""Middle nodes that cells have in common: M106."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.elements import ELEMENTS
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from support.curved import of_second_order
from support.meshes import tet_grid, tri_grid

WITH_MIDDLES = [
    name
    for name, row in ELEMENTS.items()
    if any(len(corners) <= 4 for corners in row.middles) and row.family != "pyramid"
]


def two_cells(name):
    """A cell of a type and its mirror image across one of its facets, which they share."""
    nodes = np.zeros((ELEMENTS[name].n_nodes, 3))
    nodes[:, : ELEMENTS[name].nodes.shape[1]] = ELEMENTS[name].nodes
    both = np.concatenate([nodes, nodes * [1, -1, 1]])
    points, number = np.unique(both.round(9), axis=0, return_inverse=True)
    cells = number.reshape(2, -1)
    return Mesh(points, [Block(name, cells)])


def mismatched(of):
    return [group for group in check(of, ("M106",)).groups]


def with_own(of, place):
    """The mesh with a node of its own in a place of its last cell, near to the old one."""
    (block,) = of.blocks
    cells = block.cells.copy()
    points = np.concatenate([of.points, of.points[cells[-1, place]][None] + 0.01])
    cells[-1, place] = len(of.points)
    return Mesh(points, [replace(block, cells=cells)])


@pytest.mark.parametrize("name", WITH_MIDDLES)
def test_every_common_middle_node_is_looked_at(name):
    of = two_cells(name)
    assert not mismatched(of)
    (block,) = of.blocks
    n_corners = ELEMENTS[name].n_nodes - len(ELEMENTS[name].middles)
    common = [
        place
        for place, corners in enumerate(ELEMENTS[name].middles, n_corners)
        if len(corners) <= 4 and np.isin(block.cells[1, list(corners)], block.cells[0]).all()
    ]
    assert common
    for place in range(n_corners, ELEMENTS[name].n_nodes):
        found = mismatched(with_own(of, place))
        assert len(found) == (place in common)
        for group in found:
            (one,) = group.findings(of)
            assert (one.cell, one.other_cells) == (1, ((0, 0),))


@pytest.mark.parametrize("grid", [tri_grid(3), tet_grid(2)], ids=["plane", "space"])
def test_a_middle_node_in_two_places(grid):
    of = of_second_order(grid)
    (block,) = of.blocks
    cells = block.cells.copy()
    cells[cells == cells[0, -1]] = cells[-1, -1]
    (group,) = mismatched(replace(of, blocks=[replace(block, cells=cells)]))
    assert {one.message for one in group.findings(of)} == {
        "a middle node of the cell is that of another edge or face too"
    }


def test_a_middle_node_that_is_a_corner():
    of = of_second_order(tet_grid(1))
    (block,) = of.blocks
    other = np.r_[block.cells[0, 4], len(of.points) : len(of.points) + 9]
    points = np.concatenate([of.points, np.random.default_rng(0).random((9, 3)) + 2])
    both = Mesh(points, [*of.blocks, Block("tetra10", other[None])])
    (group,) = mismatched(both)
    (one,) = group.findings(both, 1)
    assert one.message == "a middle node of the cell is a corner of a cell too"
    assert (1, 0) in one.other_cells


@pytest.mark.parametrize(("kind", "width"), [("vertex", 1), ("line", 2), ("triangle", 3)])
def test_cells_of_lower_dimension_may_be_attached_to_middle_nodes(kind, width):
    of = of_second_order(tet_grid(1))
    (block,) = of.blocks
    rows = [
        [block.cells[0, 4], *block.cells[0, :2]][: ["vertex", "line", "triangle"].index(kind) + 1]
    ]
    assert not mismatched(replace(of, blocks=[Block(kind, np.array(rows)), block]))


def test_facets_have_the_middle_nodes_of_their_cells():
    one = tet_grid(1)
    facets = Block("triangle", one.blocks[0].cells[:, :3].copy())
    of = of_second_order(replace(one, blocks=[facets, *one.blocks]))
    assert not mismatched(of)
    cells = of.blocks[0].cells.copy()
    cells[0, 3] = len(of.points)
    points = np.concatenate([of.points, of.points[:1]])
    (group,) = mismatched(Mesh(points, [replace(of.blocks[0], cells=cells), of.blocks[1]]))
    assert len(group) >= 1
