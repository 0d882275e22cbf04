"""Writing is all or nothing."""

import os
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from meshopt_cli.errors import WriteError
from meshopt_cli.formats import FORMATS, encoding_for, read, write
from meshopt_cli.mesh.model import Block
from support.encodings import POINTS, tets
from support.meshes import tet_grid


def assert_unwritable(path, words):
    with pytest.raises(WriteError, match=words) as caught:
        write(path, tets(), FORMATS["medit"].default)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


class Halfway:
    """A writer that fails after a part of the file."""

    def __init__(self, error):
        self.error = error

    def __call__(self, path, mesh, encoding):
        Path(path).write_bytes(b"MeshVersionFormatted 2\n")
        raise self.error


@pytest.mark.parametrize("error", [ValueError("no\nway"), OSError(28, "No space left on device")])
def test_failure_leaves_the_old_file(tmp_path, monkeypatch, error):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    monkeypatch.setitem(FORMATS, "medit", replace(FORMATS["medit"], write=Halfway(error)))
    assert_unwritable(path, "cannot be written")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_interruption_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    halfway = replace(FORMATS["medit"], write=Halfway(KeyboardInterrupt()))
    monkeypatch.setitem(FORMATS, "medit", halfway)
    with pytest.raises(KeyboardInterrupt):
        write(path, tets(), FORMATS["medit"].default)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_folder_that_cannot_be_written_to(tmp_path, monkeypatch):
    def refuse(*args):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    assert_unwritable(tmp_path / "mesh.mesh", "permission denied")
    assert list(tmp_path.iterdir()) == []
    assert_unwritable(tmp_path / "none" / "mesh.mesh", "no such folder")


def test_only_files_that_may_be_written_are_replaced(tmp_path, monkeypatch):
    (tmp_path / "folder.mesh").mkdir()
    assert_unwritable(tmp_path / "folder.mesh", "it is a folder")
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    monkeypatch.setattr(os, "access", lambda *args: False)
    assert_unwritable(path, "write-protected")
    assert path.read_text() == "old"


def test_permissions_are_kept(tmp_path):
    path = tmp_path / "mesh.mesh"
    old = os.umask(0o027)
    try:
        write(path, tets(), FORMATS["medit"].default)
        assert path.stat().st_mode & 0o777 == 0o640
        path.chmod(0o604)
        write(path, tets(), FORMATS["medit"].default)
        assert path.stat().st_mode & 0o777 == 0o604
    finally:
        os.umask(old)


def test_symbolic_links_are_written_through(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    link = tmp_path / "mesh.mesh"
    link.symlink_to(folder / "real.mesh")
    for _ in range(2):  # first where there is nothing behind it
        write(link, tets(), FORMATS["medit"].default)
        assert link.is_symlink()
        assert list(folder.iterdir()) == [folder / "real.mesh"]
        assert len(read(link)[0].points) == len(POINTS)


@pytest.mark.parametrize("suffix", [".mesh", ".meshb", ".msh", ".vtk", ".vtu"])
def test_a_block_without_cells(tmp_path, suffix):
    """A file may announce cells of a type and have none of them."""
    mesh = tet_grid(1)
    mesh.blocks.append(Block("line", np.empty((0, 2), np.int64)))
    path = tmp_path / f"mesh{suffix}"
    write(path, mesh, encoding_for(path))
    again, _ = read(path)
    assert sum(len(block.cells) for block in again.blocks) == len(mesh.blocks[0].cells)


def test_owner_and_group_are_kept(tmp_path):
    path = tmp_path / "mesh.mesh"
    path.write_text("old")
    try:
        os.chown(path, 12345, 23456)
    except PermissionError:
        pytest.skip("only root may do that")
    write(path, tets(), FORMATS["medit"].default)
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 23456)


LIMITED = """
import resource, sys
from pathlib import Path
from meshopt_cli.errors import WriteError
from meshopt_cli.formats import FORMATS, read, write
mesh, source = read(Path(sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))
try:
    write(Path(sys.argv[2]), mesh, FORMATS[sys.argv[3]].default)
except WriteError as error:
    sys.exit(str(error))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
@pytest.mark.parametrize("name", FORMATS)
def test_no_room_leaves_the_old_file(tmp_path, name):
    write(tmp_path / "in.mesh", tet_grid(4), FORMATS["medit"].default)
    folder = tmp_path / "folder"
    folder.mkdir()
    path = folder / f"out{FORMATS[name].extensions[0]}"
    path.write_text("old")
    arguments = [sys.executable, "-c", LIMITED, str(tmp_path / "in.mesh"), str(path), name]
    ran = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert ran.returncode == 1
    (line,) = ran.stderr.splitlines()
    assert line.startswith(f"{path}: cannot be written")
    assert path.read_text() == "old"
    assert list(folder.iterdir()) == [path]


FOREVER = """
import sys
from pathlib import Path
from meshopt_cli.formats import encoding_for, read, write
meshes = [read(Path(name))[0] for name in sys.argv[1:3]]
path = Path(sys.argv[3])
while True:
    for mesh in meshes:
        write(path, mesh, encoding_for(path))
        print("written", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signal")
@pytest.mark.parametrize("name", ["mesh.mesh", "mesh.msh", "mesh.vtu", "mesh.vtk.gz"])
def test_a_process_that_is_killed_leaves_the_old_file_or_the_new_one(tmp_path, name):
    whole = []
    inputs = [tmp_path / "one.mesh", tmp_path / "two.mesh"]
    for path, n in zip(inputs, (6, 7), strict=True):
        write(path, tet_grid(n), FORMATS["medit"].default)
        write(tmp_path / name, read(path)[0], encoding_for(Path(name)))
        whole.append((tmp_path / name).read_bytes())
    command = [sys.executable, "-c", FOREVER, *map(str, inputs), str(tmp_path / name)]
    for delay in (0.0, 0.003, 0.011, 0.017):
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            process.stdout.readline()
            time.sleep(delay)
            process.kill()
        assert (tmp_path / name).read_bytes() in whole
