"""Arrays that number points and cells: no number is there twice, and what stays keeps its own."""

import numpy as np
import pytest

from meshopt_cli.mesh.model import Block, Mesh
from support.edits import shaken
from support.meshes import tet_grid, tri_grid
from support.runs import optimized

GRIDS = {"plane": tri_grid(8), "space": tet_grid(4)}


def numbered(grid: Mesh, dtype, first: int) -> Mesh:
    """A shaken grid that numbers its points and, in two blocks, its cells backwards."""
    mesh = shaken(grid, 0.3, 5)
    (block,) = mesh.blocks
    n, cut = len(block.cells), len(block.cells) // 3
    numbers = (first + np.arange(n)[::-1]).astype(dtype)
    parts = [slice(0, cut), slice(cut, n)]
    mesh.blocks = [
        Block(block.type, block.cells[rows], {"GlobalElementId": numbers[rows]}) for rows in parts
    ]
    mesh.point_data["GlobalNodeId"] = (first + 2 * np.arange(len(mesh.points))).astype(dtype)
    return mesh


def cells_by_number(mesh: Mesh) -> dict[int, frozenset]:
    """The vertices of each cell, by their numbers, by its number."""
    points = mesh.point_data["GlobalNodeId"].tolist()
    numbers = [n for block in mesh.blocks for n in block.data["GlobalElementId"].tolist()]
    cells = [c for block in mesh.blocks for c in block.cells.tolist()]
    assert len(set(numbers)) == len(numbers)
    return {n: frozenset(points[i] for i in cell) for n, cell in zip(numbers, cells, strict=True)}


@pytest.mark.parametrize("dtype", [np.int64, np.uint32, np.float64])
@pytest.mark.parametrize("grid", GRIDS)
def test_numbers_stay_with_what_they_number(grid, dtype):
    mesh = numbered(GRIDS[grid], dtype, 7)
    result = optimized(mesh, preset="best")
    before, after = mesh.point_data["GlobalNodeId"], result.point_data["GlobalNodeId"]
    assert after.dtype == dtype
    assert len(set(after.tolist())) == len(after)
    place = dict(zip(before.tolist(), mesh.points.tolist(), strict=True))
    stays = [n for n, x in zip(after.tolist(), result.points.tolist(), strict=True)
             if n in place and place[n] == x]  # fmt: skip
    assert len(stays) >= 4
    new = set(after.tolist()) - set(before.tolist())
    assert all(n > before.max() for n in new)

    old_cells, new_cells = cells_by_number(mesh), cells_by_number(result)
    numbers = {corners: n for n, corners in old_cells.items()}
    kept = [n for n, corners in new_cells.items() if corners in numbers]
    assert kept
    assert all(numbers[new_cells[n]] == n for n in kept)
    assert all(n > max(old_cells) for n in set(new_cells) - set(kept))


def test_numbers_that_grow_out_of_their_type_get_a_wider_one():
    mesh = numbered(tri_grid(8), np.int64, 0)
    for data, name in ((b.data, "GlobalElementId") for b in mesh.blocks):
        data[name] = data[name].astype(np.uint8)
    result = optimized(mesh)
    assert len(cells_by_number(result)) == sum(len(block.cells) for block in result.blocks)


def test_numbers_of_the_other_cells_are_taken_too():
    """Lines and triangles are numbered together: new triangles do not get the number of a line."""
    mesh = numbered(tri_grid(8), np.int64, 0)
    n = sum(len(block.cells) for block in mesh.blocks)
    line = np.array([[0, 1]])
    mesh.blocks.append(Block("line", line, {"GlobalElementId": np.array([n + 5])}))
    result = optimized(mesh)
    cells_by_number(result)
    (kept,) = [block for block in result.blocks if block.type == "line"]
    assert kept.data["GlobalElementId"].tolist() == [n + 5]
