"""What a run writes is neither what it reads, nor twice in one place."""

import os
from pathlib import Path

import pytest

from meshopt_cli.errors import ConfigError, WriteError
from meshopt_cli.files.places import require_places
from meshopt_cli.files.sink import PIPE


@pytest.fixture
def mesh(tmp_path):
    path = tmp_path / "mesh.msh"
    path.write_text("mesh")
    return path


def test_an_input_by_any_of_its_names(mesh, tmp_path):
    (tmp_path / "soft.msh").symlink_to(mesh)
    os.link(mesh, tmp_path / "hard.msh")
    around = tmp_path / "folder" / ".." / "mesh.msh"
    (tmp_path / "folder").mkdir()
    for name in (mesh, tmp_path / "soft.msh", tmp_path / "hard.msh", around):
        with pytest.raises(ConfigError, match="input"):
            require_places([name], [mesh])
        require_places([name], [mesh], replaced=[name])


def test_no_two_things_in_one_place(tmp_path):
    one, again = tmp_path / "a.json", tmp_path / "x" / ".." / "a.json"
    for pair in ((one, one), (one, again), (PIPE, PIPE)):
        with pytest.raises(ConfigError, match="two things"):
            require_places(pair, [])
    require_places([one, tmp_path / "b.json", PIPE, Path(os.devnull), Path(os.devnull)], [PIPE])


def test_where_nothing_can_be_written(tmp_path, mesh):
    for bad in (tmp_path, tmp_path / "none" / "a.json", mesh / "a.json"):
        with pytest.raises(WriteError, match="cannot be written"):
            require_places([bad], [])
