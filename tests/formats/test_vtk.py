"""VTK files, the old kind and the XML."""

import numpy as np
import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, write
from support.encodings import (
    assert_same,
    assert_same_array,
    assert_unreadable,
    tagged,
    tets,
    text_mesh,
    warnings_of,
)

VTK_51 = """# vtk DataFile Version 5.1
title
ASCII
DATASET UNSTRUCTURED_GRID
FIELD FieldData 1
TIME 1 1 double
0.5
POINTS 4 float
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 3 7
OFFSETS vtktypeint64
0 4 7
CONNECTIVITY vtktypeint64
0 1 2 3 0 1 2
CELL_TYPES 2
10
5

CELL_DATA 2
SCALARS id int 1
LOOKUP_TABLE default
4 5
FIELD FieldData 2
a%20flag 1 2 unsigned_char
1 0
ids 1 2 vtkIdType
7 8
POINT_DATA 4
NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1
GLOBAL_IDS gid vtkIdType
9 8 7 6
TENSORS t double
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
1 2 3 4 5 6 7 8 9
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("UNSTRUCTURED_GRID", "HYPER_GRID"),
        ("10\n5", "42\n5"),
        ("POINTS 4", "POINTS 5"),
        ("0 4 7", "0 4 8"),
    ],
)
def test_vtk_files_that_are_refused(tmp_path, capfd, old, new):
    assert_unreadable(text_mesh(tmp_path, VTK_51.replace(old, new), "mesh.vtk"), "VTK")
    assert capfd.readouterr() == ("", "")


def test_vtk_list_of_types_that_ends_early(tmp_path):
    text = """# vtk DataFile Version 3.0
title
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 3 double
0 0 0 1 0 0 0 1 0
CELLS 2 8
3 0 1 2
3 2 1 0
CELL_TYPES 2
5
"""
    assert_unreadable(text_mesh(tmp_path, text, "mesh.vtk"), "truncated")


def test_vtu_of_later_versions(tmp_path):
    encoding = Encoding("vtu", "1.0", binary=False)
    path = tmp_path / "mesh.vtu"
    mesh = tagged(tets(), encoding)
    write(path, mesh, encoding)
    path.write_text(path.read_text().replace('version="1.0" byte', 'version="2.3" byte'))
    again, source = read(path)
    assert_same(again, mesh)
    assert source.encoding.version == "2.3"
    assert encoding_for(path, source.encoding).version == "1.0"


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('compressor="vtkZLibDataCompressor"', 'compressor="vtkZstdCompressor"', "vtkZstdCompr"),
        ('NumberOfCells="6"', 'NumberOfCells="7"', "offsets"),
        ('NumberOfPoints="5"', 'NumberOfPoints="6"', "Points"),
        ('"UnstructuredGrid"', '"PolyData"', "PolyData"),
        ('"UnstructuredGrid"', '"vtkMultiBlockDataSet"', "vtkMultiBlockDataSet"),
        ('"connectivity"', '"vertices"', "connectivity"),
        ('NumberOfComponents="3"', 'NumberOfComponents="2"', "Points"),
        ("</UnstructuredGrid>", "", "malformed"),
    ],
)
def test_vtu_files_that_are_refused(tmp_path, old, new, word):
    path = tmp_path / "mesh.vtu"
    write(path, tets(), FORMATS["vtu"].default)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert_unreadable(path, word)


@pytest.mark.parametrize("count", ['NumberOfComponents=""', ""])
def test_points_without_a_count_of_their_coordinates_have_three(tmp_path, count):
    path = tmp_path / "mesh.vtu"
    mesh = tets()
    write(path, mesh, FORMATS["vtu"].default)
    text = path.read_text()
    assert text.count('NumberOfComponents="3"') >= 1
    path.write_text(text.replace('NumberOfComponents="3"', count, 1))
    assert_same_array(read(path)[0].points, mesh.points)


@pytest.mark.parametrize("name", ["vtk", "vtu"])
def test_names_that_would_become_one_stay_two(tmp_path, name):
    mesh = tets()
    mesh.point_data = {"a\tb": np.arange(5), "a\nb": np.arange(5) + 7, "": np.arange(5) + 14}
    path = tmp_path / f"mesh.{name}"
    write(path, mesh, FORMATS[name].default)
    again, _ = read(path)
    assert [values[0] for values in again.point_data.values()] == [0, 7, 14]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("UNSTRUCTURED_GRID", "\x1b[31mGRID"),
        ("SCALARS id int 1", "SCALARS %1B[31m quaternion 1"),
        ("SCALARS id int 1\nLOOKUP_TABLE default\n4 5", "FIELD f 1\n%1B[31m%0A 1 2 string\na\nb"),
        ("TIME 1 1 double", "%1B[31mTIME 1 1 string"),
    ],
)
def test_what_a_terminal_would_obey_is_not_said(tmp_path, caplog, old, new):
    assert old in VTK_51
    path = text_mesh(tmp_path, VTK_51.replace(old, new), "mesh.vtk")
    try:
        said = ", ".join(read(path)[1].lost)
    except ReadError as error:
        said = str(error)
    assert "[31m" in said
    assert said.isprintable()
    assert all(line.isprintable() for line in warnings_of(caplog))
