"""Names of the arrays that mean something, and which of them make regions of the cells."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from ..errors import ConfigError
from . import adjacency
from .model import Array, Block, Mesh, top_blocks

# Arrays that tell cells of one region from those of another, whatever their values.
PHYSICAL, GEOMETRICAL, REF = TAG_NAMES = ("gmsh:physical", "gmsh:geometrical", "medit:ref")
# Dimension and tag of the entity that Gmsh has a node on.
DIM_TAGS = "gmsh:dim_tags"
# Where a node lies on its curve or surface in Gmsh.
PARAMETRIC = "gmsh:parametric"
# The part of the mesh, as made for parallel computing, that Gmsh has a cell in: no region.
PARTITION = "gmsh:partition"
# Medit's flags of vertices and of cells: what is required must stay.
CORNER, REQUIRED, RIDGE = FLAGS = ("medit:corner", "medit:required", "medit:ridge")
# Whole numbers of cells that tell no regions apart, unless they are asked to: in small
# letters only, what VTK and ParaView call parts, the processes that have them, and ghosts.
_PARTS = {"vtkghosttype", "vtkghostlevels", "vtkprocessid", "processid", "processids"}
_PARTS |= {"partitionid", "partitionids", "vtkpartitionid", "vtkpartitionids"}
# What this program says of cells begins so, and makes no regions of them.
OWN = "meshopt:"
METRIC = f"{OWN}metric"  # on points, while a metric drives the work
# By them a user tells vertices where to stay: at all, along a line, in a plane, and in a
# half-space; a vector of zeros says nothing.
HELD = f"{OWN}fixed"
ALONG, WITHIN, LIMIT = TOLD = (f"{OWN}along", f"{OWN}within", f"{OWN}limit")
# Members of the sets that a mesh in memory has of its cells and points.
SET = "set:"
# Flags of vertices that stay.
STAY = (CORNER, REQUIRED, HELD)
# Vectors at some of the vertices.
NORMAL, TANGENT = "medit:normal", "medit:tangent"
# Any other array of whole numbers does so when it has few values.
MAX_LABELS = 64
# What tells one cell, or point, from all others is a number of it, and no label: by such a name, or
# where there are more rows than these, however few its values are.
_NUMBER = re.compile(r"(^|[^a-z])(ids?|index|indices|number|numbers)$|I[Dd]s?$", re.ASCII)
MOST_ALONE = 8


@dataclass(frozen=True)
class Regions:
    """What makes regions of the cells of a mesh: names of arrays, and how many they make."""

    arrays: tuple[str, ...]
    count: int


def is_whole(values: Array) -> bool:
    """Whether an array holds one whole number a row, as an integer or as a real."""
    if values.ndim != 1 or values.dtype.kind not in "iuf":
        return False
    if values.dtype.kind != "f":
        return True
    some = values[: 1 << 10]  # most reals are not whole, and soon seen not to be
    return _are_whole(some) and (len(some) == len(values) or _are_whole(values))


def _are_whole(reals: Array) -> bool:
    return bool(np.all((np.rint(reals) == reals) & (np.abs(reals) < 2.0**53)))


def is_number(name: str, values: Array) -> bool:
    """Whether an array, (n,), numbers cells or points: each has a whole number of its own."""
    if not is_whole(values) or len(adjacency.distinct(values)) < len(values):
        return False
    return len(values) > MOST_ALONE or is_called_number(name)


def is_called_number(name: str) -> bool:
    """Whether an array has such a name as those have that number cells or points."""
    return bool(_NUMBER.search(name))


def is_identity(name: str, values: Array) -> bool:
    """Whether the values of an array are numbers that nothing else may have; reals have to be
    called so, as most that are whole are not meant to be."""
    return (values.dtype.kind in "iu" or is_called_number(name)) and is_number(name, values)


def numbered(values: Array, is_new: Array, *taken: Array) -> Array:
    """Numbers, of which the new ones follow the greatest of those that are taken."""
    first = max(int(numbers.max()) for numbers in taken if len(numbers)) + 1
    n = np.count_nonzero(is_new)
    if values.dtype.kind in "iu" and first + n > np.iinfo(values.dtype).max:
        values = values.astype(np.int64)
    values[is_new] = np.arange(first, first + n)
    return values


def raised(values: Array, above: int, by: int) -> Array:
    """Numbers, of which those above another are so much greater."""
    if values.dtype.kind in "iu" and int(values.max(initial=0)) + by > np.iinfo(values.dtype).max:
        values = values.astype(np.int64)
    return np.where(values > above, values + by, values).astype(values.dtype)


def is_tag(name: str, arrays: list[Array]) -> bool:
    """Whether an array, given block by block, tells regions of the cells apart."""
    if _tells_nothing(name) or not all(is_whole(a) for a in arrays):
        return False
    return name in TAG_NAMES or (
        _n_values(arrays) <= MAX_LABELS and not is_number(name, np.concatenate(arrays))
    )


def _tells_nothing(name: str) -> bool:
    """Whether arrays of a name are no regions, whatever their values."""
    plain = re.sub("[^a-z]", "", name.lower())
    return name in FLAGS or name == PARTITION or plain in _PARTS or name.startswith(OWN)


def _n_values(arrays: list[Array]) -> int:
    return len(adjacency.distinct(np.concatenate(arrays)))


def labels(blocks: list[Block]) -> dict[str, Array | None]:
    """The distinct values of the arrays that may tell regions, on all of some blocks of a piece of
    a mesh; None for those that have too many, unless their name alone says that they do."""
    found: dict[str, Array | None] = {}
    for name, arrays in _on_all(blocks).items():
        if not _tells_nothing(name) and all(is_whole(a) for a in arrays):
            values = adjacency.distinct(np.concatenate(arrays)).astype(np.int64)
            found[name] = values if len(values) <= MAX_LABELS or name in TAG_NAMES else None
    return found


def tags_among(of_pieces: list[dict[str, Array | None]], n_cells: int) -> tuple[str, ...]:
    """The arrays that make regions of a mesh in pieces, as `is_tag` has it.

    Parameters
    ----------
    of_pieces : list of dict
        What `labels` gives for each piece.
    n_cells : int
        Of all pieces.
    """
    names = [n for n in of_pieces[0] if all(n in one for one in of_pieces)]
    found = []
    for name in names:
        values = [one[name] for one in of_pieces]
        several = [one for one in values if one is not None]
        n = len(adjacency.distinct(np.concatenate(several))) if several else 0
        few = len(several) == len(values) and n <= MAX_LABELS
        if name in TAG_NAMES or (few and n < max(n_cells, MOST_ALONE + 1)):
            found.append(name)
    return tuple(found)


def tags_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> dict[str, Array]:
    """The tags that make regions of the cells of some blocks, each (ne, ...), by name.

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
        A name is that of no array of numbers on all cells of the greatest dimension.
    """
    arrays = _on_all(top_blocks(mesh))
    fit = [
        n for n, values in arrays.items() if len({(a.shape[1:], a.dtype.kind) for a in values}) == 1
    ]
    fit = [n for n in fit if arrays[n][0].dtype.kind in "iuf"]
    for name in names:
        if name not in fit:
            known = f"choose from {', '.join(fit)}" if fit else "the mesh has none"
            raise ConfigError(f"no array {name!r} of numbers on all cells: {known}")
    return replace(mesh, regions=names)


def regions_in(mesh: Mesh) -> Regions:
    """What makes regions of the cells of the greatest dimension."""
    blocks = top_blocks(mesh)
    tags = tags_of(blocks, mesh.regions)
    return Regions(tuple(tags), int(combinations(tags).max(initial=-1)) + 1 if tags else 1)


def doubtful_tags(mesh: Mesh) -> dict[str, int]:
    """Arrays that may be meant to make regions, but have too many values: how many, by name.

    They hold whole numbers that several cells have in common, four of them or more on average.
    """
    if mesh.regions is not None:
        return {}
    found = {}
    for name, arrays in _on_all(top_blocks(mesh)).items():
        is_plain = not _tells_nothing(name) and name not in TAG_NAMES
        if is_plain and all(is_whole(a) for a in arrays):
            n_values = _n_values(arrays)
            if MAX_LABELS < n_values <= sum(map(len, arrays)) / 4:
                found[name] = n_values
    return found


def regions_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> Array:
    """Region of each cell, (ne,) int64: a combination of tags, numbered from 0 in order.

    Blocks whose cells have the same tags make one region: a file may cut one region into
    several blocks.
    """
    tags = tags_of(blocks, regions)
    return combinations(tags) if tags else np.zeros(sum(len(b.cells) for b in blocks), np.int64)


def combinations(tags: dict[str, Array]) -> Array:
    """A number for each combination of the values of some arrays, one at least, (ne, ...) each."""
    columns = [c for values in tags.values() for c in values.reshape(len(values), -1).T]
    whole = [c.astype(np.int64) if is_whole(c) else _ranks(c) for c in columns]
    _, number, _ = adjacency.distinct_rows(np.stack(whole, axis=1))
    return number


def _ranks(reals: Array) -> Array:
    """Numbers in the order of reals, the same for the same ones."""
    _, rank = np.unique(reals, return_inverse=True)
    return rank


def flagged(values: Array) -> Array:
    """Where an array, (n,) of numbers, is set."""
    return np.nan_to_num(values) != 0
