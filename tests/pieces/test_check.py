"""The check of a mesh in pieces finds what is wrong between them."""

from __future__ import annotations

import pytest

from meshopt_cli.errors import EXIT_BAD_MESH, EXIT_DONE, EXIT_FILES
from meshopt_cli.formats.vtk.parallel import sources_of
from meshopt_cli.jobs.check import Task
from meshopt_cli.mesh.pieces import IDS
from meshopt_cli.pieces.check import check_pieces
from meshopt_cli.pieces.engines import Here
from meshopt_cli.quality.gates import NO_GATES
from support.edits import shaken
from support.files import write
from support.meshes import hex_grid, in_space, tet_grid, tri_grid


def verdicts(index):
    task = Task((), (), (), NO_GATES, None, None)
    return list(check_pieces(index, task, Here()))


@pytest.fixture(params=["tets", "triangles", "hexahedra"])
def index(request, tmp_path, pieces_of):
    made = {
        "tets": lambda: shaken(tet_grid(5)),
        "triangles": lambda: in_space(shaken(tri_grid(12))),
        "hexahedra": lambda: hex_grid(5),
    }
    return pieces_of(write(tmp_path / "in.vtu", made[request.param]()), 4)


def changed(index, k, read, change):
    path, piece = sources_of(index)[k], read(index)[k]
    write(path, change(piece) or piece)


def test_a_valid_mesh_is_valid_in_pieces(index):
    found = verdicts(index)
    assert [one.status for one in found] == [EXIT_DONE] * 5
    assert found[-1].path == str(index)


def test_a_valid_mesh_is_valid_in_pieces_without_numbers(index, read):
    for k in range(4):
        changed(index, k, read, lambda piece: piece.point_data.clear())
    assert all(one.status == EXIT_DONE for one in verdicts(index))


def shared(index, read):
    """A point of the first piece that another one has, by its row there."""
    one, *others = read(index)
    for row, number in enumerate(one.point_data[IDS].tolist()):
        if any(number in other.point_data[IDS] for other in others):
            return row
    raise AssertionError


def code_of(found):
    assert found[-1].status == EXIT_BAD_MESH
    assert all(one.is_valid for one in found[:-1])
    return set(found[-1].counts)


def test_a_point_that_lies_elsewhere_in_another_piece(index, read):
    row = shared(index, read)

    def move(piece):
        piece.points[row] += 1e-6

    changed(index, 0, read, move)
    assert "M205" in code_of(verdicts(index))


def test_a_point_that_is_called_otherwise_in_another_piece(index, read):
    row = shared(index, read)

    def rename(piece):
        piece.point_data[IDS][row] = 10**9

    changed(index, 0, read, rename)
    assert "M202" in code_of(verdicts(index))


def test_a_piece_that_is_there_twice(index, read):
    piece = read(index)[1]
    changed(index, 2, read, lambda _: piece)
    assert code_of(verdicts(index)) & {"M204", "M207"}


def test_cells_turned_over_in_a_piece(index, read):
    def turn(piece):
        for block in piece.blocks:
            block.cells[:, :2] = block.cells[:, [1, 0]]

    changed(index, 0, read, turn)
    found = verdicts(index)
    assert any(not one.is_valid for one in found)


def test_a_file_that_is_missing(index):
    sources_of(index)[2].unlink()
    found = verdicts(index)
    assert [one.status for one in found] == [EXIT_DONE, EXIT_DONE, EXIT_FILES, EXIT_DONE]
