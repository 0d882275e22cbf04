"""Gmsh's MSH 4.1 and 2.2, text and binary: their codes, and reading.

meshio is not asked, because it refuses physical groups on part of the entities,
elements of two types on one entity, entities without nodes of their own and
elements without tags; turns node 0 into the last one and fails on numbers beyond
the last; takes views for lists in order of number, and cannot write them as text.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

import numpy as np

from .formats_text import UnreadableError, numbers
from .mesh import Array, Block, Mesh

log = logging.getLogger("meshopt")

PHYSICAL = "gmsh:physical"
GEOMETRICAL = "gmsh:geometrical"
DIM_TAGS = "gmsh:dim_tags"
VIEW_WIDTHS = (1, 3, 9)  # components of a value in a view

TYPES = {
    1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge",
    7: "pyramid", 8: "line3", 9: "triangle6", 10: "quad9", 11: "tetra10",
    12: "hexahedron27", 13: "wedge18", 14: "pyramid14", 15: "vertex", 16: "quad8",
    17: "hexahedron20", 18: "wedge15", 19: "pyramid13", 21: "triangle10",
    23: "triangle15", 25: "triangle21", 26: "line4", 27: "line5", 28: "line6",
    29: "tetra20", 30: "tetra35", 31: "tetra56", 36: "quad16", 37: "quad25",
    38: "quad36", 90: "wedge40", 91: "wedge75", 92: "hexahedron64", 93: "hexahedron125",
}  # fmt: skip
CODES = {cell_type: code for code, cell_type in TYPES.items()}
_LINEAR = {
    "vertex": (0, 1),
    "line": (1, 2),
    "triangle": (2, 3),
    "quad": (2, 4),
    "tetra": (3, 4),
    "hexahedron": (3, 8),
    "wedge": (3, 6),
    "pyramid": (3, 5),
}
# places in Gmsh's order of the nodes, in the order that VTK and a `Block` have
ORDER = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
    "pyramid13": [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12],
}
ORDER["hexahedron27"] = [*ORDER["hexahedron20"], 22, 23, 21, 24, 20, 25, 26]

_SECTION = re.compile(rb"^\$(\w+)[ \t]*\r?\n", re.MULTILINE)
_HEADER = re.compile(rb"\s*(\S+)\s+([01])\s+(\d+)[ \t]*\r?\n")
_NAME = re.compile(rb'^[ \t]*(\d+)[ \t]+(-?\d+)[ \t]+"(.*)"[ \t\r]*$', re.MULTILINE)


def dimension_of(cell_type: str) -> int:
    """Dimension of a type of cell, from 0 to 3."""
    return _LINEAR[cell_type.rstrip("0123456789")][0]


def n_nodes_of(cell_type: str) -> int:
    """Count of nodes of a type of cell."""
    family = cell_type.rstrip("0123456789")
    return int(cell_type[len(family) :] or _LINEAR[family][1])


class _Numbers:
    """Hands out the numbers of a section run by run, be they text or binary."""

    def __init__(self, data: bytes, text: bool, real: bool, size: int = 8) -> None:
        self._data, self._text, self._at = data, text, 0
        self._values = numbers(data, float if real else int) if text else np.empty(0)
        self._types = {"int": "<i4", "size": f"<u{size}", "real": "<f8"}

    def take(self, kind: str, count: int = 1) -> Array:
        """Return the next `count` numbers, "int", "size" or "real", in 64 bits."""
        dtype = np.dtype(self._types[kind])
        width, length = (1, len(self._values)) if self._text else (dtype.itemsize, len(self._data))
        start, self._at = self._at, self._at + count * width
        if count < 0 or self._at > length:
            raise UnreadableError("it ends in the middle of a section")
        if self._text:
            taken = self._values[start : self._at]
        else:
            taken = np.frombuffer(self._data, dtype, count, start)
        return taken.astype(np.float64 if kind == "real" else np.int64)

    def one(self, kind: str) -> int:
        """Return the next number, an integer."""
        return int(self.take(kind)[0])


@dataclass
class _Run:
    """Elements that stand together: numbers, numbers of nodes, data of their Block."""

    type: str
    tags: Array
    nodes: Array
    data: dict[str, Array]
    entities: Array | None = None


@dataclass
class Entity:
    """What the file says of an entity: its first physical group, and what bounds it."""

    physical: int = 0
    bounds: Array | None = None


Entities = dict[tuple[int, int], Entity]


def read(data: bytes) -> Mesh:
    """Read a mesh of version 4.1 or 2.2.

    Parameters
    ----------
    data : bytes
        The whole file.

    Returns
    -------
    Mesh
        Points are in the order of their numbers in the file. An element that names
        a node which is not there has a number out of range in its place. Views
        become arrays under their names; where they have no value there is a NaN.

    Raises
    ------
    UnreadableError
        The file is truncated or malformed.
    """
    sections = list(_sections(data))
    header = next((body for name, body in sections if name == "MeshFormat"), b"")
    version, text, size = parse_header(header)
    names: dict[str, tuple[int, int]] = {}
    entities: Entities = {}
    points, tags, dim_tags, runs = None, np.empty(0, np.int64), None, None
    views, dropped = [], []
    for name, body in sections:
        if name == "PhysicalNames":
            names = _read_names(body)
        elif name == "Entities":
            entities = _read_entities(_Numbers(body, text, real=True, size=size))
        elif name == "Nodes" and version == "2.2":
            tags, points = _read_nodes_22(body, text)
        elif name == "Nodes":
            tags, points, dim_tags = _read_nodes_41(_Numbers(body, text, real=True, size=size))
        elif name == "Elements" and version == "2.2":
            runs = _read_elements_22(body, text)
        elif name == "Elements":
            runs = _read_elements_41(_Numbers(body, text, real=False, size=size), entities)
        elif name in ("NodeData", "ElementData"):
            views.append((name, *_read_view(body, text)))
        elif name not in ("MeshFormat", "Comments"):
            dropped.append(name)
    if points is None or runs is None:
        raise UnreadableError(
            f"there is no section ${'Nodes' if points is None else 'Elements'} in it"
        )
    if dropped:
        log.warning("the sections %s of the Gmsh file are dropped", ", ".join(dropped))

    order = np.argsort(tags, kind="stable")
    tags = tags[order]
    blocks = [Block(run.type, _cells(run, tags), run.data, run.entities) for run in runs]
    mesh = Mesh(points[order], blocks, names=names)
    if dim_tags is not None:
        mesh.point_data[DIM_TAGS] = dim_tags[order]
    for kind, name, rows, values in views:
        if kind == "NodeData":
            found = _spread(tags, rows, values)
            if found is not None:
                mesh.point_data[name] = found
        else:
            for block, run in zip(blocks, runs, strict=True):
                found = _spread(run.tags, rows, values)
                if found is not None:
                    block.data[name] = found
    return mesh


def parse_header(body: bytes) -> tuple[str, bool, int]:
    """Take apart what stands in $MeshFormat: version 2.2 or 4.1, text?, bytes of a count."""
    header = _HEADER.match(body)
    if not header:
        raise UnreadableError("there is no header $MeshFormat in it")
    version, text, size = header[1].decode(errors="replace"), header[2] == b"0", int(header[3])
    version = {"2": "2.2", "2.0": "2.2", "2.1": "2.2", "4": "4.0"}.get(version, version)
    if version not in ("2.2", "4.1"):
        raise UnreadableError(f"Gmsh format {version} is not supported: save it as 4.1 or 2.2")
    if not text and body[header.end() : header.end() + 4] != b"\1\0\0\0":
        raise UnreadableError("it is binary in big-endian order: save it as text")
    if size not in (4, 8):
        raise UnreadableError(f"its numbers have {size} bytes")
    return version, text, size


def _sections(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Go through the sections of a file: name, and what stands in it."""
    at = 0
    while match := _SECTION.search(data, at):
        stop = data.find(b"$End" + match[1], match.end())
        if stop < 0:
            raise UnreadableError(f"the section ${match[1].decode()} has no end")
        yield match[1].decode(), data[match.end() : stop]
        at = stop + len(match[1]) + 4


def _read_names(body: bytes) -> dict[str, tuple[int, int]]:
    names: dict[str, tuple[int, int]] = {}
    for dimension, tag, name in _NAME.findall(body):
        key = name.decode(errors="surrogateescape")
        if key in names:
            log.warning("the second physical group named %r is left without a name", key)
        else:
            names[key] = (int(tag), int(dimension))
    return names


def _read_entities(section: _Numbers) -> Entities:
    entities = {}
    several = 0
    for dimension, count in enumerate(section.take("size", 4)):
        for _ in range(count):
            tag = section.one("int")
            section.take("real", 6 if dimension else 3)  # the bounding box
            physical = section.take("int", section.one("size"))
            bounds = section.take("int", section.one("size")) if dimension else physical[:0]
            first = int(physical[0]) if len(physical) else 0
            entities[dimension, tag] = Entity(first, bounds if len(bounds) else None)
            several += len(physical) > 1
    if several:
        log.warning("%d entities are in several physical groups: only the first is kept", several)
    return entities


def _read_nodes_22(body: bytes, text: bool) -> tuple[Array, Array]:
    n, body = _first_line(body)
    row = np.dtype([("tag", "<i4"), ("x", "<f8", (3,))])
    if text:
        values = numbers(body, float)
        if len(values) != 4 * n:
            raise UnreadableError(f"{n} nodes are announced, and {len(values) // 4} found")
        rows = values.reshape(n, 4)
        return rows[:, 0].astype(np.int64), rows[:, 1:]
    if not 0 <= n * row.itemsize <= len(body):
        raise UnreadableError("it ends in the middle of a section")
    records = np.frombuffer(body, row, n)
    return records["tag"].astype(np.int64), records["x"]


def _read_nodes_41(section: _Numbers) -> tuple[Array, Array, Array]:
    n_blocks, n, _, _ = section.take("size", 4)
    tags, points, dim_tags = [np.empty(0, np.int64)], [np.empty((0, 3))], [np.empty((0, 2), int)]
    for _ in range(n_blocks):
        dimension, tag, parametric = (int(number) for number in section.take("int", 3))
        if dimension not in range(4):
            raise UnreadableError(f"an entity has dimension {dimension}")
        count = section.one("size")
        tags.append(section.take("size", count))
        width = 3 + (dimension if parametric else 0)
        points.append(section.take("real", count * width).reshape(count, width)[:, :3])
        dim_tags.append(np.tile(np.array([dimension, tag]), (count, 1)))
    if sum(map(len, tags)) != n:
        raise UnreadableError(f"{n} nodes are announced, and {sum(map(len, tags))} found")
    return np.concatenate(tags), np.concatenate(points), np.concatenate(dim_tags)


def _read_elements_41(section: _Numbers, entities: Entities) -> list[_Run]:
    n_blocks, n, _, _ = section.take("size", 4)
    with_physical = any(entity.physical for entity in entities.values())
    runs = []
    for _ in range(n_blocks):
        dimension, tag, code = (int(number) for number in section.take("int", 3))
        count = section.one("size")
        width = 1 + n_nodes_of(_type(code))
        rows = section.take("size", count * width).reshape(count, width)
        entity = entities.get((dimension, tag), Entity())
        data = {GEOMETRICAL: np.full(count, tag)}
        if with_physical:
            data[PHYSICAL] = np.full(count, entity.physical)
        runs.append(_Run(_type(code), rows[:, 0], rows[:, 1:], data, entity.bounds))
    if sum(len(run.tags) for run in runs) != n:
        raise UnreadableError(f"{n} elements are announced, and another number found")
    return runs


def _read_elements_22(body: bytes, text: bool) -> list[_Run]:
    n, body = _first_line(body)
    found = list(_runs_of_text(numbers(body, int), n) if text else _runs_of_binary(body, n))
    n_tags = max((rows.shape[1] - 1 - n_nodes_of(kind) for kind, rows in found), default=0)
    if n_tags > 2:
        log.warning("the partitions of the elements in the Gmsh file are dropped")
    runs = []
    for kind, group in groupby(found, key=itemgetter(0)):
        n_nodes = n_nodes_of(kind)
        parts = [rows for _, rows in group]  # they differ in the count of tags
        pairs = np.zeros((sum(map(len, parts)), 2), np.int64)
        start = 0
        for rows in parts:
            tags = rows[:, 1:-n_nodes][:, :2]
            pairs[start : start + len(rows), : tags.shape[1]] = tags
            start += len(rows)
        data = {name: pairs[:, i] for i, name in enumerate((PHYSICAL, GEOMETRICAL)[:n_tags])}
        numbers_of = np.concatenate([rows[:, 0] for rows in parts])
        nodes = np.concatenate([rows[:, -n_nodes:] for rows in parts])
        runs.append(_Run(kind, numbers_of, nodes, data))
    return runs


def _runs_of_text(values: Array, n: int) -> Iterator[tuple[str, Array]]:
    """Cut a list of elements into runs of one type and count of tags.

    Every element says how long it is: so look at some as if they were like the
    first, at more if they are, and stop at the first that is not.
    """
    at = done = 0
    while done < n:
        if at + 3 > len(values):
            raise UnreadableError(f"{n} elements are announced, and {done} found")
        code, n_tags = values[at + 1], values[at + 2]
        kind = _type(int(code))
        width = 3 + int(n_tags) + n_nodes_of(kind)
        if n_tags < 0 or at + width > len(values):
            raise UnreadableError(f"{n} elements are announced, and {done} found")
        look = 64
        while True:
            rows = values[at : at + min(look, n - done) * width]
            rows = rows[: len(rows) // width * width].reshape(-1, width)
            same = (rows[:, 1] == code) & (rows[:, 2] == n_tags)
            alike = len(rows) if same.all() else int(same.argmin())
            if alike < look:
                break
            look *= 4
        yield kind, np.delete(rows[:alike], (1, 2), axis=1)
        at, done = at + alike * width, done + alike


def _runs_of_binary(body: bytes, n: int) -> Iterator[tuple[str, Array]]:
    section, done = _Numbers(body, text=False, real=False), 0
    while done < n:
        code, count, n_tags = (int(number) for number in section.take("int", 3))
        width = 1 + n_tags + n_nodes_of(_type(code))
        if count < 1 or n_tags < 0:
            raise UnreadableError(f"{n} elements are announced, and {done} found")
        yield _type(code), section.take("int", count * width).reshape(count, width)
        done += count


def _read_view(body: bytes, text: bool) -> tuple[str, Array, Array]:
    """Read $NodeData or $ElementData: name, numbers of its rows, and values."""
    lists: list[list[bytes]] = []
    for _ in range(3):  # texts, reals, integers
        count, body = _first_line(body)
        *lines, body = body.split(b"\n", count)
        lists.append(lines)
    (name, *_), (_, width, n, *_) = lists[0] or [b"view"], map(int, lists[2])
    if text:
        rows = numbers(body, float).reshape(n, 1 + width)
        tags, values = rows[:, 0].astype(np.int64), rows[:, 1:]
    else:
        records = np.frombuffer(body, [("tag", "<i4"), ("value", "<f8", (width,))], n)
        tags, values = records["tag"].astype(np.int64), records["value"]
    values = values[:, 0] if width == 1 else values
    return name.strip().strip(b'"').decode(errors="surrogateescape"), tags, values


def _first_line(body: bytes) -> tuple[int, bytes]:
    line, _, rest = body.partition(b"\n")
    return int(line), rest


def _type(code: int) -> str:
    if code not in TYPES:
        raise UnreadableError(f"elements of type {code} are not supported")
    return TYPES[code]


def _cells(run: _Run, tags: Array) -> Array:
    cells = _positions(tags, run.nodes)
    return cells[:, ORDER[run.type]] if run.type in ORDER else cells


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
