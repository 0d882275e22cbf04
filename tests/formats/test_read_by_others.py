"""What is written is read by others, where they know the format: meshio, VTK, Gmsh, Mmg."""

import contextlib
import io
import os
import subprocess
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, write
from meshopt_cli.formats import read as read_again
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import (
    ENCODINGS,
    GEOMETRICAL,
    PHYSICAL,
    REF,
    Encoding,
    name_of,
    path_for,
    tagged,
    zoo,
)
from support.meshes import tet_grid

DIMENSIONS = {"line": 1, "triangle": 2, "tetra": 3}
NARROW = ("int", "byte")


def beyond_meshio(encoding):
    """Arrays that meshio does not read: it has no name of VTK's for narrow integers in version 5,
    and counts the cells of several types wrongly for a view in version 2.2 of Gmsh.
    """
    if encoding.format == "vtk" and encoding.version >= "5":
        return NARROW
    return ("v",) if encoding.format == "gmsh22" else ()


def whole(encoding):
    """Tetrahedra in two groups, with a triangle and a line of the boundary, and arrays.

    Coordinates have few digits, as Mmg writes them; it takes values of points for sizes.
    """
    grid = tet_grid(2)
    tets = grid.blocks[0].cells
    groups = [np.array([5]), np.array([4]), 1 + np.arange(len(tets)) % 2]
    cells = [np.array([[0, 1]]), tets[:1, :3], tets]
    mesh = Mesh(grid.points, [], {"T": 1 + grid.points[:, 0] / 7})
    if FORMATS[encoding.format].family in ("vtk", "vtu"):
        mesh.fields = {"TIME": np.array([0.25]), "box": np.arange(6).reshape(2, 3)}
    for kind, rows, group in zip(DIMENSIONS, cells, groups, strict=True):
        data = {PHYSICAL: group, GEOMETRICAL: group, REF: group}
        if FORMATS[encoding.format].family in ("vtk", "vtu"):
            data |= {"int": group.astype(np.int32), "byte": group.astype(np.uint8)}
        data["v"] = np.linspace(0, 1 / 3, 3 * len(rows)).reshape(-1, 3)
        mesh.blocks.append(Block(kind, rows, data))
    return mesh


def places_of(points, rows):
    """The corners of cells by their coordinates: others may number points anew."""
    return sorted(sorted(points[row].tolist()) for row in np.asarray(rows, int))


def by_meshio(path, encoding):
    """Points, the cells of each type, and arrays of cells."""
    import meshio

    kind = "gmsh" if encoding.format.startswith("gmsh") else None
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        mesh = meshio.read(path, kind)
    cells = {b.type: [] for b in mesh.cells}
    for block in mesh.cells:
        cells[block.type] += block.data.tolist()
    names = [name for name in mesh.cell_data if ":" in name or name in ("v", *NARROW)]
    return mesh.points, cells, {name: np.concatenate(mesh.cell_data[name]) for name in names}


def by_vtk(path, encoding):
    vtk = pytest.importorskip("vtk")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    xml = encoding.format == "vtu"
    reader = vtk.vtkXMLUnstructuredGridReader() if xml else vtk.vtkUnstructuredGridReader()
    reader.SetFileName(str(path))
    if not xml:
        reader.ReadAllFieldsOn()
    reader.Update()
    data = reader.GetOutput()
    kinds = {3: "line", 5: "triangle", 10: "tetra"}
    cells = {kind: [] for kind in kinds.values()}
    for i in range(data.GetNumberOfCells()):
        held = data.GetCell(i).GetPointIds()
        cells[kinds[data.GetCellType(i)]].append(
            [held.GetId(k) for k in range(held.GetNumberOfIds())]
        )
    held = data.GetCellData()
    names = [held.GetArrayName(i) for i in range(held.GetNumberOfArrays())]
    arrays = {name: vtk_to_numpy(held.GetArray(name)) for name in names}
    return vtk_to_numpy(data.GetPoints().GetData()), cells, arrays


def by_gmsh(path, encoding):
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        tags, places, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        first = int(tags.min())
        cells = {}
        for kind, number in (("line", 1), ("triangle", 2), ("tetra", 4)):
            _, nodes = gmsh.model.mesh.getElementsByType(number)
            cells[kind] = (nodes.reshape(-1, DIMENSIONS[kind] + 1).astype(int) - first).tolist()
        return places.reshape(-1, 3)[order], cells, {}
    finally:
        gmsh.finalize()


def by_mmg(path, encoding):
    """What Mmg's program writes again, when it is told to change nothing; it adds a boundary."""
    spec = find_spec("mmgpy") or pytest.skip("mmgpy is not installed")
    folder = Path(spec.submodule_search_locations[0])
    program, again = folder / "bin" / "mmg3d_O3", path.with_name("again.mesh")
    idle = ["-noinsert", "-noswap", "-nomove", "-nosurf", "-v", "0"]
    environment = os.environ | {"LD_LIBRARY_PATH": str(folder / "lib")}
    subprocess.run(
        [program, *idle, "-in", path, "-out", again],
        env=environment,
        capture_output=True,
        check=True,
    )
    mesh, _ = read_again(again)
    (tets,) = (block for block in mesh.blocks if block.type == "tetra")
    return mesh.points, {"tetra": tets.cells}, {REF: tets.data[REF]}


# What each of them knows, by name.
READERS = {
    "meshio": (by_meshio, lambda e: not (e.format == "medit" and e.version > "2")),
    "vtk": (by_vtk, lambda e: e.format in ("vtk", "vtu")),
    # of VTK, Gmsh reads no version from 5 on, and no binary files, its own included
    "gmsh": (
        by_gmsh,
        lambda e: (
            e.format.startswith("gmsh") or (e.format == "vtk" and e.version < "5" and not e.binary)
        ),
    ),
    "mmg": (
        by_mmg,
        lambda e: e.format in ("gmsh22", "medit") or (e.format == "meditb" and e.version < "3"),
    ),
}
# One version of each kind is a default; the other one has to be asked for.
ALL = [*ENCODINGS, *(Encoding("vtk", "5.1", binary=binary) for binary in (False, True))]
ALL = list(dict.fromkeys(ALL))


@pytest.mark.parametrize("encoding", ALL, ids=name_of)
@pytest.mark.parametrize("reader", READERS)
def test_others_read_what_is_written(tmp_path, encoding, reader):
    read, knows = READERS[reader]
    if not knows(encoding):
        pytest.skip(f"{reader} does not know it")
    mesh = whole(encoding)
    beyond = beyond_meshio(encoding) if reader == "meshio" else ()
    for block in mesh.blocks:
        block.data = {name: a for name, a in block.data.items() if name not in beyond}
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    points, cells, arrays = read(path, encoding)
    assert sorted(points.tolist()) == sorted(mesh.points.tolist())
    for block in mesh.blocks:
        if block.type in cells:
            assert places_of(points, cells[block.type]) == places_of(mesh.points, block.cells)
    assert cells.keys() == ({"tetra"} if reader == "mmg" else DIMENSIONS.keys())
    if reader in ("meshio", "vtk"):
        assert arrays
    if FORMATS[encoding.format].family in ("vtk", "vtu"):
        for name in mesh.blocks[0].data if reader in ("meshio", "vtk") else ():
            wanted = np.concatenate([block.data[name] for block in mesh.blocks])
            assert arrays[name].dtype == wanted.dtype
            np.testing.assert_array_equal(arrays[name], wanted)
    elif reader == "mmg":
        assert sorted(arrays[REF]) == sorted(mesh.blocks[-1].data[REF])


@pytest.mark.parametrize(
    "encoding", [e for e in ALL if FORMATS[e.format].family in ("vtk", "vtu")], ids=name_of
)
def test_cells_of_every_linear_type_go_to_vtk(tmp_path, encoding):
    """Each has the volume there that it has here."""
    vtk = pytest.importorskip("vtk")
    mesh = tagged(zoo(), encoding)
    path = path_for(tmp_path, encoding)
    write(path, mesh, encoding)
    xml = encoding.format == "vtu"
    reader = vtk.vtkXMLUnstructuredGridReader() if xml else vtk.vtkUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    assert data.GetNumberOfCells() == len(mesh.blocks)
    assert data.GetCellData().GetNumberOfArrays() == len(mesh.blocks[0].data)
    assert data.GetPointData().GetNumberOfArrays() == len(mesh.point_data)
