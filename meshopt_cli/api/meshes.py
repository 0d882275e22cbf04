"""Meshes that functions take and give: of files, of other libraries, or plain arrays."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ..mesh import model

if TYPE_CHECKING:
    from ..formats import Source
    from ..formats.memory import Held

# A path, a `Mesh`, a meshio.Mesh, a pyvista.UnstructuredGrid or PolyData, or (points, cells).
AnyMesh: TypeAlias = Any


@dataclass
class Mesh(model.Mesh):
    """All that a mesh file holds, and the file.

    Attributes
    ----------
    points : (np, 2) or (np, 3) float32 or float64
    blocks : list of Block
        Cells, by their types: `type` as meshio spells it, `cells` (n, k) int64, `data`.
    point_data : dict of str to (np, ...) array
    names : dict of (dimension, tag) to str
        Names of physical groups.
    source : Source, optional
        The file that it was read from: what is written in a format of the same family is like it.
    """

    source: Source | None = None


def of_file(mesh: model.Mesh, source: Source | None) -> Mesh:
    """A mesh that knows its file."""
    return Mesh(**{f.name: getattr(mesh, f.name) for f in fields(model.Mesh)}, source=source)


def read(
    path: str | os.PathLike[str], *, input_format: str | None = None, max_size: int | None = None
) -> Mesh:
    """Read a mesh from a file.

    Parameters
    ----------
    path : str or path
        Compressed files are known by their content.
    input_format : str, optional
        The format that it must have, whatever its name: see `meshopt list formats`.
    max_size : int, optional
        The most bytes that it may have, or that may come out of a compressed file.

    Raises
    ------
    ReadError
        The file cannot be read.
    ConfigError
        There is no such format.
    """
    from .. import formats

    return of_file(*formats.read(Path(path), input_format, max_size))


def write(
    path: str | os.PathLike[str],
    mesh: AnyMesh,
    *,
    file_format: str | None = None,
    binary: bool | None = None,
) -> Path:
    """Write a mesh to a file, which has all of it at once or stays as it was.

    Parameters
    ----------
    path : str or path
        What its name ends in says the format; `.gz` after that makes a compressed file.
    mesh : mesh of any kind
        See `optimize`; of a path, the file is read first, and so converted.
    file_format : str, optional
        A format whatever the name says: see `meshopt list formats`.
    binary : bool, optional
        Binary or text; as the mesh was read without it.

    Returns
    -------
    Path

    Raises
    ------
    ReadError, WriteError
        A file cannot be read, or written.
    ConfigError
        It is no mesh, or there is no such format.
    """
    from .. import formats

    given = taken(mesh)
    encoding = formats.encoding_for(Path(path), given.source.encoding, file_format, binary)
    return formats.write(Path(path), given.mesh, encoding).path


def taken(mesh: AnyMesh, input_format: str | None = None, max_size: int | None = None) -> Held:
    """A mesh of whatever kind, and how to hand it back.

    Raises
    ------
    ConfigError
        It is no mesh.
    ReadError
        It cannot be read, or taken over.
    """
    from .. import formats
    from ..formats.memory import Held, held

    if isinstance(mesh, str | os.PathLike):
        mesh = read(mesh, input_format=input_format, max_size=max_size)
    if not isinstance(mesh, model.Mesh):
        return held(mesh)
    source = mesh.source if isinstance(mesh, Mesh) else None
    known = source or formats.Source(Path("mesh"), formats.MEMORY, "")
    return Held(mesh, known, lambda made: of_file(made, source))
