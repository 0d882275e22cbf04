"""Writing of Gmsh's MSH 4.1 and 2.2, text and binary."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np
from numpy.typing import ArrayLike

from .formats_gmsh import (
    CODES,
    DIM_TAGS,
    GEOMETRICAL,
    ORDER,
    PHYSICAL,
    Entities,
    Entity,
    dimension_of,
)
from .formats_text import write_rows
from .mesh import Array, Block, Mesh


def write(stream: BinaryIO, mesh: Mesh, version: str, binary: bool) -> None:
    """Write a mesh of version 4.1 or 2.2.

    Parameters
    ----------
    stream : binary file
    mesh : Mesh
        Its points have three coordinates and its blocks types out of `CODES`. Arrays
        but the tags become views: they are of numbers, of a width in `VIEW_WIDTHS`.
    version : "4.1" or "2.2"
    binary : bool
    """
    stream.write(f"$MeshFormat\n{version} {int(binary)} 8\n".encode())
    stream.write((b"\1\0\0\0\n" if binary else b"") + b"$EndMeshFormat\n")
    if mesh.names:
        stream.write(f"$PhysicalNames\n{len(mesh.names)}\n".encode())
        for name, (tag, dimension) in sorted(mesh.names.items(), key=lambda item: item[1][::-1]):
            line = f'{dimension} {tag} "{name}"\n'
            stream.write(line.encode(errors="surrogateescape"))
        stream.write(b"$EndPhysicalNames\n")
    blocks = mesh.blocks if version == "2.2" else by_entity(mesh.blocks)
    tags = np.cumsum([1, *(len(block.cells) for block in blocks)])
    if version == "2.2":
        _write_nodes_22(stream, mesh.points, binary)
        _write_elements_22(stream, blocks, tags, binary)
    else:
        dim_tags = mesh.point_data.get(DIM_TAGS)
        if dim_tags is None:
            dim_tags = classify(len(mesh.points), blocks)
        _write_entities(stream, mesh.points, blocks, dim_tags, binary)
        _write_nodes_41(stream, mesh.points, dim_tags, binary)
        _write_elements_41(stream, blocks, tags, binary)
    for name, values in mesh.point_data.items():
        if name != DIM_TAGS:
            _write_view(stream, "NodeData", name, np.arange(1, len(values) + 1), values, binary)
    for name in dict.fromkeys(name for block in blocks for name in block.data):
        if name not in (PHYSICAL, GEOMETRICAL):
            with_it = [i for i, block in enumerate(blocks) if name in block.data]
            rows = np.concatenate([np.arange(tags[i], tags[i + 1]) for i in with_it])
            values = np.concatenate([blocks[i].data[name] for i in with_it])
            _write_view(stream, "ElementData", name, rows, values, binary)


def by_entity(blocks: list[Block]) -> list[Block]:
    """Cut blocks up so that each lies on one entity, which has one physical group.

    Parts of an entity in different groups, all but the first, get new entities.

    Returns
    -------
    list of Block
        In each of them the values of "gmsh:geometrical" and "gmsh:physical" are the
        same for all cells.
    """
    parts = []
    for block in blocks:
        if not len(block.cells):
            continue
        zeros = np.zeros(len(block.cells), np.int64)
        keys = np.column_stack([block.data.get(name, zeros) for name in (GEOMETRICAL, PHYSICAL)])
        for (tag, physical), here in _groups(keys):
            data = {name: values[here] for name, values in block.data.items()}
            data[GEOMETRICAL] = np.full(len(here), tag)
            data[PHYSICAL] = np.full(len(here), physical)
            part = Block(block.type, block.cells[here], data, block.entities)
            parts.append((dimension_of(block.type), tag, physical, part))
    used: dict[tuple[int, int], int] = {}
    for dimension, tag, physical, _ in parts:
        used.setdefault((dimension, tag), physical)
    new: dict[tuple[int, int, int], int] = {}
    for dimension, tag, physical, part in parts:
        if used[dimension, tag] != physical:
            key = (dimension, tag, physical)
            if key not in new:
                new[key] = max(t for d, t in used if d == dimension) + 1
                used[dimension, new[key]] = physical
            part.data[GEOMETRICAL] = np.full(len(part.cells), new[key])
    return [part for *_, part in parts]


def _entity(block: Block) -> tuple[int, int]:
    return dimension_of(block.type), int(block.data[GEOMETRICAL][0])


def classify(n: int, blocks: list[Block]) -> Array:
    """Find the entity of each node: the one of lowest dimension whose cells use it.

    Parameters
    ----------
    n : int
        Number of points.
    blocks : list of Block
        As `by_entity` makes them.

    Returns
    -------
    (n, 2) int64
        Dimension and tag. A node that no cell uses goes with the highest entity.
    """
    # of equal dimensions, the first block has the last word
    downwards = sorted(reversed(blocks), key=lambda block: -dimension_of(block.type))
    dim_tags = np.tile(np.array(_entity(downwards[0]) if blocks else (3, 1)), (n, 1))
    for block in downwards:
        dim_tags[_used(block, n)] = _entity(block)
    return dim_tags


def _used(block: Block, n: int) -> Array:
    """Points that the cells of a block use, but numbers out of range."""
    used = np.zeros(n, dtype=bool)
    used[block.cells[(block.cells >= 0) & (block.cells < n)]] = True
    return np.flatnonzero(used)


def _put(stream: BinaryIO, binary: bool, *parts: tuple[str, ArrayLike]) -> None:
    """Write a few numbers, ("i4" | "u8" | "f8", values) by kind, on one line of text."""
    if binary:
        stream.write(b"".join(np.asarray(values, "<" + kind).tobytes() for kind, values in parts))
    else:
        flat = [str(value) for _, values in parts for value in np.ravel(values).tolist()]
        stream.write((" ".join(flat) + "\n").encode())


def _end(stream: BinaryIO, name: str, binary: bool) -> None:
    stream.write(b"\n" * binary + f"$End{name}\n".encode())


def _write_entities(
    stream: BinaryIO, points: Array, blocks: list[Block], dim_tags: Array, binary: bool
) -> None:
    """Write every entity that has nodes or cells, or bounds one that has."""
    entities: Entities = {}
    nodes: dict[tuple[int, int], list[Array]] = {}
    for key, own in _groups(dim_tags):
        entities[key], nodes[key] = Entity(), [own]
    for block in blocks:
        key = _entity(block)
        bounds = entities[key].bounds if key in entities else None
        bounds = bounds if block.entities is None else block.entities
        entities[key] = Entity(int(block.data[PHYSICAL][0]), bounds)
        nodes.setdefault(key, []).append(_used(block, len(points)))
        for tag in [] if block.entities is None else np.abs(block.entities).tolist():
            entities.setdefault((key[0] - 1, tag), Entity())
    stream.write(b"$Entities\n")
    counts = np.bincount([dimension for dimension, _ in entities], minlength=4)
    _put(stream, binary, ("u8", counts))
    for key in sorted(entities):
        dimension, tag = key
        x = points[np.concatenate(nodes.get(key, [np.empty(0, np.int64)]))]
        x = x if len(x) else np.zeros((1, 3))
        box = np.concatenate([np.fmin.reduce(x), np.fmax.reduce(x)])[: 6 if dimension else 3]
        groups = [entities[key].physical] if entities[key].physical else []
        parts: list[tuple[str, ArrayLike]]
        parts = [("i4", tag), ("f8", box), ("u8", len(groups)), ("i4", groups)]
        if dimension:
            bounds = entities[key].bounds
            parts += [("u8", 0)] if bounds is None else [("u8", len(bounds)), ("i4", bounds)]
        _put(stream, binary, *parts)
    _end(stream, "Entities", binary)


def _groups(keys: Array) -> Iterator[tuple[tuple[int, int], Array]]:
    """Go through the distinct rows of two columns, in order, and where each of them is."""
    if not len(keys):
        return
    order = np.lexsort((keys[:, 1], keys[:, 0]))
    ordered = keys[order]
    cuts = np.flatnonzero((ordered[1:] != ordered[:-1]).any(axis=1)) + 1
    for here in np.split(order, cuts):
        yield (int(keys[here[0], 0]), int(keys[here[0], 1])), here


def _write_nodes_41(stream: BinaryIO, points: Array, dim_tags: Array, binary: bool) -> None:
    groups = list(_groups(dim_tags))
    stream.write(b"$Nodes\n")
    _put(stream, binary, ("u8", [len(groups), len(points), min(1, len(points)), len(points)]))
    for key, own in groups:
        _put(stream, binary, ("i4", [*key, 0]), ("u8", len(own)))
        if binary:
            stream.write((own + 1).astype("<u8").tobytes())
            stream.write(points[own].astype("<f8").tobytes())
        else:
            write_rows(stream, "%d\n", [own + 1])
            write_rows(stream, "%r %r %r\n", points[own].T)
    _end(stream, "Nodes", binary)


def _write_elements_41(stream: BinaryIO, blocks: list[Block], tags: Array, binary: bool) -> None:
    stream.write(b"$Elements\n")
    n = int(tags[-1]) - 1
    _put(stream, binary, ("u8", [len(blocks), n, min(1, n), n]))
    for block, tag in zip(blocks, tags[:-1], strict=True):
        kind = [*_entity(block), CODES[block.type]]
        _put(stream, binary, ("i4", kind), ("u8", len(block.cells)))
        _write_elements(stream, _element_rows(block, tag), "<u8" if binary else "")
    _end(stream, "Elements", binary)


def _element_rows(block: Block, tag: int, *columns: Array) -> Array:
    cells = block.cells
    if block.type in ORDER:
        cells = cells[:, np.argsort(ORDER[block.type])]
    return np.column_stack([np.arange(tag, tag + len(cells)), *columns, cells + 1])


def _write_elements(stream: BinaryIO, rows: Array, binary_type: str) -> None:
    if binary_type:
        stream.write(rows.astype(binary_type).tobytes())
    else:
        write_rows(stream, " ".join(["%d"] * rows.shape[1]) + "\n", rows.T)


def _write_nodes_22(stream: BinaryIO, points: Array, binary: bool) -> None:
    stream.write(f"$Nodes\n{len(points)}\n".encode())
    tags = np.arange(1, len(points) + 1)
    if binary:
        rows = np.empty(len(points), [("tag", "<i4"), ("x", "<f8", (3,))])
        rows["tag"], rows["x"] = tags, points
        stream.write(rows.tobytes())
    else:
        write_rows(stream, "%d %r %r %r\n", [tags, *points.T])
    _end(stream, "Nodes", binary)


def _write_elements_22(stream: BinaryIO, blocks: list[Block], tags: Array, binary: bool) -> None:
    stream.write(f"$Elements\n{tags[-1] - 1}\n".encode())
    for block, tag in zip(blocks, tags[:-1], strict=True):
        n = len(block.cells)
        pair = [block.data.get(name, np.zeros(n, np.int64)) for name in (PHYSICAL, GEOMETRICAL)]
        if binary and n:
            stream.write(np.array([CODES[block.type], n, 2], "<i4").tobytes())
            _write_elements(stream, _element_rows(block, tag, *pair), "<i4")
        else:
            head = [np.full(n, CODES[block.type]), np.full(n, 2)]
            _write_elements(stream, _element_rows(block, tag, *head, *pair), "")
    _end(stream, "Elements", binary)


def _write_view(
    stream: BinaryIO, kind: str, name: str, rows: Array, values: Array, binary: bool
) -> None:
    values = values.reshape(len(rows), -1).astype(np.float64)
    width = values.shape[1]
    title = name.replace('"', "'").replace("\n", " ")
    head = f'${kind}\n1\n"{title}"\n1\n0.0\n3\n0\n{width}\n{len(rows)}\n'
    stream.write(head.encode(errors="surrogateescape"))
    if binary:
        records = np.empty(len(rows), [("tag", "<i4"), ("value", "<f8", (width,))])
        records["tag"], records["value"] = rows, values
        stream.write(records.tobytes())
    else:
        write_rows(stream, "%d" + " %r" * width + "\n", [rows, *values.T])
    _end(stream, kind, binary)
