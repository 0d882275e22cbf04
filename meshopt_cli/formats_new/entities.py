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

from ..mesh import Array, Block, dimension_of

PHYSICAL = "gmsh:physical"
GEOMETRICAL = "gmsh:geometrical"
DIM_TAGS = "gmsh:dim_tags"


def by_entity(blocks: list[Block]) -> list[Block]:
    """Cut blocks up so that each lies on one entity, which has one physical group.

    Parts of an entity in different groups, all but the first, get new entities. In each
    of the new blocks, "gmsh:geometrical" and "gmsh:physical" are the same for all cells.
    """
    keys_of, top = [], [0, 0, 0, 0]
    for block in blocks:
        zeros = np.zeros(len(block.cells), np.int64)
        keys_of.append(
            np.column_stack([block.data.get(name, zeros) for name in (GEOMETRICAL, PHYSICAL)])
        )
        dimension = dimension_of(block.type)
        top[dimension] = max([top[dimension], *keys_of[-1][:1, 0], *keys_of[-1][:, 0]])
    group_of: dict[tuple[int, int], int] = {}
    new: dict[tuple[int, int, int], int] = {}
    parts = []
    for block, keys in zip(blocks, keys_of, strict=True):
        dimension = dimension_of(block.type)
        for (tag, group), here in _alike(keys):
            own = tag
            if group_of.setdefault((dimension, tag), group) != group:
                if (dimension, tag, group) not in new:
                    top[dimension] += 1
                    new[dimension, tag, group] = top[dimension]
                own = new[dimension, tag, group]
            data = {name: values[here] for name, values in block.data.items()}
            data |= {GEOMETRICAL: np.full(len(here), own), PHYSICAL: np.full(len(here), group)}
            parts.append(Block(block.type, block.cells[here], data, block.entities))
    return parts
