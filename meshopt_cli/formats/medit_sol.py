"""Medit's `.sol` (text) and `.solb` (binary): fields at the vertices of a mesh.

A file has one section of them, SolAtVertices, whose rows hold the values of all fields at a vertex,
one after the other. Symmetric tensors are (xx, xy, yy) in the plane and (xx, xy, yy, xz, yz, zz)
in space.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ReadError, reason, shown
from ..files.sink import written
from ..mesh.model import Array
from .sniff import UnreadableError
from .streams import extension, opened
from .text import lines, rows_of

SCALAR, VECTOR, TENSOR, MATRIX = 1, 2, 3, 4  # as files number the types of fields
EXTENSIONS = (".sol", ".solb")

_SECTION, _CODE = "SolAtVertices", 62
_DIMENSION, _END = 3, 54
_DIMENSIONS = (2, 3)
_MOST_FIELDS = 1000


@dataclass(frozen=True)
class Solution:
    """What a file holds.

    Attributes
    ----------
    dimension : int
        2 or 3.
    fields : list of (int, array)
        The type of each field, and its values (np, k) float64.
    """

    dimension: int
    fields: list[tuple[int, Array]]


def is_sol(path: Path) -> bool:
    """Whether a file is called like one of these."""
    return extension(path) in EXTENSIONS


def width_of(kind: int, dimension: int) -> int:
    """How many numbers a field of a type has at a vertex."""
    widths = {SCALAR: 1, VECTOR: dimension, TENSOR: dimension * (dimension + 1) // 2}
    return widths.get(kind, dimension**2)


def read_sol(path: Path, max_size: int | None = None) -> Solution:
    """Read the fields at vertices.

    Parameters
    ----------
    path : Path
        Text or binary by its content, compressed or not.
    max_size : int, optional
        See `formats.read`.

    Raises
    ------
    ReadError
        With one line that says what is wrong with which file.
    """
    try:
        with opened(path, max_size) as contents:
            data, _ = contents.whole()
    except OSError as error:
        raise ReadError(f"{path}: cannot be read: {reason(error)}") from error
    if not data:
        raise ReadError(f"{path}: the file is empty")
    try:
        is_binary = data[:4] in (b"\1\0\0\0", b"\0\0\0\1")
        return _read_binary(data) if is_binary else _read_text(data)
    except UnreadableError as error:
        raise ReadError(f"{path}: not a readable file of solutions: {shown(str(error))}") from None
    except (ValueError, IndexError, struct.error):
        raise ReadError(f"{path}: not a readable file of solutions: malformed") from None


def _read_text(data: bytes) -> Solution:
    from .medit import sections

    dimension = 0
    for name, content in sections(data):
        if name == "Dimension":
            dimension = _dimension(int(content.split(None, 1)[0]))
        elif name == _SECTION:
            if not dimension:
                raise UnreadableError(f"{_SECTION} comes before Dimension")
            count, n_fields, rest = [*content.split(None, 2), b""][:3]
            n = _number_of_fields(int(n_fields))
            *kinds, rows = [*rest.split(None, n), b""][: n + 1]
            types = _types(map(int, kinds), n)
            width = sum(width_of(kind, dimension) for kind in types)
            table = rows_of(_SECTION, rows, int(count), np.float64, width)
            return _taken_apart(table, types, dimension)
    raise UnreadableError(f"there is no {_SECTION} in it")


def _read_binary(data: bytes) -> Solution:
    order = "<" if data[:1] == b"\1" else ">"
    _, version = struct.unpack_from(order + "ii", data)
    if version not in (1, 2, 3, 4):
        raise UnreadableError(f"version {version} is not supported")
    head = struct.Struct(order + ("ii" if version < 3 else "iq"))
    real = np.dtype(order + ("f4" if version == 1 else "f8"))
    counts = struct.Struct(order + ("i" if version < 4 else "q"))
    at, dimension = 8, 0
    while at + head.size <= len(data):
        code, after = head.unpack_from(data, at)
        start = at + head.size
        if code == _END:
            break
        if not at < after <= len(data):
            raise UnreadableError("it ends in the middle of a section")
        if code == _DIMENSION:
            dimension = _dimension(struct.unpack_from(order + "i", data, start)[0])
        elif code == _CODE:
            if not dimension:
                raise UnreadableError(f"{_SECTION} comes before Dimension")
            (count,) = counts.unpack_from(data, start)
            start += counts.size
            n = _number_of_fields(struct.unpack_from(order + "i", data, start)[0])
            types = _types(struct.unpack_from(f"{order}{n}i", data, start + 4), n)
            start += 4 + 4 * n
            width = sum(width_of(kind, dimension) for kind in types)
            if not 0 <= count * width * real.itemsize <= after - start:
                raise UnreadableError(
                    f"{_SECTION} should have {count} x {width} numbers, and has "
                    f"{max(after - start, 0)} bytes"
                )
            table = np.frombuffer(data, real, count * width, start).reshape(count, width)
            return _taken_apart(table.astype(np.float64), types, dimension)
        at = after
    raise UnreadableError(f"there is no {_SECTION} in it")


def _dimension(said: int) -> int:
    if said not in _DIMENSIONS:
        raise UnreadableError(f"Dimension {said} is not supported")
    return said


def _number_of_fields(said: int) -> int:
    if not 0 < said <= _MOST_FIELDS:
        raise UnreadableError(f"{said} fields are not supported")
    return said


def _types(said: object, n: int) -> list[int]:
    """The types of fields, if all are known."""
    found = [int(kind) for kind in said]  # type: ignore[attr-defined]
    unknown = [kind for kind in found if kind not in (SCALAR, VECTOR, TENSOR, MATRIX)]
    if unknown or len(found) < n:
        raise UnreadableError(f"fields of type {unknown[0] if unknown else 'none'}")
    return found


def _taken_apart(table: Array, types: list[int], dimension: int) -> Solution:
    ends = np.cumsum([width_of(kind, dimension) for kind in types])
    parts = np.split(table, ends[:-1], axis=1)
    fields = [(kind, np.ascontiguousarray(p)) for kind, p in zip(types, parts, strict=True)]
    return Solution(dimension, fields)


def write_sol(path: Path, solution: Solution, version: int = 2) -> None:
    """Write fields, binary where the file is called `.solb`, and it is there at once or not at all.

    Parameters
    ----------
    version : int
        1 (numbers of single precision) to 4 (counts of 64 bits), of binary files.

    Raises
    ------
    OSError
        It cannot be written.
    """
    kinds = [kind for kind, _ in solution.fields]
    table = np.concatenate([values for _, values in solution.fields], axis=1)
    with written(path, []) as temporary, temporary.open("wb") as stream:
        if extension(path) == ".sol":
            head = f"MeshVersionFormatted {version}\nDimension {solution.dimension}\n"
            types = " ".join(map(str, [len(kinds), *kinds]))
            stream.write(f"{head}\n{_SECTION}\n{len(table)}\n{types}\n".encode())
            stream.writelines(lines(table))
            stream.write(b"\nEnd\n")
            return
        place = struct.Struct("<ii" if version < 3 else "<iq")
        count = struct.pack("<i" if version < 4 else "<q", len(table))
        said = count + struct.pack(f"<{1 + len(kinds)}i", len(kinds), *kinds)
        body = said + table.astype("<f4" if version == 1 else "<f8").tobytes()
        stream.write(struct.pack("<ii", 1, version))
        first = 8 + place.size + 4
        stream.write(place.pack(_DIMENSION, first) + struct.pack("<i", solution.dimension))
        stream.write(place.pack(_CODE, first + place.size + len(body)) + body)
        stream.write(place.pack(_END, 0))
