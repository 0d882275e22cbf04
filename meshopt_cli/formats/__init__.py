"""Files of meshes: which there are, what they are like inside, reading and writing.

What came in goes out: version, text or binary, names, tags, cells of lower dimension,
arrays, and every bit of every coordinate. Files may be compressed, or pipes. What a format
cannot hold is dropped with a warning that names it. What a format needs stands in a module of
its own. Some go through meshio, which is imported here only, and not before it is needed.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import (
    ConfigError,
    MeshoptError,
    NoReaderError,
    ReadError,
    WriteError,
    chosen,
    reason,
    shown,
)
from ..files.sink import PIPE, ZIPPED, is_stream, written
from ..mesh.model import Array, Mesh
from .foreign import NO_MESHES, foreign_kind
from .numbering import Numbering, numbering
from .sniff import ADVICE, MEMORY, Encoding, UnreadableError, encoding_of
from .streams import Contents, as_file, extension, opened
from .table import FORMATS, Format

__all__ = ["FORMATS", "MEMORY", "PIPE", "Encoding", "Format", "Numbering", "Source", "Written"]
__all__ += ["encoding_for", "extension"]
__all__ += ["fitted", "numbering", "owned", "read", "sniff", "write"]

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
    lost : tuple of str
        What of the file is not in the mesh.
    """

    path: Path
    encoding: Encoding
    sha256: str
    lost: tuple[str, ...] = ()


@dataclass(frozen=True)
class Written(Source):
    """The file that a mesh was written to; `lost` is what of the mesh its format cannot hold."""


def sniff(path: Path) -> Encoding:
    """Find out what a file is, from its first bytes.

    Raises
    ------
    ReadError
        It cannot be opened, has an unknown extension, or is no known kind of mesh.
    """
    with _opened(path) as contents:
        return _sniff(path, contents.head, None)


def read(
    path: Path, file_format: str | None = None, max_size: int | None = None
) -> tuple[Mesh, Source]:
    """Read a mesh from a file.

    Parameters
    ----------
    path : Path
        `PIPE` stands for stdin. Compressed files are known by their content.
    file_format : str, optional
        The key of `FORMATS` that it must have, whatever its extension.
    max_size : int, optional
        The most bytes that it may have, or that may come out of a compressed file. Without it
        this is a thousand times what went in, or 256 MiB if that is more.

    Returns
    -------
    mesh : Mesh
        Its arrays are C-contiguous, in native order, and may be written to. Vertex
        numbers may be out of range, and points not finite: `check` looks for that.
    source : Source
        What of the file is not in the mesh is warned of, too.

    Raises
    ------
    ConfigError
        There is no format of that name.
    ReadError
        With one line that says what is wrong with which file.
    """
    path = Path(path)
    wanted = None if file_format is None else chosen(FORMATS, file_format, "format")
    with _opened(path, max_size) as contents:
        encoding = _sniff(path, contents.head, wanted)
        data, digest = contents.whole()
    row = FORMATS[encoding.format]
    try:
        # numpy stops where a NaN stands for an integer; a number too large for its type is infinite
        with np.errstate(invalid="raise", over="ignore"), as_file(path, data) as plain:
            mesh, dropped = row.read(plain, data, encoding)
            mesh = owned(mesh)
    except MeshoptError:
        raise
    except (Exception, SystemExit) as error:  # meshio raises anything
        if isinstance(error, MemoryError):
            raise
        # What others say of it is about their code, not about the file.
        is_ours = isinstance(error, UnreadableError)
        what = _one_line(error) if is_ours else "truncated or malformed"
        kind = row.title_of(extension(path))
        raise ReadError(f"{path}: not a readable {kind} file: {what}") from error
    lost = tuple(dict.fromkeys(map(shown, dropped)))
    if lost:
        log.warning("%s: dropped on reading: %s", path, ", ".join(lost))
    return mesh, Source(path, encoding, digest, lost)


def encoding_for(
    path: Path,
    source: Encoding | None = None,
    file_format: str | None = None,
    binary: bool | None = None,
) -> Encoding:
    """Choose what to write: the format by its name or by the extension, the rest as it was.

    Parameters
    ----------
    path : Path
        Where to write. A pipe or device gets the format of the source, if its name says none.
    source : Encoding, optional
        What was read. A format of the same family keeps its version if it has it, and
        text or binary where the extension does not say it.
    file_format : str, optional
        A key of `FORMATS`, which goes before the extension.
    binary : bool, optional
        Binary or text, whatever the source was.

    Raises
    ------
    ConfigError
        There is no format of that name, or it is either text or binary by its name.
    WriteError
        The extension is unknown.
    """
    new = _encoding_for(path, source, file_format)
    if binary is None or binary == new.binary:
        return new
    row = FORMATS[new.format]
    if row.family == "medit":
        raise ConfigError(f"{path}: Medit's files are text in .mesh, and binary in .meshb")
    return replace(new, binary=binary, compressed=binary and row.default.compressed)


def _encoding_for(path: Path, source: Encoding | None, file_format: str | None) -> Encoding:
    if file_format is not None:
        row = chosen(FORMATS, file_format, "format")
    elif source is not None and is_stream(path) and not _with_extension(path):
        row = FORMATS[source.format]
    else:
        rows = _with_extension(path)
        if not rows:
            known = any(extension(path) in row.others for row in FORMATS.values())
            what = f"{extension(path)} is read, and not written" if known else "unknown extension"
            raise WriteError(f"{path}: {what}: choose one of {_extensions()}")
        row = next((row for row in rows if source and row.name == source.format), rows[0])
    new = row.default
    if source is None or source == MEMORY or FORMATS[source.format].family != row.family:
        return new
    if row.family == "gmsh":
        return replace(new, binary=source.binary)
    if row.family == "medit":
        return replace(new, version=source.version)
    from .vtk.write import VTK_VERSIONS, VTU_VERSIONS

    if row.family == "vtk":
        later = "4.2" if source.version < "5" else "5.1"
        return replace(source, version=source.version if source.version in VTK_VERSIONS else later)
    return source if source.version in VTU_VERSIONS else replace(source, version=new.version)


def write(path: Path, mesh: Mesh, encoding: Encoding) -> Written:
    """Write a mesh to a file, which has all of it at once or stays as it was.

    Parameters
    ----------
    path : Path
        Through a symbolic link, the file behind it is replaced. An older file hands
        its permissions on. A name that ends in `.gz` makes a compressed file, and `PIPE`
        stands for stdout.
    mesh : Mesh
    encoding : Encoding
        From `encoding_for`.

    Returns
    -------
    Written
        With what the format cannot hold, of which there is a warning too.

    Raises
    ------
    WriteError
        With one line that says what is wrong with which file.
    """
    row = FORMATS[encoding.format]
    digest: list[str] = []
    try:
        ready, dropped = row.fit(mesh, encoding)
        with written(path, digest) as temporary:
            row.write(temporary, ready, encoding)
    except NoReaderError as error:  # a mesh is needed, unlike what is only shown
        raise WriteError(str(error)) from None
    except MeshoptError:
        raise
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {reason(error)}") from error
    except Exception as error:
        raise WriteError(f"{path}: cannot be written as {row.title}: {_one_line(error)}") from error
    return Written(path, encoding, digest[0], _without(path, row, dropped))


def fitted(path: Path, mesh: Mesh, encoding: Encoding) -> tuple[Mesh, tuple[str, ...]]:
    """A mesh as a format holds it, and what it cannot hold, of which there is a warning."""
    row = FORMATS[encoding.format]
    ready, dropped = row.fit(mesh, encoding)
    return ready, _without(path, row, dropped)


def _without(path: Path, row: Format, dropped: list[str]) -> tuple[str, ...]:
    lost = tuple(dict.fromkeys(map(shown, dropped)))
    if lost:
        log.warning("%s: %s cannot hold %s: dropped", path, row.title, ", ".join(lost))
    return lost


@contextlib.contextmanager
def _opened(path: Path, max_size: int | None = None) -> Iterator[Contents]:
    try:
        with opened(path, max_size) as contents:
            yield contents
    except OSError as error:
        raise ReadError(f"{path}: cannot be read: {reason(error)}") from error


def _one_line(error: BaseException) -> str:
    return shown(" ".join(str(error).split()))[:300]


def _extensions(to_read: bool = False) -> str:
    rows = FORMATS.whole().values()
    known = dict.fromkeys(end for row in rows for end in row.extensions)
    known |= dict.fromkeys(end for row in rows for end in row.others if to_read)
    return f"{', '.join(known)}, and these with {ZIPPED}"


def _with_extension(path: Path, to_read: bool = False) -> list[Format]:
    end = extension(path)

    def found() -> list[Format]:
        rows = FORMATS.values()
        return [row for row in rows if end in row.extensions or (to_read and end in row.others)]

    if not (rows := found()) and end:
        FORMATS.whole()
        rows = found()
    return rows


def _sniff(path: Path, head: bytes, wanted: Format | None) -> Encoding:
    every = list(FORMATS.values())
    unnamed = is_stream(path) and not _with_extension(path, to_read=True)
    rows = [wanted] if wanted else every if unnamed else _with_extension(path, to_read=True)
    if not rows:
        if extension(path) in ADVICE:
            raise ReadError(f"{path}: {ADVICE[extension(path)]}")
        raise ReadError(f"{path}: unknown extension: known are {_extensions(to_read=True)}")
    if not head:
        raise ReadError(f"{path}: the file is empty")
    if head.startswith(b"version https://git-lfs"):
        raise ReadError(f"{path}: a Git LFS pointer, not the mesh: run git lfs pull")
    by_name = next((row.default for row in rows if row.by_name), None) if not unnamed else None
    try:
        found = encoding_of(head) or by_name
    except UnreadableError as error:
        raise ReadError(f"{path}: {error}") from None
    kind = "mesh" if unnamed and not wanted else rows[0].title
    if found is None:
        what = foreign_kind(head)
        remedy = ": export it as VTK or Gmsh where it was made" if what not in NO_MESHES else ""
        raise ReadError(f"{path}: not a {kind} file{f', but {what}{remedy}' if what else ''}")
    if wanted and FORMATS[found.format].family != wanted.family:
        raise ReadError(f"{path}: not a {kind} file, but {found.format}")
    if all(FORMATS[found.format].family != row.family for row in rows):
        log.warning("%s: named like %s, but it is %s", path, rows[0].title, found.format)
    return found


def owned(mesh: Mesh) -> Mesh:
    """Bring arrays into the form that `read` promises, of one or two dimensions.

    Those that have it are shared.
    """

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
        replace(b, cells=np.require(b.cells, np.int64, ["C", "W"]), data=own(b.data))
        for b in mesh.blocks
    ]
    point_data, fields = own(mesh.point_data), own(mesh.fields)
    return replace(mesh, points=points, blocks=blocks, point_data=point_data, fields=fields)
