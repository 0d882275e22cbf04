"""Medit's `.mesh` (text) and `.meshb` (binary).

Binary is read by meshio, once the sections are taken out that it refuses or discards, which
`medit_lists` looks after. Text is taken apart here: meshio wants each count on a line of its
own, knows versions 1 and 2 only, rounds large references in version 1, and is slow.

Both are written here. Of binary, meshio has versions 3 and 4 only, so that a file would
lose its version, and single precision with it; text it formats row by row.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array, Block, Mesh
from ..mesh.tags import REF
from . import medit_lists
from .bridge import from_meshio, silent
from .sniff import Encoding, UnreadableError
from .streams import copied
from .text import lines, rows_of

# section, its code in binary files, and nodes of each type of cell
_CELLS = {
    "line": ("Edges", 5, 2),
    "triangle": ("Triangles", 6, 3),
    "quad": ("Quadrilaterals", 7, 4),
    "tetra": ("Tetrahedra", 8, 4),
    "wedge": ("Prisms", 9, 6),
    "hexahedron": ("Hexahedra", 10, 8),
    "pyramid": ("Pyramids", 49, 5),
    "line3": ("EdgesP2", 25, 3),
    "triangle6": ("TrianglesP2", 24, 6),
    "tetra10": ("TetrahedraP2", 30, 10),
}
NAMES = {cell_type: name for cell_type, (name, _, _) in _CELLS.items()}
CODES = {cell_type: code for cell_type, (_, code, _) in _CELLS.items()}
_CURVED = {code: cell_type for cell_type, code in CODES.items() if cell_type not in FAMILIES}
# Sections of other cells with nodes besides corners, and of orders of their nodes.
_OTHER_CELLS = re.compile(r"[A-Z][a-z]+[PQ][0-9]+(Ordering)?")

_DIMENSION, _VERTICES, _END = 3, 4, 54
_LAST = "End"
_TYPES = {name: cell_type for cell_type, name in NAMES.items()}
_TYPES["Hexaedra"] = "hexahedron"  # as some programs spell it
# bamg counts its versions from 0
_VALUES = {"MeshVersionFormatted": (b"0", b"1", b"2", b"3", b"4"), "Dimension": (b"2", b"3")}
_KEYWORD = re.compile(rb"[A-Z][A-Za-z]{2,}\w*")


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a mesh, with references as "medit:ref", and what of its file is left out.

    Vertex numbers start from 0 and are otherwise as the file has them: a 0 in it is a -1.
    """
    mesh, lists, dropped = (_read_binary if encoding.binary else _read_text)(data)
    if encoding.version == "1":
        mesh.points = mesh.points.astype(np.float32)
    return mesh, dropped + medit_lists.attach(mesh, lists)


# A mesh, the sections of `medit_lists` in the file, and the names of those left out.
_Parts = tuple[Mesh, dict[str, Array], list[str]]


def _read_text(data: bytes) -> _Parts:
    mesh = Mesh(np.empty((0, 0)), [])
    lists: dict[str, Array] = {}
    dropped = []
    values: dict[str, int] = {}
    ended, name = False, ""
    for name, content in sections(data):
        if name == _LAST:
            ended = True
            break
        count, rows = [*content.split(None, 1), b"", b""][:2]
        if name in _VALUES:
            if count not in _VALUES[name]:
                raise UnreadableError(f"{name} {count.decode(errors='replace')} is not supported")
            values[name] = int(count)
        elif name == "Vertices" or name in _TYPES or name in medit_lists.SECTIONS:
            if len(values) < len(_VALUES):
                raise UnreadableError(f"{name} comes before {' and '.join(_VALUES)}")
            dimension = values["Dimension"]
            n = int(count)
            if name == "Vertices":
                table = rows_of(name, rows, n, np.float64, dimension + 1)
                mesh.points = np.ascontiguousarray(table[:, :dimension])
                mesh.point_data[REF] = table[:, dimension].astype(np.int64)
            elif name in _TYPES:
                table = rows_of(name, rows, n, np.int64, _CELLS[_TYPES[name]][2] + 1)
                mesh.blocks.append(Block(_TYPES[name], table[:, :-1] - 1, {REF: table[:, -1]}))
            elif n:
                kind = np.float64 if medit_lists.kind_of(name) == "f" else np.int64
                width = medit_lists.width_of(name, dimension)
                lists[name] = rows_of(name, rows, n, kind, width)
        elif count != b"0":
            dropped.append(_left_out(name))
    if REF not in mesh.point_data:
        raise UnreadableError("there are no Vertices in it")
    if not ended:  # as some programs leave it
        dropped.append(f"what follows {name}, if anything: the file may be cut off, without End")
    return mesh, lists, dropped


def _left_out(name: str) -> str:
    """The name of a section that is not read, if the mesh is a mesh without it."""
    if _OTHER_CELLS.fullmatch(name):
        raise UnreadableError(f"{name} are not supported: save it with cells of first order")
    return name


def sections(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Go through a text: keywords, and what follows each."""
    if b"#" in data or b'"' in data:  # comments and names of other files
        data = re.sub(rb"#[^\r\n]*|\"[^\"\r\n]*\"", b"", data)
    # Letters are rare in it: they are looked for all at once.
    letters = np.frombuffer(data, np.uint8)
    capital = (letters >= ord("A")) & (letters <= ord("Z"))
    capital[:-1] &= letters[1:] >= ord("A")
    capital[1:] &= letters[:-1] < ord("A")
    found = (_KEYWORD.match(data, at) for at in np.flatnonzero(capital).tolist())
    words = [m for m in found if m and m[0][:3].lower() not in (b"nan", b"inf")]
    ends = [word.start() for word in words[1:]] + [len(data)]
    for word, end in zip(words, ends, strict=True):
        yield word[0].decode(), data[word.end() : end]


def _read_binary(data: bytes) -> _Parts:
    import meshio.medit

    plain, curved, lists, dropped = _plain_binary(data)
    # meshio goes by the last letter of a name
    with copied(plain, "mesh.meshb") as copy, silent():
        mesh = from_meshio(meshio.medit.read(copy))
    mesh.blocks += [Block(kind, rows[:, :-1] - 1, {REF: rows[:, -1]}) for kind, rows in curved]
    for data_of in (mesh.point_data, *(block.data for block in mesh.blocks)):
        data_of[REF] = data_of[REF].astype(np.int64)
    return mesh, lists, dropped


def _plain_binary(
    data: bytes,
) -> tuple[bytes, list[tuple[str, Array]], dict[str, Array], list[str]]:
    """Keep what meshio can read; each section says where the next starts.

    Cells of second order are rows of nodes from 1 and a reference, by their type.
    """
    from meshio.medit._medit_internal import medit_codes

    order = "<" if data[:4] == b"\1\0\0\0" else ">"
    _, version = struct.unpack_from(order + "ii", data)
    head = struct.Struct(order + ("ii" if version < 3 else "iq"))
    kinds = {"f": order + ("f4" if version == 1 else "f8")}
    kinds["i"] = order + ("i8" if version == 4 else "i4")
    size = int(kinds["i"][-1])
    at, plain, dimension = 8, [data[:8]], 3
    lists: dict[str, Array] = {}
    dropped: list[str] = []
    curved: list[tuple[str, Array]] = []

    def count_of(name: str, start: int, after: int, row: int) -> int:
        """How many rows of so many bytes a section has, which must end where the next starts."""
        found = np.frombuffer(data[start:after], kinds["i"], min(1, (after - start) // size))
        count = int(found[0]) if len(found) else -1
        if not 0 <= count * row <= after - start - size:
            there = max(after - start - size, 0)
            raise UnreadableError(f"{name} should have {count} rows, and has {there} bytes")
        return count

    def table(name: str, kind: str, width: int, start: int, after: int) -> Array:
        count = count_of(name, start, after, width * int(kinds[kind][-1]))
        rows = np.frombuffer(data, kinds[kind], count * width, start + size)
        return rows.astype(kind + "8").reshape(count, width)

    while at + head.size <= len(data):
        code, after = head.unpack_from(data, at)
        if code == _END:
            return b"".join([*plain, data[at:]]), curved, lists, dropped
        if not at < after <= len(data):
            break
        start, name = at + head.size, medit_lists.CODES.get(code, "")
        if code in _CURVED:
            kind = _CURVED[code]
            rows = table(_CELLS[kind][0], "i", _CELLS[kind][2] + 1, start, after)
            curved.append((kind, rows))
        elif code in (_DIMENSION, _VERTICES, *CODES.values()):
            if code == _DIMENSION:
                (dimension,) = struct.unpack_from(order + "i", data, start)
                if dimension not in (2, 3):
                    raise UnreadableError(f"Dimension {dimension} is not supported")
                end = start + 4
            else:
                row = dimension * int(kinds["f"][-1]) + size
                title = "Vertices"
                if code != _VERTICES:
                    title, _, n_nodes = next(row for row in _CELLS.values() if row[1] == code)
                    row = (n_nodes + 1) * size
                end = start + size + row * count_of(title, start, after, row)
            # Without what may lie between its rows and the next section: meshio goes on there.
            plain.append(data[at:end])
        elif name:
            width = medit_lists.width_of(name, dimension)
            rows = table(name, medit_lists.kind_of(name), width, start, after)
            if len(rows):
                lists[name] = rows
        elif any(data[start : start + 4]):  # the count of its rows
            dropped.append(_left_out(medit_codes.get(code, (f"Gmf{code}",))[0][3:]))
        at = after
    raise UnreadableError("it ends in the middle of a section")


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh, whose blocks have types out of `CODES`, with references and lists."""
    refs = mesh.point_data.get(REF, np.zeros(len(mesh.points), np.int64))
    lists = medit_lists.pick(mesh.point_data)
    whole = Mesh(mesh.points, _one_a_type(mesh.blocks), {REF: refs, **lists})
    version = 1 if mesh.points.dtype == np.float32 else max(2, int(encoding.version))
    (_write_binary if encoding.binary else _write_text)(path, whole, version)


def _one_a_type(blocks: list[Block]) -> list[Block]:
    """Join the blocks of each type, since readers look at one section of a name only."""
    joined = []
    for cell_type in dict.fromkeys(block.type for block in blocks):
        same = [block for block in blocks if block.type == cell_type]
        names = dict.fromkeys([REF, *(name for b in same for name in medit_lists.pick(b.data))])
        data = {
            name: np.concatenate([b.data.get(name, np.zeros(len(b.cells), np.int64)) for b in same])
            for name in names
        }
        joined.append(Block(cell_type, np.concatenate([b.cells for b in same]), data))
    return joined


def _write_text(path: Path, mesh: Mesh, version: int) -> None:
    n, dimension = mesh.points.shape
    with path.open("wb") as stream:
        stream.write(f"MeshVersionFormatted {version}\nDimension {dimension}\n".encode())
        stream.write(f"\nVertices\n{n}\n".encode())
        stream.writelines(lines(mesh.points, mesh.point_data[REF]))
        for block in mesh.blocks:
            stream.write(f"\n{NAMES[block.type]}\n{len(block.cells)}\n".encode())
            stream.writelines(lines(block.cells + 1, block.data[REF]))
        for name, _, rows in medit_lists.sections_of(mesh):
            stream.write(f"\n{name}\n{len(rows)}\n".encode())
            stream.writelines(lines(rows))
        stream.write(b"\nEnd\n")


def _write_binary(path: Path, mesh: Mesh, version: int) -> None:
    """Write version 1 (32-bit reals), 2, 3 (positions of 64 bits) or 4 (integers too)."""
    columns = [mesh.point_data[REF], *(block.data[REF] for block in mesh.blocks)]
    if any(len(c) and max(c.max(), -c.min()) >= 1 << 31 for c in columns):
        version = 4
    if 8 * mesh.points.size + 40 * sum(len(block.cells) for block in mesh.blocks) > 1 << 30:
        version = max(3, version)
    real, integer = "<f4" if version == 1 else "<f8", "<i8" if version == 4 else "<i4"
    n, dimension = mesh.points.shape
    vertices = np.empty(n, [("x", real, (dimension,)), ("ref", integer)])
    vertices["x"], vertices["ref"] = mesh.points, mesh.point_data[REF]
    sections: list[tuple[int, Array]] = [(_VERTICES, vertices)]
    for block in mesh.blocks:
        rows = np.column_stack([block.cells + 1, block.data[REF]]).astype(integer)
        sections.append((CODES[block.type], rows))
    for _, code, rows in medit_lists.sections_of(mesh):
        sections.append((code, rows.astype(real if rows.dtype.kind == "f" else integer)))
    head = struct.Struct("<ii" if version < 3 else "<iq")
    with path.open("wb") as stream:
        stream.write(struct.pack("<ii", 1, version))
        stream.write(head.pack(_DIMENSION, 8 + head.size + 4) + struct.pack("<i", dimension))
        for code, rows in sections:
            count = np.array(len(rows), integer).tobytes()
            after = stream.tell() + head.size + len(count) + rows.nbytes
            stream.write(head.pack(code, after) + count + rows.tobytes())
        stream.write(head.pack(_END, 0))
