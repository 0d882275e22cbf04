"""Meshes are optimized piece by piece: as well as in one, with the same bytes whoever does it."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.boundary.policy import Slide
from meshopt_cli.errors import (
    BadMeshError,
    ConfigError,
    ReadError,
    UnsupportedMeshError,
    WriteError,
)
from meshopt_cli.formats.vtk.parallel import folder_of, sources_of
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.jobs.optimize_mesh import Task
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.pieces import IDS, border_facets
from meshopt_cli.pieces.engines import Here, local
from meshopt_cli.pieces.run import PiecesTask, optimize_pieces
from meshopt_cli.plans.config import Request
from meshopt_cli.validity import check
from support.broken import BROKEN
from support.edits import shaken
from support.files import contents, write
from support.meshes import hex_grid, in_space, mesh, quad_grid, tet_grid


def task(index, output, preset="standard", **options):
    return PiecesTask(index, output, Task(Request(preset=preset), **options))


def optimized(index, tmp_path, name="out", preset="standard", engine=None):
    output = tmp_path / f"{name}.pvtu"
    report = optimize_pieces(task(index, output, preset), engine or Here())
    return report, output


def bytes_of(index):
    return [data for _, data in sorted(contents(folder_of(index)).items())]


@pytest.mark.parametrize("kind", ["whole", "triangles"])
@pytest.mark.parametrize("n", [1, 2, 6])
def test_it_is_as_good_as_in_one_piece(kind, n, request, pieces_of, tmp_path):
    path = request.getfixturevalue(kind)
    report, output = optimized(pieces_of(path, n), tmp_path)
    alone = optimize_file(
        FileTask(path, tmp_path / "alone.vtu", Task(Request(preset="standard")))
    ).result
    assert report.before.n_cells == alone.before.n_cells
    assert report.before.n_points == alone.before.n_points
    assert report.before.mean == pytest.approx(alone.before.mean)
    assert report.before.worst == alone.before.worst
    assert report.after.worst <= 1.35 * alone.after.worst
    assert report.after.mean <= 1.05 * alone.after.mean
    mesh = formats.read(output)[0]
    assert check(mesh).is_valid
    assert sum(len(b.cells) for b in mesh.blocks) == report.after.n_cells
    assert len(mesh.points) == report.after.n_points


def facets_by_place(mesh):
    return {
        frozenset(p.tobytes() for p in mesh.points[facet])
        for rows in border_facets(mesh).values()
        for facet in rows
    }


def test_the_boundary_and_the_regions_stay(whole, pieces_of, tmp_path):
    _, output = optimized(pieces_of(whole, 5), tmp_path)
    before, after = formats.read(whole)[0], formats.read(output)[0]
    assert facets_by_place(before) == facets_by_place(after)
    for tag in (0, 1):
        sides = []
        for one in (before, after):
            blocks = [b.cells[b.data["gmsh:physical"] == tag] for b in one.blocks]
            only = Mesh(one.points, [Block("tetra", np.concatenate(blocks))])
            sides.append(facets_by_place(only))
        assert sides[0] == sides[1]


def test_pieces_fit_bit_for_bit_and_have_numbers_of_their_own(whole, pieces_of, tmp_path, read):
    _, output = optimized(pieces_of(whole, 5), tmp_path)
    places = {}
    for piece in read(output):
        ids = piece.point_data[IDS].tolist()
        assert len(set(ids)) == len(ids)
        for number, place in zip(ids, piece.points, strict=True):
            assert places.setdefault(number, place.tobytes()) == place.tobytes()
    assert max(places) < 2 * len(places) + 1000
    assert sorted(set(places.values())) == sorted(places.values())


def test_data_go_along(pieces_of, tmp_path, read):
    """Fields that are linear stay so, and numbers of cells and points stay their own."""
    of = shaken(tet_grid(8), 0.25, 3)
    n, cells = len(of.points), of.blocks[0].cells
    of.point_data = {
        "t": of.points @ [1.0, -2.0, 3.0],
        "node_id": np.arange(7, n + 7, dtype="i4"),
    }
    of.blocks[0].data = {"cell_id": np.arange(1, len(cells) + 1), "w": np.full(len(cells), 2.5)}
    index = pieces_of(write(tmp_path / "data.vtu", of), 4)
    report, output = optimized(index, tmp_path)
    after = formats.read(output)[0]
    np.testing.assert_allclose(after.point_data["t"], after.points @ [1.0, -2.0, 3.0], atol=1e-9)
    assert after.point_data["node_id"].dtype == np.int32
    (block,) = after.blocks
    assert set(block.data) == {"cell_id", "w"}
    assert (block.data["w"] == 2.5).all()
    for numbers in (block.data["cell_id"], after.point_data["node_id"], after.point_data[IDS]):
        assert len(set(numbers.tolist())) == len(numbers)
        assert numbers.max() < 10 * len(numbers)
    before = dict(zip(of.point_data["node_id"].tolist(), range(n), strict=True))
    kept = [number for number in after.point_data["node_id"].tolist() if number in before]
    assert len(kept) > n // 2
    assert report.after.n_cells == len(block.cells)


def test_the_report_tells_what_the_boundary_allows_and_the_regions(whole, pieces_of, tmp_path):
    report, _ = optimized(pieces_of(whole, 5), tmp_path, preset="fast")
    alone = optimize_file(
        FileTask(whole, tmp_path / "alone.vtu", Task(Request(preset="fast")))
    ).report
    assert report.before.target == alone.before.target
    assert report.after.target == alone.after.target
    assert report.regions == alone.regions
    assert report.before.counts == alone.before.counts
    assert report.before.types == alone.before.types
    worst = [(cell.quality, cell.where) for cell in report.before.worst_cells]
    assert worst == [(cell.quality, cell.where) for cell in alone.before.worst_cells]
    assert all(cell.cell.startswith("piece ") for cell in report.after.worst_cells)


def test_nobody_changes_a_byte(whole, pieces_of, tmp_path):
    index = pieces_of(whole, 4)
    _, expected = optimized(index, tmp_path)
    for jobs in (2, 3):
        with local(jobs, quiet, 0) as engine:
            _, output = optimized(index, tmp_path, f"by{jobs}", engine=engine)
        assert bytes_of(output) == bytes_of(expected)


def quiet(verbosity):
    """Set up a process."""


class Ending:
    """An engine that is ended after so many steps, and one that does each of them once more."""

    def __init__(self, left):
        self.left = left
        self.done = 0

    def map(self, step, calls):
        for i, call in enumerate(calls):
            if self.left == 0:
                raise KeyboardInterrupt
            self.left -= 1
            self.done += 1
            yield i, step(*call)


@pytest.mark.parametrize("after", [2, 5, 9, 14])
def test_a_run_goes_on_where_it_was_ended(after, whole, pieces_of, tmp_path):
    index = pieces_of(whole, 3)
    first = Ending(-1)
    _, expected = optimized(index, tmp_path, "expected", "fast", first)
    with pytest.raises(KeyboardInterrupt):
        optimized(index, tmp_path, preset="fast", engine=Ending(after))
    assert not (tmp_path / "out.pvtu").exists()
    again = Ending(-1)
    _, output = optimized(index, tmp_path, preset="fast", engine=again)
    assert again.done == first.done - after
    assert bytes_of(output) == bytes_of(expected)
    assert not output.with_suffix(".work").exists()


def test_another_job_does_not_go_on(whole, pieces_of, tmp_path):
    index = pieces_of(whole, 3)
    with pytest.raises(KeyboardInterrupt):
        optimized(index, tmp_path, preset="fast", engine=Ending(5))
    again, first = Ending(-1), Ending(-1)
    _, output = optimized(index, tmp_path, preset="standard", engine=again)
    _, other = optimized(index, tmp_path, "other", "standard", first)
    assert again.done == first.done
    assert bytes_of(output) == bytes_of(other)


def test_pieces_without_numbers_fit_by_place(whole, pieces_of, tmp_path, read):
    index = pieces_of(whole, 4)
    _, expected = optimized(index, tmp_path, "expected")
    for path, piece in zip(sources_of(index), read(index), strict=True):
        del piece.point_data[IDS]
        write(path, piece)
    report, output = optimized(index, tmp_path)
    assert check(formats.read(output)[0]).is_valid
    assert facets_by_place(formats.read(output)[0]) == facets_by_place(formats.read(expected)[0])
    assert report.after.n_points == len(formats.read(output)[0].points)


def test_ghosts_are_left_out(whole, pieces_of, tmp_path, read):
    index = pieces_of(whole, 2)
    one, other = read(index)
    n = len(other.points)
    ghost = other.blocks[0].cells[:20]
    number = n + np.arange(len(ghost) * 4)
    first = sources_of(index)[0]
    points = np.concatenate([one.points, other.points[ghost].reshape(-1, 3)])
    ids = np.concatenate([one.point_data[IDS], other.point_data[IDS][ghost].ravel()])
    number = len(one.points) + np.arange(ghost.size).reshape(ghost.shape)
    block = one.blocks[0]
    block.cells = np.concatenate([block.cells, number])
    tags = block.data["gmsh:physical"]
    block.data["gmsh:physical"] = np.concatenate([tags, np.zeros(len(ghost), tags.dtype)])
    marks = np.arange(len(block.cells)) >= len(tags)
    block.data["vtkGhostType"] = marks.astype(np.uint8)
    one.points, one.point_data[IDS] = points, ids
    write(first, one)
    second = sources_of(index)[1]
    other.blocks[0].data["vtkGhostType"] = np.zeros(len(other.blocks[0].cells), np.uint8)
    write(second, other)
    report, output = optimized(index, tmp_path, preset="fast")
    assert report.before.n_cells == len(formats.read(whole)[0].blocks[0].cells)
    assert check(formats.read(output)[0]).is_valid


def test_what_needs_the_whole_is_refused(whole, pieces_of, tmp_path):
    index, output = pieces_of(whole, 2), tmp_path / "out.pvtu"
    for wrong, what in [
        ({"policy": Slide()}, "slide"),
        ({"keep_off": ("x=0.5:0.1",)}, "keep-off"),
        ({"write_quality": True}, "write-quality"),
        ({"no_data": True}, "no-data"),
    ]:
        with pytest.raises(ConfigError, match=what):
            optimize_pieces(task(index, output, **wrong), Here())
    request = Request(below=3.0)
    with pytest.raises(ConfigError, match="below"):
        optimize_pieces(PiecesTask(index, output, Task(request)), Here())


def test_a_folder_of_others_is_left_alone(whole, pieces_of, tmp_path):
    index, folder = pieces_of(whole, 2), tmp_path / "out.work"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(WriteError, match=r"out\.work"):
        optimized(index, tmp_path, preset="fast")
    assert (folder / "notes.txt").read_text() == "mine"
    (folder / "notes.txt").unlink()
    optimized(index, tmp_path, preset="fast")


def test_what_is_wrong_with_a_piece_is_told(whole, pieces_of, tmp_path, read):
    index = pieces_of(whole, 3)
    path, piece = sources_of(index)[1], read(index)[1]
    other = Mesh(piece.points, piece.blocks, piece.point_data | {"t": piece.points[:, 0]})
    write(path, other)
    with pytest.raises(ReadError, match=path.name):
        optimized(index, tmp_path)
    cells = piece.blocks[0].cells
    cells[1] = cells[0]
    write(path, piece)
    with pytest.raises(BadMeshError, match=rf"{path.name}.*M201"):
        optimized(index, tmp_path, preset="fast")
    shutil.copy(write(tmp_path / "bad.vtu", BROKEN["hanging node"][0]), path)
    with pytest.raises((BadMeshError, ReadError), match=path.name):
        optimized(index, tmp_path, preset="fast")
    path.unlink()
    with pytest.raises(ReadError, match=path.name):
        optimized(index, tmp_path)
    assert not (tmp_path / "out.pvtu").exists()


def test_cells_of_several_types_are_refused(pieces_of, tmp_path):
    flat = quad_grid(6)
    cells = flat.blocks[0].cells
    mixed = in_space(mesh(flat.points, quad=cells[:18], triangle=cells[18:, :3]))
    mixed.blocks[1].cells = np.concatenate([cells[18:, :3], cells[18:][:, [0, 2, 3]]])
    index = pieces_of(write(tmp_path / "mixed.vtu", mixed), 3)
    with pytest.raises(UnsupportedMeshError, match="quad and triangle"):
        optimized(index, tmp_path)


@pytest.mark.parametrize("grid", [hex_grid(6), quad_grid(14)], ids=["hexahedra", "quads"])
def test_other_cells_go_in_pieces_too(grid, pieces_of, tmp_path):
    of = shaken(grid, 0.25, 1)
    path = write(tmp_path / "cells.vtu", of if of.points.shape[1] == 3 else in_space(of))
    report, output = optimized(pieces_of(path, 3), tmp_path)
    assert report.after.worst < report.before.worst
    assert report.after.mean < report.before.mean
    assert check(formats.read(output)[0]).is_valid


def test_a_piece_may_pay_only_where_it_would_be_the_worst(whole, pieces_of, tmp_path):
    """A mesh in pieces gets no worse, whatever its pieces do for themselves."""
    report, _ = optimized(pieces_of(whole, 6), tmp_path, preset="best")
    assert report.after.worst <= report.before.worst
    assert report.after.mean <= report.before.mean
