"""What does not go over is named: what was not read, and what cannot be written."""

import json

import numpy as np

from meshopt_cli import formats
from support.edits import shaken
from support.files import write
from support.meshes import tet_grid


def test_everything_that_is_lost_is_in_the_report(meshopt, tmp_path):
    one = shaken(tet_grid(3))
    (block,) = one.blocks
    block.data = {
        "medit:ref": np.ones(len(block.cells), np.int64),
        "medit:required": np.arange(len(block.cells)) % 2,
    }
    path = write(tmp_path / "in.mesh", one)
    path.write_text(path.read_text().replace("\nEnd", '\nGeometry\n"other.mesh"\n\nEnd'))
    assert formats.read(path)[1].lost == ("Geometry",)

    ran = meshopt("optimize", path, tmp_path / "out.msh", "--json", "--file-format", "gmsh22")
    assert ran.status == 0
    assert json.loads(ran.out)["lost"] == ["Geometry"]
    assert "in.mesh: dropped on reading: Geometry" in ran.err

    ran = meshopt("optimize", tmp_path / "out.msh", tmp_path / "back.vtu", "--json")
    assert json.loads(ran.out)["lost"] == []


def test_a_report_of_a_mesh_names_what_was_not_read(meshopt, tmp_path):
    path = write(tmp_path / "in.mesh", tet_grid(2))
    path.write_text(path.read_text().replace("\nEnd", "\nIdentifier\n1\n\nEnd"))
    ran = meshopt("report", path, "--format", "json")
    assert json.loads(ran.out)["lost"] == ["Identifier"]
    assert "lost: Identifier" in meshopt("report", path).out
