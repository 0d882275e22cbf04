"""What a file is, told from its first bytes."""

from __future__ import annotations

import re
from dataclasses import dataclass

HEAD = 1 << 20  # bytes that are enough to tell

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


def encoding_of(head: bytes) -> Encoding | None:
    """Tell what a file is from its first `HEAD` bytes; None if it is no known kind of mesh.

    Raises
    ------
    UnreadableError
        It is a known kind, of a version that is not supported.
    """
    return next(filter(None, (look(head) for look in _SNIFFERS)), None)


def gmsh_header(body: bytes) -> tuple[str, bool, int]:
    """Take apart what stands in $MeshFormat: version 2.2 or 4.1, text?, bytes of a count."""
    header = _GMSH_HEADER.match(body)
    if not header:
        raise UnreadableError("there is no header $MeshFormat in it")
    version, text, size = header[1].decode(errors="replace"), header[2] == b"0", int(header[3])
    version = {"2": "2.2", "2.0": "2.2", "2.1": "2.2", "4": "4.0"}.get(version, version)
    if version not in ("2.2", "4.1"):
        raise UnreadableError(f"Gmsh format {version} is not supported: save it as 4.1 or 2.2")
    if not text and body[header.end() : header.end() + 4] != b"\1\0\0\0":
        raise UnreadableError("it is binary in big-endian order: save it as text")
    return version, text, size


def _sniff_gmsh(head: bytes) -> Encoding | None:
    if head.lstrip().startswith((b"$NOD", b"$PARA", b"$ELM")):
        raise UnreadableError("Gmsh format 1 is not supported: save it as 4.1 or 2.2")
    header = re.search(rb"^\$MeshFormat\s*?\n", head, re.MULTILINE)
    if not header or not head.lstrip().startswith(b"$"):
        return None
    version, text, _ = gmsh_header(head[header.end() :])
    return Encoding("gmsh" if version == "4.1" else "gmsh22", version, not text)


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
