"""Writes VTK's files, without XML (`.vtk`) and with it (`.vtu`), such that others read them too.

meshio knows fewer names of numbers than VTK, and none of VTK's for integers of less than 64 bits
from version 5 on, which stay as VTK has them.
"""

from __future__ import annotations

import base64
import html
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...mesh.model import Array, Mesh
from ..sniff import Encoding
from ..text import lines
from .arrays import KINDS
from .cells import NUMBERS, ORDER

VTU_VERSIONS = ("0.1", "1.0")  # that can be written: later ones differ in other cells only
VTK_VERSIONS = ("2.0", "3.0", "4.0", "4.1", "4.2", "5.1")

_BLOCK = 1 << 15  # bytes that are compressed at a time, as VTK does
_LEVEL = 4  # of compression
_NAMES = {"i1": "char", "u1": "unsigned_char", "i2": "short", "u2": "unsigned_short"}
_NAMES |= {"i4": "int", "u4": "unsigned_int", "f4": "float", "f8": "double"}
_NAMES_OF_64 = {"4": {"i8": "long", "u8": "unsigned_long"}}
_NAMES_OF_64["5"] = {"i8": "vtktypeint64", "u8": "vtktypeuint64"}
_XML_NAMES = {code: name for name, code in KINDS.items()}


def _code(values: Array) -> str:
    """Kind and size of the numbers, "f8": reals of other sizes are written as these."""
    if values.dtype == bool:
        return "u1"
    if values.dtype.kind == "f" and values.dtype.itemsize not in (4, 8):
        return "f8"
    return f"{values.dtype.kind}{values.dtype.itemsize}"


def number_type(values: Array) -> str:
    """What a file with XML calls the numbers of an array: "Float64"."""
    return _XML_NAMES[_code(values)]


def vertices_of(mesh: Mesh) -> list[Array]:
    """The cells of each block, in VTK's order of their vertices."""
    orders = [ORDER.get(NUMBERS[block.type]) for block in mesh.blocks]
    return [
        block.cells if order is None else block.cells[:, order]
        for block, order in zip(mesh.blocks, orders, strict=True)
    ]


def _of_all(mesh: Mesh, values: list[int], kind: str) -> Array:
    """A value for each cell, given those of the blocks."""
    return np.repeat(np.array(values, kind), [len(block.cells) for block in mesh.blocks])


def ends_of(mesh: Mesh) -> Array:
    """Where each cell ends in the row of all vertices."""
    return np.cumsum(_of_all(mesh, [block.cells.shape[1] for block in mesh.blocks], "i8"))


def types_of(mesh: Mesh, kind: str) -> Array:
    return _of_all(mesh, [NUMBERS[block.type] for block in mesh.blocks], kind)


def cell_data_of(mesh: Mesh) -> dict[str, Array]:
    """The arrays of all cells: every block has the same."""
    names = mesh.blocks[0].data if mesh.blocks else {}
    return {name: np.concatenate([b.data[name] for b in mesh.blocks]) for name in names}


def in_a_row(parts: list[Array]) -> Array:
    return np.concatenate([part.ravel() for part in parts]) if parts else np.empty(0, np.int64)


def write_vtk(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a file without XML; names in the mesh have no blanks.

    Versions below 5 differ in their first line only, as far as meshes go.
    """
    # meshio does not read version 5 without cells
    new = encoding.version >= "5" and bool(mesh.blocks)
    version = encoding.version if encoding.version in VTK_VERSIONS else "4.2"
    if new != (version >= "5"):
        version = "5.1" if new else "4.2"
    with path.open("wb") as stream:
        legacy = _Legacy(stream, encoding.binary, version)
        legacy.mesh(mesh)
        legacy.fields(mesh.fields)  # where Gmsh does not look, which stops at them
        legacy.data("CELL_DATA", sum(len(b.cells) for b in mesh.blocks), cell_data_of(mesh))
        legacy.data("POINT_DATA", len(mesh.points), mesh.point_data)


class _Legacy:
    """Writes the sections of a file without XML."""

    def __init__(self, stream: BinaryIO, binary: bool, version: str):
        self.stream = stream
        self.binary = binary
        self.names = _NAMES | _NAMES_OF_64["4" if version < "5" else "5"]
        self.new = version >= "5"
        kind = "BINARY" if binary else "ASCII"
        self.say(f"# vtk DataFile Version {version}\nwritten by meshopt\n{kind}")
        self.say("DATASET UNSTRUCTURED_GRID")

    def say(self, line: str) -> None:
        self.stream.write(f"{line}\n".encode())

    def numbers(self, *parts: Array) -> None:
        """Rows of numbers, one array after another."""
        for part in parts:
            if self.binary:
                self.stream.write(part.astype(f">{_code(part)}").tobytes())
            elif part.size:
                self.stream.writelines(lines(part))
        if self.binary:
            self.stream.write(b"\n")

    def mesh(self, mesh: Mesh) -> None:
        """Points and cells."""
        self.say(f"POINTS {len(mesh.points)} {self.names[_code(mesh.points)]}")
        self.numbers(mesh.points)
        vertices = vertices_of(mesh)
        n, size = sum(map(len, vertices)), sum(part.size for part in vertices)
        if self.new:
            self.say(f"CELLS {n + 1} {size}\nOFFSETS vtktypeint64")
            self.numbers(np.append(0, ends_of(mesh)))
            self.say("CONNECTIVITY vtktypeint64")
            self.numbers(*vertices)
        else:
            self.say(f"CELLS {n} {n + size}")
            counted = (np.insert(part, 0, part.shape[1], axis=1) for part in vertices)
            self.numbers(*(part.astype(np.int32) for part in counted))
        self.say(f"CELL_TYPES {n}")
        self.numbers(types_of(mesh, "i4"))

    def data(self, keyword: str, n: int, arrays: dict[str, Array]) -> None:
        """The arrays of points, or of cells."""
        if arrays:
            self.say(f"{keyword} {n}")
            self.fields(arrays)

    def fields(self, arrays: dict[str, Array]) -> None:
        """Arrays with their names, types and sizes."""
        if not arrays:
            return
        self.say(f"FIELD FieldData {len(arrays)}")
        for name, values in arrays.items():
            width = values.shape[1] if values.ndim == 2 else 1
            self.say(f"{name} {width} {len(values)} {self.names[_code(values)]}")
            self.numbers(values)


def write_vtu(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a file with XML: version 0.1 has counts of 32 bits, 1.0 those of 64."""
    says = f'version="{encoding.version}" byte_order="LittleEndian"'
    if encoding.version != "0.1":
        says += ' header_type="UInt64"'
    if encoding.compressed:
        says += ' compressor="vtkZLibDataCompressor"'
    n = sum(len(block.cells) for block in mesh.blocks)
    cells = {"connectivity": in_a_row(vertices_of(mesh)), "offsets": ends_of(mesh)}
    cells["types"] = types_of(mesh, "u1")
    sections = {"Points": {"Points": mesh.points}, "Cells": cells}
    sections |= {"PointData": mesh.point_data, "CellData": cell_data_of(mesh)}
    with path.open("wb") as stream:
        stream.write(f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" {says}>\n'.encode())
        stream.write(b"<UnstructuredGrid>\n")
        if mesh.fields:
            stream.write(b"<FieldData>\n")
            for name, values in mesh.fields.items():
                rows = f' NumberOfTuples="{len(values)}"'
                stream.writelines(_data_array(name, values, encoding, rows))
            stream.write(b"</FieldData>\n")
        stream.write(f'<Piece NumberOfPoints="{len(mesh.points)}" NumberOfCells="{n}">\n'.encode())
        for tag, arrays in sections.items():
            stream.write(f"<{tag}>\n".encode())
            for name, values in arrays.items():
                stream.writelines(_data_array(name, values, encoding))
            stream.write(f"</{tag}>\n".encode())
        stream.write(b"</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _data_array(
    name: str, values: Array, encoding: Encoding, attributes: str = ""
) -> Iterator[bytes]:
    said = html.escape(name).encode("ascii", "xmlcharrefreplace").decode()
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    form = "binary" if encoding.binary else "ascii"
    kind = number_type(values)
    yield f'<DataArray type="{kind}" Name="{said}"{width}{attributes} format="{form}">\n'.encode()
    if not encoding.binary:
        yield from lines(values) if values.size else ()
    else:
        head = np.dtype("<u4" if encoding.version == "0.1" else "<u8")
        packed = values.astype(f"<{_code(values)}", copy=False).tobytes()
        if encoding.compressed:
            blocks = [
                zlib.compress(packed[at : at + _BLOCK], _LEVEL)
                for at in range(0, len(packed), _BLOCK)
            ]
            sizes = [len(blocks), _BLOCK, len(packed) % _BLOCK, *map(len, blocks)]
            yield base64.b64encode(np.array(sizes, head).tobytes())
            packed = b"".join(blocks)
        else:
            packed = np.array([len(packed)], head).tobytes() + packed
        yield base64.b64encode(packed) + b"\n"
    yield b"</DataArray>\n"
