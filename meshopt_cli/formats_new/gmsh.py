"""Gmsh's MSH 4.1 and 2.2, text and binary, section by section.

meshio reads and writes header, names, entities and nodes, the elements of version 2.2,
and those of version 4.1 as far as writing goes. Sections of our own, and why:

- elements of 4.1 are read here, since meshio discards their numbers, by which views go,
  refuses physical groups on part of the entities, and fails on the node 0 or one beyond
  the last (in 2.2, its inner function leaves node numbers alone);
- views are read and written here, since meshio takes them for lists of all elements in
  order, and does not write their numbers as numbers in text;
- entities of 4.1 are written here, since meshio leaves out those without nodes of their
  own, with their groups, puts the others into a group 0 where they have none, and
  refuses those with cells of two types (see `entities`).
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..mesh import Array, Block, Mesh
from . import entities
from .bridge import complete_cells, listening
from .entities import DIM_TAGS, GEOMETRICAL, PHYSICAL
from .sniff import Encoding, UnreadableError, gmsh_header

log = logging.getLogger("meshopt")

VIEW_WIDTHS = (1, 3, 9)  # components of a value in a view
_TAGS = (PHYSICAL, GEOMETRICAL)
_SECTION = re.compile(rb"^\$(\w+)[ \t]*\r?\n", re.MULTILINE)


def cell_types() -> dict[str, int]:
    """Gmsh's number of each type of element, by its name in a Block."""
    from meshio.gmsh.common import _meshio_to_gmsh_type

    return _meshio_to_gmsh_type


@dataclass
class _Run:
    """Elements that stand together: their numbers, those of their nodes, and tags.

    `tags` has the columns of `_TAGS`; without groups in the file there is only the second.
    """

    type: str
    numbers: Array
    nodes: Array
    tags: Array
    bounds: Array | None = None


def read(path: Path, data: bytes, encoding: Encoding) -> Mesh:
    """Read a mesh.

    Returns
    -------
    Mesh
        Points are in the order of their numbers in the file. An element that names a node
        which is not there has a number out of range in its place. Views become arrays
        under their names; where they have no value there is a NaN.
    """
    from meshio.gmsh import _gmsh22, _gmsh41
    from meshio.gmsh.common import _gmsh_to_meshio_order

    text, old = not encoding.binary, encoding.format == "gmsh22"
    names: dict[str, tuple[int, int]] = {}
    groups, bounds = [], []  # of the entities of each dimension, by tag
    nodes, runs, views, dropped = None, None, [], []
    with path.open("rb") as f, listening(logging.WARNING):
        for section, start, end in _sections(data):
            f.seek(start)
            if section == "MeshFormat":
                _, _, size = gmsh_header(data[start:end])
            elif section == "PhysicalNames":
                names = _read_names(f)
            elif section == "Entities":
                groups, bounds = _gmsh41._read_entities(f, text, size)
            elif section == "Nodes" and old:
                nodes = (*_gmsh22._read_nodes(f, text), None)
            elif section == "Nodes":
                points, tags, dim_tags = _gmsh41._read_nodes(f, text, size)
                nodes = (points, tags + 1, dim_tags)
            elif section == "Elements" and old:
                runs = _read_elements_22(f, text, data[start:end])
            elif section == "Elements":
                runs = _read_elements_41(f, text, size, groups, bounds)
            elif section in ("NodeData", "ElementData"):
                views.append((section, *_read_view(f, text)))
            elif section != "Comments":
                dropped.append(section)
    if nodes is None or runs is None:
        missing = "Nodes" if nodes is None else "Elements"
        raise UnreadableError(f"there is no section ${missing} in it")
    if dropped:
        log.warning("the sections %s of the Gmsh file are dropped", ", ".join(dropped))
    if any(len(group) > 1 for group_of in groups for group in group_of.values()):
        log.warning("of entities in several physical groups only the first is kept")

    points, tags, dim_tags = nodes
    order = np.argsort(tags, kind="stable")
    tags = tags[order].astype(np.int64)
    mesh = Mesh(points[order], [], names=names)
    if dim_tags is not None:
        mesh.point_data[DIM_TAGS] = dim_tags[order]
    for run in runs:
        cells = _gmsh_to_meshio_order(run.type, _positions(tags, run.nodes))
        named = _TAGS[-run.tags.shape[1] :] if run.tags.shape[1] else ()
        columns = {name: run.tags[:, i] for i, name in enumerate(named)}
        mesh.blocks.append(Block(run.type, cells, columns, run.bounds))
    for section, name, rows, values in views:
        holders = [(tags, mesh.point_data)]
        if section == "ElementData":
            holders = [(r.numbers, b.data) for r, b in zip(runs, mesh.blocks, strict=True)]
        for numbers, arrays in holders:
            found = _spread(numbers, rows, values)
            if found is not None:
                arrays[name] = found
    return mesh


def _sections(data: bytes) -> Iterator[tuple[str, int, int]]:
    """Go through the sections of a file: name, and where its content starts and ends."""
    end = 0
    while match := _SECTION.search(data, end):
        end = data.find(b"$End" + match[1], match.end())
        if end < 0:
            raise UnreadableError(f"the section ${match[1].decode()} has no end")
        yield match[1].decode(), match.end(), end
        end += len(match[1]) + 4


def _read_names(f: BinaryIO) -> dict[str, tuple[int, int]]:
    from meshio.gmsh.common import _read_physical_names

    start = f.tell()
    n = int(f.readline())
    f.seek(start)
    names: dict[str, Array] = {}
    _read_physical_names(f, names)
    if len(names) < n:
        log.warning("of physical groups with the same name only the last keeps it")
    return {name: (int(tag), int(dimension)) for name, (tag, dimension) in names.items()}


def _read_elements_22(f: BinaryIO, text: bool, section: bytes) -> list[_Run]:
    from meshio.gmsh import _gmsh22

    n = int(f.readline())
    cells: list[tuple[str, Array]] = []
    tags: dict[str, Array] = {}
    if text:
        _gmsh22._read_cells_ascii(f, cells, tags, n)
        lines = section.split(b"\n", n + 1)[1 : n + 1]
        numbers = np.array([line.split(None, 1)[0] for line in lines], np.int64)
    else:
        _gmsh22._read_cells_binary(f, cells, tags, n)
        numbers = np.arange(1, n + 1)  # as Gmsh writes them
    if any(len(row) > 2 for rows in tags.values() for row in rows):
        log.warning("the partitions of the elements in the Gmsh file are dropped")
    pairs = {kind: [(*row, 0, 0)[:2] for row in rows] for kind, rows in tags.items()}
    runs, start, used = [], 0, dict.fromkeys(tags, 0)
    for kind, nodes in cells:
        stop, first = start + len(nodes), used[kind]
        used[kind] = first + len(nodes)
        own = np.array(pairs[kind][first : used[kind]], np.int64).reshape(-1, 2)
        runs.append(_Run(kind, numbers[start:stop], nodes.astype(np.int64) + 1, own))
        start = stop
    return runs


def _read_elements_41(
    f: BinaryIO, text: bool, size: int, groups: list[dict], bounds: list[dict]
) -> list[_Run]:
    from meshio._common import num_nodes_per_cell

    known = {code: kind for kind, code in cell_types().items()}

    def take(kind: str, count: int) -> Array:
        return np.fromfile(f, kind, count, " " if text else "")

    n_blocks, n, _, _ = take(f"i{size}", 4)
    with_groups = any(group for group_of in groups for group in group_of.values())
    runs = []
    for _ in range(n_blocks):
        dimension, tag, code = take("i4", 3)
        (count,) = take(f"i{size}", 1)
        if code not in known:
            raise UnreadableError(f"elements of type {code} are not supported")
        width = 1 + num_nodes_per_cell[known[code]]
        rows = take(f"i{size}", count * width).reshape(count, width)
        tags = np.full((count, 1), tag, np.int64)
        if with_groups:
            group = [*groups[dimension].get(tag, []), 0][0]
            tags = np.insert(tags, 0, group, axis=1)
        bound = bounds[dimension].get(tag, []) if bounds else []
        bound = np.asarray(bound, np.int64) if len(bound) else None
        runs.append(_Run(known[code], rows[:, 0], rows[:, 1:], tags, bound))
    if sum(len(run.numbers) for run in runs) != n:
        raise UnreadableError(f"{n} elements are announced, and another number found")
    return runs


def _read_view(f: BinaryIO, text: bool) -> tuple[str, Array, Array]:
    """Read $NodeData or $ElementData: name, numbers of its rows, and values."""
    texts, _, integers = [[f.readline() for _ in range(int(f.readline()))] for _ in range(3)]
    width, n = int(integers[1]), int(integers[2])
    name = texts[0].strip().strip(b'"').decode() if texts else "view"
    if text:
        rows = np.fromfile(f, float, n * (1 + width), " ").reshape(n, 1 + width)
        numbers, values = rows[:, 0], rows[:, 1:]
    else:
        records = np.fromfile(f, [("number", "<i4"), ("value", "<f8", (width,))], n)
        numbers, values = records["number"], records["value"]
    return name, numbers.astype(np.int64), values[:, 0] if width == 1 else values


def _positions(tags: Array, wanted: Array) -> Array:
    """Where each wanted number stands among sorted `tags`, out of range if it does not."""
    if np.array_equal(tags, np.arange(1, len(tags) + 1)):
        return wanted - 1
    if not len(tags):
        return np.full(wanted.shape, -1)
    at = np.minimum(np.searchsorted(tags, wanted), len(tags) - 1)
    return np.where(tags[at] == wanted, at, -1)


def _spread(tags: Array, rows: Array, values: Array) -> Array | None:
    """Give each tag the value of the row of that number, else NaN; None if all are NaN."""
    order = np.argsort(tags, kind="stable")
    at = _positions(tags[order], rows)
    inside = (at >= 0) & (at < len(tags))
    if not inside.any():
        return None
    spread = np.full((len(tags), *values.shape[1:]), np.nan)
    spread[order[at[inside]]] = values[inside]
    return spread


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh.

    Its points have three coordinates and its blocks types out of `cell_types`. Arrays but
    the tags become views: they are of numbers, of a width in `VIEW_WIDTHS`.
    """
    import meshio
    from meshio.gmsh import _gmsh22, _gmsh41
    from meshio.gmsh.common import _write_physical_names

    complete_cells()
    binary, old = encoding.binary, encoding.format == "gmsh22"
    points = mesh.points.astype(np.float64)
    blocks = mesh.blocks if old else entities.by_entity(mesh.blocks)
    cells = [meshio.CellBlock(block.type, block.cells) for block in blocks]
    zeros = [np.zeros(len(block.cells), np.int64) for block in blocks]
    tags = {
        name: [block.data.get(name, none) for block, none in zip(blocks, zeros, strict=True)]
        for name in _TAGS
    }
    with path.open("wb") as f, listening(logging.INFO):
        f.write(f"$MeshFormat\n{'2.2' if old else '4.1'} {int(binary)} 8\n".encode())
        f.write((b"\1\0\0\0\n" if binary else b"") + b"$EndMeshFormat\n")
        _write_physical_names(f, mesh.names)
        if old:
            _gmsh22._write_nodes(f, points, ".16e", binary)
            _gmsh22._write_elements(f, cells, tags, binary)
        else:
            dim_tags = mesh.point_data.get(DIM_TAGS)
            if dim_tags is None:
                dim_tags = entities.classify(len(points), blocks)
            entities.write(f, points, blocks, dim_tags, binary)
            _gmsh41._write_nodes(f, points, cells, {DIM_TAGS: dim_tags}, ".16e", binary)
            _gmsh41._write_elements(f, cells, tags, binary)
        for name, values in mesh.point_data.items():
            if name != DIM_TAGS:
                _write_view(f, "NodeData", name, np.arange(1, len(values) + 1), values, binary)
        numbers = np.cumsum([1, *(len(block.cells) for block in blocks)])
        for name in dict.fromkeys(name for block in blocks for name in block.data):
            if name not in _TAGS:
                with_it = [i for i, block in enumerate(blocks) if name in block.data]
                rows = [np.arange(numbers[i], numbers[i + 1]) for i in with_it]
                arrays = [blocks[i].data[name] for i in with_it]
                joined = np.concatenate(rows), np.concatenate(arrays)
                _write_view(f, "ElementData", name, *joined, binary)


def _write_view(
    f: BinaryIO, section: str, name: str, rows: Array, values: Array, binary: bool
) -> None:
    values = values.reshape(len(rows), -1).astype(np.float64)
    width = values.shape[1]
    title = name.replace('"', "'").replace("\n", " ")
    head = f'${section}\n1\n"{title}"\n1\n0.0\n3\n0\n{width}\n{len(rows)}\n'
    f.write(head.encode(errors="replace"))
    if binary:
        records = np.empty(len(rows), [("number", "<i4"), ("value", "<f8", (width,))])
        records["number"], records["value"] = rows, values
        f.write(records.tobytes() + b"\n")
    else:
        for row, value in zip(rows.tolist(), values.tolist(), strict=True):
            f.write(f"{row} {' '.join(map(repr, value))}\n".encode())
    f.write(f"$End{section}\n".encode())
