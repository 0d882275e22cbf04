"""VTK's data sets and arrays of every kind, and what is to be read of them."""

from __future__ import annotations

import numpy as np
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

vtk.vtkObject.GlobalWarningDisplayOff()

ARRAYS = {
    "char": vtk.vtkCharArray,
    "signed char": vtk.vtkSignedCharArray,
    "unsigned char": vtk.vtkUnsignedCharArray,
    "short": vtk.vtkShortArray,
    "unsigned short": vtk.vtkUnsignedShortArray,
    "int": vtk.vtkIntArray,
    "unsigned int": vtk.vtkUnsignedIntArray,
    "long": vtk.vtkLongArray,
    "unsigned long": vtk.vtkUnsignedLongArray,
    "long long": vtk.vtkLongLongArray,
    "type 64": vtk.vtkTypeInt64Array,
    "unsigned type 64": vtk.vtkTypeUInt64Array,
    "id": vtk.vtkIdTypeArray,
    "float": vtk.vtkFloatArray,
    "double": vtk.vtkDoubleArray,
    "bit": vtk.vtkBitArray,
}
# Cells of VTK's types: those of the same number of vertices, and those of any.
SIZES = {1: 1, 3: 2, 5: 3, 8: 4, 9: 4, 10: 4, 11: 8, 12: 8, 13: 6, 14: 5, 15: 10, 16: 12, 21: 3,
         22: 6, 23: 8, 24: 10, 25: 20, 26: 15, 27: 13, 28: 9, 29: 27, 30: 6, 31: 12, 32: 18,
         33: 24, 34: 7, 35: 4}  # fmt: skip
ANY = (0, 2, 4, 6, 7)
ORDERS = {8: [0, 1, 3, 2], 11: [0, 1, 3, 2, 4, 5, 7, 6], 13: [0, 2, 1, 3, 5, 4]}
OUT = {0: "VTK_EMPTY_CELL (0)", 4: "VTK_POLY_LINE (4)"}
FIELD = "TimeValue"
STRINGS = "names"


def array(kind, name, n, width, random):
    """An array with random values of one kind."""
    made = ARRAYS[kind]()
    made.SetName(name)
    made.SetNumberOfComponents(width)
    made.SetNumberOfTuples(n)
    for i in range(n * width):
        value = int(random.integers(2 if kind == "bit" else 100))
        if kind in ("float", "double"):
            value = float(random.normal() * 10.0 ** random.integers(-30, 30))
        made.SetValue(i, chr(value) if kind == "char" else value)
    return made


def with_arrays(data, random):
    """Give a data set arrays of all kinds, on points and on cells, and a field of its own."""
    sides = ((data.GetPointData(), data.GetNumberOfPoints()),
             (data.GetCellData(), data.GetNumberOfCells()))  # fmt: skip
    for held, n in sides:
        for kind in ARRAYS:  # of several bits, VTK writes a part only
            width = 1 if kind == "bit" else int(random.integers(1, 5))
            held.AddArray(array(kind, f"a {kind}, 100 %", n, width, random))
        held.SetScalars(array("int", "scalars", n, int(random.integers(1, 5)), random))
        held.SetVectors(array("double", "vectors", n, 3, random))
        held.SetNormals(array("float", "normals", n, 3, random))
        held.SetTCoords(array("float", "texture", n, int(random.integers(1, 4)), random))
        held.SetTensors(array("double", "tensors", n, 9, random))
        held.SetGlobalIds(array("id", "global ids", n, 1, random))
        held.SetPedigreeIds(array("id", "pedigree ids", n, 1, random))
        words = vtk.vtkStringArray()
        words.SetName(STRINGS)
        for i in range(n):
            words.InsertNextValue("a word, 1 % \n" * (i % 30))
        held.AddArray(words)
    time = vtk.vtkDoubleArray()
    time.SetName(FIELD)
    time.InsertNextValue(0.5)
    data.GetFieldData().AddArray(time)
    return data


def points(n, random, kind=vtk.VTK_DOUBLE):
    made = vtk.vtkPoints()
    made.SetDataType(kind)
    for _ in range(n):
        made.InsertNextPoint(*random.normal(size=3))
    return made


def ids(values):
    made = vtk.vtkIdList()
    for value in values:
        made.InsertNextId(int(value))
    return made


def unstructured(random):
    """Cells of every type that a mesh has or that is dropped, in any order."""
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points(30, random))
    for number in random.permutation([*SIZES, *ANY, 5, 10, 10, 6, 7, 2]).tolist():
        size = {0: 0, 7: random.integers(3, 5), 2: 3}.get(number, random.integers(3, 7))
        grid.InsertNextCell(number, ids(random.permutation(30)[: SIZES.get(number, size)]))
    return with_arrays(grid, random)


def surface(random):
    """Vertices, lines, polygons and strips."""
    data = vtk.vtkPolyData()
    data.SetPoints(points(30, random, vtk.VTK_FLOAT))
    for put, least, most in (
        (data.SetVerts, 1, 3),
        (data.SetLines, 2, 4),
        (data.SetPolys, 3, 5),
        (data.SetStrips, 3, 7),
    ):
        cells = vtk.vtkCellArray()
        for _ in range(random.integers(0 if put != data.SetPolys else 1, 5)):
            cells.InsertNextCell(ids(random.permutation(30)[: random.integers(least, most)]))
        put(cells)
    return with_arrays(data, random)


def image(random):
    """Equal steps in three, two or one directions."""
    data = vtk.vtkImageData()
    low = random.integers(-3, 3, 3)
    high = low + random.integers(0, 4, 3) * (random.random(3) < 0.8)
    data.SetExtent(*np.column_stack([low, high]).ravel().tolist())
    data.SetOrigin(*random.normal(size=3))
    data.SetSpacing(*random.uniform(0.1, 1, 3))
    return with_arrays(data, random)


def rectilinear(random):
    data = vtk.vtkRectilinearGrid()
    counts = random.integers(1, 5, 3).tolist()
    data.SetDimensions(*counts)
    puts = (data.SetXCoordinates, data.SetYCoordinates, data.SetZCoordinates)
    for put, n in zip(puts, counts, strict=True):
        axis = vtk.vtkDoubleArray()
        for value in np.cumsum(random.random(n)):
            axis.InsertNextValue(value)
        put(axis)
    return with_arrays(data, random)


def structured(random):
    data = vtk.vtkStructuredGrid()
    counts = random.integers(1, 5, 3).tolist()
    data.SetDimensions(*counts)
    data.SetPoints(points(int(np.prod(counts)), random))
    return with_arrays(data, random)


# Kinds of data sets: how to make one, how to write it with XML, and the extension then.
KINDS = {
    "unstructured": (unstructured, vtk.vtkXMLUnstructuredGridWriter, "vtu"),
    "surface": (surface, vtk.vtkXMLPolyDataWriter, "vtp"),
    "image": (image, vtk.vtkXMLImageDataWriter, "vti"),
    "rectilinear": (rectilinear, vtk.vtkXMLRectilinearGridWriter, "vtr"),
    "structured": (structured, vtk.vtkXMLStructuredGridWriter, "vts"),
}


def write_legacy(path, data, version, binary):
    writer = vtk.vtkDataSetWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    writer.SetFileVersion(version)
    writer.SetFileType(2 if binary else 1)
    assert writer.Write()


def read_legacy(path):
    """What VTK itself reads of a file."""
    reader = vtk.vtkDataSetReader()
    reader.SetFileName(str(path))
    for what in ("Scalars", "Vectors", "Normals", "Tensors", "TCoords", "Fields", "ColorScalars"):
        getattr(reader, f"ReadAll{what}On")()
    reader.Update()
    return reader.GetOutput()


def write_xml(path, data, writer, mode, compressor, wide, big, encoded):
    """Write with a data mode (0: text, 1: base64, 2: appended), a compressor (0: none), ..."""
    made = writer()
    made.SetInputData(data)
    made.SetFileName(str(path))
    made.SetDataMode(mode)
    made.SetCompressorType(compressor)
    made.SetBlockSize(1024)
    (made.SetHeaderTypeToUInt64 if wide else made.SetHeaderTypeToUInt32)()
    made.SetByteOrder(0 if big else 1)
    made.SetEncodeAppendedData(encoded)
    assert made.Write()


def read_xml(path):
    """What VTK itself reads of a file."""
    reader = vtk.vtkXMLGenericDataObjectReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def expected_cells(data):
    """The cells that a mesh has of a data set: their vertices, and their numbers in it."""
    for i in range(data.GetNumberOfCells()):
        number = data.GetCellType(i)
        if number in OUT:
            continue
        held = data.GetCell(i).GetPointIds()
        cell = [held.GetId(k) for k in range(held.GetNumberOfIds())]
        if number == 2:
            yield from (([vertex], i) for vertex in cell)
        elif number == 6:
            for k in range(len(cell) - 2):
                a, b, c = cell[k : k + 3]
                yield ([b, a, c] if k % 2 else [a, b, c]), i
        else:
            yield [cell[k] for k in ORDERS.get(number, range(len(cell)))], i


def values_of(held):
    """The arrays of points or cells, without strings."""
    found = {}
    for k in range(held.GetNumberOfArrays()):
        one = held.GetAbstractArray(k)
        width = one.GetNumberOfComponents()
        if isinstance(one, vtk.vtkBitArray):
            flat = np.array([one.GetValue(i) for i in range(one.GetNumberOfValues())], np.uint8)
            found[one.GetName()] = flat if width == 1 else flat.reshape(-1, width)
        elif not isinstance(one, vtk.vtkStringArray):
            found[one.GetName()] = vtk_to_numpy(one)
    return found


def assert_read_as_by_vtk(mesh, data):
    """Compare a mesh with a data set: points, cells, their numbers, and all arrays."""
    places = np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())]).reshape(-1, 3)
    np.testing.assert_allclose(mesh.points, places, rtol=1e-15, atol=1e-15)
    wanted = list(expected_cells(data))
    assert [row for b in mesh.blocks for row in b.cells.tolist()] == [row for row, _ in wanted]
    numbers, n = [], 0
    for block in mesh.blocks:
        here = np.arange(n, n + len(block.cells)) if block.numbers is None else block.numbers
        numbers, n = numbers + here.tolist(), n + len(block.cells)
    assert numbers == [number for _, number in wanted]
    fields = values_of(data.GetFieldData())
    assert {name: a.tolist() for name, a in mesh.fields.items()} == {
        name: a.tolist() for name, a in fields.items()
    }
    of_points, of_cells = values_of(data.GetPointData()), values_of(data.GetCellData())
    assert mesh.point_data.keys() == of_points.keys()
    for name, values in of_points.items():
        assert_equal(mesh.point_data[name], values)
    for block in mesh.blocks:
        assert block.data.keys() == of_cells.keys()
    for name, values in of_cells.items():
        if mesh.blocks:
            assert_equal(np.concatenate([b.data[name] for b in mesh.blocks]), values[numbers])


def assert_equal(found, values):
    assert found.dtype == values.dtype
    np.testing.assert_array_equal(found, values)
