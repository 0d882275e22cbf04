"""Names of the arrays that mean something, and which of them make regions of the cells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import ConfigError
from . import adjacency
from .model import Array, Block, Mesh, top_blocks

# Integer arrays that tell cells of one region from those of another, whatever their values.
PHYSICAL, GEOMETRICAL, REF = TAG_NAMES = ("gmsh:physical", "gmsh:geometrical", "medit:ref")
# Dimension and tag of the entity that Gmsh has a node on.
DIM_TAGS = "gmsh:dim_tags"
# Medit's flags of vertices and of cells: what is required must stay.
CORNER, REQUIRED, RIDGE = FLAGS = ("medit:corner", "medit:required", "medit:ridge")
# Vectors at some of the vertices.
NORMAL, TANGENT = "medit:normal", "medit:tangent"
# Any other integer array does so when it has few values: otherwise it numbers the cells.
MAX_LABELS = 64


def is_whole(values: Array) -> bool:
    """Whether an array holds one whole number a row."""
    return values.ndim == 1 and values.dtype.kind in "iu"


def is_tag(name: str, arrays: list[Array]) -> bool:
    """Whether an array, given block by block, tells regions of the cells apart."""
    if name in FLAGS or not all(is_whole(a) for a in arrays):
        return False
    return name in TAG_NAMES or len(adjacency.distinct(np.concatenate(arrays))) <= MAX_LABELS


def tags_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> dict[str, Array]:
    """The tags that make regions of the cells of some blocks, each (ne,), by name.

    They are on all of the blocks.

    Parameters
    ----------
    regions : tuple of str, optional
        Only these arrays; see `Mesh.regions`.
    """
    arrays = _on_all(blocks)
    if regions is not None:
        return {n: np.concatenate(a) for n, a in arrays.items() if n in regions}
    return {n: np.concatenate(a) for n, a in arrays.items() if is_tag(n, a)}


def _on_all(blocks: list[Block]) -> dict[str, list[Array]]:
    """The arrays that all of some blocks have, block by block."""
    names = [n for n in blocks[0].data if all(n in b.data for b in blocks)] if blocks else []
    return {n: [b.data[n] for b in blocks] for n in names}


def with_regions(mesh: Mesh, names: tuple[str, ...]) -> Mesh:
    """The mesh, in which these arrays make regions, and no others.

    Raises
    ------
    ConfigError
        A name is that of no array of whole numbers, one a cell, on all cells of the greatest
        dimension.
    """
    arrays = _on_all(top_blocks(mesh))
    fit = [n for n, values in arrays.items() if all(is_whole(a) for a in values)]
    for name in names:
        if name not in fit:
            known = f"choose from {', '.join(fit)}" if fit else "the mesh has none"
            raise ConfigError(f"no array {name!r} of whole numbers on all cells: {known}")
    return replace(mesh, regions=names)


def regions_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> Array:
    """Region of each cell, (ne,) int64: a combination of tags, numbered from 0 in order.

    Blocks whose cells have the same tags make one region: a file may cut one region into
    several blocks.
    """
    tags = tags_of(blocks, regions)
    return combinations(tags) if tags else np.zeros(sum(len(b.cells) for b in blocks), np.int64)


def combinations(tags: dict[str, Array]) -> Array:
    """A number for each combination of the values of some arrays, one at least, (ne,) each."""
    rows = np.stack([values.astype(np.int64) for values in tags.values()], axis=1)
    _, number, _ = adjacency.distinct_rows(rows)
    return number


def flagged(values: Array) -> Array:
    """Where an array, (n,) of numbers, is set."""
    return np.nan_to_num(values) != 0
