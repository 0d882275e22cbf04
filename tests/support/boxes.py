"""Squares and cubes whose sides are declared."""

from __future__ import annotations

import numpy as np

from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block
from support.invariants import volumes
from support.meshes import tet_grid, tri_grid


def box(dimension, n, seed, amount=0.3):
    """A unit square or cube whose vertices are shaken, those of the boundary within it.

    Each side is declared, with its own tag.
    """
    grid = tri_grid(n) if dimension == 2 else tet_grid(n)
    generator = np.random.default_rng(seed)
    points = grid.points
    step = generator.uniform(-amount / n, amount / n, points.shape)
    step[(points == 0) | (points == 1)] = 0.0
    source = cast(grid)
    wide = np.zeros((len(points), 3))
    wide[:, :dimension] = step
    for _ in range(30):
        bad = volumes(source.points + wide, source.cells) < 1e-4 / n**dimension
        if not bad.any():
            break
        wide[source.cells[bad]] *= 0.5
    skin = source.skin
    corners = points[skin]
    side = np.zeros(len(skin), np.int64)
    for axis in range(dimension):
        for k in (0, 1):
            side[(corners[:, :, axis] == k).all(axis=1)] = 1 + 2 * axis + k
    grid.points = points + wide[:, :dimension]
    kind = "triangle" if dimension == 3 else "line"
    grid.blocks[0].data = {"gmsh:physical": np.full(len(source.cells), 9)}
    grid.blocks.append(Block(kind, skin, {"gmsh:physical": side}))
    return grid


def on_sides(points):
    return np.minimum(np.abs(points), np.abs(points - 1)) < 1e-9
