"""Cells as the simplices of their corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.model import Block, Mesh
from support.edits import inside
from support.meshes import hex_grid, mesh, quad_grid, tri_grid


class Corners(NamedTuple):
    """What `relocate_all` takes, in its order."""

    points: np.ndarray
    simplices: np.ndarray
    shapes: np.ndarray
    shape: np.ndarray
    fixed: np.ndarray
    cell: np.ndarray


def corners(of: Mesh) -> Corners:
    """The corners of all cells of a grid of the unit square or cube, whose boundary is fixed."""
    simplices, shapes, shape, cell = [], [], [], []
    n_cells = 0
    for block in of.blocks:
        family = FAMILIES[block.type]
        for rows in family.corners:
            edges = family.reference[rows[1:]] - family.reference[rows[0]]
            simplices.append(block.cells[:, rows])
            shape.append(np.full(len(block.cells), len(shapes)))
            shapes.append(np.linalg.inv(edges[:, : family.dimension].T))
            cell.append(n_cells + np.arange(len(block.cells)))
        n_cells += len(block.cells)
    n, width = of.points.shape
    return Corners(
        np.column_stack([of.points, np.zeros((n, 3 - width))]),
        np.concatenate(simplices),
        np.array(shapes),
        np.concatenate(shape),
        ~inside(of),
        np.concatenate(cell),
    )


def wedge_grid(n: int) -> Mesh:
    """Wedges over the triangles of a grid."""
    flat = tri_grid(n)
    (block,) = flat.blocks
    n_flat = len(flat.points)
    points = [np.column_stack([flat.points, np.full(n_flat, k / n)]) for k in range(n + 1)]
    cells = [
        np.hstack([block.cells + k * n_flat, block.cells + (k + 1) * n_flat]) for k in range(n)
    ]
    return mesh(np.concatenate(points), wedge=np.concatenate(cells))


def tri_quad_grid(n: int) -> Mesh:
    """Squares, of which every other is two triangles."""
    grid = quad_grid(n)
    quads = grid.blocks[0].cells
    halved = np.arange(len(quads)) % 3 == 0
    halves = np.concatenate([quads[halved][:, [0, 1, 2]], quads[halved][:, [0, 2, 3]]])
    return Mesh(grid.points, [Block("triangle", halves), Block("quad", quads[~halved])])


def pyramid_grid(n: int) -> Mesh:
    """Cubes, some of them six pyramids around their middle, and one of these two tetrahedra."""
    grid = hex_grid(n)
    cubes = grid.blocks[0].cells
    split = np.arange(len(cubes)) % 2 == 0
    middles = grid.points[cubes[split]].mean(axis=1)
    tops = len(grid.points) + np.arange(len(middles))
    pyramids = np.concatenate(
        [np.column_stack([cubes[split][:, facet[::-1]], tops])
         for facet in np.concatenate(FAMILIES["hexahedron"].facets)]
    )  # fmt: skip
    points = np.concatenate([grid.points, middles])
    return Mesh(points, [Block("pyramid", pyramids), Block("hexahedron", cubes[~split])])


def thrown(of: Mesh, seed: int = 0) -> Mesh:
    """The grid with its inner vertices anywhere in it."""
    free = inside(of)
    points = of.points.copy()
    points[free] = np.random.default_rng(seed).uniform(size=(free.sum(), points.shape[1]))
    return Mesh(points, [Block(block.type, block.cells) for block in of.blocks])
