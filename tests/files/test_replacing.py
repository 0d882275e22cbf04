"""Files that take the place of others: whose they are, who may do what, what is left."""

import os
import stat

import pytest

from meshopt_cli.files import atomic
from meshopt_cli.files.atomic import PREFIX, replacing
from meshopt_cli.files.ending import temporary_folder
from meshopt_cli.files.sweep import sweep

ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
OTHER = 12345  # number of a user and a group that run nothing here


def put(path, text="new"):
    with replacing(path) as place:
        assert not place.stat().st_mode & 0o077 or not path.exists()
        place.write_text(text)


def mode_of(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("mode", [0o644, 0o600, 0o777, 0o6777, 0o4755, 0o1664])
def test_permissions_are_handed_on_but_those_to_run_as_another(tmp_path, mode):
    path = tmp_path / "out.msh"
    path.write_text("old")
    path.chmod(mode)
    put(path)
    assert path.read_text() == "new"
    assert mode_of(path) == mode & 0o777


@pytest.mark.skipif(not ROOT, reason="only root gives files away")
def test_the_owner_is_kept_where_it_can_be(tmp_path):
    path = tmp_path / "out.msh"
    path.write_text("old")
    os.chown(path, OTHER, OTHER)
    path.chmod(0o6777)
    put(path)
    assert (path.stat().st_uid, path.stat().st_gid, mode_of(path)) == (OTHER, OTHER, 0o777)


@pytest.mark.parametrize("mode", [0o666, 0o777, 0o6777, 0o670, 0o604])
def test_where_the_owner_is_another_nobody_else_may_write(tmp_path, monkeypatch, mode):
    """And where the group is, it may do what all others may."""
    path = tmp_path / "out.msh"
    path.write_text("old")
    path.chmod(mode)
    old = os.stat_result((*path.stat()[:4], OTHER, OTHER, *path.stat()[6:10]))
    new = tmp_path / "new"
    new.write_text("new")
    refused = PermissionError(1, "Operation not permitted")
    monkeypatch.setattr(os, "fchown", lambda *_: (_ for _ in ()).throw(refused))
    with new.open() as file:
        atomic._hand_on(old, file.fileno())
    got = mode_of(new)
    assert not got & ~mode
    assert not got & 0o7022
    assert got >> 3 & 7 == got >> 3 & got & 7


def test_what_dead_runs_left_is_swept(tmp_path):
    """What a living run writes, and what is not ours, stays."""
    left = tmp_path / f"{PREFIX}left"
    left.write_text("half")
    link = tmp_path / f"{PREFIX}link"
    link.symlink_to(tmp_path / "none")
    with replacing(tmp_path / "one.msh") as place:
        place.write_text("whole")
        assert not left.exists()
        put(tmp_path / "other.msh")
        assert place.exists()
    assert sorted(tmp_path.iterdir()) == sorted(
        [link, tmp_path / "one.msh", tmp_path / "other.msh"]
    )


def test_a_file_that_is_about_to_be_locked_is_not_swept(tmp_path):
    newborn = tmp_path / f"{PREFIX}new"
    newborn.touch()
    sweep(tmp_path, PREFIX)
    assert newborn.exists()
    os.utime(newborn, (0, 0))
    sweep(tmp_path, PREFIX)
    assert not newborn.exists()


def test_folders_of_dead_runs_are_swept_too(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with temporary_folder() as first:
        (first / "half").write_text("half")
        with temporary_folder():
            assert first.exists()
        left = first.with_name(f"{first.name}-left")
        first.joinpath("x").write_text("x")
        left.mkdir()
        (left / "half").write_text("half")
        with temporary_folder():
            assert first.exists()
            assert not left.exists()
    assert list(tmp_path.iterdir()) == []
