"""The table of formats: one row for each that can be read and written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ..mesh.model import Mesh
from ..registry import Table
from . import tags
from .sniff import Encoding


@dataclass(frozen=True)
class Format:
    """A row of `FORMATS`.

    Attributes
    ----------
    family : str
        Formats of one family keep each other's version, and text or binary.
    title : str
        What messages call it.
    extensions : tuple of str
        In lower case, with the dot. Of two rows with the same, the first is written.
    default : Encoding
        What a new file is like.
    description : str
    first_number : int
        Number of the first cell and of the first point in a file.
    cell_name, point_name : str
        What they are called; without a name, cells are counted by type.
    read : function of (path, content, encoding)
        Makes a mesh, and lists what of the file it left out.
    fit : function of (mesh, encoding)
        Makes the mesh that `write` takes, and lists what it left out.
    write : function of (path, mesh, encoding)
    others : tuple of str
        More extensions, of files that are read, and are not written.
    by_name : bool
        Files are known by their extension alone, as those of formats that others add.
    """

    family: str
    title: str
    extensions: tuple[str, ...]
    default: Encoding
    description: str
    first_number: int
    cell_name: str
    point_name: str
    read: Callable[[Path, bytes, Encoding], tuple[Mesh, list[str]]]
    fit: Callable[[Mesh, Encoding], tuple[Mesh, list[str]]]
    write: Callable[[Path, Mesh, Encoding], None]
    others: tuple[str, ...] = ()
    by_name: bool = False

    @property
    def name(self) -> str:
        """What `--file-format` calls it."""
        return self.default.format

    def title_of(self, extension: str) -> str:
        """What messages call a file of it that is read, by its extension: "VTP" with ".vtp"."""
        return extension[1:].upper() if extension in self.others else self.title


def _late(module: str, name: str) -> Callable[..., Any]:
    """A function of a module that a call of it imports: of all formats a run needs one or two."""

    def function(*arguments: Any) -> Any:
        return getattr(import_module(module, __package__), name)(*arguments)

    return function


def _gmsh(new: Encoding, written: tuple[str, ...], read: str, others: tuple[str, ...]) -> Format:
    about = f"Gmsh, version {new.version}, text or binary; {read} read"
    functions = _late(".gmsh.read", "read"), tags.for_gmsh, _late(".gmsh.write", "write")
    ends = (".msh", *written)
    return Format("gmsh", "Gmsh", ends, new, about, 1, "element", "node", *functions, others)


def _vtk(
    title: str, new: Encoding, about: str, read: Callable, write: Callable, *others: str
) -> Format:
    functions = read, tags.for_vtk, write
    name = new.format
    return Format(name, title, (f".{name}",), new, about, 0, "cell", "point", *functions, others)


def _medit(extension: str, new: Encoding) -> Format:
    about = f"Medit, {'binary' if new.binary else 'text'}, as Mmg reads and writes it"
    functions = _late(".medit", "read"), tags.for_medit, _late(".medit", "write")
    return Format("medit", "Medit", (extension,), new, about, 1, "", "vertex", *functions)


_ROWS = (
    _gmsh(Encoding("gmsh", "4.1", False), (".msh4",), "4.0 is", (".msh40", ".msh41")),
    _gmsh(
        Encoding("gmsh22", "2.2", False),
        (".msh2",),
        "1, 2.0, 2.1 and 3 are",
        (".msh1", ".msh22", ".msh3"),
    ),
    _vtk(
        "VTK",
        Encoding("vtk", "4.2", binary=True),
        "VTK without XML, versions 2.0 to 5.1, text or binary",
        _late(".vtk.legacy", "read"),
        _late(".vtk.write", "write_vtk"),
    ),
    _vtk(
        "VTU",
        Encoding("vtu", "1.0", binary=True, compressed=True),
        "VTK with XML, text or binary, compressed or not",
        _late(".vtk.xml", "read"),
        _late(".vtk.write", "write_vtu"),
        *(".vtp", ".vti", ".vtr", ".vts"),
        *(".pvtu", ".pvtp", ".pvti", ".pvtr", ".pvts"),
    ),
    _medit(".mesh", Encoding("medit", "2", binary=False)),
    _medit(".meshb", Encoding("meditb", "2", binary=True)),
)

FORMATS = Table[Format]("meshopt.formats", "format", _ROWS, lambda row: isinstance(row, Format))
