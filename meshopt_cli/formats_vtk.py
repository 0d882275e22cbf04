"""What `formats.py` needs to know of VTK's formats beyond what meshio does.

meshio reads and writes the format without XML, once it knows the names of numbers,
and reads VTU, which is written here: meshio prints reals with twelve digits.
"""

from __future__ import annotations

import base64
import html
import re
import sys
import zlib
from collections.abc import Mapping
from typing import BinaryIO

import numpy as np

from .formats_text import UnreadableError, write_rows
from .mesh import Array, Mesh

# VTK's names of numbers; a vtkIdType is written with 32 bits in this format
NUMBERS = {
    "char": "int8",
    "signed_char": "int8",
    "unsigned_char": "uint8",
    "short": "int16",
    "unsigned_short": "uint16",
    "int": "int32",
    "unsigned_int": "uint32",
    "long": "int64",
    "unsigned_long": "uint64",
    "vtktypeint64": "int64",
    "vtktypeuint64": "uint64",
    "vtkidtype": "int32",
}
# those to write in version 5.1, where VTK does not know meshio's vtktypeint32
WRITTEN = {kind: name for name, kind in NUMBERS.items() if name != "vtkidtype"}

# attributes that meshio does not know, and others that are written in the same way
_ATTRIBUTES = {
    b"NORMALS": (rb"^NORMALS[ \t]", rb"VECTORS "),
    b"_IDS": (
        rb"^(?:GLOBAL|PEDIGREE)_IDS[ \t]+(\S+)[ \t]+(\S+)[^\n]*",
        rb"SCALARS \1 \2 1\nLOOKUP_TABLE default",
    ),
    b"TEXTURE_COORDINATES": (
        rb"^TEXTURE_COORDINATES[ \t]+(\S+)[ \t]+(\d)[ \t]+(\S+)[^\n]*",
        rb"SCALARS \1 \3 \2\nLOOKUP_TABLE default",
    ),
}

BLOCK = 1 << 15
_KINDS = {"f": "Float", "i": "Int", "u": "UInt"}
_WEDGE = [0, 2, 1, 3, 5, 4]  # VTK looks at the triangles from the other side


def plain_vtk(data: bytes) -> bytes:
    """Rewrite a file without XML so that meshio knows all the attributes in it."""
    for word, (attribute, known) in _ATTRIBUTES.items():
        if word in data:
            data = re.sub(attribute, known, data, flags=re.MULTILINE)
    return data


def n_cells_vtk(data: bytes) -> int | None:
    """Count of cells that a file without XML announces, if it does."""
    at = data.find(b"\nCELL_TYPES")
    count = re.match(rb"\nCELL_TYPES[ \t]+(\d+)", data[at : at + 80]) if at >= 0 else None
    return int(count[1]) if count else None


def plain_vtu(data: bytes) -> bytes:
    """Rewrite a file so that meshio accepts its version: they differ in polyhedra only."""
    return re.sub(rb'(<VTKFile\b[^>]*\bversion=")[^"]*', rb"\g<1>1.0", data, count=1)


def n_cells_vtu(data: bytes) -> int | None:
    """Count of cells that a file announces, if it does.

    Raises
    ------
    UnreadableError
        The file is one of those that meshio reads wrongly or not at all.
    """
    counts = re.findall(rb'<Piece\b[^>]*\bNumberOfCells\s*=\s*["\']\s*(\d+)', data)
    if len(counts) > 1:
        raise UnreadableError("it has several pieces: merge them")
    if counts == [b"0"]:
        raise UnreadableError("it has no cells")
    if b'compressor="vtkLZ4DataCompressor"' in data[:4096]:
        raise UnreadableError("LZ4 compression is not supported: save it with ZLib or without")
    return int(counts[0]) if counts else None


def write_vtu(
    stream: BinaryIO,
    mesh: Mesh,
    types: Mapping[str, int],
    version: str,
    *,
    binary: bool,
    compressed: bool,
) -> None:
    """Write a mesh as VTU.

    Parameters
    ----------
    stream : binary file
    mesh : Mesh
        In it, points have three coordinates and all blocks the same arrays.
    types : mapping of str to int
        VTK's number of each type of cell.
    version : "0.1" or "1.0"
        In the first, counts of bytes have 32 bits: it is for arrays below 4 GB.
    binary : bool
        False for text.
    compressed : bool
        With zlib, if binary.
    """
    count = np.dtype(np.uint32 if version == "0.1" else np.uint64)
    how = "ascii" if not binary else "zlib" if compressed else "raw"
    n_cells = sum(len(block.cells) for block in mesh.blocks)
    sizes = [np.full(len(block.cells), block.cells.shape[1]) for block in mesh.blocks]
    kinds = [np.full(len(block.cells), types[block.type], np.uint8) for block in mesh.blocks]
    cells = [
        (block.cells[:, _WEDGE] if block.type == "wedge" else block.cells).ravel()
        for block in mesh.blocks
    ]
    none = [np.empty(0, np.int64)]

    def put(name: str, values: Array) -> None:
        _array(stream, name, np.ascontiguousarray(values), how, count)

    compressor = ' compressor="vtkZLibDataCompressor"' if how == "zlib" else ""
    stream.write(
        f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="{version}"'
        f' byte_order="{sys.byteorder.capitalize()}Endian"'
        f' header_type="UInt{8 * count.itemsize}"{compressor}>\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(mesh.points)}" NumberOfCells="{n_cells}">\n'
        "<Points>\n".encode()
    )
    put("Points", mesh.points)
    stream.write(b"</Points>\n<Cells>\n")
    put("connectivity", np.concatenate(none + cells))
    put("offsets", np.cumsum(np.concatenate(none + sizes)))
    put("types", np.concatenate([np.empty(0, np.uint8), *kinds]))
    stream.write(b"</Cells>\n<PointData>\n")
    for name, values in mesh.point_data.items():
        put(name, values)
    stream.write(b"</PointData>\n<CellData>\n")
    for name in mesh.blocks[0].data if mesh.blocks else ():
        put(name, np.concatenate([block.data[name] for block in mesh.blocks]))
    stream.write(b"</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _array(stream: BinaryIO, name: str, values: Array, how: str, count: np.dtype) -> None:
    kind = f"{_KINDS[values.dtype.kind]}{8 * values.dtype.itemsize}"
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    shape = "ascii" if how == "ascii" else "binary"
    stream.write(
        f'<DataArray type="{kind}" Name="{html.escape(name)}"{width} format="{shape}">\n'.encode()
    )
    if how == "ascii":
        columns = values.T if values.ndim == 2 else [values]
        item = "%r" if values.dtype.kind == "f" else "%d"
        write_rows(stream, " ".join([item] * len(columns)) + "\n", columns)
    elif how == "raw":
        stream.write(base64.b64encode(np.array(values.nbytes, count).tobytes() + values.tobytes()))
    else:
        raw = memoryview(values.tobytes())
        blocks = [zlib.compress(raw[at : at + BLOCK]) for at in range(0, len(raw), BLOCK)]
        header = [len(blocks), BLOCK, len(raw) % BLOCK, *map(len, blocks)]
        stream.write(base64.b64encode(np.array(header, count).tobytes()))
        stream.write(base64.b64encode(b"".join(blocks)))
    stream.write(b"\n</DataArray>\n")
