"""Files of meshes: which there are, what they are like inside, reading and writing.

What came in goes out: version, text or binary, names, tags, cells of lower dimension,
arrays, and every bit of every coordinate. What a format cannot hold is dropped with a
warning that names it. Reading and writing go through meshio, which is imported here only,
and not before it is needed; what a format needs besides stands in a module of its own.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ..errors import ConfigError, ReadError, WriteError
from ..mesh import Array, Block, Mesh
from .atomic import replacing
from .numbering import Numbering, numbering
from .sniff import HEAD, Encoding, UnreadableError, encoding_of
from .table import FORMATS, Format
from .vtk import VTU_VERSIONS

__all__ = ["FORMATS", "Encoding", "Format", "Numbering", "Source", "encoding_for"]
__all__ += ["numbering", "read", "sniff", "write"]

log = logging.getLogger("meshopt")


@dataclass(frozen=True)
class Source:
    """The file that a mesh was read from.

    Attributes
    ----------
    path : Path
    encoding : Encoding
    sha256 : str
        Of the bytes of the file, in hexadecimal.
    """

    path: Path
    encoding: Encoding
    sha256: str


def sniff(path: Path) -> Encoding:
    """Find out what a file is, from its first bytes.

    Raises
    ------
    ReadError
        It cannot be opened, has an unknown extension, or is no known kind of mesh.
    """
    with _opened(path) as stream:
        return _sniff(path, stream.read(HEAD))


def read(path: Path) -> tuple[Mesh, Source]:
    """Read a mesh from a file.

    Returns
    -------
    mesh : Mesh
        Its arrays are C-contiguous, in native order, and may be written to. Vertex
        numbers may be out of range, and points not finite: `check` looks for that.
    source : Source

    Raises
    ------
    ReadError
        With one line that says what is wrong with which file.
    """
    path = Path(path)
    with _opened(path) as stream:
        head = stream.read(HEAD)
        encoding = _sniff(path, head)
        data = head + stream.read()
    row = FORMATS[encoding.format]
    try:
        with np.errstate(invalid="raise"):  # where a NaN stands for an integer
            mesh = _owned(row.read(path, data, encoding))
    except (Exception, SystemExit) as error:  # meshio raises anything
        reason = _one_line(error)
        if not isinstance(error, UnreadableError):
            reason = f"truncated or malformed ({reason})"
        raise ReadError(f"{path}: not a readable {row.title} file: {reason}") from error
    return mesh, Source(path, encoding, hashlib.sha256(data).hexdigest())


def encoding_for(
    path: Path, source: Encoding | None = None, file_format: str | None = None
) -> Encoding:
    """Choose what to write: the format by its name or by the extension, the rest as it was.

    Parameters
    ----------
    path : Path
        Where to write.
    source : Encoding, optional
        What was read. A format of the same family keeps its version if it has it, and
        text or binary where the extension does not say it.
    file_format : str, optional
        A key of `FORMATS`, which goes before the extension.

    Raises
    ------
    ConfigError
        There is no format of that name.
    WriteError
        The extension is unknown.
    """
    if file_format is not None:
        if file_format not in FORMATS:
            raise ConfigError(f"no format {file_format!r}: choose one of {', '.join(FORMATS)}")
        row = FORMATS[file_format]
    else:
        rows = _with_extension(path)
        if not rows:
            raise WriteError(f"{path}: unknown extension: choose one of {_extensions()}")
        row = next((row for row in rows if source and row.name == source.format), rows[0])
    new = row.default
    if source is None or FORMATS[source.format].family != row.family:
        return new
    if row.family == "gmsh":
        return replace(new, binary=source.binary)
    if row.family == "medit":
        return replace(new, version=source.version)
    if row.family == "vtk":
        return replace(source, version="4.2" if source.version < "5" else "5.1")
    return source if source.version in VTU_VERSIONS else replace(source, version=new.version)


def write(path: Path, mesh: Mesh, encoding: Encoding) -> list[str]:
    """Write a mesh to a file, which has all of it at once or stays as it was.

    Parameters
    ----------
    path : Path
        Through a symbolic link, the file behind it is replaced. An older file hands
        its permissions on.
    mesh : Mesh
    encoding : Encoding
        From `encoding_for`.

    Returns
    -------
    list of str
        What the format cannot hold, of which there is a warning too.

    Raises
    ------
    WriteError
        With one line that says what is wrong with which file.
    """
    row = FORMATS[encoding.format]
    try:
        fitted, dropped = row.fit(mesh, encoding)
        with replacing(path) as temporary:
            row.write(temporary, fitted, encoding)
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {_reason(error)}") from error
    except Exception as error:
        raise WriteError(f"{path}: cannot be written as {row.title}: {_one_line(error)}") from error
    dropped = list(dict.fromkeys(dropped))
    if dropped:
        log.warning("%s: %s cannot hold %s: dropped", path, row.title, ", ".join(dropped))
    return dropped


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    try:
        with open(path, "rb") as stream:
            yield stream
    except OSError as error:
        raise ReadError(f"{path}: cannot be read: {_reason(error)}") from error


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__


def _extensions() -> str:
    return ", ".join(dict.fromkeys(e for row in FORMATS.values() for e in row.extensions))


def _with_extension(path: Path) -> list[Format]:
    extension = Path(path).suffix.lower()
    return [row for row in FORMATS.values() if extension in row.extensions]


def _sniff(path: Path, head: bytes) -> Encoding:
    rows = _with_extension(path)
    if not rows:
        raise ReadError(f"{path}: unknown extension: known are {_extensions()}")
    if not head:
        raise ReadError(f"{path}: the file is empty")
    if head.startswith(b"version https://git-lfs"):
        raise ReadError(f"{path}: a Git LFS pointer, not the mesh: run git lfs pull")
    try:
        found = encoding_of(head)
    except UnreadableError as error:
        raise ReadError(f"{path}: {error}") from None
    if found is None:
        raise ReadError(f"{path}: not a {rows[0].title} file")
    if FORMATS[found.format].family != rows[0].family:
        log.warning("%s: named like %s, but it is %s", path, rows[0].title, found.format)
    return found


def _owned(mesh: Mesh) -> Mesh:
    """Bring arrays into the form that `read` promises, of one or two dimensions."""

    def own(arrays: dict[str, Array]) -> dict[str, Array]:
        result = {}
        for name, values in arrays.items():
            flat = values.reshape(len(values), -1) if values.size else values
            flat = flat[:, 0] if flat.shape[1:] == (1,) else flat
            kind = np.dtype(np.uint8) if flat.dtype == bool else flat.dtype.newbyteorder("=")
            result[name] = np.require(flat, kind, ["C", "W"])
        return result

    real = np.float32 if mesh.points.dtype.newbyteorder("=") == np.float32 else np.float64
    points = np.require(mesh.points, real, ["C", "W"])
    blocks = [
        Block(b.type, np.require(b.cells, np.int64, ["C", "W"]), own(b.data), b.entities)
        for b in mesh.blocks
    ]
    return Mesh(points, blocks, own(mesh.point_data), mesh.names)
