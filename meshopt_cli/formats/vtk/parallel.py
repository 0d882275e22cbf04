"""The index of a mesh in pieces, `.pvtu`: it names the files that have them, beside it."""

from __future__ import annotations

import html
import re
from pathlib import Path

from ...errors import ReadError, WriteError, reason
from ...files.sink import written
from ...mesh.model import Array, Mesh
from ...mesh.pieces import IDS
from ..sniff import UnreadableError
from .tree import parse
from .write import number_type

SUFFIX = ".pvtu"
_KIND = "PUnstructuredGrid"


def is_index(path: Path) -> bool:
    """Whether a file is an index of pieces, by its name."""
    return path.suffix.lower() == SUFFIX


def folder_of(path: Path) -> Path:
    """Where the pieces of an index stand that is written."""
    return path.with_suffix("")


def names_of(path: Path, n: int) -> list[str]:
    """The names of its n pieces in this folder."""
    return [f"{path.stem}_{i:0{len(str(n - 1))}}.vtu" for i in range(n)]


def is_piece_of(path: Path, name: str) -> bool:
    """Whether a file of its folder is called as `names_of` calls one of however many pieces."""
    return re.fullmatch(rf"{re.escape(path.stem)}_\d+\.vtu", name) is not None


def sources_of(path: Path) -> list[Path]:
    """The files of the pieces that an index names, in its order.

    Raises
    ------
    ReadError
        It cannot be read, or is none.
    """
    try:
        root, _ = parse(path.read_bytes())
        body = root.first(_KIND)
        names = [piece.get("Source") for piece in body.all("Piece")] if body else []
        if root.get("type") != _KIND or not names or not all(names):
            raise UnreadableError("it names no files of pieces")
    except OSError as error:
        raise ReadError(f"{path}: cannot be read: {reason(error)}") from error
    except UnreadableError as error:
        raise ReadError(f"{path}: not a readable PVTU file: {error}") from error
    return [path.parent / name.replace("\\", "/") for name in dict.fromkeys(names)]


def write_index(path: Path, names: list[str], like: Mesh) -> None:
    """Write an index, which names files in `folder_of(path)`.

    Parameters
    ----------
    like : Mesh
        One of the pieces, as it is in its file: all have the same arrays.

    Raises
    ------
    WriteError
    """
    cell_data = like.blocks[0].data if like.blocks else {}
    lines = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="{_KIND}" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f'<{_KIND} GhostLevel="0">',
        f'<PPointData GlobalIds="{IDS}">',
        *(_declared(name, values) for name, values in like.point_data.items()),
        "</PPointData>",
        "<PCellData>",
        *(_declared(name, values) for name, values in cell_data.items()),
        "</PCellData>",
        f"<PPoints>\n{_declared('Points', like.points)}\n</PPoints>",
        *(f'<Piece Source="{_said(f"{folder_of(path).name}/{name}")}"/>' for name in names),
        f"</{_KIND}>",
        "</VTKFile>",
    ]
    try:
        with written(path, []) as place:
            place.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {reason(error)}") from error


def _declared(name: str, values: Array) -> str:
    width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    return f'<PDataArray type="{number_type(values)}" Name="{_said(name)}"{width}/>'


def _said(text: str) -> str:
    return html.escape(text)
