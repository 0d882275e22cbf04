"""Cells as the simplices of their corners."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.model import Block, Mesh
from support.edits import inside
from support.meshes import mesh, tri_grid


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


def thrown(of: Mesh, seed: int = 0) -> Mesh:
    """The grid with its inner vertices anywhere in it."""
    free = inside(of)
    points = of.points.copy()
    points[free] = np.random.default_rng(seed).uniform(size=(free.sum(), points.shape[1]))
    return Mesh(points, [Block(block.type, block.cells) for block in of.blocks])
