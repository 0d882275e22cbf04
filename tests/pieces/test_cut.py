"""A mesh is cut in pieces, and these are put together: nothing is lost or there twice."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.errors import BadMeshError, ConfigError, ReadError, WriteError
from meshopt_cli.formats.vtk.parallel import folder_of, sources_of
from meshopt_cli.jobs.split_file import join_file, split_file
from meshopt_cli.mesh.model import Block, Mesh, top_blocks
from meshopt_cli.mesh.pieces import IDS, border_facets, cut, merged, part_of, pieces_of_cells
from support.edits import shaken
from support.files import write
from support.kinds import solid_with_fin
from support.meshes import hex_grid, in_space, quad_grid, tet_grid, tri_grid
from support.samples import SAMPLES

MESHES = {
    "tets": lambda: shaken(tet_grid(4)),
    "triangles": lambda: in_space(shaken(tri_grid(9))),
    "quads": lambda: quad_grid(7),
    "hexahedra": lambda: hex_grid(4),
    "regions": lambda: formats.read(SAMPLES / "two_regions.msh")[0],
    "fin": solid_with_fin,
}
every = pytest.mark.parametrize("name", MESHES)
counts = pytest.mark.parametrize("n", [1, 2, 3, 7])


def cells_of(mesh):
    """How often each cell is there, by the places of its corners and its arrays."""
    return Counter(
        (block.type, mesh.points[cell].tobytes(), *(block.data[n][k].item() for n in block.data))
        for block in mesh.blocks
        for k, cell in enumerate(block.cells)
    )


@every
@counts
def test_each_cell_goes_to_one_piece(name, n):
    mesh = MESHES[name]()
    parts = list(cut(mesh, n))
    assert len(parts) == n
    assert sum(map(cells_of, parts), Counter()) == cells_of(mesh)
    sizes = [sum(len(block.cells) for block in top_blocks(part)) for part in parts]
    assert max(sizes) - min(sizes) <= 1 + n.bit_length()
    for part in parts:
        np.testing.assert_array_equal(mesh.points[part.point_data[IDS]], part.points)


@every
@counts
def test_pieces_make_the_mesh_again(name, n):
    mesh = MESHES[name]()
    again = merged(list(cut(mesh, n)))
    order = np.argsort(again.point_data[IDS])
    np.testing.assert_array_equal(again.points[order], mesh.points)
    assert cells_of(again) == cells_of(mesh)


@every
def test_a_cell_of_lower_dimension_goes_with_one_that_it_bounds(name):
    mesh = MESHES[name]()
    pieces = pieces_of_cells(mesh, 4)
    tops = top_blocks(mesh)
    is_top = [any(block is one for one in tops) for block in mesh.blocks]
    corners = [set() for _ in range(4)]
    for block, piece, top in zip(mesh.blocks, pieces, is_top, strict=True):
        if top:
            for cell, own in zip(block.cells.tolist(), piece.tolist(), strict=True):
                corners[own].add(frozenset(cell))
    for block, piece, top in zip(mesh.blocks, pieces, is_top, strict=True):
        if not top:
            for cell, own in zip(block.cells.tolist(), piece.tolist(), strict=True):
                around = [set(cell) <= one for k in range(4) for one in corners[k]]
                assert not any(around) or any(set(cell) <= one for one in corners[own])


def test_pieces_are_near_each_other():
    """The border of a piece is a small part of its facets."""
    for part in cut(tet_grid(10), 8):
        (facets,) = border_facets(part).values()
        assert len(facets) < 0.25 * 4 * len(part.blocks[0].cells)


def test_points_that_no_cell_has_stay():
    mesh = tet_grid(2)
    mesh.points = np.concatenate([mesh.points, [[5.0, 5.0, 5.0]]])
    parts = list(cut(mesh, 3))
    assert sum(5.0 in part.points for part in parts) == 1
    assert len(merged(parts).points) == len(mesh.points)


def test_a_part_has_the_arrays_of_its_cells_and_points():
    mesh = tet_grid(2)
    mesh.point_data["t"] = np.arange(len(mesh.points))
    mesh.blocks[0].data["k"] = np.arange(len(mesh.blocks[0].cells))
    mask = mesh.blocks[0].data["k"] % 5 == 1
    part = part_of(mesh, [mask])
    np.testing.assert_array_equal(part.blocks[0].data["k"], np.flatnonzero(mask))
    np.testing.assert_array_equal(mesh.points[part.point_data["t"]], part.points)


@every
def test_files_are_split_and_joined(name, tmp_path):
    mesh = MESHES[name]()
    path = write(tmp_path / "in.vtu", Mesh(in_space(mesh).points if mesh.points.shape[1] == 2
                                           else mesh.points, mesh.blocks))  # fmt: skip
    done = split_file(path, tmp_path / "out.pvtu", 3)
    assert len(done.n_cells) == 3
    assert [p.suffix for p in sources_of(tmp_path / "out.pvtu")] == [".vtu"] * 3
    join_file(tmp_path / "out.pvtu", tmp_path / "again.vtu")
    one, other = (formats.read(tmp_path / name)[0] for name in ("in.vtu", "again.vtu"))
    assert cells_of(one) == cells_of(other)
    assert len(one.points) == len(other.points)


def test_what_was_there_is_replaced_as_a_whole(tmp_path, whole):
    index = tmp_path / "out.pvtu"
    split_file(whole, index, 5)
    split_file(whole, index, 2)
    assert len(list(folder_of(index).iterdir())) == 2
    (folder_of(index) / "notes.txt").write_text("mine")
    with pytest.raises(WriteError, match=r"notes\.txt"):
        split_file(whole, index, 3)
    assert len(sources_of(index)) == 2


def test_meshes_of_others_are_not_replaced(tmp_path, whole):
    """A folder of that name may be somebody's, and have meshes in it."""
    index = tmp_path / "out.pvtu"
    folder_of(index).mkdir()
    mine = folder_of(index) / "part.vtu"
    mine.write_bytes(whole.read_bytes())
    with pytest.raises(WriteError, match=r"part\.vtu"):
        split_file(whole, index, 3)
    assert mine.read_bytes() == whole.read_bytes()
    assert not index.exists()


def test_what_cannot_be_cut_is_refused(tmp_path, whole):
    with pytest.raises(ConfigError, match="pvtu"):
        split_file(whole, tmp_path / "out.vtu", 2)
    with pytest.raises(ConfigError, match="pieces cannot be made"):
        split_file(whole, tmp_path / "out.pvtu", 10**6)
    bad = write(
        tmp_path / "bad.vtu", Mesh(np.zeros((2, 3)), [Block("tetra", np.array([[0, 1, 2, 9]]))])
    )
    with pytest.raises(BadMeshError, match="M00"):
        split_file(bad, tmp_path / "out.pvtu", 1)
    assert not (tmp_path / "out.pvtu").exists()
    (tmp_path / "empty.pvtu").write_text("<VTKFile type='PUnstructuredGrid'/>")
    with pytest.raises(ReadError, match="names no files"):
        sources_of(tmp_path / "empty.pvtu")
    with pytest.raises(ReadError, match="no such file"):
        sources_of(tmp_path / "none.pvtu")
