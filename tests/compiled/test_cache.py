"""Whose compiled code is run, where it is kept, and for how long."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from meshopt_cli.compiled import cache, decorators, trust, ways
from meshopt_cli.compiled.marks import Code
from meshopt_cli.compiled.once import once
from support.compiling import at

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes as POSIX has them")
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
OTHER = 12345
CODE = Code(b"image", "f")


def twice(values):
    for i in range(values.shape[0]):
        values[i] *= 2.0


@pytest.fixture
def root(tmp_path, monkeypatch):
    """The folder of `MESHOPT_CACHE_DIR`, looked at anew, and nothing else to fall back to."""
    root = tmp_path / "cache"
    for name in ("XDG_CACHE_HOME", "HOME", "USERPROFILE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(cache.VARIABLE, str(root))
    monkeypatch.setattr(cache, "folders", once(cache.folders.__wrapped__))
    monkeypatch.setattr(cache, "_incomplete", set())
    return root


def again(monkeypatch):
    """As in another run."""
    monkeypatch.setattr(cache, "folders", once(cache.folders.__wrapped__))
    monkeypatch.setattr(cache, "_incomplete", set())


def test_new_folders_are_private(root):
    old = os.umask(0)
    try:
        cache.write("a.o", CODE)
    finally:
        os.umask(old)
    for path in (root, cache.folder()):
        assert path.stat().st_mode & 0o077 == 0
    assert cache.folder().parent == root
    assert cache.read("a.o") == CODE


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o757])
@pytest.mark.parametrize("which", ["root", "folder"])
def test_where_others_can_write_nothing_is_read(root, monkeypatch, caplog, mode, which):
    """Nor written, and the user who asked for the place hears of it."""
    cache.write("a.o", CODE)
    place = {"root": root, "folder": cache.folder()}[which]
    place.chmod(mode)
    again(monkeypatch)
    if which == "root" and mode & 0o1000:  # as in /tmp, what is ours stays
        assert cache.read("a.o") == CODE
        return
    assert cache.read("a.o") is None
    assert root not in cache.folder().parents
    assert cache.VARIABLE in caplog.text
    place.chmod(0o700)


@pytest.mark.skipif(not ROOT, reason="only root gives files away")
def test_what_is_of_another_user_is_not_read(root, monkeypatch):
    cache.write("a.o", CODE)
    os.chown(cache.folder() / "a.o", OTHER, OTHER)
    assert cache.read("a.o") is None
    os.chown(cache.folder(), OTHER, OTHER)
    again(monkeypatch)
    assert root not in cache.folder().parents


@pytest.mark.parametrize("mode", [0o622, 0o602, 0o666])
def test_a_file_that_others_can_write_is_not_read(root, mode):
    cache.write("a.o", CODE)
    (cache.folder() / "a.o").chmod(mode)
    is_private = not mode & 0o002 and trust._is_private(os.getegid())
    assert (cache.read("a.o") is None) == (not is_private)


@pytest.mark.parametrize("kind", ["fifo", "folder", "link", "device"])
def test_what_is_no_file_is_passed_over(root, tmp_path, kind):
    """Without waiting for anything, and it is no mark either."""
    place = cache.folder() / "a.o"
    cache.write("b.o", CODE)
    if kind == "fifo":
        os.mkfifo(place)
    elif kind == "folder":
        place.mkdir()
    else:
        place.symlink_to(cache.folder() / "b.o" if kind == "link" else "/dev/zero")
    assert cache.read("a.o") is None
    assert not cache.has("a.o")
    if kind != "folder":
        cache.write("a.o", CODE)
        assert cache.read("a.o") == CODE


@pytest.mark.skipif(ways.INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize("image", [b"", b"garbage", b"\x7fELF" + bytes(500)])
def test_what_cannot_be_loaded_is_made_anew(tmp_path, monkeypatch, image):
    """Though its checksum is right; and the loader is not given up for it."""
    monkeypatch.setattr(cache, "folders", at(tmp_path))
    decorators.Entry(twice)(np.ones(2))
    (stored,) = tmp_path.iterdir()
    cache.write(stored.name, Code(image, "?"))
    values = np.ones(2)
    decorators.Entry(twice)(values)
    assert values.tolist() == [2.0, 2.0]
    made = cache.read(stored.name)
    assert made is not None
    assert made.image != image
    assert ways.way() is ways.Way.NATIVE


def test_a_folder_that_can_only_be_read_is_read(root, monkeypatch):
    """What it has not is kept elsewhere."""
    cache.write("a.o", CODE)
    cache.mark("group.native")
    complete = cache.folder()
    again(monkeypatch)
    writable = cache._is_writable
    monkeypatch.setattr(cache, "_is_writable", lambda place: place != complete and writable(place))
    assert cache.read("a.o") == CODE
    assert cache.has("group.native")
    cache.write("b.o", CODE)
    assert cache.read("b.o") == CODE
    assert not (complete / "b.o").exists()


def test_what_could_not_be_stored_is_not_noted(root, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    put = cache._put
    monkeypatch.setattr(cache, "_put", full)
    cache.write("a.o", CODE)
    monkeypatch.setattr(cache, "_put", put)
    cache.mark("group.native")
    assert not cache.has("group.native")
    assert not list(cache.folder().iterdir())


def test_what_is_old_goes(root, tmp_path):
    """Other versions after a month, what killed runs left after a day, and nothing else."""
    used = cache.folder()
    month, day = time.time() - 40 * 86_400, time.time() - 2 * 86_400
    old, recent, other = root / ("a" * 16), root / ("b" * 16), root / "notes"
    elsewhere = tmp_path / "elsewhere"
    for path in (old, recent, other, elsewhere):
        path.mkdir()
        (path / "file").touch()
    link = root / ("c" * 16)
    link.symlink_to(elsewhere)
    left, kept = used / f"a.o.{'d' * 16}", used / "a.o"
    for path, when in ((old, month), (recent, day), (other, month), (elsewhere, month)):
        os.utime(path, (when, when))
    for path in (left, kept):
        path.touch()
        os.utime(path, (month, month))
    cache.mark("group.native")
    there = {path for path in (old, recent, other, left, kept) if path.exists()}
    assert there == {recent, other, kept}
    assert (elsewhere / "file").exists()


@pytest.mark.skipif(not ROOT, reason="only root can be somebody else")
def test_a_run_takes_no_code_that_another_user_put_into_a_folder_for_all(tmp_path, samples):
    """As a whole: the command compiles its own."""
    place = tmp_path / "shared"
    place.mkdir()
    place.chmod(0o777)
    code = "from meshopt_cli.compiled import cache; print(cache.folder())"
    environment = {**os.environ, cache.VARIABLE: str(place)}
    environment.pop("HOME", None)
    ran = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert place not in Path(ran.stdout.strip()).parents
