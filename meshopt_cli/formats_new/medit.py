"""Medit's `.mesh` (text) and `.meshb` (binary).

Both are read by meshio, once the sections are taken out that it refuses, like
RequiredEdges, or of which it reads no more than the name. In text its reader also wants
each count on a line of its own, knows versions 1 and 2 only, and rounds large references
in version 1: so the text is set anew as one of version 2.

Text is written by meshio. Binary is written here: meshio has versions 3 and 4 only, so
that a file would lose its version, and single precision with it.
"""

from __future__ import annotations

import logging
import re
import struct
from pathlib import Path

import numpy as np

from ..mesh import Array, Block, Mesh
from .bridge import copy_of, from_meshio, listening, to_meshio
from .sniff import Encoding, UnreadableError

log = logging.getLogger("meshopt")

REF = "medit:ref"
# code in binary files of each type of cell, by its name in a Block
CODES = {
    "line": 5,
    "triangle": 6,
    "quad": 7,
    "tetra": 8,
    "wedge": 9,
    "hexahedron": 10,
    "pyramid": 49,
}
_DIMENSION, _VERTICES, _END = 3, 4, 54
_SECTIONS = (
    "Vertices",
    "Edges",
    "Triangles",
    "Quadrilaterals",
    "Tetrahedra",
    "Prisms",
    "Hexahedra",
    "Hexaedra",  # as some programs spell it
    "Pyramids",
)
_VERSION = "MeshVersionFormatted"
_ONE_OF = {_VERSION: (b"1", b"2", b"3", b"4"), "Dimension": (b"2", b"3")}
_KEYWORD = re.compile(rb"[A-Za-z]{3,}\w*")  # an exponent is one letter
_NO_KEYWORDS = (b"nan", b"inf", b"infinity")


def read(path: Path, data: bytes, encoding: Encoding) -> Mesh:
    """Read a mesh.

    Returns
    -------
    Mesh
        References of vertices and cells are "medit:ref". Vertex numbers start from 0 and
        are otherwise as the file has them, so a 0 in it is a -1 here.
    """
    import meshio.medit

    plain, dropped = _plain_binary(data) if encoding.binary else _plain_text(data)
    if dropped:
        log.warning("the sections %s of the Medit file are dropped", ", ".join(dropped))
    # meshio goes by the last letter
    with copy_of(plain, "b" if encoding.binary else "a") as copy, listening(logging.WARNING):
        mesh = from_meshio(meshio.medit.read(copy))
    if encoding.version == "1":
        mesh.points = mesh.points.astype(np.float32)
    return mesh


def _plain_text(data: bytes) -> tuple[bytes, list[str]]:
    """Set a text anew with what meshio knows; also the names of the sections left out."""
    if b"#" in data or b'"' in data:  # comments and names of other files
        data = re.sub(rb"#[^\r\n]*|\"[^\"\r\n]*\"", b"", data)
    words = [m for m in _KEYWORD.finditer(data) if m[0].lower() not in _NO_KEYWORDS]
    ends = [word.start() for word in words[1:]] + [len(data)]
    plain, dropped = [], []
    for word, end in zip(words, ends, strict=True):
        name = word[0].decode()
        if name == "End":
            break
        count, rows = [*data[word.end() : end].split(None, 1), b"", b""][:2]
        if name in _ONE_OF:
            if count not in _ONE_OF[name] or rows:
                raise UnreadableError(f"its {name} is not one of {_numbers(_ONE_OF[name])}")
            plain.append(b"%s %s\n" % (word[0], b"2" if name == _VERSION else count))
        elif name in _SECTIONS:
            plain.append(b"%s\n%s\n%s\n" % (word[0], count, rows.replace(b"\r", b"\n")))
        elif count != b"0":
            dropped.append(name)
    else:
        log.info("the Medit file has no End: it may be truncated")
    return b"".join(plain), dropped


def _numbers(values: tuple[bytes, ...]) -> str:
    return b", ".join(values).decode()


def _plain_binary(data: bytes) -> tuple[bytes, list[str]]:
    """Do the same for a binary file, in which each section says where the next starts."""
    from meshio.medit._medit_internal import medit_codes

    order = "<" if data[:4] == b"\1\0\0\0" else ">"
    _, version = struct.unpack_from(order + "ii", data)
    if version not in (1, 2, 3, 4):
        raise UnreadableError(f"its version is {version}, not one of 1, 2, 3, 4")
    head = struct.Struct(order + ("ii" if version < 3 else "iq"))
    at, plain, dropped = 8, [data[:8]], []
    while at + head.size <= len(data):
        code, after = head.unpack_from(data, at)
        if code == _END:
            return b"".join([*plain, data[at:]]), dropped
        if not at < after <= len(data):
            break
        if code in (_DIMENSION, _VERTICES, *CODES.values()):
            plain.append(data[at:after])
        elif any(data[at + head.size : at + head.size + 4]):  # the count of its rows
            dropped.append(medit_codes.get(code, (f"Gmf{code}",))[0][3:])
        at = after
    raise UnreadableError("it ends in the middle of a section")


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh, whose blocks have types out of `CODES`, with "medit:ref" if it is there."""
    from meshio.medit import _medit

    zeros = np.zeros(len(mesh.points), np.int64)
    whole = Mesh(mesh.points, _one_a_type(mesh.blocks), {REF: mesh.point_data.get(REF, zeros)})
    single = mesh.points.dtype == np.float32
    version = 1 if single else max(2, int(encoding.version))
    if encoding.binary:
        _write_binary(path, whole, version)
        return
    with listening(logging.INFO):
        _medit.write_ascii_file(path, to_meshio(whole))
    with path.open("rb+") as stream:  # meshio writes 1 or 2, where 3 and 4 would be the same
        stream.write(f"{_VERSION} {version}".encode())


def _one_a_type(blocks: list[Block]) -> list[Block]:
    """Join the blocks of each type, since readers look at one section of a name only."""
    joined = []
    for cell_type in dict.fromkeys(block.type for block in blocks):
        same = [block for block in blocks if block.type == cell_type]
        refs = [block.data.get(REF, np.zeros(len(block.cells), np.int64)) for block in same]
        cells = np.concatenate([block.cells for block in same])
        joined.append(Block(cell_type, cells, {REF: np.concatenate(refs)}))
    return joined


def _write_binary(path: Path, mesh: Mesh, version: int) -> None:
    """Write version 1 (32-bit reals), 2, 3 (long files) or 4 (64-bit integers too)."""
    columns = [mesh.point_data[REF], *(block.data[REF] for block in mesh.blocks)]
    if any(len(c) and (c.max() >= 1 << 31 or c.min() < -(1 << 31)) for c in columns):
        version = 4
    size = 8 * mesh.points.size + 40 * sum(len(block.cells) for block in mesh.blocks)
    if size > 1 << 30:  # positions in the file may need 64 bits
        version = max(3, version)
    real, integer = "<f4" if version == 1 else "<f8", "<i8" if version == 4 else "<i4"
    n, dimension = mesh.points.shape
    vertices = np.empty(n, [("x", real, (dimension,)), ("ref", integer)])
    vertices["x"], vertices["ref"] = mesh.points, mesh.point_data[REF]
    sections: list[tuple[int, Array]] = [(_VERTICES, vertices)]
    for block in mesh.blocks:
        rows = np.column_stack([block.cells + 1, block.data[REF]]).astype(integer)
        sections.append((CODES[block.type], rows))

    head = struct.Struct("<ii" if version < 3 else "<iq")
    with path.open("wb") as stream:
        stream.write(struct.pack("<ii", 1, version))
        stream.write(head.pack(_DIMENSION, 8 + head.size + 4) + struct.pack("<i", dimension))
        for code, rows in sections:
            count = np.array(len(rows), integer).tobytes()
            after = stream.tell() + head.size + len(count) + rows.nbytes
            stream.write(head.pack(code, after) + count + rows.tobytes())
        stream.write(head.pack(_END, 0))
