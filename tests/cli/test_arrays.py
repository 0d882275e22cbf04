"""Arrays of a mesh: which go along, and which make regions."""

import numpy as np

from meshopt_cli import formats
from meshopt_cli.mesh.model import Block
from support.edits import shaken
from support.files import write
from support.meshes import in_space, tet_grid, tri_grid


def test_arrays_go_along_unless_told_otherwise(meshopt, tmp_path):
    one = shaken(tet_grid(3))
    n = len(one.blocks[0].cells)
    one.blocks[0].data = {"stress": np.linspace(0, 1, n), "part": np.arange(n) // (n // 2)}
    one.point_data = {"T": np.linspace(0, 1, len(one.points))}
    path, output = write(tmp_path / "in.vtu", one), tmp_path / "out.vtu"
    for options, names in (((), {"stress", "part"}), (("--no-data",), {"part"})):
        ran = meshopt("optimize", path, output, "--passes", "smooth", *options)
        assert (ran.status, ran.err) == (0, "")
        result = formats.read(output)[0]
        assert set(result.blocks[0].data) == names
        assert set(result.point_data) == ({"T"} if "stress" in names else set())


def test_arrays_that_make_regions(meshopt, tmp_path):
    one = shaken(tet_grid(3))
    n = len(one.blocks[0].cells)
    one.blocks[0].data = {"part": np.arange(n) % 2, "layer": np.arange(n) // (n // 3)}
    path, output = write(tmp_path / "in.vtu", one), tmp_path / "out.vtu"
    ran = meshopt("optimize", path, output, "--region", "part", "--region", "layer")
    assert ran.status == 0
    ran = meshopt("optimize", path, output, "--region", "parts")
    assert ran.status == 2
    assert f"{path}: no array 'parts'" in ran.complaint
    assert "part, layer" in ran.complaint


def test_arrays_on_cells_of_all_dimensions(meshopt, tmp_path):
    """VTK has every array on every cell: one that lines keep and triangles lose is a trap."""
    one = in_space(shaken(tri_grid(5)))
    one.blocks.append(Block("line", np.array([[0, 1], [1, 2]])))
    for block in one.blocks:
        n = len(block.cells)
        block.data = {"stress": np.linspace(0, 1, n), "part": np.full(n, 3)}
    for suffix in (".vtk", ".vtu"):
        path, output = tmp_path / f"in{suffix}", tmp_path / f"out{suffix}"
        write(path, one)
        ran = meshopt("optimize", path, output)
        assert ran.status == 0
        result = formats.read(output)[0]
        assert all(b.data["stress"].max() <= 1 for b in result.blocks)
        assert [b.type for b in result.blocks] == ["triangle", "line"]
        assert all(np.all(b.data["part"] == 3) for b in result.blocks)
