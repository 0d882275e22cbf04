"""Cells and points taken out of a mesh, or given new numbers, with all that belongs to them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh.model import Array, Block, Mesh
from ..mesh.tags import is_identity, numbered


def rows_of(block: Block, rows: Array) -> Block:
    """Some cells of a block, by a mask or by their rows, with their arrays."""
    data = {name: values[rows] for name, values in block.data.items()}
    return replace(block, cells=block.cells[rows], data=data, numbers=None)


def without_cells(mesh: Mesh, gone: Array) -> Mesh:
    """A mesh without some of its cells.

    Parameters
    ----------
    gone : (n_cells,) bool
        Cells are counted through all blocks.
    """
    ends = np.cumsum([len(block.cells) for block in mesh.blocks])
    blocks = [
        rows_of(block, ~gone[end - len(block.cells) : end]) if len(block.cells) else block
        for block, end in zip(mesh.blocks, ends.tolist(), strict=True)
    ]
    return replace(mesh, blocks=blocks)


def without_points(mesh: Mesh, first: Array, gone: Array) -> Mesh:
    """A mesh in which points are put in the place of others, and some are gone.

    Parameters
    ----------
    first : (np,) int64
        The point that takes the place of each, itself where it stays.
    gone : (np,) bool
        No point that takes the place of another is among these. Vertices of cells that do not
        exist go on not to exist.
    """
    n = len(mesh.points)
    number = np.where(gone, -1, np.cumsum(~gone) - 1)[first]
    n_left = n - int(gone.sum())
    blocks = [replace(block, cells=_renamed(block.cells, number, n_left)) for block in mesh.blocks]
    return mesh.with_points(~gone, number, blocks)


def _renamed(cells: Array, number: Array, n_left: int) -> Array:
    inside = (cells >= 0) & (cells < len(number))
    if inside.all():
        return number[cells] if cells.size else cells
    return np.where(inside, number[np.where(inside, cells, 0)], np.where(cells < 0, -1, n_left))


@dataclass(frozen=True)
class New:
    """A cell to be added.

    Attributes
    ----------
    type : str
    nodes : tuple of int
    block, row : int
        The cell that it has its arrays from, but for numbers of cells: it gets one of its own.
    """

    type: str
    nodes: tuple[int, ...]
    block: int
    row: int


def with_cells(mesh: Mesh, added: list[New]) -> Mesh:
    """A mesh with more cells: each at the end of the block it has its arrays from, or in a block
    after it where its type is another."""
    groups: dict[int, dict[str, list[New]]] = {}
    for cell in added:
        groups.setdefault(cell.block, {}).setdefault(cell.type, []).append(cell)
    taken = _numbers_of_cells(mesh)
    blocks = []
    for number, block in enumerate(mesh.blocks):
        more = groups.get(number, {})
        own = more.pop(block.type, [])
        blocks.append(_joined(block, _part(block, own, taken)) if own else block)
        blocks += [_part(block, cells, taken) for cells in more.values()]
    return replace(mesh, blocks=blocks)


def _part(block: Block, added: list[New], taken: dict[str, list[Array]]) -> Block:
    part = rows_of(block, np.array([cell.row for cell in added]))
    for name in part.data.keys() & taken.keys():
        values = numbered(part.data[name], np.ones(len(added), bool), *taken[name])
        part.data[name] = values
        taken[name].append(values)
    nodes = np.array([cell.nodes for cell in added], np.int64)
    return replace(part, type=added[0].type, cells=nodes)


def _joined(one: Block, other: Block) -> Block:
    data = {name: np.concatenate([one.data[name], other.data[name]]) for name in one.data}
    return replace(one, cells=np.concatenate([one.cells, other.cells]), data=data, numbers=None)


def _numbers_of_cells(mesh: Mesh) -> dict[str, list[Array]]:
    """The arrays that number cells, block by block."""
    found: dict[str, list[Array]] = {}
    for block in mesh.blocks:
        for name, values in block.data.items():
            found.setdefault(name, []).append(values)
    return {
        name: arrays
        for name, arrays in found.items()
        if all(a.ndim == 1 for a in arrays) and is_identity(name, np.concatenate(arrays))
    }
