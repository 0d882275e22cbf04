"""What a file is, told from its first bytes."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import NamedTuple

HEAD = 1 << 20  # bytes that are enough to tell

# What a file of Gmsh's first version starts with, but for blanks: it has no header.
MARGIN = 256
GMSH_1 = (b"$NOD", b"$NOE", b"$PARA", b"$ELM")
_GMSH_HEADER = re.compile(rb"\s*(\S+)\s+([01])\s+(\d+)[ \t]*\r?\n")
_VTK_HEADER = re.compile(
    rb"\s*# *vtk DataFile Version\s+(\S+)[^\n]*\n[^\n]*\n\s*(\w*)", re.IGNORECASE
)
# What to do about files that are none of the formats, by their extension.
ADVICE = {
    ".vtm": "it only names other files: give those",
    ".vtmb": "it only names other files: give those",
    ".pvd": "it only names other files: give those",
    ".vtkhdf": "HDF5 is not read: save it as .vtu",
}


class UnreadableError(ValueError):
    """What a file holds cannot be read, for a reason that the user can be told."""


@dataclass(frozen=True)
class Encoding:
    """What the inside of a file is like, or is to be.

    Attributes
    ----------
    format : str
        A key of `FORMATS`.
    version : str
        As the file says it: "4.1", "2.2", "5.1", ...
    binary : bool
        False for text.
    compressed : bool
        Only a binary VTU file can be.
    """

    format: str
    version: str
    binary: bool
    compressed: bool = False


# Of a mesh that comes from no file.
MEMORY = Encoding("memory", "", binary=True)


class GmshHeader(NamedTuple):
    """What a file of Gmsh says about itself: `size` is bytes of a count, `order` is of bytes."""

    version: float
    text: bool
    size: int
    order: str


def encoding_of(head: bytes) -> Encoding | None:
    """Tell what a file is from its first `HEAD` bytes; None if it is no known kind of mesh.

    Raises
    ------
    UnreadableError
        It is a known kind, of a version that is not supported.
    """
    return next(filter(None, (look(head) for look in _SNIFFERS)), None)


def gmsh_header(body: bytes) -> GmshHeader:
    """Take apart what stands in $MeshFormat: the version, compared as a number, and the rest."""
    header = _GMSH_HEADER.match(body)
    if not header:
        raise UnreadableError("there is no header $MeshFormat in it")
    said, text, size = header[1].decode(errors="replace"), header[2] == b"0", int(header[3])
    try:
        version = float(said)
    except ValueError:
        version = math.nan
    if not 1 <= version < 4.2:
        raise UnreadableError(
            f"Gmsh format {said} is not supported: gmsh -save -format msh41 -o OUT.msh IN.msh "
            "converts it"
        )
    mark = body[header.end() : header.end() + 4]
    if not text and mark not in (b"\1\0\0\0", b"\0\0\0\1"):
        raise UnreadableError("it is binary, but the 1 that tells the order of bytes is missing")
    if not text and version >= 4 and size not in (4, 8):
        raise UnreadableError(f"counts of {size} bytes are not supported: save it as text")
    return GmshHeader(version, text, size, ">" if not text and mark[:1] == b"\0" else "<")


def _sniff_gmsh(head: bytes) -> Encoding | None:
    if head[:MARGIN].lstrip().startswith(GMSH_1):
        return Encoding("gmsh22", "1.0", binary=False)
    header = re.search(rb"^(?:\xef\xbb\xbf)?\$MeshFormat\s*?\n", head, re.MULTILINE)
    if not header:
        return None
    version, text, *_ = gmsh_header(head[header.end() :])
    return Encoding("gmsh" if version >= 4 else "gmsh22", str(version), not text)


def _sniff_vtk(head: bytes) -> Encoding | None:
    header = _VTK_HEADER.match(head)
    if not header:
        return None
    return Encoding("vtk", header[1].decode("latin-1"), header[2].upper() == b"BINARY")


def _sniff_xml(head: bytes) -> Encoding | None:
    header = re.search(rb"<VTKFile\b([^>]*)>", head[:4096])
    if not header:
        return None
    version = re.search(rb'\bversion\s*=\s*["\']([^"\']*)', header[1])
    form = re.search(rb'<DataArray\b[^>]*\bformat\s*=\s*["\'](\w+)', head)
    binary = form is not None and form[1] != b"ascii"
    said = version[1].decode("latin-1") if version else "0.1"
    if re.search(rb'\btype\s*=\s*["\']P[A-Z]', header[1]):  # it names the files of its pieces
        return Encoding("vtu", said, True, True)
    return Encoding("vtu", said, binary, binary and b"compressor" in header[1])


def _sniff_medit(head: bytes) -> Encoding | None:
    if head[:4] in (b"\1\0\0\0", b"\0\0\0\1"):
        version = int.from_bytes(head[4:8], "little" if head[0] else "big")
        return Encoding("meditb", str(version), True)
    header = re.match(rb"(?:\s|#[^\n]*\n)*MeshVersionFormatted\s+(\d+)", head)
    return Encoding("medit", str(int(header[1])), False) if header else None


_SNIFFERS = (_sniff_gmsh, _sniff_vtk, _sniff_xml, _sniff_medit)
