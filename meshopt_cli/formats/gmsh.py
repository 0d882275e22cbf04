"""Gmsh's MSH 4.1 and 2.2, text and binary, section by section.

The sections are read and written by functions of meshio, but these:

- elements are read by `gmsh_elements`;
- views are read and written here, since meshio takes them for lists of all elements in
  order, and does not write their numbers as numbers in text;
- entities are written by `entities`, which says why;
- nodes and elements in text are written here, since meshio formats them row by row.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from ..mesh.model import Array, Mesh
from ..mesh.tags import DIM_TAGS, GEOMETRICAL, PHYSICAL
from . import entities, gmsh_elements
from .bridge import listening
from .gmsh_elements import cell_types
from .gmsh_order import from_gmsh, to_gmsh
from .sniff import Encoding, UnreadableError, gmsh_header
from .text import lines

if TYPE_CHECKING:
    from meshio import CellBlock

VIEW_WIDTHS = (1, 3, 9)  # components of a value in a view
_SECTION = re.compile(rb"^\$(\w+)[ \t]*\r?\n", re.MULTILINE)


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a mesh, and what of its file is left out.

    Points are in the order of their numbers in the file. An element that names a node which
    is not there has a number out of range in its place. Views become arrays under their
    names; where they have no value there is a NaN.
    """
    from meshio.gmsh import _gmsh22, _gmsh41, common

    text, old = not encoding.binary, encoding.format == "gmsh22"
    names: dict[str, Array] = {}
    groups, bounds = [], []  # of the entities of each dimension, by tag
    nodes, elements, views = None, None, []
    lost: list[str] = []
    with path.open("rb") as f, listening(logging.WARNING):
        for section, content in _sections(data, f):
            if section == "MeshFormat":
                *_, size = gmsh_header(content)
            elif section == "PhysicalNames":
                common._read_physical_names(f, names)
                if len(names) < int(content.split(None, 1)[0]):
                    lost.append("the name of all but the last of groups with the same one")
            elif section == "Entities":
                groups, bounds = _gmsh41._read_entities(f, text, size)
            elif section == "Nodes" and old:
                nodes = (*_gmsh22._read_nodes(f, text), None)
            elif section == "Nodes":
                points, tags, dim_tags = _gmsh41._read_nodes(f, text, size)
                nodes = (points, tags + 1, dim_tags)
            elif section == "Elements" and old:
                elements = gmsh_elements.read_22(content, text, lost)
            elif section == "Elements":
                elements = gmsh_elements.read_41(content, text, size, groups, bounds)
            elif section in ("NodeData", "ElementData"):
                views.append((section, *_read_view(f, text)))
            elif section != "Comments":
                lost.append(f"the section ${section}")
    if nodes is None or elements is None:
        missing = "Nodes" if nodes is None else "Elements"
        raise UnreadableError(f"there is no section ${missing} in it")

    points, tags, dim_tags = nodes
    order = np.argsort(tags, kind="stable")
    tags = tags[order].astype(np.int64)
    blocks, numbers_of = elements
    for block in blocks:
        places = from_gmsh(block.type, _places(tags, block.cells))
        block.cells = common._gmsh_to_meshio_order(block.type, places)
    mesh = Mesh(points[order], blocks, {}, {n: (int(t), int(d)) for n, (t, d) in names.items()})
    for dimension, of in enumerate(groups):
        several = {(dimension, int(tag)): group[1:] for tag, group in of.items()}
        mesh.more_groups |= {key: tuple(map(int, more)) for key, more in several.items() if more}
    if dim_tags is not None:
        mesh.point_data[DIM_TAGS] = dim_tags[order]
    for section, name, rows, values in views:
        holders = [(tags, mesh.point_data)]
        if section == "ElementData":
            holders = [(n, block.data) for n, block in zip(numbers_of, blocks, strict=True)]
        for numbers, arrays in holders:
            at = _places(numbers, rows)
            inside = (at >= 0) & (at < len(numbers))
            if inside.any():
                arrays[name] = np.full((len(numbers), *values.shape[1:]), np.nan)
                arrays[name][at[inside]] = values[inside]
    return mesh, lost


def _sections(data: bytes, f: BinaryIO) -> Iterator[tuple[str, bytes]]:
    """Go through the sections of a file: name and content, at which f is set."""
    at = 0
    while match := _SECTION.search(data, at):
        at = data.find(b"$End" + match[1], match.end())
        if at < 0:
            raise UnreadableError(f"the section ${match[1].decode()} has no end")
        f.seek(match.end())
        yield match[1].decode(), data[match.end() : at]
        at += len(match[1]) + 4


def _places(numbers: Array, wanted: Array) -> Array:
    """Where each wanted number stands among others, out of range if it does not."""
    if np.array_equal(numbers, np.arange(1, len(numbers) + 1)):
        return wanted - 1
    order = np.argsort(numbers, kind="stable")
    at = np.searchsorted(numbers, wanted, sorter=order)
    at = order[np.minimum(at, len(numbers) - 1)]
    return np.where(numbers[at] == wanted, at, -1)


def _read_view(f: BinaryIO, text: bool) -> tuple[str, Array, Array]:
    """Read $NodeData or $ElementData: name, numbers of its rows, and values."""
    texts, _, integers = [[f.readline() for _ in range(int(f.readline()))] for _ in range(3)]
    width, n = int(integers[1]), int(integers[2])
    if text:
        rows = np.fromfile(f, float, n * (1 + width), " ").reshape(n, 1 + width)
        numbers, values = rows[:, 0], rows[:, 1:]
    else:
        records = np.fromfile(f, _record(width), n)
        numbers, values = records["number"], records["value"]
    name = texts[0].strip().strip(b'"').decode()
    return name, numbers.astype(np.int64), values[:, 0] if width == 1 else values


def _record(width: int) -> np.dtype:
    return np.dtype([("number", "<i4"), ("value", "<f8", (width,))])


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh.

    Its points have three coordinates, its blocks "gmsh:geometrical" and types out of
    `cell_types`; for version 4.1, they are as `entities.by_entity` makes them. Arrays become
    views: they are of numbers, of a width in `VIEW_WIDTHS`.
    """
    import meshio
    from meshio.gmsh import _gmsh22, _gmsh41, common

    binary, old = encoding.binary, encoding.format == "gmsh22"
    points = mesh.points.astype(np.float64)
    blocks = mesh.blocks
    with path.open("wb") as f, listening(logging.INFO):
        cells = [meshio.CellBlock(b.type, to_gmsh(b.type, b.cells)) for b in blocks]
        tags = {GEOMETRICAL: [block.data[GEOMETRICAL] for block in blocks]}
        f.write(f"$MeshFormat\n{'2.2' if old else '4.1'} {int(binary)} 8\n".encode())
        f.write((b"\1\0\0\0\n" if binary else b"") + b"$EndMeshFormat\n")
        common._write_physical_names(f, mesh.names)
        if old:
            tags[PHYSICAL] = [b.data.get(PHYSICAL, np.zeros(len(b.cells), int)) for b in blocks]
        else:
            dim_tags = mesh.point_data.get(DIM_TAGS, entities.classify(len(points), blocks))
            entities.write(f, points, blocks, dim_tags, mesh.more_groups, binary)
        if old and binary:
            _gmsh22._write_nodes(f, points, "", binary)
            _gmsh22._write_elements(f, cells, tags, binary)
        elif old:
            _write_text_22(f, points, cells, tags)
        elif binary:
            _gmsh41._write_nodes(f, points, cells, {DIM_TAGS: dim_tags}, "", binary)
            _gmsh41._write_elements(f, cells, tags, binary)
        else:
            _write_text_41(f, points, dim_tags, cells, tags)
        for name, values in mesh.point_data.items():
            if name != DIM_TAGS:
                _write_view(f, "NodeData", name, np.arange(1, len(values) + 1), values, binary)
        for name in dict.fromkeys(name for block in blocks for name in block.data):
            if name not in (PHYSICAL, GEOMETRICAL):
                here = [np.full(len(block.cells), name in block.data) for block in blocks]
                rows = np.flatnonzero(np.concatenate(here)) + 1
                values = np.concatenate([b.data[name] for b in blocks if name in b.data])
                _write_view(f, "ElementData", name, rows, values, binary)


def _write_text_22(
    f: BinaryIO, points: Array, cells: list[CellBlock], tags: dict[str, list[Array]]
) -> None:
    from meshio.gmsh import common

    f.write(f"$Nodes\n{len(points)}\n".encode())
    f.writelines(lines(np.arange(1, len(points) + 1), points))
    f.write(f"$EndNodes\n$Elements\n{sum(map(len, cells))}\n".encode())
    first = 1
    for block, *of_block in zip(cells, tags[PHYSICAL], tags[GEOMETRICAL], strict=True):
        rows = common._meshio_to_gmsh_order(block.type, block.data) + 1
        head = np.tile([cell_types()[block.type], 2], (len(rows), 1))
        f.writelines(lines(np.arange(first, first + len(rows)), head, *of_block, rows))
        first += len(rows)
    f.write(b"$EndElements\n")


def _write_text_41(
    f: BinaryIO,
    points: Array,
    dim_tags: Array,
    cells: list[CellBlock],
    tags: dict[str, list[Array]],
) -> None:
    """Write the nodes entity by entity, then the elements, whose blocks have one entity each."""
    from meshio.gmsh import common

    n = len(points)
    order = np.lexsort(dim_tags.T[::-1])
    starts = np.flatnonzero(np.diff(dim_tags[order], axis=0, prepend=-1).any(axis=1))
    f.write(f"$Nodes\n{len(starts)} {n} 1 {n}\n".encode())
    for start, end in pairwise([*starts, n]):
        nodes = order[start:end]
        dimension, tag = dim_tags[nodes[0]]
        f.write(f"{dimension} {tag} 0 {len(nodes)}\n".encode())
        f.writelines(lines(nodes + 1))
        f.writelines(lines(points[nodes]))
    n = sum(map(len, cells))
    f.write(f"$EndNodes\n$Elements\n{len(cells)} {n} 1 {n}\n".encode())
    first = 1
    for block, entity in zip(cells, tags[GEOMETRICAL], strict=True):
        rows = common._meshio_to_gmsh_order(block.type, block.data) + 1
        head = f"{block.dim} {entity[0]} {cell_types()[block.type]} {len(rows)}\n"
        f.write(head.encode())
        f.writelines(lines(np.arange(first, first + len(rows)), rows))
        first += len(rows)
    f.write(b"$EndElements\n")


def _write_view(
    f: BinaryIO, section: str, name: str, rows: Array, values: Array, binary: bool
) -> None:
    values = values.reshape(len(rows), -1).astype(np.float64)
    there = ~np.isnan(values).all(axis=1)
    rows, values = rows[there], values[there]
    width = values.shape[1]
    title = name.replace('"', "'").replace("\n", " ")
    head = f'${section}\n1\n"{title}"\n1\n0.0\n3\n0\n{width}\n{len(rows)}\n'
    f.write(head.encode(errors="replace"))
    if binary:
        records = np.empty(len(rows), _record(width))
        records["number"], records["value"] = rows, values
        f.write(records.tobytes() + b"\n")
    else:
        f.writelines(lines(rows, values))
    f.write(f"$End{section}\n".encode())
