"""Files that cannot be read."""

import contextlib

import numpy as np
import pytest

from meshopt_cli.errors import ReadError
from meshopt_cli.formats import read, write
from support.encodings import assert_unreadable, every_encoding, path_for, tagged, tets


def is_refused(path):
    """Read a file that may be good or bad; any error but a ReadError fails the test."""
    with contextlib.suppress(ReadError):
        read(path)
        return False
    return True


def test_missing_folder_empty_and_unknown(tmp_path):
    assert_unreadable(tmp_path / "no.msh", "no such file")
    (tmp_path / "folder.msh").mkdir()
    assert_unreadable(tmp_path / "folder.msh", "directory")
    (tmp_path / "none.vtk").touch()
    assert_unreadable(tmp_path / "none.vtk", "empty")
    (tmp_path / "mesh.stl").write_text("solid")
    assert_unreadable(
        tmp_path / "mesh.stl", "extension", ".msh, .msh4, .msh2, .vtk, .vtu, .mesh, .meshb"
    )
    (tmp_path / "lfs.mesh").write_text("version https://git-lfs.github.com/spec/v1\noid 1\n")
    assert_unreadable(tmp_path / "lfs.mesh", "git lfs pull")


def test_no_permission(tmp_path, monkeypatch):
    def refuse(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(ReadError, match="permission denied"):
        read(tmp_path / "mesh.msh")


@pytest.mark.parametrize("extension", [".msh", ".vtk", ".vtu", ".mesh", ".meshb"])
@pytest.mark.parametrize("content", [b"hello\n", b"\0\1\2\3" * 99, "é\n".encode("latin-1"), b"\n"])
def test_garbage(tmp_path, extension, content):
    path = tmp_path / ("mesh" + extension)
    path.write_bytes(content)
    assert_unreadable(path, "not a")


@every_encoding
def test_truncated_files(tmp_path, capfd, encoding):
    path = path_for(tmp_path, encoding)
    write(path, tagged(tets(), encoding), encoding)
    whole = path.read_bytes()
    n_refused = 0
    for eighth in range(1, 8):
        path.write_bytes(whole[: len(whole) * eighth // 8])
        n_refused += is_refused(path)
    assert n_refused >= 4
    assert capfd.readouterr() == ("", "")


@every_encoding
def test_damaged_files(tmp_path, encoding):
    path = path_for(tmp_path, encoding)
    write(path, tagged(tets(), encoding), encoding)
    whole = path.read_bytes()
    random = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(whole)
        damaged[random.integers(len(whole))] = random.integers(256)
        path.write_bytes(damaged)
        is_refused(path)
