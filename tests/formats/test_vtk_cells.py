"""VTK's types of cells: what becomes of each, with XML and without."""

import numpy as np
import pytest

from meshopt_cli.formats import FORMATS, read, write
from meshopt_cli.formats.numbering import numbering
from meshopt_cli.formats.vtk.cells import NUMBERS, TYPES
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import assert_unreadable, text_mesh

TET, TRIANGLE, LINE = 10, 5, 3
CELLS = {TET: [0, 1, 2, 3], TRIANGLE: [0, 1, 2], LINE: [0, 1]}


def legacy(cells):
    stream = "\n".join(" ".join(map(str, [len(cell), *cell])) for _, cell in cells)
    size = sum(len(cell) + 1 for _, cell in cells)
    types = " ".join(str(number) for number, _ in cells)
    return f"CELLS {len(cells)} {size}\n{stream}\nCELL_TYPES {len(cells)}\n{types}\n"


def file_of(folder, cells, points, extension):
    """A file with a list of types and vertices, and the array "n" that numbers them."""
    n, numbers = len(cells), " ".join(map(str, range(len(cells))))
    places = " ".join(map(str, np.ravel(points).tolist()))
    if extension == "vtk":
        text = (
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
            f"POINTS {len(points)} double\n{places}\n{legacy(cells)}"
            f"CELL_DATA {n}\nSCALARS n int\n{numbers}\n"
        )
        return text_mesh(folder, text, "mesh.vtk")
    rows = {
        "connectivity": [v for _, cell in cells for v in cell],
        "offsets": np.cumsum([len(cell) for _, cell in cells]).tolist(),
        "types": [number for number, _ in cells],
    }
    head = '<DataArray type="Int64" format="ascii" Name='
    arrays = "".join(
        f'{head}"{name}">{" ".join(map(str, row))}</DataArray>' for name, row in rows.items()
    )
    text = (
        f'<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{n}"><CellData>'
        f'<DataArray type="Int32" Name="n" format="ascii">{numbers}</DataArray></CellData>'
        f'<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{places}'
        f"</DataArray></Points><Cells>{arrays}</Cells></Piece></UnstructuredGrid></VTKFile>"
    )
    return text_mesh(folder, text, "mesh.vtu")


POINTS = np.random.default_rng(0).random((32, 3)).round(3)
both = pytest.mark.parametrize("extension", ["vtk", "vtu"])


@both
@pytest.mark.parametrize(
    ("number", "cell", "kind", "rows"),
    [
        (8, [0, 1, 2, 3], "quad", [[0, 1, 3, 2]]),
        (11, list(range(8)), "hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]]),
        (13, list(range(6)), "wedge", [[0, 2, 1, 3, 5, 4]]),
        (6, [0, 1, 2, 3, 4], "triangle", [[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
        (7, [0, 1, 2], "triangle", [[0, 1, 2]]),
        (7, [0, 1, 2, 3], "quad", [[0, 1, 2, 3]]),
        (2, [3, 1, 2], "vertex", [[3], [1], [2]]),
        (4, [3, 1], "line", [[3, 1]]),
        (71, [3, 1, 2, 0], "tetra", [[3, 1, 2, 0]]),
        (73, list(range(6)), "wedge", [list(range(6))]),
        (79, list(range(8)), "hexahedron", [list(range(8))]),
    ],
)
def test_types_that_are_converted(tmp_path, extension, number, cell, kind, rows):
    path = file_of(tmp_path, [(number, cell), (number, cell[::-1])], POINTS, extension)
    (block,) = read(path)[0].blocks
    assert block.type == kind
    assert block.cells[: len(rows)].tolist() == rows
    assert block.data["n"].tolist() == [0] * len(rows) + [1] * len(rows)


@both
@pytest.mark.parametrize("kind", NUMBERS)
def test_types_of_a_block_keep_their_vertices(tmp_path, extension, kind):
    n = TYPES[NUMBERS[kind]].n
    mesh = Mesh(np.random.default_rng(1).random((n, 3)), [Block(kind, np.arange(n)[None])])
    path = tmp_path / f"mesh.{extension}"
    write(path, mesh, FORMATS[extension].default)
    (block,) = read(path)[0].blocks
    assert (block.type, block.cells.tolist()) == (kind, [list(range(n))])


def test_the_table_has_the_types_of_vtk():
    vtk = pytest.importorskip("vtk")
    names = {name for name in dir(vtk) if name.startswith("VTK_") and not name.endswith("TYPES")}
    for number, row in TYPES.items():
        assert row.name in names
        assert getattr(vtk, row.name) == number
        made = vtk.vtkGenericCell.InstantiateCell(number)
        if made is not None:
            assert made.GetCellDimension() == max(row.dimension, 0)
            assert row.n in (0, made.GetNumberOfPoints())


@both
@pytest.mark.parametrize("number", [n for n, row in TYPES.items() if not row.type] + [99])
def test_types_that_stay_out(tmp_path, extension, number):
    """They are dropped beside cells of greater dimension, and else the file is refused."""
    dimension = TYPES[number].dimension if number in TYPES else 3
    out = (number, list(range(7)) if dimension > 0 else [])  # no first order has seven
    if number in (2, 6):
        pytest.skip("always converted")
    if number in (8, 11):
        assert_unreadable(
            file_of(tmp_path, [out], POINTS, extension), TYPES[number].name, "7 vertices"
        )
        return
    larger = {-1: LINE, 0: LINE, 1: TRIANGLE, 2: TET}
    cells = [out, (larger.get(dimension, TET), CELLS[larger.get(dimension, TET)]), out]
    path = file_of(tmp_path, cells, POINTS, extension)
    name = TYPES[number].name if number in TYPES else "99"
    if dimension == 3:
        assert_unreadable(path, f"{name} ({number})" if number in TYPES else name)
        return
    mesh, source = read(path)
    (lost,) = source.lost
    assert lost.startswith("2 cells of type")
    assert name in lost
    assert mesh.blocks[0].data["n"].tolist() == [1]
    alone = file_of(tmp_path, [out, (LINE, [0, 1])], POINTS, extension)
    if number == 4:
        assert [block.type for block in read(alone)[0].blocks] == ["line"]
    elif dimension > 0:
        assert_unreadable(alone, name)


@both
def test_cells_are_numbered_as_in_the_file(tmp_path, extension):
    """A finding names the cell of the file, where others stayed out or were divided."""
    cells = [
        (4, [0, 1, 2]),
        (6, [0, 1, 2, 3]),
        (TRIANGLE, [1, 2, 4]),
        (0, []),
        (TRIANGLE, [2, 3, 4]),
    ]
    mesh, source = read(file_of(tmp_path, cells, POINTS, extension))
    names = numbering(source.encoding, mesh)
    (block,) = mesh.blocks
    found = [names.cell(0, row) for row in range(len(block.cells))]
    assert found == ["cell 1", "cell 1", "cell 2", "cell 4"]


@both
def test_cells_that_are_all_there_need_no_numbers(tmp_path, extension):
    cells = [(TRIANGLE, [0, 1, 2]), (8, [0, 1, 2, 3]), (TRIANGLE, [1, 2, 4])]
    mesh, source = read(file_of(tmp_path, cells, POINTS, extension))
    assert [block.numbers for block in mesh.blocks] == [None] * 3
    assert numbering(source.encoding, mesh).cell(2, 0) == "cell 2"


@both
def test_hidden_cells_are_named(tmp_path, extension):
    cells = [(TRIANGLE, [0, 1, 2]), (TRIANGLE, [1, 2, 3]), (TRIANGLE, [2, 3, 4])]
    path = file_of(tmp_path, cells, POINTS, extension)
    text = path.read_text().replace("n int\n0 1 2", "vtkGhostType int\n0 32 0")
    text = text.replace('"n" format="ascii">0 1 2', '"vtkGhostType" format="ascii">0 32 0')
    path.write_text(text)
    mesh, source = read(path)
    assert mesh.blocks[0].cells.tolist() == [[0, 1, 2], [2, 3, 4]]
    assert source.lost == ("1 hidden cell",)
