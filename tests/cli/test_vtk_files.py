"""Surfaces, grids and pieces of VTK on the command line."""

import json

import pytest

from meshopt_cli.formats import read

SURFACE = """<VTKFile type="PolyData" version="1.0"><PolyData>
<Piece NumberOfPoints="5" NumberOfVerts="0" NumberOfLines="1" NumberOfStrips="0" NumberOfPolys="4">
<Points><DataArray type="Float64" Name="Points" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 1 1 0 0 1 0 0.3 0.4 0</DataArray></Points>
<CellData><DataArray type="Int32" Name="wall" format="ascii">0 1 1 2 2</DataArray></CellData>
<Lines><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Lines>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">
0 1 4 1 2 4 2 3 4 3 0 4</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3 6 9 12</DataArray></Polys>
</Piece></PolyData></VTKFile>
"""
IMAGE = """# vtk DataFile Version 3.0
a grid
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 3 3 3
ORIGIN 0 0 0
SPACING 1 1 1
"""


@pytest.fixture
def surface(tmp_path):
    path = tmp_path / "surface.vtp"
    path.write_text(SURFACE)
    return path


def test_a_surface_is_optimized(meshopt, surface, tmp_path):
    out = tmp_path / "out.vtu"
    ran = meshopt("optimize", surface, out, "--json")
    assert ran.status == 0
    assert json.loads(ran.out)["lost"] == ["1 cell of type polyline, VTK_POLY_LINE (4)"]
    assert "surface.vtp: dropped on reading: 1 cell of type polyline" in ran.err
    (block,) = read(out)[0].blocks
    assert sorted(block.data["wall"].tolist()) == [1, 1, 2, 2]


def test_findings_name_the_cells_of_the_file(meshopt, surface):
    surface.write_text(SURFACE.replace("3 0 4<", "3 4 0<"))
    ran = meshopt("check", surface)
    assert ran.status == 1
    assert "surface.vtp:cell 4: M101" in ran.out


def test_a_grid_is_checked(meshopt, tmp_path):
    path = tmp_path / "grid.vtk"
    path.write_text(IMAGE)
    ran = meshopt("check", path)
    assert (ran.status, ran.out) == (0, f"{path}: valid\n")
    assert meshopt("optimize", path, tmp_path / "out.vtu").status == 0


@pytest.mark.parametrize("arguments", [["out.vtp"], ["--in-place"]])
def test_what_is_not_written_is_said_ahead(meshopt, surface, tmp_path, arguments):
    ran = meshopt("optimize", surface, *(a.replace("out", f"{tmp_path}/out") for a in arguments))
    assert ran.status == 3
    assert ".vtp is read, and not written: choose one of" in ran.err
    assert surface.read_text() == SURFACE
    assert list(tmp_path.iterdir()) == [surface]


def test_extensions_that_are_read_are_listed(meshopt):
    assert ".vtu .vtp .vti" in meshopt("list", "formats").out
