"""A mesh comes back with all that came in."""

import numpy as np

from meshopt_cli.mesh.model import Block, Mesh
from support.edits import layered, shaken
from support.invariants import volumes
from support.meshes import tet_grid
from support.places import cells_of, facets, places
from support.runs import optimized


def test_unused_points_stay():
    one = shaken(tet_grid(4))
    extra = np.array([[9.0, 9, 9], [0.51, 0.52, 0.53], [-1, 0, 0]])
    one.points = np.concatenate([extra[:2], one.points, extra[2:]])
    one.blocks[0].cells += 2
    result = optimized(one)
    assert np.array_equal(result.points[:2], extra[:2])
    used = np.zeros(len(result.points), bool)
    used[cells_of(result, "tetra")] = True
    assert np.array_equal(result.points[~used], extra)
    assert np.all(volumes(result.points, cells_of(result, "tetra")) > 0)


def patchwork():
    """A mesh with cells of every dimension in a deliberate order, and all kinds of arrays."""
    one = layered()
    (block,) = one.blocks
    layer = block.data["layer"]
    rim = np.sort(facets(block.cells), axis=1)
    rim, times = np.unique(rim, axis=0, return_counts=True)
    rim = rim[times == 1]
    parts = [block.cells[layer == 9], block.cells[layer == -4]]

    def part(kind, cells, ref):
        return Block(kind, np.asarray(cells), {"medit:ref": np.full(len(cells), ref)})

    blocks = [
        part("vertex", [[0], [124]], 1),
        part("tetra", parts[0][::2], 9),
        part("triangle", rim[::2], 5),
        part("tetra", parts[1], -4),
        part("line", rim[:7, :2], 8),
        part("tetra", parts[0][1::2], 9),
        part("triangle", rim[1::2], 6),
    ]
    names = {"upper": (9, 3), "lower": (-4, 3), "skin": (5, 2)}
    data = {"medit:ref": np.arange(len(one.points)), "T": np.linspace(0, 1, len(one.points))}
    return Mesh(one.points, blocks, data, names)


def test_blocks_keep_their_order_and_their_cells():
    one = patchwork()
    result = optimized(one)
    kinds = [b.type for b in result.blocks]
    # A region in two blocks may come back in one.
    assert [k for k in kinds if k != "tetra"] == [b.type for b in one.blocks if b.type != "tetra"]
    assert kinds[:5] == [b.type for b in one.blocks[:5]]
    for kind in ("vertex", "line", "triangle"):
        old = [b for b in one.blocks if b.type == kind]
        new = [b for b in result.blocks if b.type == kind]
        for a, b in zip(old, new, strict=True):
            assert places(one, a.cells) == places(result, b.cells)
            assert np.array_equal(a.data["medit:ref"], b.data["medit:ref"])
    tets = [b for b in result.blocks if b.type == "tetra"]
    assert [len(set(b.data["medit:ref"])) for b in tets] == [1] * len(tets)
    assert {int(b.data["medit:ref"][0]) for b in tets} == {9, -4}


def test_names_and_whole_numbers_of_points_are_kept():
    one = patchwork()
    result = optimized(one)
    assert result.names == one.names
    assert set(result.point_data) == {"medit:ref", "T"}
    number = {tuple(point): k for k, point in enumerate(one.points)}
    known = [k for k, point in enumerate(result.points) if tuple(point) in number]
    assert len(known) >= 5**3 - 3**3
    for k in known:
        assert result.point_data["medit:ref"][k] == number[tuple(result.points[k])]


def test_the_input_is_left_as_it_is():
    one = patchwork()
    points, cells = one.points.copy(), [b.cells.copy() for b in one.blocks]
    optimized(one)
    assert np.array_equal(one.points, points)
    assert all(np.array_equal(b.cells, c) for b, c in zip(one.blocks, cells, strict=True))


def test_empty_blocks_do_no_harm():
    one = shaken(tet_grid(3))
    for kind, width in (("tetra", 4), ("quad", 4), ("triangle", 3), ("vertex", 1)):
        one.blocks.append(Block(kind, np.empty((0, width), np.int64)))
    result = optimized(one)
    assert len(cells_of(result, "tetra"))
    assert all(not len(b.cells) for b in result.blocks if b.type != "tetra")
