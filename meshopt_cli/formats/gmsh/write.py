"""Writing Gmsh's MSH files, versions 4.1 and 2.2, text and binary."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...cells import dimension_of
from ...mesh.model import Array, Block, Mesh
from ...mesh.tags import DIM_TAGS, GEOMETRICAL, PARAMETRIC, PARTITION, PHYSICAL
from ..sniff import Encoding
from . import model
from .order import to_gmsh
from .periodic import write_periodic
from .repeats import with_repeats
from .sink import Sink
from .types import code_of
from .views import write_views


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh.

    Its points have three coordinates, its blocks "gmsh:geometrical" and types out of
    `cell_types`; for version 4.1, they are as `model.by_entity` makes them. Arrays become
    views: they are of numbers, of a width in `VIEW_WIDTHS`.
    """
    binary, old = encoding.binary, encoding.format == "gmsh22"
    mesh = Mesh(**{**vars(mesh), "points": mesh.points.astype(np.float64)})
    with path.open("wb") as f:
        f.write(f"$MeshFormat\n{'2.2' if old else '4.1'} {int(binary)} 8\n".encode())
        f.write((b"\1\0\0\0\n" if binary else b"") + b"$EndMeshFormat\n")
        _write_names(f, mesh.names)
        sink = Sink(f, binary)
        if old:
            mesh.blocks = with_repeats(mesh.blocks, mesh.more_groups)
            _write_nodes_22(f, sink, mesh.points)
            _write_elements_22(f, sink, mesh.blocks)
        else:
            default = model.classify(len(mesh.points), mesh.blocks)
            dim_tags = mesh.point_data.get(DIM_TAGS, default)
            model.write(f, sink, mesh, dim_tags)
            _write_nodes_41(f, sink, mesh, dim_tags)
            _write_elements_41(f, sink, mesh.blocks)
        write_periodic(f, mesh.periodic, old, binary)
        write_views(f, mesh, binary, (PARTITION,) if old else ())


def _write_names(f: BinaryIO, names: dict[tuple[int, int], str]) -> None:
    if names:
        rows = [f'{dimension} {tag} "{name}"\n' for (dimension, tag), name in names.items()]
        f.write(f"$PhysicalNames\n{len(rows)}\n{''.join(rows)}$EndPhysicalNames\n".encode())


def _write_nodes_22(f: BinaryIO, sink: Sink, points: Array) -> None:
    f.write(f"$Nodes\n{len(points)}\n".encode())
    sink.rows(("i4", np.arange(1, len(points) + 1)), ("f8", points))
    sink.end("Nodes")


def _write_elements_22(f: BinaryIO, sink: Sink, blocks: list[Block]) -> None:
    """Write elements with a group, an entity and, where there are any, one partition."""
    f.write(f"$Elements\n{sum(len(block.cells) for block in blocks)}\n".encode())
    first = 1
    for block in blocks:
        n, code = len(block.cells), code_of(block.type)
        nothing = np.zeros(n, np.int64)
        tags = [block.data.get(PHYSICAL, nothing), block.data[GEOMETRICAL]]
        if PARTITION in block.data:
            tags += [nothing + 1, block.data[PARTITION]]
        numbers, nodes = np.arange(first, first + n), to_gmsh(block.type, block.cells) + 1
        if sink.binary and n:
            sink.put(("i4", (code, n, len(tags))))
        else:
            numbers = np.column_stack([numbers, np.tile([code, len(tags)], (n, 1))])
        sink.rows(("i4", numbers), *(("i4", values) for values in tags), ("i4", nodes))
        first += n
    sink.end("Elements")


def _write_nodes_41(f: BinaryIO, sink: Sink, mesh: Mesh, dim_tags: Array) -> None:
    """Write the nodes entity by entity, those that have parameters apart."""
    n = len(mesh.points)
    parameters = mesh.point_data.get(PARAMETRIC, np.full((n, 2), np.nan))
    dimension = dim_tags[:, 0]
    has = (dimension > 0) & np.isfinite(parameters[:, 0])
    has &= np.where(dimension == 2, np.isfinite(parameters[:, 1]), dimension == 1)
    keys = np.column_stack([dim_tags, has])
    order = np.lexsort(keys.T[::-1])
    starts = np.flatnonzero(np.diff(keys[order], axis=0, prepend=-1).any(axis=1))
    f.write(b"$Nodes\n")
    sink.put(("u8", (len(starts), n, min(n, 1), n)))
    for start, end in pairwise([*starts, n]):
        nodes = order[start:end]
        head = keys[nodes[0]].tolist()
        sink.put(("i4", head), ("u8", len(nodes)))
        sink.rows(("u8", nodes + 1))
        given = parameters[nodes, : head[0] * head[2]]
        sink.rows(("f8", np.column_stack([mesh.points[nodes], given])))
    sink.end("Nodes")


def _write_elements_41(f: BinaryIO, sink: Sink, blocks: list[Block]) -> None:
    """Write the blocks, which have one entity each."""
    n = sum(len(block.cells) for block in blocks)
    f.write(b"$Elements\n")
    sink.put(("u8", (len(blocks), n, min(n, 1), n)))
    first = 1
    for block in blocks:
        head = dimension_of(block.type), block.data[GEOMETRICAL][0], code_of(block.type)
        sink.put(("i4", head), ("u8", len(block.cells)))
        numbers = np.arange(first, first + len(block.cells))
        sink.rows(("u8", numbers), ("u8", to_gmsh(block.type, block.cells) + 1))
        first += len(block.cells)
    sink.end("Elements")
