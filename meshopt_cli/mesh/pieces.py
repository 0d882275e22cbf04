"""A mesh in pieces: each has cells of its own, and the points of these, which have one number each
through all pieces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..cells import dimension_of, family_of
from .adjacency import distinct, places_in
from .model import Array, Block, Mesh, top_blocks
from .plane import with_depth

# The array of the points that has their numbers through all pieces, as VTK calls it.
IDS = "GlobalPointIds"


def pieces_of_cells(mesh: Mesh, n: int) -> list[Array]:
    """Piece of each cell of each block, (n,) int64: as many in each piece, near each other.

    Cells of the greatest dimension are cut in halves by the plane through the median of their
    centres, across their longest extent, again and again. A cell of lower dimension goes with the
    first piece that has a cell around it, or with the first of all.

    Parameters
    ----------
    n : int
        Pieces, at most as many as there are cells of the greatest dimension.
    """
    top = top_blocks(mesh)
    points = with_depth(mesh.points)
    centres = np.concatenate([points[block.cells].mean(axis=1) for block in top])
    piece = np.zeros(len(centres), dtype=np.int64)
    waiting = [(np.arange(len(centres)), 0, n)]
    while waiting:
        rows, first, count = waiting.pop()
        if count == 1:
            piece[rows] = first
            continue
        axis = int(np.argmax(np.ptp(centres[rows], axis=0)))
        rows = rows[np.lexsort((rows, centres[rows, axis]))]
        half = count // 2
        at = len(rows) * half // count
        waiting += [(rows[:at], first, half), (rows[at:], first + half, count - half)]
    return with_lower_cells(mesh, np.split(piece, np.cumsum([len(b.cells) for b in top])[:-1]))


def with_lower_cells(mesh: Mesh, of_top: list[Array]) -> list[Array]:
    """Piece of each cell of each block, where that of the cells of the greatest dimension is known.

    Parameters
    ----------
    of_top : list of (n,) int64
        Of the blocks `top_blocks` gives.
    """
    top = top_blocks(mesh)
    known = {id(block): piece for block, piece in zip(top, of_top, strict=True)}
    return [
        known[id(block)] if id(block) in known else _around(mesh, block, top, of_top)
        for block in mesh.blocks
    ]


def _around(mesh: Mesh, block: Block, top: list[Block], of_top: list[Array]) -> Array:
    """The first piece with a cell around each cell of a block of lower dimension; 0 without."""
    family = family_of(block.type)
    n_corners = block.cells.shape[1] if family is None else family.n_corners
    rows = block.cells[:, :n_corners]
    used = np.zeros(len(mesh.points), dtype=bool)
    used[rows] = True
    sides: list[Array] = []
    pieces: list[Array] = []
    for own, piece in zip(top, of_top, strict=True):
        for table in _sides(own.type, dimension_of(block.type), n_corners):
            side = np.take(own.cells, table, axis=1)
            here = used[side].all(axis=2)
            cell, local = np.nonzero(here)
            sides.append(side[cell, local])
            pieces.append(piece[cell])
    piece = np.concatenate([np.empty(0, np.int64), *pieces])
    if not len(piece):
        return np.zeros(len(rows), dtype=np.int64)
    order = np.argsort(piece, kind="stable")
    place = places_in(np.concatenate(sides)[order], rows, len(mesh.points))
    return np.where(place < 0, 0, piece[order][place])


def _sides(cell_type: str, dimension: int, n_corners: int) -> list[Array]:
    """Corners of the sides of a cell that have a dimension, in tables of so many columns."""
    family = family_of(cell_type)
    if family is None or dimension < 0:
        return []
    if dimension == 0:
        return [np.arange(family.n_corners)[:, None]]
    if dimension == family.dimension - 1:
        return [table for table in family.facets if table.shape[1] == n_corners]
    return [family.edges] if dimension == 1 else []


def part_of(mesh: Mesh, masks: list[Array], with_unused: bool = False) -> Mesh:
    """Some cells of a mesh with their points, in its order.

    Parameters
    ----------
    masks : list of (n,) bool
        Which cells of each block.
    with_unused : bool
        With the points, too, that no cell of the mesh has.
    """
    kept = np.zeros(len(mesh.points), dtype=bool)
    if with_unused:
        kept[:] = True
        for block in mesh.blocks:
            kept[block.cells] = False
    blocks = []
    for block, mask in zip(mesh.blocks, masks, strict=True):
        data = {name: values[mask] for name, values in block.data.items()}
        blocks.append(replace(block, cells=block.cells[mask], data=data, numbers=None))
        kept[blocks[-1].cells] = True
    number = np.cumsum(kept) - 1
    blocks = [replace(block, cells=number[block.cells]) for block in blocks if len(block.cells)]
    return mesh.with_points(kept, np.where(kept, number, -1), blocks)


def cut(mesh: Mesh, n: int) -> Iterator[Mesh]:
    """A mesh in n pieces, whose points have the array `IDS`; see `pieces_of_cells`."""
    numbered = replace(
        mesh, point_data=mesh.point_data | {IDS: np.arange(len(mesh.points), dtype=np.int64)}
    )
    pieces = pieces_of_cells(numbered, n)
    for i in range(n):
        yield part_of(numbered, [piece == i for piece in pieces], with_unused=i == 0)


def merged(parts: list[Mesh]) -> Mesh:
    """Parts of a mesh as one, whose points are those of the first, then the others by their number.

    All have the array `IDS` and the same other arrays; of a point that several have, the values of
    the first count. Cells of a type stand together, in the order of the parts.
    """
    ids = np.concatenate([part.point_data[IDS] for part in parts])
    first = parts[0].point_data[IDS]
    others = np.setdiff1d(ids, first)
    order = np.concatenate([first, others])
    by_id = np.argsort(order, kind="stable")
    number = by_id[np.searchsorted(order, ids, sorter=by_id)]
    row = np.full(len(order), -1)
    row[number[::-1]] = np.arange(len(ids))[::-1]
    point_data = {
        name: np.concatenate([part.point_data[name] for part in parts])[row]
        for name in parts[0].point_data
    }
    points = np.concatenate([part.points for part in parts])[row]
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    groups: dict[str, list[Block]] = {}
    for part, start in zip(parts, starts, strict=False):
        for block in part.blocks:
            moved = replace(block, cells=number[start + block.cells], numbers=None)
            groups.setdefault(block.type, []).append(moved)
    return replace(parts[0], points=points, point_data=point_data, numbers=None,
                   blocks=[joined(blocks) for blocks in groups.values()])  # fmt: skip


def joined(blocks: list[Block]) -> Block:
    """Blocks of one type, with the same arrays, as one."""
    if len(blocks) == 1:
        return blocks[0]
    data = {n: np.concatenate([block.data[n] for block in blocks]) for n in blocks[0].data}
    return replace(blocks[0], cells=np.concatenate([b.cells for b in blocks]), data=data)


def border_facets(mesh: Mesh) -> dict[int, Array]:
    """Facets of cells of the greatest dimension that bound one cell only, by the count of their
    corners, (n, k) int64, turned outwards."""
    from .facets import CellSet, facets_of

    sets = [
        CellSet(family.name, block.cells[:, : family.n_corners], np.arange(len(block.cells)))
        for block in top_blocks(mesh)
        if (family := family_of(block.type)) is not None
    ]
    found: dict[int, list[Array]] = {}
    for facets in facets_of(sets, len(mesh.points)):
        found.setdefault(facets.rows.shape[1], []).append(facets.rows[facets.alone()])
    return {width: np.concatenate(rows) for width, rows in found.items()}


def border_vertices(mesh: Mesh) -> Array:
    """The vertices of `border_facets`, ascending."""
    rows = [facets.ravel() for facets in border_facets(mesh).values()]
    return distinct(np.concatenate(rows)) if rows else np.empty(0, np.int64)
