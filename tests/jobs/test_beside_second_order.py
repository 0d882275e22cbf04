"""What stands beside cells of second order in a file, and comes back with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.periodic import Link
from meshopt_cli.validity import check
from support.curved import middles_by_place, of_second_order, renumbered
from support.edits import shaken
from support.meshes import tet_grid, tri_grid
from support.runs import optimized
from support.samples import raw_ball

every_policy = pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=lambda p: p.name)


@pytest.mark.parametrize("make", [lambda: shaken(tri_grid(5)), lambda: shaken(tet_grid(3))])
def test_a_declared_middle_node_stays(make):
    of = of_second_order(make())
    free = middles_by_place(optimized(of))
    gone = [edge for edge in middles_by_place(of) if edge not in free]
    assert gone
    place = middles_by_place(of)[gone[0]]
    node = int(np.flatnonzero((of.points == place).all(axis=1))[0])
    of.blocks.append(Block("vertex", np.array([[node], [0]]), {"tag": np.array([5, 6])}))
    result = optimized(of)
    block = result.blocks[-1]
    assert block.data["tag"].tolist() == [5, 6]
    assert result.points[block.cells[:, 0]].tolist() == of.points[[node, 0]].tolist()
    assert middles_by_place(result)[gone[0]] == place


@every_policy
def test_cells_attached_to_middle_nodes_come_back(policy):
    """Beams and shells beside solids, which have middle nodes where others have vertices."""
    of = of_second_order(raw_ball())
    free = middles_by_place(optimized(of, policy))
    number = {tuple(place): k for k, place in enumerate(of.points.tolist())}
    gone = [(edge, place) for edge, place in middles_by_place(of).items() if edge not in free]
    (ends, place), *_ = gone
    a, b = (number[end] for end in ends)
    m, n = number[place], len(of.points)
    points = np.concatenate([of.points, [[3.0, 0, 0], [3, 1, 0], [3, 0.5, 0.1]]])
    lower = {
        "line": [[a, m], [m, b], [n, m]],
        "line3": [[m, n + 1, n + 2]],
        "triangle": [[m, n, n + 1]],
        "quad": [[a, m, n, n + 1]],
    }
    tags = {k: {"tag": np.arange(len(rows)) + 5} for k, rows in lower.items()}
    blocks = [Block(k, np.array(rows), tags[k]) for k, rows in lower.items()]
    of = Mesh(points, [*blocks, *of.blocks])
    assert not check(of).errors
    result = optimized(of, policy)
    assert check(result).codes == check(of).codes
    for old, new in zip(blocks, result.blocks, strict=False):
        assert new.type == old.type
        assert new.data["tag"].tolist() == old.data["tag"].tolist()
        assert result.points[new.cells].tolist() == points[old.cells].tolist()
    assert middles_by_place(replace(result, blocks=result.blocks[-1:]))[ends] == place


@every_policy
def test_periodic_sides_keep_their_middle_nodes(policy):
    one = shaken(tri_grid(6), 0.3)
    of = of_second_order(one)
    low, high = (np.flatnonzero(of.points[:, 0] == x) for x in (0, 1))
    low, high = (rows[np.argsort(of.points[rows, 1])] for rows in (low, high))
    of.periodic = [Link(1, 2, 1, (), np.stack([high, low], axis=1))]
    (link,) = optimized(of, policy).periodic
    result = optimized(of, policy)
    assert len(link.pairs) == 13
    assert result.points[link.pairs].tolist() == of.points[of.periodic[0].pairs].tolist()


def test_a_file_that_declares_every_node_says_nothing_by_it():
    of = of_second_order(raw_ball())
    plain = optimized(of)
    every = Block("vertex", np.arange(len(of.points))[:, None])
    result = optimized(replace(of, blocks=[*of.blocks, every]))
    assert result.points.tobytes() == plain.points.tobytes()
    assert len(result.blocks[-1].cells) < len(of.points)


def test_points_that_nothing_uses_stay():
    of = renumbered(of_second_order(shaken(tri_grid(4))), 1)
    of.points[-1] += 0
    stray = np.array([[9.0, 9.0], [8.0, 7.0]])
    of = replace(of, points=np.concatenate([stray[:1], of.points, stray[1:]]),
                 blocks=[replace(b, cells=b.cells + 1) for b in of.blocks])  # fmt: skip
    result = optimized(of)
    assert set(map(tuple, stray.tolist())) <= set(map(tuple, result.points.tolist()))
    assert result.points[0].tolist() == stray[0].tolist()
