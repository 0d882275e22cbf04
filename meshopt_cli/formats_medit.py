"""Medit's `.mesh` (text) and `.meshb` (binary), straight to and from a `Mesh`.

meshio is not asked, because it refuses `RequiredEdges` and the versions 3 and 4 in
text, writes one section for each block where readers look at one only, cannot
write versions 1 and 2 in binary, and formats number by number.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from .formats_text import UnreadableError, numbers, write_rows
from .mesh import Array, Block, Mesh

log = logging.getLogger("meshopt")

REF = "medit:ref"
# name in text, name in a Block, vertices, code in binary
SECTIONS = (
    ("Edges", "line", 2, 5),
    ("Triangles", "triangle", 3, 6),
    ("Quadrilaterals", "quad", 4, 7),
    ("Tetrahedra", "tetra", 4, 8),
    ("Hexahedra", "hexahedron", 8, 10),
    ("Prisms", "wedge", 6, 9),
    ("Pyramids", "pyramid", 5, 49),
)
CELL_TYPES = tuple(cell_type for _, cell_type, _, _ in SECTIONS)
_BY_NAME = {name: (cell_type, n) for name, cell_type, n, _ in SECTIONS}
_BY_NAME["Hexaedra"] = _BY_NAME["Hexahedra"]  # as some programs spell it
_BY_CODE = {code: name for name, _, _, code in SECTIONS}
_BY_TYPE = {cell_type: (name, code) for name, cell_type, _, code in SECTIONS}
_VERTICES, _DIMENSION, _END = 4, 3, 54
_OTHER_CODES = {
    13: "Corners",
    14: "Ridges",
    15: "RequiredVertices",
    16: "RequiredEdges",
    17: "RequiredTriangles",
    18: "RequiredQuadrilaterals",
    20: "NormalAtVertices",
    59: "Tangents",
    60: "Normals",
    61: "TangentAtVertices",
}
_KEYWORD = re.compile(rb"[A-Za-z]{3,}\w*")  # an exponent is one letter


def read(data: bytes, binary: bool) -> Mesh:
    """Read a Medit mesh.

    Parameters
    ----------
    data : bytes
        The whole file.
    binary : bool
        True for `.meshb`.

    Returns
    -------
    Mesh
        References of vertices and cells are "medit:ref". Vertex numbers start from
        0 and are otherwise as the file has them, so a 0 in it is a -1 here.

    Raises
    ------
    UnreadableError
        The file is truncated or malformed.
    """
    points, refs, blocks, dropped = None, None, [], []
    for name, values in _binary_sections(data) if binary else _text_sections(data):
        if name == "Vertices" and values is not None:
            points, refs = values
        elif name in _BY_NAME and values is not None:
            cells, cell_refs = values
            blocks.append(Block(_BY_NAME[name][0], cells, {REF: cell_refs}))
        else:
            dropped.append(name)
    if points is None or refs is None:
        raise UnreadableError("there are no Vertices in it")
    if dropped:
        log.warning("the sections %s of the Medit file are dropped", ", ".join(dropped))
    return Mesh(points, blocks, {REF: refs})


_Section = tuple[str, tuple[Array, Array] | None]


def _text_sections(data: bytes) -> Iterator[_Section]:
    """Go through the sections: points or cells with references, or None if dropped."""
    if b"#" in data or b'"' in data:  # comments and names of other files
        data = re.sub(rb"#[^\r\n]*|\"[^\"\r\n]*\"", b"", data)
    keywords = [
        (match[0].decode(), match.start(), match.end())
        for match in _KEYWORD.finditer(data)
        if match[0].lower() not in (b"nan", b"inf", b"infinity")
    ]
    version = dimension = 0
    for i, (name, _, start) in enumerate(keywords):
        body = data[start : keywords[i + 1][1] if i + 1 < len(keywords) else len(data)]
        if name == "End":
            return
        if name == "MeshVersionFormatted":
            version = _one_of(name, body, (1, 2, 3, 4))
        elif name == "Dimension":
            dimension = _one_of(name, body, (2, 3))
        elif name == "Vertices":
            if not version or not dimension:
                raise UnreadableError("Vertices come before MeshVersionFormatted and Dimension")
            rows = _rows(name, numbers(body, float), dimension + 1)
            real = np.float32 if version == 1 else np.float64
            yield name, (rows[:, :-1].astype(real), rows[:, -1].astype(np.int64))
        elif name in _BY_NAME:
            rows = _rows(name, numbers(body, int), _BY_NAME[name][1] + 1)
            yield name, (rows[:, :-1] - 1, rows[:, -1].copy())
        elif body.split(None, 1)[:1] != [b"0"]:
            yield name, None
    log.info("the Medit file has no End: it may be truncated")


def _one_of(name: str, body: bytes, known: tuple[int, ...]) -> int:
    values = numbers(body, int)
    if len(values) != 1 or values[0] not in known:
        raise UnreadableError(f"{name} is not one of {', '.join(map(str, known))}")
    return int(values[0])


def _rows(name: str, values: Array, width: int) -> Array:
    """Shape what stands in a section, which starts with the number of rows."""
    n = int(values[0]) if len(values) else -1
    if n < 0 or len(values) != 1 + n * width:
        raise UnreadableError(f"{name} do not hold as many numbers as they announce")
    return values[1:].reshape(n, width)


def _layout(version: int, order: str = "<") -> tuple[np.dtype, np.dtype, np.dtype]:
    """Types of real numbers, integers and positions in a binary file."""
    return (
        np.dtype(order + ("f4" if version == 1 else "f8")),
        np.dtype(order + ("i8" if version == 4 else "i4")),
        np.dtype(order + ("i4" if version < 3 else "i8")),
    )


def _binary_sections(data: bytes) -> Iterator[_Section]:
    """Do the same for a binary file, in which each section says where the next starts."""
    order = "<" if data[:4] == b"\1\0\0\0" else ">"
    code_type = np.dtype(order + "i4")
    at, dimension = 4, 0

    def take(dtype: np.dtype, count: int = 1) -> Array:
        nonlocal at
        if count < 0 or at + count * dtype.itemsize > len(data):
            raise UnreadableError("it ends in the middle of a section")
        at += count * dtype.itemsize
        return np.frombuffer(data, dtype, count, at - count * dtype.itemsize)

    version = int(take(code_type)[0])
    if version not in (1, 2, 3, 4):
        raise UnreadableError(f"version {version} is not one of 1, 2, 3, 4")
    real, integer, position = _layout(version, order)
    while True:
        code, after = int(take(code_type)[0]), int(take(position)[0])
        if code == _END:
            return
        if code == _DIMENSION:
            dimension = int(take(code_type)[0])
            if dimension not in (2, 3):
                raise UnreadableError(f"Dimension is {dimension}")
        elif code == _VERTICES:
            if not dimension:
                raise UnreadableError("Vertices come before Dimension")
            row = np.dtype([("x", real, (dimension,)), ("ref", integer)])
            rows = take(row, int(take(integer)[0]))
            x = rows["x"].astype(real.newbyteorder("="))
            yield "Vertices", (x, rows["ref"].astype(np.int64))
        elif code in _BY_CODE:
            name = _BY_CODE[code]
            width, n = _BY_NAME[name][1] + 1, int(take(integer)[0])
            rows = take(integer, n * width).reshape(n, width).astype(np.int64)
            yield name, (rows[:, :-1] - 1, rows[:, -1].copy())
        else:
            if after <= at or after > len(data):
                raise UnreadableError("it ends in the middle of a section")
            if int(take(integer)[0]):
                yield _OTHER_CODES.get(code, f"of code {code}"), None
            at = after


def write(stream: BinaryIO, mesh: Mesh, version: int, binary: bool) -> None:
    """Write a Medit mesh.

    Parameters
    ----------
    stream : binary file
    mesh : Mesh
        Its blocks have types out of `CELL_TYPES`. "medit:ref" holds the references;
        they are 0 where it is missing, and no other array is written.
    version : int
        1 (32-bit reals), 2, 3 (long files) or 4 (64-bit integers too). In text the
        numbers are the same in all but the first.
    binary : bool
        True for `.meshb`.
    """
    refs = mesh.point_data.get(REF, np.zeros(len(mesh.points), dtype=np.int64))
    if binary:
        _write_binary(stream, mesh, refs, version)
        return
    n, dimension = mesh.points.shape
    stream.write(f"MeshVersionFormatted {version}\n\nDimension {dimension}\n".encode())
    stream.write(f"\nVertices\n{n}\n".encode())
    write_rows(stream, "%r " * dimension + "%d\n", [*mesh.points.T, refs])
    for name, _, rows in _merged(mesh.blocks):
        stream.write(f"\n{name}\n{len(rows)}\n".encode())
        write_rows(stream, " ".join(["%d"] * rows.shape[1]) + "\n", rows.T)
    stream.write(b"\nEnd\n")


def _merged(blocks: list[Block]) -> Iterator[tuple[str, int, Array]]:
    """Join the blocks of a type: name, code, and rows that count from 1."""
    for cell_type in dict.fromkeys(block.type for block in blocks):
        same = [
            np.column_stack([block.cells + 1, block.data.get(REF, np.zeros(len(block.cells), int))])
            for block in blocks
            if block.type == cell_type
        ]
        yield *_BY_TYPE[cell_type], np.concatenate(same)


def _write_binary(stream: BinaryIO, mesh: Mesh, refs: Array, version: int) -> None:
    real, integer, position = _layout(version)
    code_type = np.dtype("<i4")
    at = 0

    def put(code: int, *parts: Array) -> None:
        nonlocal at
        size = sum(part.nbytes for part in parts) + code_type.itemsize + position.itemsize
        at += size
        stream.write(np.array(code, code_type).tobytes())
        stream.write(np.array(0 if code == _END else at, position).tobytes())
        for part in parts:
            stream.write(part.tobytes())

    stream.write(np.array([1, version], code_type).tobytes())
    at += 2 * code_type.itemsize
    n, dimension = mesh.points.shape
    put(_DIMENSION, np.array(dimension, code_type))
    vertices = np.empty(n, [("x", real, (dimension,)), ("ref", integer)])
    vertices["x"], vertices["ref"] = mesh.points, refs
    put(_VERTICES, np.array(n, integer), vertices)
    for _, code, rows in _merged(mesh.blocks):
        put(code, np.array(len(rows), integer), rows.astype(integer))
    put(_END)
