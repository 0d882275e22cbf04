"""What each family of formats can hold of a `Mesh`, and how it calls it.

Each function makes a mesh fit for one family, tags carried over, and lists what had to be
left out. The mesh it is given stays as it is; its arrays are as `read` leaves them. What
tells groups of cells apart goes by `GROUPS`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from urllib.parse import quote

import numpy as np

from ..cells import SIMPLICES, dimension_of
from ..mesh.adjacency import distinct
from ..mesh.model import Array, Block, Mesh, main_blocks
from ..mesh.plane import with_depth
from ..mesh.tags import (
    DIM_TAGS,
    GEOMETRICAL,
    PARAMETRIC,
    PARTITION,
    PHYSICAL,
    REF,
    REQUIRED,
    is_whole,
    tags_of,
)
from .sniff import Encoding

# The group of a cell, where a format has one: the first of these arrays that is there, and
# without any the first other array that makes regions. VTK holds all of them as arrays.
GROUPS = {
    "gmsh": (PHYSICAL, REF),
    "medit": (REF, PHYSICAL, GEOMETRICAL),
}

# What only Gmsh has of its nodes.
OF_NODES = (DIM_TAGS, PARAMETRIC)

_PRINTABLE = "".join(map(chr, range(33, 127))).translate({ord('"'): None, ord("%"): None})


def for_gmsh(mesh: Mesh, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Fit a mesh for Gmsh: a reference becomes a physical group and an entity.

    The arrays and lists of vertices and cells that Medit has become views.
    """
    from .gmsh import model, types

    new = encoding.format == "gmsh"
    dropped = _fields(mesh) + ([] if new else _of_nodes(mesh))
    label = _label(mesh)
    held = _held(mesh.blocks, types.has_code, dropped)
    tags_of_blocks: list[dict[str, Array]] = []
    for block in held:
        tags: dict[str, Array | None]
        tags = {name: _tags(block.data.get(name)) for name in (PHYSICAL, GEOMETRICAL)}
        asked = _tags(block.data.get(mesh.regions[0])) if mesh.regions else None
        if asked is not None:
            dropped += [PHYSICAL] * (tags[PHYSICAL] is not None and mesh.regions != (PHYSICAL,))
            tags[PHYSICAL] = asked
        elif all(values is None for values in tags.values()):
            tags = {PHYSICAL: _tags(block.data.get(REF, block.data.get(label)))}
        tags_of_blocks.append({n: values for n, values in tags.items() if values is not None})
    # references that are the groups everywhere need no view
    same = all(
        np.array_equal(found.get(PHYSICAL, ()), block.data[REF])
        for block, found in zip(held, tags_of_blocks, strict=True)
        if REF in block.data
    )
    blocks = []
    for block, found in zip(held, tags_of_blocks, strict=True):
        data = _views(block.data, (PHYSICAL, GEOMETRICAL, REF)[: 2 + same], dropped) | found
        _whole_partition(data, dropped)
        blocks.append(Block(block.type, block.cells, data, block.entities if new else None))
    _number_entities(blocks)
    if new:
        blocks, renumbered = model.by_entity(blocks)
        dropped += ["the tags of entities in several groups"] * renumbered
    idle = [name for name in (REF,) if not np.any(mesh.point_data.get(name, 0))]
    point_data = _views(mesh.point_data, (*OF_NODES, *idle), dropped)
    if new and DIM_TAGS in mesh.point_data:
        point_data |= {n: mesh.point_data[n] for n in OF_NODES if n in mesh.point_data}
    names = {group: name.replace('"', "'") for group, name in mesh.names.items()}
    fitted = Mesh(_in_space(mesh.points), blocks, point_data, names, mesh.more_groups)
    return replace(fitted, periodic=mesh.periodic, views=mesh.views), dropped


def _whole_partition(data: dict[str, Array], dropped: list[str]) -> None:
    """Make the partitions of cells integers, or drop them where they are none."""
    if PARTITION in data:
        whole = _tags(np.nan_to_num(data.pop(PARTITION)))
        if whole is None:
            dropped.append(PARTITION)
        else:
            data[PARTITION] = whole


def _number_entities(blocks: list[Block]) -> None:
    """Give an entity to the cells that have none: the number of their group, if positive."""
    for dimension in range(4):
        alike = [block for block in blocks if dimension_of(block.type) == dimension]
        bare = [block for block in alike if GEOMETRICAL not in block.data]
        groups = [b.data.get(PHYSICAL, np.zeros(len(b.cells), np.int64)) for b in bare]
        top = max((int(group.max()) for group in groups if len(group)), default=0)
        for block, group in zip(bare, groups, strict=True):
            if dimension == 0 and PHYSICAL not in block.data:  # one entity a vertex
                block.data[GEOMETRICAL] = np.arange(1, len(group) + 1)
            else:
                block.data[GEOMETRICAL] = np.where(group > 0, group, max(top, 0) + 1 - group)


def for_medit(mesh: Mesh, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Fit a mesh for Medit: its reference is the physical group, else the entity.

    The entity stands for the group where no cell of that dimension is in a group. A cell that
    is a vertex becomes the reference of the vertex, which is then required.
    """
    from . import medit, medit_lists

    dropped = _names(mesh) + _model(mesh) + _of_nodes(mesh) + _fields(mesh)
    point_data = {n: values for n, values in mesh.point_data.items() if n in medit_lists.ARRAYS}
    refs = _tags(mesh.point_data.get(REF))
    known = medit.CODES
    if refs is None or not refs.any():
        known = {"vertex": 0, **known}
    held = _held(mesh.blocks, known.__contains__, dropped)
    label = _label(mesh)
    blocks = []
    for block in held:
        alike = [b.data for b in held if dimension_of(b.type) == dimension_of(block.type)]
        grouped = any(PHYSICAL in data and data[PHYSICAL].any() for data in alike)
        names = [*(mesh.regions or ()), *GROUPS["medit"], label]
        names = [name for name in names if grouped or name != PHYSICAL]
        fit = [n for n in names if any(_tags(data.get(n)) is not None for data in alike)]
        key = next(iter(fit), REF)
        values = _tags(block.data.get(key))
        lists = medit_lists.pick(block.data)
        kept = (*lists, *[key] * (values is not None))
        dropped += [n for n in block.data if n not in kept and (grouped or n != PHYSICAL)]
        data = lists if values is None else {REF: values, **lists}
        if block.type != "vertex":
            blocks.append(Block(block.type, block.cells, data))
        elif len(block.cells):
            refs = np.zeros(len(mesh.points), np.int64) if refs is None else refs.copy()
            refs[block.cells[:, 0]] = 0 if values is None else values
            if len(distinct(block.cells)) < len(mesh.points):  # of all, it would say nothing
                flags = np.array(point_data.get(REQUIRED, np.zeros(len(mesh.points))), np.uint8)
                flags[block.cells[:, 0]] = 1
                point_data[REQUIRED] = flags
    dropped += [n for n in mesh.point_data if n not in (REF, *OF_NODES, *point_data)]
    return Mesh(
        mesh.points, blocks, point_data if refs is None else {REF: refs, **point_data}
    ), dropped


def for_vtk(mesh: Mesh, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Fit a mesh for VTK: arrays run over all cells, 0 or NaN where there was none."""
    from .vtk.cells import NUMBERS

    def spelled(names: Iterable[str]) -> dict[str, str]:
        """Names without what XML cannot hold, or as VTK does without XML: no blanks."""
        new: dict[str, str] = {}
        for name in names:
            kept = "".join(letter if letter.isprintable() else "_" for letter in name) or "_"
            kept = quote(kept, safe=_PRINTABLE) if encoding.format == "vtk" else kept
            while kept in new.values():
                kept += "_"
            new[name] = kept
        return new

    dropped = _names(mesh) + _model(mesh) + _of_nodes(mesh)
    held = [b for b in _held(mesh.blocks, NUMBERS.__contains__, dropped) if len(b.cells)]
    blocks = [Block(block.type, block.cells) for block in held]
    for name, kept in spelled(dict.fromkeys(name for b in held for name in b.data)).items():
        some = [block.data[name] for block in held if name in block.data]
        if len({array.shape[1:] for array in some}) != 1:
            dropped.append(name)
            continue
        kind, shape = np.result_type(*some), some[0].shape[1:]
        missing = np.full((1, *shape), np.nan if kind.kind == "f" else 0)
        for block, old in zip(blocks, held, strict=True):
            array = old.data.get(name, np.repeat(missing, len(block.cells), axis=0))
            block.data[kept] = array.astype(kind)
    names = spelled(name for name in mesh.point_data if name not in OF_NODES)
    point_data = {kept: mesh.point_data[name] for name, kept in names.items()}
    fields = {kept: mesh.fields[name] for name, kept in spelled(mesh.fields).items()}
    return Mesh(_in_space(mesh.points), blocks, point_data, fields=fields), dropped


def _in_space(points: Array) -> Array:
    """Give points in the plane a third coordinate, 0."""
    return with_depth(points).astype(points.dtype)


def _label(mesh: Mesh) -> str:
    """The array that makes regions of a mesh without groups; "" if there is none."""
    for cell_type in reversed(SIMPLICES[2:]):
        if blocks := main_blocks(mesh, cell_type):
            return next(iter(tags_of(blocks, mesh.regions)), "")
    return ""


def _fields(mesh: Mesh) -> list[str]:
    """The arrays of the mesh as a whole, which only VTK can hold."""
    return [f"the field {name}" for name in mesh.fields]


def _names(mesh: Mesh) -> list[str]:
    """The physical names, which only Gmsh can hold, with the tags that stay."""
    said = ", ".join(dict.fromkeys(f"{name} = {tag}" for (_, tag), name in mesh.names.items()))
    return [f"the physical names {said}"] * bool(said)


def _model(mesh: Mesh) -> list[str]:
    """What else of a mesh only Gmsh can hold."""
    several = ["all but the first physical group of an entity"] * bool(mesh.more_groups)
    pairs = ["which points of periodic sides stand for each other"] * bool(mesh.periodic)
    timed = [name for name, view in mesh.views.items() if view.time]
    times = [f"the times of {', '.join(timed)}"] * bool(timed)
    return several + pairs + times


def _of_nodes(mesh: Mesh) -> list[str]:
    """What of a mesh only Gmsh's version 4.1 can hold."""
    here = DIM_TAGS in mesh.point_data or any(b.entities is not None for b in mesh.blocks)
    parameters = ["the parameters of nodes"] * (PARAMETRIC in mesh.point_data)
    return ["the entities of nodes and their bounds"] * here + parameters


def _held(blocks: list[Block], is_known: Callable[[str], bool], dropped: list[str]) -> list[Block]:
    """Keep the blocks of known types.

    Raises
    ------
    ValueError
        One of the others has the highest dimension: without it there is no mesh.
    """
    top = max((dimension_of(block.type) for block in blocks if len(block.cells)), default=0)
    for block in blocks:
        if not is_known(block.type) and len(block.cells):
            if dimension_of(block.type) == top:
                raise ValueError(
                    f"the format has no cells of type {block.type}: Gmsh's and VTK's have"
                )
            dropped.append(f"the cells of type {block.type}")
    return [block for block in blocks if is_known(block.type)]


def _tags(values: Array | None) -> Array | None:
    """Take an array for tags if it holds whole numbers, one a row."""
    return values.astype(np.int64) if values is not None and is_whole(values) else None


def _views(data: dict[str, Array], but: tuple[str, ...], dropped: list[str]) -> dict[str, Array]:
    """Keep the arrays that Gmsh can hold as views."""
    from .gmsh.views import VIEW_WIDTHS

    others = {name: values for name, values in data.items() if name not in but}
    fit = [n for n, values in others.items() if int(np.prod(values.shape[1:])) in VIEW_WIDTHS]
    dropped += [name for name in others if name not in fit]
    return {name: others[name] for name in fit}
