"""Which cells are in a group that somebody names: by the name of a physical group, or by a tag."""

from __future__ import annotations

import re

import numpy as np

from ..cells import dimension_of
from .model import Array, Mesh
from .tags import GEOMETRICAL, PHYSICAL, TAG_NAMES, is_whole, regions_in

_TAG = re.compile(r"-?[0-9]{1,18}", re.ASCII)
_OF_DIMENSION = re.compile(r"([0-3]):(.+)", re.DOTALL)


def cells_in(mesh: Mesh, name: str, dimension: int) -> list[Array] | None:
    """Which cells of each block are in a group of one dimension, (n,) bool each.

    Parameters
    ----------
    name : str
        Of a physical group of this dimension, or else the number of a region or an entity: a value
        of the first array of tags that the cells have.

    Returns
    -------
    list of Array, optional
        None where no group has this name, and it is no number.
    """
    tags = [tag for (d, tag), named in mesh.names.items() if (d, named) == (dimension, name)]
    arrays: tuple[str, ...] = (PHYSICAL,)
    entities: list[int] = []
    if tags:
        more = mesh.more_groups.items()
        entities = [entity for (d, entity), groups in more
                    if d == dimension and set(groups) & set(tags)]  # fmt: skip
    elif _TAG.fullmatch(name):
        tags = [int(name)]
        arrays = mesh.regions or (*TAG_NAMES, *regions_in(mesh).arrays)
    else:
        return None
    found = []
    for block in mesh.blocks:
        inside = np.zeros(len(block.cells), dtype=bool)
        if dimension_of(block.type) == dimension:
            for array in arrays:
                values = block.data.get(array)
                if values is not None and values.ndim == 1:
                    inside |= np.isin(values, tags)
                    break
            if entities and GEOMETRICAL in block.data:
                inside |= np.isin(block.data[GEOMETRICAL], entities)
        found.append(inside)
    return found


def cells_named(mesh: Mesh, name: str) -> list[Array] | None:
    """Which cells of each block are in a group of any dimension, (n,) bool each.

    Parameters
    ----------
    name : str
        Of physical groups, of each dimension that has it; or else a number, as `cells_in` takes it,
        of the greatest dimension that has it; or either after a dimension, as in "2:7" or "2:wall".

    Returns
    -------
    list of Array, optional
        None where no cell is in such a group.
    """
    named = [d for (d, _), known in mesh.names.items() if known == name]
    if named:
        return _all_of(mesh, name, named)
    of_one = _OF_DIMENSION.fullmatch(name)
    if of_one is not None:
        return _all_of(mesh, of_one[2], [int(of_one[1])])
    for dimension in (3, 2, 1, 0):
        found = _all_of(mesh, name, [dimension])
        if found is not None:
            return found
    return None


def _all_of(mesh: Mesh, name: str, dimensions: list[int]) -> list[Array] | None:
    found = [cells for d in dimensions if (cells := cells_in(mesh, name, d)) is not None]
    if not found:
        return None
    inside = [np.logical_or.reduce(masks) for masks in zip(*found, strict=True)]
    return inside if any(mask.any() for mask in inside) else None


def names_of_groups(mesh: Mesh) -> list[str]:
    """The names of all physical groups; without any, the tags of regions and entities."""
    if mesh.names:
        return list(dict.fromkeys(mesh.names.values()))
    arrays = mesh.regions or (*TAG_NAMES, *regions_in(mesh).arrays)
    tags: set[int] = set()
    for block in mesh.blocks:
        for array in arrays:
            values = block.data.get(array)
            if values is not None and is_whole(values):
                tags |= set(np.unique(values).astype(np.int64).tolist())
                break
    return [str(tag) for tag in sorted(tags)]
