"""Which encoding a file has, and which it will have."""

import subprocess
import sys
from pathlib import Path

import pytest

from meshopt_cli.errors import ConfigError, WriteError
from meshopt_cli.formats import FORMATS, Encoding, encoding_for, sniff, write
from support.encodings import every_encoding, tagged, tets, warnings_of


def test_encoding_keeps_what_the_family_of_the_source_had():
    binary = Encoding("gmsh22", "2.2", binary=True)
    assert encoding_for(Path("x.msh"), binary) == binary
    assert encoding_for(Path("x.MSH"), binary) == binary
    assert encoding_for(Path("x.msh"), binary, "gmsh") == Encoding("gmsh", "4.1", binary=True)
    assert encoding_for(Path("x.msh")) == Encoding("gmsh", "4.1", binary=False)
    assert encoding_for(Path("x.msh"), FORMATS["vtk"].default) == FORMATS["gmsh"].default
    assert encoding_for(Path("x.mesh"), Encoding("meditb", "3", binary=True)) == Encoding(
        "medit", "3", binary=False
    )
    for old, new in (("2.0", "2.0"), ("3.0", "3.0"), ("1.0", "4.2"), ("5.0", "5.1")):
        wanted = Encoding("vtk", new, binary=False)
        assert encoding_for(Path("x.vtk"), Encoding("vtk", old, binary=False)) == wanted
    assert encoding_for(Path("x.vtk"), FORMATS["medit"].default) == FORMATS["vtk"].default
    plain = Encoding("vtu", "0.1", binary=True)
    assert encoding_for(Path("x.vtu"), plain) == plain
    assert encoding_for(Path("x.vtu")).compressed
    assert encoding_for(Path("x.anything"), None, "meditb").format == "meditb"


def test_unknown_formats_are_refused_with_the_choices():
    with pytest.raises(ConfigError, match=r"gmsh, gmsh22, vtk, vtu, medit, meditb"):
        encoding_for(Path("x.msh"), None, "stl")
    with pytest.raises(
        WriteError, match=r"x\.stl: .*\.msh, \.msh4, \.msh2, \.vtk, \.vtu, \.mesh, \.meshb"
    ):
        encoding_for(Path("x.stl"))
    with pytest.raises(WriteError, match=r"\.msh"):
        encoding_for(Path("x"))


@every_encoding
def test_sniffing_looks_into_the_file(tmp_path, caplog, encoding):
    path = tmp_path / "wrong_name.vtk"
    write(path, tagged(tets(), encoding), encoding)
    assert sniff(path) == encoding
    assert bool(warnings_of(caplog)) == (encoding.format != "vtk")


def test_formats_table():
    for name, row in FORMATS.items():
        assert row.name == row.default.format == name
        assert row.description
        assert encoding_for(Path("x" + row.extensions[0]), row.default) == row.default


def test_importing_is_cheap():
    code = "import sys, meshopt_cli.formats; sys.exit('meshio' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
