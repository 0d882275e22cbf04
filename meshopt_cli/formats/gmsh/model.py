"""The entities of Gmsh's version 4.1: every cell and every node lies on one.

An entity is a dimension and a tag. It may be in a physical group, and have others of the
dimension below as bounds. meshio's writer leaves out those without nodes of their own, and
their groups with them; it puts those without a group into a group 0, and refuses one with
cells of two types. So they are written here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from ...cells import dimension_of
from ...mesh.model import Array, Block, Mesh
from ...mesh.tags import GEOMETRICAL, PHYSICAL
from .sink import Sink


def by_entity(blocks: list[Block]) -> tuple[list[Block], bool]:
    """Cut blocks up so that each lies on one entity, which has one physical group.

    Parts of an entity in different groups, all but the first, get new entities. In each
    of the new blocks, "gmsh:geometrical" and "gmsh:physical" are the same for all cells.

    Returns
    -------
    blocks : list of Block
    renumbered : bool
        Whether there are new entities.
    """
    blocks = [block for block in blocks if len(block.cells)]
    top = [0, 0, 0, 0]
    for block in blocks:
        dimension = dimension_of(block.type)
        top[dimension] = max(top[dimension], int(block.data[GEOMETRICAL].max()))
    group_of: dict[tuple[int, int], int] = {}
    homes: dict[tuple[int, int, int], int] = {}
    parts, renumbered = [], False
    for block in blocks:
        dimension, zeros = dimension_of(block.type), np.zeros(len(block.cells), np.int64)
        keys = np.column_stack([block.data[GEOMETRICAL], block.data.get(PHYSICAL, zeros)])
        for (tag, group), here in _alike(keys):
            if (dimension, tag, group) not in homes:
                fits = group_of.setdefault((dimension, tag), group) == group
                top[dimension] += not fits
                renumbered |= not fits
                homes[dimension, tag, group] = tag if fits else top[dimension]
            rows = slice(None) if len(here) == len(block.cells) else here
            data = {name: values[rows] for name, values in block.data.items()}
            data[GEOMETRICAL] = np.full(len(here), homes[dimension, tag, group])
            data[PHYSICAL] = np.full(len(here), group)
            parts.append(Block(block.type, block.cells[rows], data, block.entities))
    return parts, renumbered


def classify(n: int, blocks: list[Block]) -> Array:
    """Find the entity of each of n nodes: the one of lowest dimension whose cells use it.

    A node that no cell uses goes with the highest entity.

    Returns
    -------
    (n, 2) int64
        Dimension and tag.
    """
    # of equal dimensions, the first block has the last word
    downwards = sorted(reversed(blocks), key=lambda block: -dimension_of(block.type))
    dim_tags = np.tile(np.array(_key(downwards[0]) if blocks else (3, 1)), (n, 1))
    for block in downwards:
        dim_tags[_used(block, n)] = _key(block)
    return dim_tags


def write(f: BinaryIO, sink: Sink, mesh: Mesh, dim_tags: Array) -> None:
    """Write every entity that has nodes or cells, bounds one that has, or is linked to another.

    The blocks are as `by_entity` makes them; the points have three coordinates, and dimension
    and tag of their entity in the (np, 2) dim_tags.
    """
    points = mesh.points
    nodes = {key: [own] for key, own in _alike(dim_tags)}
    groups: dict[tuple[int, int], list[int]] = {}
    bounds: dict[tuple[int, int], Array] = {}
    for block in mesh.blocks:
        dimension, _ = key = _key(block)
        nodes.setdefault(key, []).append(_used(block, len(points)))
        groups[key] = [int(group) for group in block.data[PHYSICAL][:1] if group]
        if block.entities is not None:
            bounds[key] = block.entities
            for tag in np.abs(block.entities).tolist():
                nodes.setdefault((dimension - 1, tag), [])
    for link in mesh.periodic:  # Gmsh cannot read on after one that it does not know
        for tag, side in zip((link.tag, link.master), link.pairs.T, strict=True):
            nodes.setdefault((link.dimension, tag), []).append(side)

    f.write(b"$Entities\n")
    sink.put(("u8", np.bincount([dimension for dimension, _ in nodes], minlength=4)))
    for key in sorted(nodes):
        dimension, tag = key
        x = points[np.concatenate([np.empty(0, np.int64), *nodes[key]])]
        x = x if len(x) else np.zeros((1, 3))
        box = np.concatenate([np.fmin.reduce(x), np.fmax.reduce(x)])[: 6 if dimension else 3]
        group = [*groups.get(key, []), *mesh.more_groups.get(key, ())]
        bound = bounds.get(key, np.empty(0, int))
        ends: list[tuple[str, ArrayLike]]
        ends = [("u8", len(bound)), ("i4", bound)] if dimension else []
        sink.put(("i4", tag), ("f8", box), ("u8", len(group)), ("i4", group), *ends)
    sink.end("Entities")


def _key(block: Block) -> tuple[int, int]:
    return dimension_of(block.type), int(block.data[GEOMETRICAL][0])


def _used(block: Block, n: int) -> Array:
    """Points that the cells of a block use, but numbers out of range."""
    used = np.zeros(n, bool)
    used[block.cells[(block.cells >= 0) & (block.cells < n)]] = True
    return np.flatnonzero(used)


def _alike(keys: Array) -> Iterator[tuple[tuple[int, int], Array]]:
    """Go through the distinct rows of two columns, in order, and where each of them is."""
    if len(keys) and (keys == keys[0]).all():  # as most blocks are
        yield (int(keys[0, 0]), int(keys[0, 1])), np.arange(len(keys))
        return
    order = np.lexsort((keys[:, 1], keys[:, 0]))
    ordered = keys[order]
    cuts = np.flatnonzero((ordered[1:] != ordered[:-1]).any(axis=1)) + 1
    for here in np.split(order, cuts) if len(keys) else ():
        yield (int(keys[here[0], 0]), int(keys[here[0], 1])), here
