"""What stands in a VTK file without XML: every section, in any order, and what is not kept."""

import numpy as np
import pytest

from meshopt_cli.formats import Encoding, read, write
from support.encodings import assert_unreadable, ints, tets, text_mesh, warnings_of

HEAD = """# vtk DataFile Version 3.0
title
ASCII
DATASET UNSTRUCTURED_GRID
"""
POINTS = "POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
CELLS = "CELLS 2 9\n4 0 1 2 3\n3 0 1 2\nCELL_TYPES 2\n10 5\n"


def of_cells(tmp_path, text, name="a"):
    """The array that some sections make, both rows of it."""
    mesh, source = read(text_mesh(tmp_path, f"{HEAD}{POINTS}{CELLS}CELL_DATA 2\n{text}", "m.vtk"))
    assert source.lost == ()
    return np.concatenate([block.data[name] for block in mesh.blocks])


@pytest.mark.parametrize(
    ("text", "kind", "values"),
    [
        ("SCALARS a float\nLOOKUP_TABLE default\n1 2\n", "f4", [1, 2]),
        ("SCALARS a double 2\nLOOKUP_TABLE default\n1 2 3 4\n", "f8", [[1, 2], [3, 4]]),
        ("SCALARS a int 4\n1 2 3 4 5 6 7 8\n", "i4", [[1, 2, 3, 4], [5, 6, 7, 8]]),
        ("scalars a unsigned_char 1\nlookup_table default\n1 255\n", "u1", [1, 255]),
        ("SCALARS a bit 1\nLOOKUP_TABLE default\n1 0\n", "u1", [1, 0]),
        ("COLOR_SCALARS a 3\n0 0.5 1 1 0 0.25\n", "u1", [[0, 128, 255], [255, 0, 64]]),
        ("COLOR_SCALARS a 1\n0 255\n", "f4", [0, 255]),
        ("VECTORS a double\n1 2 3 4 5 6\n", "f8", [[1, 2, 3], [4, 5, 6]]),
        ("NORMALS a float\n1 2 3 4 5 6\n", "f4", [[1, 2, 3], [4, 5, 6]]),
        ("TEXTURE_COORDINATES a 2 float\n1 2 3 4\n", "f4", [[1, 2], [3, 4]]),
        ("TENSORS a int\n" + "1 " * 18, "i4", [[1] * 9] * 2),
        ("TENSORS6 a double\n" + "1 " * 12, "f8", [[1] * 6] * 2),
        ("GLOBAL_IDS a vtkIdType\n7 8\n", "i8", [7, 8]),
        ("PEDIGREE_IDS a vtkIdType\n7 8\n", "i8", [7, 8]),
        ("EDGE_FLAGS a unsigned_char\n1 0\n", "u1", [1, 0]),
        ("FIELD f 1\na 1 2 vtktypeint64\n7 8\n", "i8", [7, 8]),
        ("FIELD f 1\na 1 2 vtktypeint16\n7 8\n", "i2", [7, 8]),
        ("FIELD f 2\nNULL_ARRAY\na 1 2 unsigned_long\n7 18446744073709551615\n", "u8", [7, -1]),
        ("FIELD f 1\na 1 2 signed_char\n-7 8\n", "i1", [-7, 8]),
        ("FIELD f 1\na 1 2 unsigned_char\n-7 300\n", "i8", [-7, 300]),
        ("FIELD f 1\na 1 2 int\n1.0 2e0\n", "i4", [1, 2]),
        ("FIELD f 1\na 1 2 double\nnan -inf\n", "f8", [np.nan, -np.inf]),
        ("FIELD f 1\na 1 2 float\n\n\n 1\n\n2\n", "f4", [1, 2]),
        ("# said by hand\n#too\nFIELD f 1\na 1 2 int # of two\n1 # first\n2\n", "i4", [1, 2]),
        ("FIELD f 2\n1st 1 2 int\n5 6\na 1 2 int\n1 2\n", "i4", [1, 2]),
        ("FIELD f 2\ninfo 1 2 int\n5 6\nnano 1 2 int\n1 2\nSCALARS a int\n3 4\n", "i4", [3, 4]),
        ("METADATA\nINFORMATION 0\n\nSCALARS a int\n1 2", "i4", [1, 2]),
        ("SCALARS a int\n1 2\nMETADATA\nCOMPONENT_NAMES\nx\n\nSCALARS b int\n3 4", "i4", [1, 2]),
        ("SCALARS a%20%25 int\n1 2\nSCALARS a int\n3 4\n", "i4", [3, 4]),
        ("FIELD f 2\n#b 1 2 int\n1 2\na 1 2 int\n3 4\n", "i4", [3, 4]),
    ],
)
def test_attributes(tmp_path, text, kind, values):
    found = of_cells(tmp_path, text if text.endswith("\n") else text + "\n")
    assert found.dtype == np.dtype(kind)
    np.testing.assert_array_equal(found, np.array(values).astype(kind))


@pytest.mark.parametrize(
    ("text", "lost"),
    [
        ("FIELD f 1\nnames 1 2 string\nfirst\nsecond%20one\n", "the strings names"),
        ("LOOKUP_TABLE hot 2\n0 0 0 1 1 1 1 1\n", "the lookup table hot"),
        ("SCALARS a int\n1 2\nVECTORS a int\n1 2 3 4 5 6\n", "the second array a"),
        ("FIELD f 1\nshort 1 1 int\n1\n", "short (1 rows for 2)"),
    ],
)
def test_what_is_not_kept_is_named(tmp_path, caplog, text, lost):
    text = f"{HEAD}{POINTS}{CELLS}CELL_DATA 2\n{text}SCALARS last int\n1 2\n"
    mesh, source = read(text_mesh(tmp_path, text, "m.vtk"))
    assert source.lost == (lost,)
    assert lost in warnings_of(caplog)[0]
    assert mesh.blocks[1].data["last"].tolist() == [2]


def test_fields_of_the_data_set(tmp_path):
    fields = (
        "FIELD FieldData 3\nTIME 1 1 double\n0.5\nbox 3 2 int\n0 0 0 1 2 3\nwho 1 1 string\nme\n"
    )
    mesh, source = read(text_mesh(tmp_path, f"{HEAD}{fields}{POINTS}{CELLS}", "m.vtk"))
    assert source.lost == ("the strings who",)
    assert {name: a.tolist() for name, a in mesh.fields.items()} == {
        "TIME": [0.5],
        "box": [[0, 0, 0], [1, 2, 3]],
    }


def test_sections_stand_in_any_order(tmp_path):
    data = "POINT_DATA 4\nSCALARS p int\n1 2 3 4\nCELL_DATA 2\nSCALARS c int\n5 6\n"
    one, _ = read(text_mesh(tmp_path, f"{HEAD}{CELLS}{data}{POINTS}", "m.vtk"))
    assert one.point_data["p"].tolist() == [1, 2, 3, 4]
    assert one.blocks[1].data["c"].tolist() == [6]


@pytest.mark.parametrize("encoding", ["\n", "\r\n"], ids=["LF", "CRLF"])
def test_line_ends(tmp_path, encoding):
    path = tmp_path / "m.vtk"
    text = f"{HEAD}{POINTS}\n{CELLS}\nCELL_DATA 2\nSCALARS a int\nLOOKUP_TABLE default\n1 2\n"
    path.write_bytes(text.replace("\n", encoding).encode())
    mesh, source = read(path)
    assert [block.cells.tolist() for block in mesh.blocks] == [[[0, 1, 2, 3]], [[0, 1, 2]]]
    assert mesh.blocks[1].data["a"].tolist() == [2]
    assert source.lost == ()


def test_binary_without_a_last_line_break(tmp_path):
    path = tmp_path / "m.vtk"
    write(path, tets(), Encoding("vtk", "4.2", binary=True))
    whole = read(path)[0]
    path.write_bytes(path.read_bytes()[:-1])
    again, source = read(path)
    assert [b.cells.tolist() for b in again.blocks] == [b.cells.tolist() for b in whole.blocks]
    assert source.lost == ()


def test_text_that_ends_in_a_line_is_named(tmp_path):
    path = text_mesh(tmp_path, (HEAD + POINTS + CELLS).rstrip("\n"), "m.vtk")
    (lost,) = read(path)[1].lost
    assert "cut off" in lost
    assert "line 11" in lost


def test_bits_of_which_the_file_has_a_part(tmp_path):
    """VTK writes one bit a row into binary files, however wide the array is."""
    path = tmp_path / "m.vtk"
    write(path, tets(), Encoding("vtk", "4.2", binary=True))
    more = b"POINT_DATA 5\nFIELD FieldData 2\nbits 3 5 bit\n\xa8\nlast 1 5 char\n\1\2\3\4\5\n"
    path.write_bytes(path.read_bytes() + more)
    mesh, source = read(path)
    assert mesh.point_data["last"].tolist() == [1, 2, 3, 4, 5]
    assert "bits" in source.lost[0]


SURFACE = """# vtk DataFile Version 2.0
by hand
ASCII
DATASET POLYDATA
POINTS 5 double
0 0 0 1 0 0 1 1 0 0 1 0 0.5 2 0
VERTICES 1 2
1 4
LINES 2 7
2 0 1
3 0 1 2
POLYGONS 2 9
4 0 1 2 3
3 3 2 4
TRIANGLE_STRIPS 1 5
4 0 1 2 3
CELL_DATA 6
SCALARS n int 1
LOOKUP_TABLE default
0 1 2 3 4 5
"""


def test_surfaces(tmp_path):
    mesh, source = read(text_mesh(tmp_path, SURFACE, "m.vtk"))
    assert [(b.type, b.cells.tolist(), b.data["n"].tolist()) for b in mesh.blocks] == [
        ("vertex", [[4]], [0]),
        ("line", [[0, 1]], [1]),
        ("quad", [[0, 1, 2, 3]], [3]),
        ("triangle", [[3, 2, 4], [0, 1, 2], [2, 1, 3]], [4, 5, 5]),
    ]
    assert source.lost == ("1 cell of type polyline, VTK_POLY_LINE (4)",)
    five = SURFACE.replace("POLYGONS 2 9\n4 0 1 2 3", "POLYGONS 2 10\n5 0 1 2 3 4")
    assert_unreadable(text_mesh(tmp_path, five, "m.vtk"), "VTK_POLYGON (7)")


GRID = (
    "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {}\nORIGIN 1 2 3\n"
)


@pytest.mark.parametrize(
    ("dimensions", "kind", "cells"),
    [
        ("2 2 2", "hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]]),
        ("3 2 1", "quad", [[0, 1, 4, 3], [1, 2, 5, 4]]),
        ("1 2 3", "quad", [[0, 1, 3, 2], [2, 3, 5, 4]]),
        ("1 3 1", "line", [[0, 1], [1, 2]]),
        ("1 1 1", "vertex", [[0]]),
    ],
)
def test_grids(tmp_path, dimensions, kind, cells):
    text = GRID.format(dimensions) + "ASPECT_RATIO 1 2 4\n"
    mesh, _ = read(text_mesh(tmp_path, text, "m.vtk"))
    assert [(block.type, block.cells.tolist()) for block in mesh.blocks] == [(kind, cells)]
    n = np.array(dimensions.split(), int)
    assert mesh.points[0].tolist() == [1, 2, 3]
    assert mesh.points[-1].tolist() == (ints(1, 2, 3) + (n - 1) * ints(1, 2, 4)).tolist()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("POINTS 4", "POINTS 5", ["POINTS", "12 numbers of 15", "'CELLS'", "line 7"]),
        ("POINTS 4", "POINTS x", ["POINTS has 'x'", "line 5"]),
        ("0 1 0 0", "0 1 b 0", ["'b'", "line 6"]),
        ("float", "quaternion", ["quaternion"]),
        ("CELLS 2 9", "CELLS 3 9", ["CELLS", "3 cells in 9 numbers"]),
        ("CELLS 2 9", "CELLS 2", ["CELLS", "line 7"]),
        ("4 0 1 2 3", "5 0 1 2 3", ["CELLS"]),
        ("10 5", "10 9", ["cell 1", "VTK_QUAD (9)", "3 vertices"]),
        ("10 5", "10 300", ["types", "no type"]),
        ("CELL_TYPES 2\n10 5\n", "", ["CELL_TYPES"]),
        (POINTS, "", ["POINTS"]),
        ("DATASET UNSTRUCTURED_GRID\n", "", ["DATASET"]),
        ("CELL_DATA 2", "CELL_DATA 3", ["s has 2 numbers of 3"]),
        ("CELL_DATA 2\n", "", ["CELL_DATA"]),
        ("SCALARS", "SCALERS", ["SCALERS", "line 13"]),
        ("1 2\n", "1\n", ["truncated", "s has 1 numbers of 2"]),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, words):
    whole = f"{HEAD}{POINTS}{CELLS}CELL_DATA 2\nSCALARS s int\n1 2\n"
    assert old in whole
    at = whole.rindex(old)
    text = whole[:at] + new + whole[at + len(old) :]
    assert_unreadable(text_mesh(tmp_path, text, "m.vtk"), *words)


def test_a_curve_has_no_cells_but_is_read(tmp_path):
    curve = SURFACE[: SURFACE.index("VERTICES")] + "LINES 1 5\n4 0 1 2 3\n"
    mesh, source = read(text_mesh(tmp_path, curve, "m.vtk"))
    assert (mesh.dimension(), len(mesh.points)) == (-1, 5)
    assert source.lost == ("1 cell of type polyline, VTK_POLY_LINE (4)",)
