"""Files of partitions, as Gmsh writes them, become pieces."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.errors import BadMeshError
from meshopt_cli.jobs.split_file import gather_files
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.mesh.pieces import IDS, cut, part_of
from meshopt_cli.mesh.tags import PARTITION
from meshopt_cli.validity import check
from support.edits import shaken
from support.files import write
from support.meshes import tet_grid

PLACES = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
TAGS = [3, 10, 20, 30, 100]
TETS = [(0, 1, 2, 3), (1, 2, 3, 4)]


def gmsh_file(path, own, ghost):
    """Two tets of a mesh: one is of partition 1 and the other of 2; a file has both, with one a
    ghost, under the numbers of the whole."""
    nodes = "\n".join(f"{tag} {x} {y} {z}" for tag, (x, y, z) in zip(TAGS, PLACES, strict=True))
    cells = [(7 + k, k + 1, TETS[k]) for k in (own, ghost)]
    elements = "\n".join(
        f"{label} 4 4 1 1 1 {partition} {' '.join(str(TAGS[v]) for v in cell)}"
        for label, partition, cell in cells[: 1 + (ghost != own)]
    )
    n = 1 + (ghost != own)
    path.write_text(
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n{nodes}\n$EndNodes\n"
        f"$Elements\n{n}\n{elements}\n$EndElements\n"
    )
    return path


def test_nodes_have_one_number_through_all_files(tmp_path):
    files = [gmsh_file(tmp_path / f"part_{k}.msh", k, k) for k in (0, 1)]
    done = gather_files(files, tmp_path / "out.pvtu")
    assert done.n_cells == (1, 1)
    assert done.n_shared == 3
    mesh = formats.read(tmp_path / "out.pvtu")[0]
    assert len(mesh.points) == 5
    assert sorted(mesh.point_data[IDS].tolist()) == [tag - 1 for tag in TAGS]
    assert check(mesh).is_valid


def test_ghosts_are_left_out(tmp_path):
    mesh = shaken(tet_grid(4))
    parts = list(cut(mesh, 3))
    files = []
    for k, part in enumerate(parts):
        other = parts[(k + 1) % 3]
        ghosts = part_of(other, [np.arange(len(other.blocks[0].cells)) < 9])
        n = len(part.points)
        cells = np.concatenate([part.blocks[0].cells, n + ghosts.blocks[0].cells])
        owner = np.where(np.arange(len(cells)) < len(part.blocks[0].cells), k + 1, 0)
        both = Mesh(
            np.concatenate([part.points, ghosts.points]),
            [Block("tetra", cells, {PARTITION: owner})],
            {IDS: np.concatenate([part.point_data[IDS], ghosts.point_data[IDS]])},
        )
        files.append(write(tmp_path / f"{k}.vtu", both))
    done = gather_files(files, tmp_path / "out.pvtu")
    assert sum(done.n_cells) == len(mesh.blocks[0].cells)
    assert check(formats.read(tmp_path / "out.pvtu")[0]).is_valid


def test_pieces_with_other_arrays_are_refused(tmp_path):
    one, other = cut(tet_grid(2), 2)
    other.point_data["t"] = np.zeros(len(other.points))
    files = [write(tmp_path / "a.vtu", one), write(tmp_path / "b.vtu", other)]
    with pytest.raises(BadMeshError, match=r"b\.vtu: it has other arrays"):
        gather_files(files, tmp_path / "out.pvtu")
    assert not (tmp_path / "out.pvtu").exists()
    assert not (tmp_path / "out").exists()
