"""Grids with anything done to them at random."""

import numpy as np
from hypothesis import strategies as st

from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.orientation import turned
from support.edits import shaken


def some_turned(points, cells, random):
    chosen = random.random(len(cells)) < random.random()
    return points, np.where(chosen[:, None], turned(cells), cells)


def some_gone(points, cells, random):
    return points, np.delete(cells, random.integers(0, len(cells), 2), axis=0)


def one_twice(points, cells, random):
    return points, np.concatenate([cells, cells[random.integers(0, len(cells), 1)]])


def one_elsewhere(points, cells, random):
    cells = cells.copy()
    cells[random.integers(len(cells)), random.integers(cells.shape[1])] = random.integers(
        len(points)
    )
    return points, cells


def one_point_moved(points, cells, random):
    points = points.copy()
    points[random.integers(len(points))] += random.uniform(-0.3, 0.3, points.shape[1])
    return points, cells


def two_points_in_one_place(points, cells, random):
    point = random.integers(len(points))
    chosen = (cells == point) & (random.random(len(cells)) < 0.5)[:, None]
    return np.concatenate([points, points[[point]]]), np.where(chosen, len(points), cells)


def two_points_made_one(points, cells, random):
    one, other = random.integers(0, len(points), 2)
    return points, np.where(cells == one, other, cells)


def twice_in_one(points, cells, random):
    away = points + random.choice([0.0, 0.5, 1.0, 3.0])
    return np.concatenate([points, away]), np.concatenate([cells, cells + len(points)])


def all_apart(points, cells, random):
    return points[cells].reshape(-1, points.shape[1]), np.arange(cells.size).reshape(cells.shape)


EDITS = (some_turned, some_gone, one_twice, one_elsewhere, one_point_moved)
EDITS += (two_points_in_one_place, two_points_made_one, twice_in_one, all_apart)


@st.composite
def meshes(draw, grid):
    """A shaken grid with up to three things done to it, and cells of lower dimension anywhere."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    mesh = shaken(grid, draw(st.sampled_from([0.05, 0.2, 0.4])), int(random.integers(1000)))
    points, cells = mesh.points, mesh.blocks[0].cells
    for edit in draw(st.lists(st.sampled_from(EDITS), max_size=3)):
        points, cells = edit(points, cells, random)
    blocks = [Block(mesh.blocks[0].type, cells)]
    if draw(st.booleans()):
        blocks[0].data["part"] = random.integers(0, 3, len(cells)).astype(float)
    for kind, width in (("line", 2), ("triangle", 3))[: cells.shape[1] - 2]:
        if draw(st.booleans()):
            blocks.append(Block(kind, random.integers(0, len(points), (3, width))))
    return Mesh(points, blocks)


def some_mirrored(points, cells, random):
    """Some cells with their corners in the opposite order, or in any."""
    cells = cells.copy()
    chosen = random.random(len(cells)) < random.random()
    order = (
        np.arange(cells.shape[1])[::-1]
        if random.random() < 0.7
        else random.permutation(cells.shape[1])
    )
    cells[chosen] = cells[chosen][:, order]
    return points, cells


@st.composite
def cells(draw, grid):
    """A grid of any cells, its points moved, after up to three edits of some of its blocks."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    reach = draw(st.sampled_from([0.0, 0.03, 0.1]))
    inside = np.all((grid.points > 0) & (grid.points < 1), axis=1)
    points, blocks = grid.points.copy(), list(grid.blocks)
    points[inside] += random.uniform(-reach, reach, points[inside].shape)
    edits = [*EDITS[1:], some_mirrored]
    if len(blocks) > 1:  # the others would lose their points
        edits.remove(all_apart)
    for edit in draw(st.lists(st.sampled_from(edits), max_size=3)):
        k = int(random.integers(len(blocks)))
        if len(blocks[k].cells) > 3:
            points, rows = edit(points, blocks[k].cells, random)
            blocks[k] = Block(blocks[k].type, rows)
    if draw(st.booleans()):
        for block in blocks:
            block.data["part"] = random.integers(0, 2, len(block.cells))
    return Mesh(points, [Block(b.type, b.cells, dict(b.data)) for b in blocks])
