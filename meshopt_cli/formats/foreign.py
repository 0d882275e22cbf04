"""Files of other programs that go by the extensions of ours, told by how they begin.

None of them is read: the table is there to say what a file is.
"""

from __future__ import annotations

import re

_START = rb"\A(?:\xef\xbb\xbf)?\s*"

# What a file is, and a pattern that its first bytes have.
FOREIGN = {
    "an MFEM mesh": _START + rb"MFEM (?:mesh|NURBS|INLINE|NC) ",
    "a GetFEM mesh": rb"^BEGIN (?:POINTS LIST|MESH STRUCTURE)",
    "a Finley mesh (esys-escript)": rb"\A[^\n]*\n\s*[1-3]D-Nodes\s+\d",
    "a GiD mesh": rb"^\s*MESH\b[^\n]*\bdimension\s+[23]\b",
    "an ANSYS Fluent mesh": _START + rb"\(\s*\d+\s+[\"(\d]",
    "a FreeFem mesh": _START + rb"\d+ +\d+ +\d+\s*\n\s*[-+.\deE]+\s+[-+.\deE]+\s+\d+\s*\n",
    "an OpenFOAM file": rb"^FoamFile\b",
    "a Netgen mesh": _START + rb"mesh3d\b",
    "an Abaqus or CalculiX input": _START
    + rb"(?:\*\*[^\n]*\n\s*)*\*(?:heading|node|part|include)\b",
    "a Nastran file": rb"^(?:BEGIN BULK|GRID[ ,*])",
    "a UNV file": rb"\A\s*-1\s*\n\s*\d{3,4}\s*\n",
    "an STL file": _START + rb"solid\b[^\n]*\n\s*facet\b",
    "a PLY file": _START + rb"ply\s*\n",
    "an OFF file": _START + rb"(?:ST|C|N|4|n)*OFF\s*\n",
    "an XDMF file": _START + rb"(?:<[?!][^>]*>\s*)*<Xdmf\b",
    "a DOLFIN mesh": _START + rb"(?:<[?!][^>]*>\s*)*<dolfin\b",
    "an HDF5 file": rb"\A\x89HDF",
    "a netCDF or Exodus file": rb"\ACDF[\x01\x02\x05]",
    "a zip archive": rb"\APK\x03\x04",
    "a web page": _START + rb"(?:<!doctype html|<html)\b",
    "a script": rb"\A#!",
}
NO_MESHES = ("a zip archive", "a web page", "a script")


def foreign_kind(head: bytes) -> str:
    """What a file of another program is, by its first bytes: "an MFEM mesh"; "" if not known."""
    how = re.MULTILINE | re.IGNORECASE
    return next((what for what, pattern in FOREIGN.items() if re.search(pattern, head, how)), "")
