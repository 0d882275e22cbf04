"""Meshes of meshio, with their sets."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ...mesh.model import Array, Block, Mesh
from ...mesh.tags import SET
from ..bridge import from_meshio


def fits(given: Any) -> bool:
    """Whether it is one; where nobody has imported meshio, nothing is."""
    meshio = sys.modules.get("meshio")
    return meshio is not None and isinstance(given, meshio.Mesh)


def take(given: Any) -> tuple[Mesh, list[str]]:
    """A mesh: sets become arrays that tell what is in them, names of groups stay."""
    mesh = from_meshio(given)
    blocks = [
        Block(b.type, b.cells, b.data | _of_sets(given.cell_sets, i, len(b.cells)))
        for i, b in enumerate(mesh.blocks)
    ]
    sets = {f"{SET}{n}": _members(rows, len(mesh.points)) for n, rows in given.point_sets.items()}
    names, fields = {}, {}
    for name, values in given.field_data.items():
        tag = np.asarray(values)
        if tag.shape == (2,) and tag.dtype.kind in "iu":
            names[int(tag[1]), int(tag[0])] = str(name)
        else:
            fields[str(name)] = np.atleast_1d(tag)
    dropped = [f"the field {name}" for name, a in fields.items() if a.dtype.kind not in "fiub"]
    fields = {name: a for name, a in fields.items() if a.dtype.kind in "fiub"}
    point_data = mesh.point_data | sets
    return replace(
        mesh, blocks=blocks, point_data=point_data, names=names, fields=fields
    ), dropped + ["which points of periodic sides stand for each other"] * bool(given.gmsh_periodic)


def back(mesh: Mesh, given: Any) -> tuple[Any, list[str]]:
    """A mesh of meshio, with the sets that the given one had."""
    import meshio

    blocks = [block for block in mesh.blocks if len(block.cells)]
    names = dict.fromkeys(n for block in blocks for n in block.data if not n.startswith(SET))
    cell_data = {name: [_data(block, name, blocks) for block in blocks] for name in names}
    cell_sets = {
        name: [_rows(block.data.get(f"{SET}{name}")) for block in blocks]
        for name in given.cell_sets
    }
    point_data = {n: a for n, a in mesh.point_data.items() if not n.startswith(SET)}
    point_sets = {name: _rows(mesh.point_data.get(f"{SET}{name}")) for name in given.point_sets}
    groups = {name: np.array([tag, d]) for (d, tag), name in mesh.names.items()}
    return meshio.Mesh(
        mesh.points, [(block.type, block.cells) for block in blocks], point_data, cell_data,
        field_data={**groups, **mesh.fields}, point_sets=point_sets, cell_sets=cell_sets,
        info=given.info,
    ), []  # fmt: skip


def _of_sets(sets: dict[str, list[Any]], block: int, n: int) -> dict[str, Array]:
    """The arrays of a block, one for each set of cells."""
    return {f"{SET}{name}": _members(rows[block], n) for name, rows in sets.items()}


def _members(rows: Iterable[int] | None, n: int) -> Array:
    """Which of n things are in a set, (n,) int8."""
    found = np.zeros(n, np.int8)
    if rows is not None:
        found[np.asarray(rows, np.int64)] = 1
    return found


def _rows(members: Array | None) -> Array:
    return np.empty(0, np.int64) if members is None else np.flatnonzero(members)


def _data(block: Block, name: str, blocks: list[Block]) -> Array:
    """An array on a block, which has to be on all: 0 or NaN where there was none."""
    if name in block.data:
        return block.data[name]
    like = next(b.data[name] for b in blocks if name in b.data)
    missing = np.nan if like.dtype.kind == "f" else 0
    return np.full((len(block.cells), *like.shape[1:]), missing, like.dtype)
