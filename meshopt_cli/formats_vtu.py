"""Writing of VTK's XML format for unstructured grids, `.vtu`.

meshio reads it, but prints reals with twelve digits when it writes text.
"""

from __future__ import annotations

import base64
import sys
import zlib
from collections.abc import Mapping
from typing import BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np

from .formats_text import write_rows
from .mesh import Array, Mesh

BLOCK = 1 << 15
_KINDS = {"f": "Float", "i": "Int", "u": "UInt"}
_WEDGE = [0, 2, 1, 3, 5, 4]  # VTK looks at the triangles from the other side


def write(
    stream: BinaryIO,
    mesh: Mesh,
    types: Mapping[str, int],
    version: str,
    *,
    binary: bool,
    compressed: bool,
) -> None:
    """Write a mesh.

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
        f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="{shape}">\n'.encode()
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
