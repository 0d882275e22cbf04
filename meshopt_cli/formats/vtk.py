"""VTK's files, without XML (`.vtk`) and with it (`.vtu`), read and written by meshio.

It needs help with some of VTK's names of numbers, with normals, with the later versions of
VTU, with cells of an unknown type, which it passes over, and with pairs, to which it would
add a third component. Its text in VTU has twelve digits only, so there its base64 is
spelled out as numbers.
"""

from __future__ import annotations

import base64
import logging
import re
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from ..mesh.model import Array, Mesh
from .bridge import from_meshio, listening, prepared, to_meshio
from .sniff import Encoding, UnreadableError

VTU_VERSIONS = ("0.1", "1.0")  # that meshio reads, and that can be written
VTK_VERSIONS = ("2.0", "3.0", "4.0", "4.1", "4.2", "5.1")  # that can be written

# VTK's names of numbers; a vtkIdType is written with 32 bits in this format
_NUMBERS = {"vtkidtype": "int32", "vtktypeint64": "int64", "vtktypeuint64": "uint64"}
_NUMBERS |= {"char": "int8", "signed_char": "int8", "unsigned_char": "uint8"}
for _bits, _name in ((16, "short"), (32, "int"), (64, "long")):
    _NUMBERS |= {_name: f"int{_bits}", f"unsigned_{_name}": f"uint{_bits}"}
_BASE64 = re.compile(rb'(<DataArray type="(\w+)"[^>]* format=")binary">\n([^<]*)\n')


def cell_types() -> dict[str, int]:
    """VTK's number of each type of cell, by its name in a Block."""
    from meshio._vtk_common import meshio_to_vtk_type

    return meshio_to_vtk_type


def _teach_names() -> None:
    """Teach meshio the names that VTK gives to numbers."""
    from meshio.vtk import _vtk_42, _vtk_51

    for module in (_vtk_42, _vtk_51):
        module.vtk_to_numpy_dtype_name.update(_NUMBERS)
    # VTK itself does not know the vtktypeint32 that meshio would write
    names = {kind: name for name, kind in _NUMBERS.items() if name != "vtkidtype"}
    _vtk_51.numpy_to_vtk_dtype.update(names)


def _complete(mesh: Mesh, announced: re.Match[bytes] | None) -> Mesh:
    """Refuse cells that meshio passed over, and those that are not rows of vertices."""
    if any(block.type.startswith("polyhedron") for block in mesh.blocks):
        raise UnreadableError("polyhedra are not supported")
    if announced and int(announced[1]) != sum(len(block.cells) for block in mesh.blocks):
        raise UnreadableError("it is truncated, or some of its cells are of a type not supported")
    return mesh


def read_vtk(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a file without XML, and what of it is left out."""
    import meshio.vtk

    _teach_names()
    known = data
    if b"\nNORMALS" in data:  # the same to meshio as vectors
        known = re.sub(rb"^NORMALS\b", b"VECTORS", data, flags=re.MULTILINE)
    has_fields = b"\nFIELD" in data[: max(data.find(b"\nPOINTS"), 0)]
    lost = ["the fields that are not of points or cells"] * has_fields
    with prepared(path, data, known) as plain, listening(logging.WARNING):
        mesh = from_meshio(meshio.vtk.read(plain), unquote)
    at = max(data.find(b"\nCELL_TYPES"), 0)
    return _complete(mesh, re.match(rb"\nCELL_TYPES[ \t]+(\d+)", data[at : at + 80])), lost


def write_vtk(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a file without XML; names in the mesh have no blanks.

    Versions below 5 differ in their first line only, as far as meshes go.
    """
    import meshio.vtk

    def unpadded(values: Array) -> Array:
        return values[:, :, None] if values.shape[1:] == (2,) else values

    _teach_names()
    whole = to_meshio(mesh)
    whole.point_data = {name: unpadded(values) for name, values in whole.point_data.items()}
    for arrays in whole.cell_data.values():
        arrays[:] = map(unpadded, arrays)
    # meshio does not read version 5.1 without cells
    version = "5.1" if mesh.blocks and encoding.version >= "5" else "4.2"
    with listening(logging.INFO):
        meshio.vtk.write(path, whole, fmt_version=version, binary=encoding.binary)
    if version == "4.2":
        said = encoding.version if encoding.version in VTK_VERSIONS[:-1] else version
        with path.open("rb+") as stream:
            start = stream.readline().rstrip()
            stream.seek(len(start) - len(version))
            stream.write(said.encode())


def read_vtu(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a file with XML, which has one piece, and what of it is left out."""
    import meshio.vtu

    pieces = list(re.finditer(rb'<Piece\b[^>]*\bNumberOfCells\s*=\s*["\']\s*(\d+)', data))
    if len(pieces) > 1:
        raise UnreadableError("it has several pieces: merge them")
    if pieces and int(pieces[0][1]) == 0:
        raise UnreadableError("it has no cells")
    if b'compressor="vtkLZ4DataCompressor"' in data[:4096]:
        raise UnreadableError("LZ4 compression is not supported: save it with ZLib or without")
    known = data
    if encoding.version not in VTU_VERSIONS:  # the others differ in polyhedra only
        known = re.sub(rb'(<VTKFile\b[^>]*\bversion=")[^"]*', rb"\g<1>1.0", data, count=1)
    with prepared(path, data, known) as plain, listening(logging.WARNING):
        whole = meshio.vtu.read(plain)
    lost = [f"the field {name}" for name in whole.field_data]
    return _complete(from_meshio(whole), pieces[0] if pieces else None), lost


def write_vtu(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a file with XML: version 0.1 has counts of 32 bits, 1.0 those of 64."""
    import html

    import meshio.vtu

    def escaped(arrays: dict[str, Array]) -> dict[str, Array]:  # as meshio does not
        names = [html.escape(name).encode("ascii", "xmlcharrefreplace") for name in arrays]
        return dict(zip((name.decode() for name in names), arrays.values(), strict=True))

    whole = to_meshio(mesh)
    whole.point_data, whole.cell_data = escaped(whole.point_data), escaped(whole.cell_data)
    compression = "zlib" if encoding.compressed else None
    wide = encoding.version != "0.1"
    with listening(logging.INFO):
        meshio.vtu.write(
            path, whole, compression=compression, header_type="UInt64" if wide else None
        )
    if not encoding.binary:
        path.write_bytes(_BASE64.sub(lambda m: _spelled(m, 8 if wide else 4), path.read_bytes()))
    if wide:  # meshio says 0.1 even then
        with path.open("rb+") as stream:
            start = stream.read(200)
            stream.seek(0)
            stream.write(start.replace(b' version="0.1"', b' version="1.0"'))


def _spelled(array: re.Match[bytes], header: int) -> bytes:
    """Turn base64, after a header of some bytes, into one number a line."""
    values = np.frombuffer(base64.b64decode(array[3])[header:], array[2].decode().lower())
    return array[1] + b'ascii">\n' + "\n".join(map(repr, values.tolist())).encode() + b"\n"
