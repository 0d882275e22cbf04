"""The table of formats: one row for each that can be read and written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..mesh import Mesh
from . import gmsh, medit, tags, vtk
from .numbering import Counting
from .sniff import Encoding


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
    counting : Counting
    read : function of (path, content, encoding)
    fit : function of (mesh, encoding)
        Makes the mesh that `write` takes, and lists what it left out.
    write : function of (path, mesh, encoding)
    """

    name: str
    family: str
    title: str
    extensions: tuple[str, ...]
    versions: tuple[str, ...]
    default: Encoding
    description: str
    counting: Counting
    read: Callable[[Path, bytes, Encoding], Mesh]
    fit: Callable[[Mesh, Encoding], tuple[Mesh, list[str]]]
    write: Callable[[Path, Mesh, Encoding], None]


def _gmsh(name: str, version: str, versions: tuple[str, ...]) -> Format:
    return Format(
        name=name,
        family="gmsh",
        title="Gmsh",
        extensions=(".msh",),
        versions=versions,
        default=Encoding(name, version, binary=False),
        description=f"Gmsh, version {version}, text or binary",
        counting=Counting(1, "node", "element"),
        read=gmsh.read,
        fit=tags.for_gmsh,
        write=gmsh.write,
    )


def _medit(name: str, extension: str, *, binary: bool) -> Format:
    return Format(
        name=name,
        family="medit",
        title="Medit",
        extensions=(extension,),
        versions=("1", "2", "3", "4"),
        default=Encoding(name, "2", binary),
        description=f"Medit, {'binary' if binary else 'text'}, as Mmg reads and writes it",
        counting=Counting(1, "vertex"),
        read=medit.read,
        fit=tags.for_medit,
        write=medit.write,
    )


_ROWS = (
    _gmsh("gmsh", "4.1", ("4.1",)),
    _gmsh("gmsh22", "2.2", ("2", "2.1", "2.2")),
    Format(
        name="vtk",
        family="vtk",
        title="VTK",
        extensions=(".vtk",),
        versions=("2.0", "3.0", "4.0", "4.1", "4.2", "5.1"),
        default=Encoding("vtk", "5.1", binary=True),
        description="VTK without XML, text or binary; versions up to 4.2 are written as 4.2",
        counting=Counting(0, "point", "cell"),
        read=vtk.read_vtk,
        fit=tags.for_vtk,
        write=vtk.write_vtk,
    ),
    Format(
        name="vtu",
        family="vtu",
        title="VTU",
        extensions=(".vtu",),
        versions=(*vtk.VTU_VERSIONS, "2.0", "2.1", "2.2", "2.3"),
        default=Encoding("vtu", "1.0", binary=True, compressed=True),
        description="VTK with XML, unstructured grid, text or binary, compressed or not",
        counting=Counting(0, "point", "cell"),
        read=vtk.read_vtu,
        fit=tags.for_vtk,
        write=vtk.write_vtu,
    ),
    _medit("medit", ".mesh", binary=False),
    _medit("meditb", ".meshb", binary=True),
)

FORMATS: dict[str, Format] = {row.name: row for row in _ROWS}
