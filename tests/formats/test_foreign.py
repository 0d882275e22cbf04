"""Files of other programs under our extensions: refused, and called by their name."""

import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import FORMATS, read
from meshopt_cli.formats.foreign import FOREIGN, NO_MESHES, foreign_kind
from support.samples import SAMPLE_NAMES, SAMPLES

FILES = {
    "an MFEM mesh": b"MFEM mesh v1.0\n\ndimension\n2\n",
    "a GetFEM mesh": b"% GETFEM MESH FILE\n% (a licence)\n\nBEGIN POINTS LIST\n\nPOINT 0 0 0\n",
    "a Finley mesh (esys-escript)": b"a square\n2D-Nodes 9\n0 0 0 0.0 0.0\n",
    "a GiD mesh": b"# made by GiD\nMESH    dimension 3 ElemType Tetrahedra  Nnode 4\nCoordinates\n",
    "an ANSYS Fluent mesh": b'(0 "GAMBIT to Fluent File")\n(2 2)\n',
    "a FreeFem mesh": b"4 2 4\n0 0 1\n1.5 -2e-1 1\n1 1 1\n0 1 1\n1 2 3 0\n",
    "an OpenFOAM file": b"/* a head */\nFoamFile\n{\n    version 2.0;\n}\n",
    "a Netgen mesh": b"mesh3d\ndimension\n3\n",
    "an Abaqus or CalculiX input": b"** a comment\n*NODE, NSET=all\n1, 0, 0, 0\n",
    "a Nastran file": b"SOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\n",
    "a UNV file": b"    -1\n  2411\n         1         1\n",
    "an STL file": b"solid part\n  facet normal 0 0 1\n",
    "a PLY file": b"ply\nformat ascii 1.0\n",
    "an OFF file": b"OFF\n4 4 6\n",
    "an XDMF file": b'<?xml version="1.0"?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf>',
    "a DOLFIN mesh": b'<?xml version="1.0"?>\n<dolfin xmlns:dolfin="x">\n',
    "an HDF5 file": b"\x89HDF\r\n\x1a\n\0",
    "a netCDF or Exodus file": b"CDF\x01\0\0",
    "a zip archive": b"PK\x03\x04\x14",
    "a web page": b"<!DOCTYPE html>\n<html><body>404</body></html>",
    "a script": b"#!/bin/sh\nmake mesh\n",
}


@pytest.mark.parametrize("what", FOREIGN)
@pytest.mark.parametrize(
    "extension", sorted({e for row in FORMATS.values() for e in row.extensions})
)
def test_a_foreign_file_is_called_by_its_name(tmp_path, what, extension):
    path = tmp_path / f"mesh{extension}"
    path.write_bytes(FILES[what].replace(b"\n", b"\r\n") if extension == ".msh" else FILES[what])
    with pytest.raises(ReadError, match=rf"not a \w+ file, but {what.split('(')[0]}") as refused:
        read(path)
    assert ("export it as" in str(refused.value)) == (what not in NO_MESHES)


@pytest.mark.parametrize("name", SAMPLE_NAMES)
def test_our_own_files_are_not_foreign(name):
    assert foreign_kind((SAMPLES / name).read_bytes()) == ""
