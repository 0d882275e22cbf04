"""The kernels that a wheel brings along: used where they fit, and nowhere else."""

from __future__ import annotations

import json
import logging
import os
import runpy
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from meshopt_cli import warmup
from meshopt_cli.compiled import cache, decorators, library, ways
from meshopt_cli.compiled.once import once
from meshopt_cli.errors import EXIT_USAGE, ConfigError
from support.compiling import at, described, outer, quotient, scaled, total
from support.processes import run_python
from support.samples import ROOT

pytestmark = [
    pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted"),
    pytest.mark.skipif(
        sys.platform != "linux" or not shutil.which(os.environ.get("CC", "cc")),
        reason="there is nothing to build the library with",
    ),
]

# Stands for a system where these are not installed.
WITHOUT_NUMBA = """
import sys
class Missing:
    def find_spec(name, path=None, target=None):
        if name.partition(".")[0] in ("numba", "llvmlite"):
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Missing)
import importlib.util as util
find = util.find_spec
util.find_spec = lambda name: None if name in ("numba", "llvmlite") else find(name)
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A library of a few entries."""
    if lacking := library.FEATURES - library._features():
        pytest.skip(f"this processor lacks {lacking}")
    folder = tmp_path_factory.mktemp("library")
    build = runpy.run_path(str(ROOT / "building" / "kernels.py"))
    entries = ((total, (outer(), 0.25)), (described, (np.ones(1),)), (quotient, (1.0, 2.0)))
    objects = [build["compiled"](decorators.Entry(f), arguments) for f, arguments in entries]
    build["link"](objects, cache.digest_of_sources(), folder)
    return folder


def look_again(monkeypatch):
    monkeypatch.setattr(library, "opened", once(library.opened.__wrapped__))


@pytest.fixture
def own(built, tmp_path, monkeypatch):
    """The library in a folder of its own, as that of the package; nothing is compiled yet."""
    folder = tmp_path / "package"
    shutil.copytree(built, folder)
    monkeypatch.setattr(library, "FOLDER", folder)
    monkeypatch.setattr(cache, "folders", at(tmp_path / "cache"))
    monkeypatch.delenv(ways.VARIABLE, raising=False)
    look_again(monkeypatch)
    return folder


def test_kernels_of_the_library_do_what_python_does(own, tmp_path):
    ours, theirs = outer(), outer()
    assert decorators.Entry(total)(ours, 0.25) == total(theirs, 0.25)
    np.testing.assert_array_equal(ours.inner.values, theirs.inner.values)
    found = decorators.Entry(described)(np.array([-3.0]))
    assert repr(found) == repr(described([-3.0]))
    assert decorators.Entry(quotient)(1.0, 0.0) == np.inf
    assert ways.way() is ways.Way.LIBRARY
    assert not (tmp_path / "cache").exists()


def test_nothing_is_left_to_compile(own, tmp_path):
    assert ways.missing(["basic"]) == []
    ways.note("basic")
    warmup.compile_groups(warmup.GROUPS)
    assert not (tmp_path / "cache").exists()


def test_what_the_library_has_not_is_compiled(own, tmp_path):
    assert decorators.Entry(scaled)(1.5, 2) == 6.0
    assert [path.suffix for path in (tmp_path / "cache").iterdir()] == [".o"]


def test_the_environment_may_ask_for_other_code(own, tmp_path, monkeypatch):
    monkeypatch.setenv(ways.VARIABLE, "native")
    assert ways.way() is ways.Way.NATIVE
    assert decorators.Entry(quotient)(1.0, 4.0) == 0.25
    assert list((tmp_path / "cache").glob("*.o"))


def edited(folder, **changed):
    path = folder / library.MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))


def truncated(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


# What may be wrong with a library, and what is said of it.
UNFIT = {
    "other sources": (lambda own, _: edited(own, sources="0" * 64), "other sources"),
    "cut": (lambda own, _: truncated(own / library.NAME), "kernels.so is damaged"),
    "gone": (lambda own, _: (own / library.NAME).unlink(), "damaged"),
    "no manifest": (lambda own, _: truncated(own / library.MANIFEST), "damaged"),
    "no entries": (lambda own, _: edited(own, results=None), "damaged"),
    "other code": (lambda _, patch: patch.setenv("NUMBA_BOUNDSCHECK", "1"), "NUMBA_BOUNDSCHECK"),
}


@pytest.mark.parametrize("fault", UNFIT)
def test_what_does_not_fit_is_not_used(fault, own, monkeypatch, caplog):
    harm, said = UNFIT[fault]
    harm(own, monkeypatch)
    with caplog.at_level(logging.INFO, "meshopt"):
        assert ways.way() is ways.Way.NATIVE
        assert library.find("any", []) is None
    (line,) = caplog.messages
    assert said in line
    monkeypatch.setenv(ways.VARIABLE, "library")
    with pytest.raises(ConfigError, match=said):
        ways.way()


@pytest.mark.parametrize("lacking", [{"avx2"}, {"fma", "movbe"}, library.FEATURES])
def test_an_older_processor_does_not_run_it(own, tmp_path, monkeypatch, lacking):
    place = tmp_path / "cpuinfo"
    place.write_text(f"processor\t: 0\nflags\t\t: fpu {' '.join(library.FEATURES - lacking)}\n")
    monkeypatch.setattr(library, "_PROCESSORS", place)
    assert ways.way() is ways.Way.NATIVE
    assert library.opened().unfit == f"the processor lacks {', '.join(sorted(lacking))}"


def test_a_package_without_a_library_says_so_where_one_is_asked_for(own, monkeypatch, caplog):
    (own / library.MANIFEST).unlink()
    with caplog.at_level(logging.INFO, "meshopt"):
        assert ways.way() is ways.Way.NATIVE
    assert not caplog.messages
    monkeypatch.setenv(ways.VARIABLE, "library")
    with pytest.raises(ConfigError, match="this package has none"):
        ways.way()


def test_the_library_needs_no_numba(own):
    code = f"""{WITHOUT_NUMBA}
from pathlib import Path
from meshopt_cli.compiled import library
library.FOLDER = Path({str(own)!r})
from meshopt_cli.compiled.decorators import Entry
from support import compiling as c
print(Entry(c.quotient)(1.0, 4.0), "numba" in sys.modules, "llvmlite" in sys.modules)
"""
    assert run_python(code, **{ways.VARIABLE: ""}).split() == ["0.25", "False", "False"]


def test_without_numba_and_library_a_line_says_what_to_install(samples, tmp_path):
    code = f"""{WITHOUT_NUMBA}
from pathlib import Path
from meshopt_cli.compiled import library
library.FOLDER = Path({str(tmp_path)!r})
from meshopt_cli.cli.entry import status_of
sys.stderr = sys.stdout
print(status_of(["report", {str(samples / "plate.vtu")!r}]))
"""
    line, status = run_python(code, **{ways.VARIABLE: ""}).splitlines()
    assert int(status) == EXIT_USAGE
    assert "no compiled kernels" in line
    assert line.endswith("python -m pip install numba")


def test_variables_that_change_no_code_do_not_count(monkeypatch):
    for name in cache.SETTINGS:
        monkeypatch.delenv(name, raising=False)
    digest = cache._digest()
    for name in ("NUMBA_NUM_THREADS", "NUMBA_CACHE_DIR", "NUMBA_DISABLE_PERFORMANCE_WARNINGS"):
        monkeypatch.setenv(name, "2")
        assert cache._digest() == digest
    for name in cache.SETTINGS:
        with monkeypatch.context() as patch:
            patch.setenv(name, "0")
            assert cache._digest() != digest


def test_variables_that_count_are_numbas():
    origin = Path(find_spec("numba").origin)
    text = (origin.parent / "core" / "config.py").read_text()
    assert [name for name in cache.SETTINGS if name not in text] == []
