"""Files of meshes: which there are, what they are like inside, reading and writing.

What came in goes out: version, text or binary, names, tags, cells of lower
dimension, arrays, and every bit of every coordinate. What a format cannot hold is
dropped with a warning that names it. Gmsh and Medit have modules of their own,
which say why; VTK goes through meshio, which is imported here and nowhere else.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import logging
import os
import secrets
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO
from urllib.parse import unquote

import numpy as np

from . import formats_gmsh, formats_gmsh_write, formats_medit, formats_tags, formats_vtk
from .errors import ConfigError, ReadError, WriteError
from .formats_sniff import HEAD, Encoding, encoding_of
from .formats_text import UnreadableError
from .mesh import Array, Block, Mesh

if TYPE_CHECKING:
    import meshio

log = logging.getLogger("meshopt")

VTU_VERSIONS = ("0.1", "1.0")  # that meshio reads, and that can be written


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


@dataclass(frozen=True)
class Format:
    """A row of `FORMATS`.

    Attributes
    ----------
    name : str
        What `--file-format` calls it.
    family : str
        Formats of one family keep each other's version, and text or binary.
    title : str
        What messages call it.
    extensions : tuple of str
        In lower case, with the dot. Of two rows with the same, the first is written.
    versions : tuple of str
        Those that can be read.
    default : Encoding
        What a new file is like.
    description : str
    read : function of (path, content, encoding)
    fit : function of (mesh, encoding)
        Makes the mesh that `write` takes, and lists what it left out.
    write : function of (stream, mesh, encoding)
    """

    name: str
    family: str
    title: str
    extensions: tuple[str, ...]
    versions: tuple[str, ...]
    default: Encoding
    description: str
    read: Callable[[Path, bytes, Encoding], Mesh]
    fit: Callable[[Mesh, Encoding], tuple[Mesh, list[str]]]
    write: Callable[[BinaryIO, Mesh, Encoding], None]


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
    with _opened(path) as stream:
        head = stream.read(HEAD)
        encoding = _sniff(path, head)
        data = head + stream.read()
    row = FORMATS[encoding.format]
    try:
        with np.errstate(invalid="raise"):  # where a NaN stands for an integer
            mesh = _owned(row.read(path, data, encoding))
    except (Exception, SystemExit) as error:
        reason = _one_line(error)
        if not isinstance(error, UnreadableError):
            reason = f"truncated or malformed ({reason or type(error).__name__})"
        raise ReadError(f"{path}: not a readable {row.title} file: {reason}") from error
    return mesh, Source(Path(path), encoding, hashlib.sha256(data).hexdigest())


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
        return replace(new, version=source.version, float_size=source.float_size)
    version = source.version
    if row.family == "vtk":
        version = "4.2" if version < "5" else "5.1"
    elif version not in VTU_VERSIONS:
        version = new.version
    return replace(source, format=row.name, version=version)


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write a mesh to a file, which has all of it at once or stays as it was.

    Parameters
    ----------
    path : Path
        Through a symbolic link, the file behind it is replaced. An older file hands
        its permissions on.
    mesh : Mesh
    encoding : Encoding
        From `encoding_for`.

    Raises
    ------
    WriteError
        With one line that says what is wrong with which file.
    """
    row = FORMATS[encoding.format]
    try:
        fitted, dropped = row.fit(mesh, encoding)
        with _replacing(Path(path)) as stream:
            row.write(stream, fitted, encoding)
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {_reason(error)}") from error
    except Exception as error:
        reason = _one_line(error) or type(error).__name__
        raise WriteError(f"{path}: cannot be written as {row.title}: {reason}") from error
    if dropped:
        what = ", ".join(dict.fromkeys(dropped))
        log.warning("%s: %s cannot hold %s: dropped", path, row.title, what)


@contextlib.contextmanager
def _replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file, and put it in the place of another once it is complete."""
    target = Path(os.path.realpath(path))
    if target.exists():
        if not target.is_file():
            raise OSError("it is not a regular file")
        if not os.access(target, os.W_OK):
            raise OSError("it is write-protected")
    temporary = target.with_name(f".meshopt-{secrets.token_hex(8)}{target.suffix}")
    try:
        with open(temporary, "xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


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
    return " ".join(str(error).split())[:200]


def _extensions() -> str:
    known = dict.fromkeys(extension for row in FORMATS.values() for extension in row.extensions)
    return ", ".join(known)


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
    """Bring arrays into the form that `read` promises."""

    def own(values: Array) -> Array:
        values = values.reshape(len(values), -1) if values.ndim > 2 else values
        values = values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values
        values = values.astype(np.uint8) if values.dtype == bool else values
        return np.require(values, values.dtype.newbyteorder("="), ["C", "W"])

    real = np.float32 if mesh.points.dtype.newbyteorder("=") == np.float32 else np.float64
    blocks = [
        Block(
            block.type,
            np.require(block.cells, np.int64, ["C", "W"]),
            {name: own(values) for name, values in block.data.items()},
            block.entities,
        )
        for block in mesh.blocks
    ]
    point_data = {name: own(values) for name, values in mesh.point_data.items()}
    return Mesh(np.require(mesh.points, real, ["C", "W"]), blocks, point_data, mesh.names)


@contextlib.contextmanager
def _overheard() -> Iterator[None]:
    """Send to our log what meshio prints, and do not let it read half a number."""
    said = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            warnings.catch_warnings(),
        ):
            warnings.filterwarnings("error", message=".*could not be read to its end")
            yield
    finally:
        if said.getvalue():
            log.info("meshio: %s", " ".join(said.getvalue().split()))


def _from_meshio(mesh: meshio.Mesh, n_cells: int | None, *, legacy: bool) -> Mesh:
    """Take over what meshio read, if it is all of it."""
    if any(block.type.startswith("polyhedron") for block in mesh.cells):
        raise UnreadableError("polyhedra are not supported")
    if n_cells is not None and n_cells != sum(len(block.data) for block in mesh.cells):
        raise UnreadableError("it is truncated, or some of its cells are of a type not supported")
    name_of = unquote if legacy else str
    blocks = [
        Block(
            block.type,
            np.asarray(block.data),
            {name_of(name): values[i] for name, values in mesh.cell_data.items()},
        )
        for i, block in enumerate(mesh.cells)
    ]
    point_data = {name_of(name): values for name, values in mesh.point_data.items()}
    return Mesh(mesh.points, blocks, point_data)


def _read_vtk(path: Path, data: bytes, encoding: Encoding) -> Mesh:
    import meshio.vtk

    _mend()
    with _overheard(), _at(path, data, formats_vtk.plain_vtk(data)) as readable:
        mesh = meshio.vtk.read(readable)
    if b"\nFIELD" in data[: max(data.find(b"\nPOINTS"), 0)]:
        log.warning("the fields of the VTK file that are not of points or cells are dropped")
    return _from_meshio(mesh, formats_vtk.n_cells_vtk(data), legacy=True)


@contextlib.contextmanager
def _at(path: Path, data: bytes, known: bytes) -> Iterator[Path]:
    """Where what meshio is to read can be found: another file if it is not the same."""
    if known == data:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "mesh")
        copy.write_bytes(known)
        yield copy


def _mend() -> None:
    """Teach meshio the names that VTK gives to numbers, and two cells it only half knows."""
    from meshio._mesh import topological_dimension
    from meshio.vtk import _vtk_42, _vtk_51

    topological_dimension.update(wedge15=3, pyramid13=3)

    for module in (_vtk_42, _vtk_51):
        module.vtk_to_numpy_dtype_name.update(formats_vtk.NUMBERS)
    _vtk_51.numpy_to_vtk_dtype.update(formats_vtk.WRITTEN)


def _write_vtk(stream: BinaryIO, mesh: Mesh, encoding: Encoding) -> None:
    import meshio.vtk

    _mend()

    def unpadded(values: Array) -> Array:  # meshio would add a third component
        return values[:, :, None] if values.shape[1:] == (2,) else values

    names = mesh.blocks[0].data if mesh.blocks else {}
    whole = meshio.Mesh(
        mesh.points,
        [(block.type, block.cells) for block in mesh.blocks],
        point_data={name: unpadded(values) for name, values in mesh.point_data.items()},
        cell_data={name: [unpadded(block.data[name]) for block in mesh.blocks] for name in names},
    )
    # meshio does not read version 5.1 without cells
    version = encoding.version if mesh.blocks else "4.2"
    with _overheard():
        meshio.vtk.write(
            stream, whole, fmt_version="4.2" if version < "5" else "5.1", binary=encoding.binary
        )


def _read_vtu(path: Path, data: bytes, encoding: Encoding) -> Mesh:
    import meshio.vtu

    _mend()
    n_cells = formats_vtk.n_cells_vtu(data)
    known = data if encoding.version in VTU_VERSIONS else formats_vtk.plain_vtu(data)
    with _overheard(), _at(path, data, known) as readable:
        mesh = meshio.vtu.read(readable)
    if mesh.field_data:
        log.warning("the fields %s of the VTU file are dropped", ", ".join(mesh.field_data))
    return _from_meshio(mesh, n_cells, legacy=False)


def _write_vtu(stream: BinaryIO, mesh: Mesh, encoding: Encoding) -> None:
    formats_vtk.write_vtu(
        stream,
        mesh,
        _vtk_types(),
        encoding.version if encoding.version in VTU_VERSIONS else "1.0",
        binary=encoding.binary,
        compressed=encoding.compressed,
    )


def _vtk_types() -> dict[str, int]:
    from meshio._vtk_common import meshio_to_vtk_type

    return meshio_to_vtk_type


def _write_medit(stream: BinaryIO, mesh: Mesh, encoding: Encoding) -> None:
    version = 1 if mesh.points.dtype == np.float32 else max(2, int(encoding.version))
    size = 8 * mesh.points.size + 40 * sum(len(block.cells) for block in mesh.blocks)
    if encoding.binary and size > 1 << 30:  # positions in the file may need 64 bits
        version = max(3, version)
    formats_medit.write(stream, mesh, version, encoding.binary)


def _write_gmsh(stream: BinaryIO, mesh: Mesh, encoding: Encoding) -> None:
    formats_gmsh_write.write(stream, mesh, encoding.version, encoding.binary)


def _rows() -> Iterator[Format]:
    def gmsh(name: str, version: str, read_as: tuple[str, ...]) -> Format:
        return Format(
            name=name,
            family="gmsh",
            title="Gmsh",
            extensions=(".msh",),
            versions=read_as,
            default=Encoding(name, version, binary=False),
            description=f"Gmsh, version {version}, text or binary",
            read=lambda path, data, encoding: formats_gmsh.read(data),
            fit=lambda mesh, encoding: formats_tags.for_gmsh(mesh, encoding.version),
            write=_write_gmsh,
        )

    def medit(name: str, extension: str, *, binary: bool) -> Format:
        return Format(
            name=name,
            family="medit",
            title="Medit",
            extensions=(extension,),
            versions=("1", "2", "3", "4"),
            default=Encoding(name, "2", binary),
            description=f"Medit, {'binary' if binary else 'text'}, as Mmg reads and writes it",
            read=lambda path, data, encoding: formats_medit.read(data, encoding.binary),
            fit=lambda mesh, encoding: formats_tags.for_medit(mesh),
            write=_write_medit,
        )

    yield gmsh("gmsh", "4.1", ("4.1",))
    yield gmsh("gmsh22", "2.2", ("2", "2.1", "2.2"))
    yield Format(
        name="vtk",
        family="vtk",
        title="VTK",
        extensions=(".vtk",),
        versions=("2.0", "3.0", "4.0", "4.1", "4.2", "5.1"),
        default=Encoding("vtk", "5.1", binary=True),
        description="VTK without XML, text or binary; versions up to 4.2 are written as 4.2",
        read=_read_vtk,
        fit=lambda mesh, encoding: formats_tags.for_vtk(mesh, _vtk_types(), legacy=True),
        write=_write_vtk,
    )
    yield Format(
        name="vtu",
        family="vtu",
        title="VTU",
        extensions=(".vtu",),
        versions=("0.1", "1.0", "2.0", "2.1", "2.2", "2.3"),
        default=Encoding("vtu", "1.0", binary=True, compressed=True),
        description="VTK with XML, unstructured grid, text or binary, compressed or not",
        read=_read_vtu,
        fit=lambda mesh, encoding: formats_tags.for_vtk(mesh, _vtk_types(), legacy=False),
        write=_write_vtu,
    )
    yield medit("medit", ".mesh", binary=False)
    yield medit("meditb", ".meshb", binary=True)


FORMATS: dict[str, Format] = {row.name: row for row in _rows()}


@dataclass(frozen=True)
class Numbering:
    """How a file counts its cells and points; see `numbering`."""

    family: str
    types: tuple[str, ...]
    starts: tuple[int, ...]

    def cell(self, block: int, row: int) -> str:
        """What to call a row of a block."""
        names = {"line": "edge", "quad": "quadrilateral", "tetra": "tetrahedron", "wedge": "prism"}
        kind = self.types[block]
        word = {"gmsh": "element", "medit": names.get(kind, kind)}.get(self.family, "cell")
        return f"{word} {self.starts[block] + row}"

    def point(self, i: int) -> str:
        """What to call a point."""
        word, first = {"gmsh": ("node", 1), "medit": ("vertex", 1)}.get(self.family, ("point", 0))
        return f"{word} {first + i}"


def numbering(encoding: Encoding, mesh: Mesh) -> Numbering:
    """Find out how a file of an encoding counts the cells and points of a mesh."""
    family = FORMATS[encoding.format].family
    counts: dict[str, int] = {}
    starts = []
    for block in mesh.blocks:
        key = block.type if family == "medit" else ""
        starts.append(counts.setdefault(key, int(family in ("gmsh", "medit"))))
        counts[key] += len(block.cells)
    return Numbering(family, tuple(block.type for block in mesh.blocks), tuple(starts))
