"""Whose compiled code is run, where it is kept, and for how long."""

import os
import subprocess
import sys
import tempfile
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
        (path / "basic.native").touch()
    (old / f"swap.sweep_swap-{'d' * 16}.o").touch()
    other_use = root / ("e" * 16)
    other_use.mkdir()
    (other_use / "thesis.tex").touch()
    link = root / ("c" * 16)
    link.symlink_to(elsewhere)
    left, kept = used / f"a.o.{'d' * 16}", used / "a.o"
    for path, when in (
        (old, month), (recent, day), (other, month), (elsewhere, month), (other_use, month),
    ):  # fmt: skip
        os.utime(path, (when, when))
    for path in (left, kept):
        path.touch()
        os.utime(path, (month, month))
    cache.mark("group.native")
    there = {path for path in (old, recent, other, other_use, left, kept) if path.exists()}
    assert there == {recent, other, other_use, kept}
    assert (elsewhere / "basic.native").exists()


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


def folder_in(**environment):
    """What a fresh Python says of the folder for machine code."""
    code = "from meshopt_cli.compiled import cache; print(cache.folder(), cache.is_lasting())"
    usual = {k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")}
    ran = subprocess.run(
        [sys.executable, "-c", code], env={**usual, cache.VARIABLE: "", **environment},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    place, lasting = ran.stdout.rsplit(maxsplit=1)
    return Path(place), lasting == "True"


@pytest.mark.skipif(not ROOT, reason="only root gives files away")
def test_root_makes_nothing_in_the_home_of_a_user(tmp_path):
    """As with sudo: the user could neither write nor read there any more."""
    home = tmp_path / "home"
    home.mkdir()
    os.chown(home, OTHER, OTHER)
    place, lasting = folder_in(HOME=str(home))
    assert not list(home.iterdir())
    assert not place.is_relative_to(home)
    assert not lasting


@pytest.mark.parametrize("mode", [0o777, 0o1777])
def test_nothing_is_made_where_it_could_be_replaced(tmp_path, mode):
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(mode)
    place, lasting = folder_in(**{cache.VARIABLE: str(shared / "mine")})
    assert lasting == place.is_relative_to(shared) == bool(mode & 0o1000)
    assert bool(list(shared.iterdir())) == lasting


@pytest.mark.parametrize("value", ["/dev/null", "/dev/null/below", "/" + "x" * 5000])
def test_what_can_be_no_folder_is_passed_over(tmp_path, value):
    place, lasting = folder_in(**{cache.VARIABLE: value, "HOME": str(tmp_path)})
    assert lasting
    assert place.parent == tmp_path / ".cache" / "meshopt"


def test_a_relative_folder_of_all_caches_is_ignored(tmp_path):
    """As its specification has it."""
    place, _ = folder_in(XDG_CACHE_HOME="relative", HOME=str(tmp_path))
    assert place.parent == tmp_path / ".cache" / "meshopt"


def test_without_a_folder_for_temporary_files_nothing_is_kept(root, monkeypatch):
    monkeypatch.delenv(cache.VARIABLE)
    monkeypatch.setattr(tempfile, "tempdir", str(root / "missing"))
    cache.write("a.o", CODE)
    cache.mark("group.native")
    assert cache.read("a.o") is None
    assert not cache.has("group.native")


def test_code_has_its_place(root):
    cache.write("a.o", CODE)
    (cache.folder() / "a.o").rename(cache.folder() / "b.o")
    assert cache.read("b.o") is None


def test_results_that_are_no_text_are_damage_as_any_other(root):
    place = cache.folder() / "a.o"
    checked = b"image\n\xff"
    cache._put(place, checked + b"\n" + cache._checksum(place, checked))
    code = cache.read("a.o")
    assert code is None or "\ufffd" in code.results


@pytest.fixture
def by_numba(tmp_path, monkeypatch):
    """A folder for what numba compiles by its own means."""
    monkeypatch.setenv(ways.VARIABLE, ways.Way.NUMBA)
    monkeypatch.setattr(cache, "folders", at(tmp_path))
    monkeypatch.setattr(cache, "_incomplete", set())
    return tmp_path


def doubled():
    values = np.ones(2)
    decorators.Entry(twice)(values)
    return values.tolist() == [2.0, 2.0]


@pytest.mark.skipif(ways.INTERPRETED, reason="nothing is compiled")
def test_what_numba_keeps_is_closed_to_others_and_loaded_again(by_numba):
    old = os.umask(0)
    try:
        assert doubled()
    finally:
        os.umask(old)
    (folder,) = by_numba.iterdir()
    assert folder.stat().st_mode & 0o077 == 0
    times = {path: path.stat().st_mtime_ns for path in folder.rglob("*.nb?")}
    assert times
    assert doubled()
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.nb?")} == times


@pytest.mark.skipif(ways.INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize("harm", ["pipes", "open to all", "a link"])
def test_what_numba_is_not_to_open_is_made_anew(by_numba, tmp_path_factory, harm):
    assert doubled()
    (folder,) = by_numba.iterdir()
    if harm == "pipes":
        for path in folder.rglob("*.nb?"):
            path.unlink()
            os.mkfifo(path)
    elif harm == "open to all":
        folder.chmod(0o777)
    else:
        folder.rename(tmp_path_factory.mktemp("other") / "folder")
        folder.symlink_to(tmp_path_factory.getbasetemp())
    assert doubled()
    assert trust.is_closed(folder)
    assert all(path.is_file() for path in folder.rglob("*.nb?"))


@pytest.mark.skipif(ways.INTERPRETED, reason="nothing is compiled")
def test_a_full_disk_is_no_harm_by_numba(by_numba):
    """And what it does not hold is not noted as compiled."""
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        assert doubled()
        ways.note("basic")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert ways.missing(["basic"]) == ["basic"]
