"""Changes to a mesh: some break it in one way, some it bears."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh
from support.invariants import volumes
from support.meshes import tet_grid


def inside(of):
    """Which vertices of a grid of the unit square or cube are inside of it."""
    return ((of.points > 1e-9) & (of.points < 1 - 1e-9)).all(axis=1)


def shaken(of, amount=0.22, seed=0):
    """A grid with its inner vertices moved at random, all simplices still positive.

    Each coordinate moves by up to `amount` times the distance between neighbours in the grid.
    """
    (block,) = of.blocks
    n, width = of.points.shape
    reach = amount / (round(n ** (1 / width)) - 1)
    step = np.random.default_rng(seed).uniform(-reach, reach, (n, width))
    step[~inside(of)] = 0.0
    if block.type in ("triangle", "tetra"):
        least = 1e-2 * volumes(of.points, block.cells)
        while (inverted := volumes(of.points + step, block.cells) < least).any():
            step[block.cells[inverted]] *= 0.5
    return Mesh(of.points + step, of.blocks, of.point_data)


def with_regions(patch: Mesh, regions: np.ndarray) -> Mesh:
    """The patch with a region for each cell of its first block."""
    patch.blocks[0].data = {"gmsh:physical": np.asarray(regions, dtype=np.int64)}
    return patch


def halves(patch: Mesh) -> Mesh:
    """The patch cut in two regions near the plane x = 1/2."""
    centres = patch.points[patch.blocks[0].cells].mean(axis=1)
    return with_regions(patch, centres[:, 0] > 0.5)


def declaring_some(patch: Mesh) -> Mesh:
    """The patch with a few edges and a vertex inside it declared."""
    source = cast(patch)
    edges = adjacency.edges(source.cells, len(source.points))
    outside = np.isin(edges, source.skin)
    inside = edges[~outside.all(axis=1)]
    vertex = inside[-1][~np.isin(inside[-1], source.skin)][0]
    return declaring(patch, line=inside[:: len(inside) // 5], vertex=[[vertex]])


def moved(base, point, to):
    points = base.points.copy()
    points[point] = to
    return Mesh(points, base.blocks)


def transformed(base, change):
    return Mesh(change(base.points), base.blocks)


def shifted(base, *by):
    return transformed(base, lambda points: points + np.array(by))


def together(one, other):
    """Two meshes as they are in one."""
    (block,) = other.blocks
    moved_on = Block(block.type, block.cells + len(one.points))
    return Mesh(np.concatenate([one.points, other.points]), [*one.blocks, moved_on])


def with_cells(base, cells):
    return Mesh(base.points, [Block(base.blocks[0].type, np.array(cells))])


def turned(base, row):
    """One cell turned over."""
    cells = base.blocks[0].cells.copy()
    cells[row] = cells[row][[1, 0, 2, 3]] if base.blocks[0].type == "tetra" else cells[row][::-1]
    return with_cells(base, cells)


def torn(base, n):
    """The first n cells torn off: they get points of their own."""
    cells = base.blocks[0].cells.copy()
    old = np.intersect1d(cells[:n], cells[n:])
    part = cells[:n]
    shared = np.isin(part, old)
    part[shared] = len(base.points) + np.searchsorted(old, part[shared])
    points = np.concatenate([base.points, base.points[old]])
    return Mesh(points, [Block(base.blocks[0].type, cells)])


def without(base, *rows):
    """A mesh with some cells deleted."""
    return with_cells(base, np.delete(base.blocks[0].cells, rows, axis=0))


def declaring(base, **cells):
    """A mesh with cells of lower dimension besides."""
    extra = [Block(kind, np.array(rows)) for kind, rows in cells.items()]
    return Mesh(base.points, [*extra, *base.blocks])


def tagged(base, tags, name="medit:ref"):
    """A mesh with a tag for each cell."""
    (block,) = base.blocks
    return Mesh(base.points, [Block(block.type, block.cells, {name: np.array(tags)})])


def untangled_badly(base, point, to):
    """A vertex moved out of its ball, and the cells that this inverts turned positive."""
    of = moved(base, point, to)
    cells = of.blocks[0].cells
    corners = of.points[cells]
    negative = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    return with_cells(of, np.where(negative[:, None], cells[:, [0, 2, 1, 3]], cells))


def at(base, *center):
    """Row of the cell with this centre."""
    middle = base.points[base.blocks[0].cells].mean(axis=1)
    return int(np.argmin(np.linalg.norm(middle - np.array(center), axis=1)))


def cell_inside(base):
    """Row of the cell that is nearest to the middle of a grid and off its boundary."""
    inner = ((base.points > 1e-9) & (base.points < 1 - 1e-9)).all(axis=1)
    n = inner[base.blocks[0].cells].sum(axis=1)
    return int(np.argmax(n))


def turned_over(one):
    """The mesh with all its main cells listed the other way round."""
    blocks = [replace(b, cells=b.cells[:, [0, 2, 1, *range(3, b.cells.shape[1])]].copy())
              for b in one.blocks]  # fmt: skip
    return replace(one, blocks=blocks)


def layered(cut=0.5):
    """A shaken grid of tets in two layers, the tag in an array; the layers share a plane."""
    grid = tet_grid(4)
    cells = grid.blocks[0].cells
    upper = grid.points[cells].mean(axis=1)[:, 2] > cut
    free = np.all((grid.points > 1e-9) & (grid.points < 1 - 1e-9), axis=1)
    free &= np.abs(grid.points[:, 2] - cut) > 1e-9
    grid.points[free] += np.random.default_rng(3).uniform(-0.05, 0.05, (free.sum(), 3))
    grid.blocks[0].data["layer"] = np.where(upper, 9, -4).astype(np.int32)
    return grid
