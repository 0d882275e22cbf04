"""Files in pieces are one mesh: shared points once, ghosts once."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import FORMATS, Encoding, encoding_for, read, write
from meshopt_cli.mesh.model import Block, Mesh
from support.encodings import assert_unreadable
from support.meshes import tet_grid
from support.settings import examples

PIECE = FORMATS["vtu"].default


def parallel(folder, sources, kind="PUnstructuredGrid", extension="pvtu"):
    path = folder / f"whole.{extension}"
    pieces = "".join(f'<Piece Source="{source}"/>' for source in sources)
    path.write_text(
        f'<VTKFile type="{kind}" version="0.1"><{kind} GhostLevel="0">{pieces}</{kind}></VTKFile>'
    )
    return path


def in_one_file(folder, sources):
    """The pieces of several files in one."""
    texts = [(folder / source).read_text() for source in sources]
    start, end = texts[0].index("<Piece"), texts[0].index("</UnstructuredGrid>")
    pieces = [text[text.index("<Piece") : text.index("</UnstructuredGrid>")] for text in texts]
    path = folder / "pieces.vtu"
    path.write_text(texts[0][:start] + "".join(pieces) + texts[0][end:])
    return path


def cut(whole, owner, ghosts=0):
    """The parts of a mesh, one for each owner, with layers of neighbours as ghosts."""
    cells = whole.blocks[0].cells
    for part in range(owner.max() + 1):
        mine = owner == part
        near = mine.copy()
        for _ in range(ghosts):
            near = np.isin(cells, np.unique(cells[near])).any(axis=1)
        used = np.unique(cells[near])
        data = {name: values[near] for name, values in whole.blocks[0].data.items()}
        if ghosts:
            data["vtkGhostType"] = (~mine[near]).astype(np.uint8)
        block = Block("tetra", np.searchsorted(used, cells[near]), data)
        point_data = {name: values[used] for name, values in whole.point_data.items()}
        yield Mesh(whole.points[used], [block], point_data)


def write_all(folder, parts):
    names = []
    for i, part in enumerate(parts):
        names.append(f"part_{i}.vtu")
        write(folder / names[-1], part, PIECE)
    return names


def made_of(mesh):
    """Coordinates and arrays of all cells, in an order of their own."""
    cells = np.concatenate([b.cells for b in mesh.blocks])
    n = np.concatenate([b.data["n"] for b in mesh.blocks])
    order = np.argsort(n)
    return mesh.points[cells[order]], n[order], mesh.point_data["T"][cells[order]]


def shaken(seed, ids):
    random = np.random.default_rng(seed)
    whole = tet_grid(3)
    whole.points = whole.points + random.normal(0, 0.01, whole.points.shape)
    whole.blocks[0].data["n"] = np.arange(len(whole.blocks[0].cells))
    whole.point_data["T"] = random.normal(size=len(whole.points))
    if ids:
        whole.point_data["GlobalNodeID"] = random.permutation(len(whole.points)) + 7
    return whole


@examples(12)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 5),
    ghosts=st.integers(0, 2),
    ids=st.booleans(),
    one_file=st.booleans(),
)
def test_pieces_make_the_whole(tmp_path_factory, seed, n, ghosts, ids, one_file):
    folder = tmp_path_factory.mktemp("pieces")
    whole = shaken(seed, ids)
    owner = np.random.default_rng(seed).integers(0, n, len(whole.blocks[0].cells))
    owner[:n] = np.arange(n)
    parts = list(cut(whole, owner, ghosts if n > 1 else 0))
    names = write_all(folder, parts)
    mesh, source = read((in_one_file if one_file else parallel)(folder, names))
    assert len(mesh.points) == len(whole.points)
    for found, wanted in zip(made_of(mesh), made_of(whole), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert ("GlobalNodeID" in mesh.point_data) == ids
    extra = sum(len(part.blocks[0].cells) for part in parts) - len(owner)
    said = [f"{extra} ghost cell{'s' * (extra > 1)}, which other pieces have"] if extra else []
    assert list(source.lost) == said


def two_halves(whole):
    x = whole.points[whole.blocks[0].cells].mean(axis=1)[:, 0]
    owner = (x > np.median(x)).astype(int)
    return list(cut(whole, owner))


def test_numbers_of_points_go_before_coordinates(tmp_path):
    """They agree where coordinates do not, to rounding."""
    whole = shaken(1, ids=True)
    parts = two_halves(whole)
    parts[1].points = parts[1].points * (1 + 1e-12)
    mesh, source = read(parallel(tmp_path, write_all(tmp_path, parts)))
    assert len(mesh.points) == len(whole.points)
    assert source.lost == ()
    for part in parts:
        del part.point_data["GlobalNodeID"]
    mesh, _ = read(parallel(tmp_path, write_all(tmp_path, parts)))
    assert len(mesh.points) == sum(len(part.points) for part in parts)


def test_numbers_that_each_piece_counts_for_itself_are_not_believed(tmp_path):
    whole = shaken(1, ids=False)
    parts = two_halves(whole)
    for part in parts:
        part.point_data["GlobalNodeID"] = np.arange(len(part.points))
    mesh, source = read(parallel(tmp_path, write_all(tmp_path, parts)))
    assert len(mesh.points) == len(whole.points)
    assert "GlobalNodeID" in source.lost[0]


def test_points_of_a_piece_in_one_place_stay_apart(tmp_path):
    whole = shaken(2, ids=False)
    split = Mesh(np.tile(whole.points, (2, 1)), [], {"T": np.tile(whole.point_data["T"], 2)})
    split.blocks = [Block("tetra", whole.blocks[0].cells, {"n": whole.blocks[0].data["n"]})]
    mesh, _ = read(parallel(tmp_path, write_all(tmp_path, [split, whole])))
    assert len(mesh.points) == 3 * len(whole.points)


def test_arrays_that_differ_are_named(tmp_path):
    parts = two_halves(shaken(3, ids=False))
    parts[0].point_data["only"] = np.zeros(len(parts[0].points))
    parts[1].point_data["T"] = parts[1].point_data["T"] + 1
    parts[1].blocks[0].data["n"] = np.zeros((len(parts[1].blocks[0].cells), 2))
    mesh, source = read(parallel(tmp_path, write_all(tmp_path, parts)))
    assert not mesh.blocks[0].data
    assert list(mesh.point_data) == ["T"]
    assert sorted(lost.split()[0] for lost in source.lost) == ["n,", "only,", "other"]


def test_cells_in_several_pieces_are_there_once(tmp_path):
    whole = shaken(4, ids=False)
    names = write_all(tmp_path, [whole, whole])
    mesh, source = read(parallel(tmp_path, names))
    n = len(whole.blocks[0].cells)
    assert len(mesh.blocks[0].cells) == n
    assert source.lost == (f"{n} cells that an earlier piece has too",)


def test_vertex_numbers_out_of_range_stay_so(tmp_path):
    parts = two_halves(shaken(5, ids=False))
    parts[0].blocks[0].cells[3, 1] = len(parts[0].points)
    parts[1].blocks[0].cells[2, 1] = -1
    mesh, _ = read(parallel(tmp_path, write_all(tmp_path, parts)))
    cells = np.concatenate([b.cells for b in mesh.blocks])
    assert np.count_nonzero(cells == -1) == 2


def test_empty_pieces_say_nothing(tmp_path):
    whole = shaken(6, ids=False)
    names = write_all(tmp_path, [Mesh(np.empty((0, 3)), []), whole])
    mesh, source = read(parallel(tmp_path, names))
    assert len(mesh.points) == len(whole.points)
    assert "n" in mesh.blocks[0].data
    assert source.lost == ()


def test_what_is_wrong_with_pieces_is_said(tmp_path):
    (name,) = write_all(tmp_path, [shaken(7, ids=False)])
    assert_unreadable(parallel(tmp_path, [name, "no.vtu"]), "no.vtu", "no such file")
    assert_unreadable(parallel(tmp_path, [name, "whole.pvtu"]), "whole.pvtu", "PUnstructuredGrid")
    assert_unreadable(parallel(tmp_path, []), "names no files")
    (tmp_path / "bad.vtu").write_bytes((tmp_path / name).read_bytes()[:-300])
    assert_unreadable(parallel(tmp_path, [name, "bad.vtu"]), "bad.vtu", "truncated")


@pytest.mark.parametrize("extension", [".vtm", ".pvd", ".vtkhdf"])
def test_files_that_are_no_mesh_say_what_to_do(tmp_path, extension):
    path = tmp_path / f"mesh{extension}"
    path.write_text("<VTKFile>")
    with pytest.raises(ReadError, match=r"give those|save it"):
        read(path)


def test_pieces_are_written_as_one_vtu(tmp_path):
    names = write_all(tmp_path, two_halves(shaken(8, ids=False)))
    _, source = read(parallel(tmp_path, names))
    assert encoding_for(tmp_path / "out.vtu", source.encoding) == Encoding(
        "vtu", "0.1", binary=True, compressed=True
    )


@pytest.mark.parametrize(("n", "level"), list(itertools.product((1, 3), (0, 1, 2))))
def test_as_vtk_cuts_it(tmp_path, n, level):
    vtk = pytest.importorskip("vtk")
    grid = vtk.vtkImageData()
    grid.SetDimensions(4, 4, 4)
    cells = vtk.vtkDataSetTriangleFilter()
    cells.SetInputData(grid)
    pieces = vtk.vtkExtractUnstructuredGridPiece()
    pieces.SetInputConnection(cells.GetOutputPort())
    writer = vtk.vtkXMLPUnstructuredGridWriter()
    writer.SetInputConnection(pieces.GetOutputPort())
    writer.SetNumberOfPieces(n)
    writer.SetEndPiece(n - 1)
    writer.SetGhostLevel(level)
    writer.SetFileName(str(tmp_path / "cut.pvtu"))
    writer.Write()
    mesh, _ = read(tmp_path / "cut.pvtu")
    assert len(mesh.points) == 64
    assert sum(len(b.cells) for b in mesh.blocks) == cells.GetOutput().GetNumberOfCells()
    marked = any("Ghost" in name for name in [*mesh.point_data, *mesh.blocks[0].data])
    assert marked == (n == 1 and level > 0)
