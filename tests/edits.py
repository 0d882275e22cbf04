"""Changes to a mesh that break it in one way."""

import numpy as np

from meshopt_cli.mesh.model import Block, Mesh


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
