"""The ways to run the kernels: by the loader, and by numba's own means where it does not work."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from meshopt_cli.cli.main import status_of
from meshopt_cli.compiled import cache, decorators, ways
from meshopt_cli.errors import EXIT_USAGE, ConfigError

pytestmark = pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted")

ROOT = Path(__file__).parent.parent


class Part(NamedTuple):
    """A part of `Found`, and of arguments."""

    values: np.ndarray
    factor: float


class Found(NamedTuple):
    """Results of every kind."""

    is_positive: bool
    number: int
    rest: tuple[float, int]


@decorators.inlined
def half(value):
    return 0.5 * value


@decorators.kernel
def weighed(part, i):
    return half(part.values[i]) / part.factor


def found(part, shift):
    total = shift
    for i in range(len(part.values)):
        total += weighed(part, i)
        part.values[i] = -1.0
    return Found(total > 0.0, len(part.values), (total, 7))


def nothing(values):
    values[0] = 1.0


def same(values):
    return values


def some():
    """Arguments of `found`, of which the kernel makes infinity."""
    return Part(np.array([3.0, 5.0, 1.0 / 3.0]), 0.0), 0.25


def checked():
    """Call a kernel, which must do what it does in Python; print which way it ran."""
    ours, theirs = some(), some()
    result = decorators.Entry(found)(*ours)
    with np.errstate(all="ignore"):
        # Python raises an error where numpy divides by zero.
        expected = found(theirs[0]._replace(factor=np.float64(theirs[0].factor)), theirs[1])
    assert result == expected
    assert [type(value) for value in (*result, *result.rest)] == [bool, int, tuple, float, int]
    assert ours[0].values.tolist() == theirs[0].values.tolist()
    print(ways.way(), "meshopt_cli.compiled.jit" in sys.modules)


def run(code, **environment):
    """What Python prints, and what it says besides, with the package and the tests at hand."""
    ran = subprocess.run(
        [sys.executable, "-c", f"import sys\nimport test_ways as t\n{code}"],
        env={**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip(), ran.stderr


@pytest.fixture
def environment(tmp_path):
    """An empty folder for machine code, and no way asked for."""
    return {"MESHOPT_CACHE_DIR": str(tmp_path / "cache"), ways.VARIABLE: ""}


@pytest.mark.parametrize("name", ["native", "numba"])
def test_the_environment_names_a_way(name, tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path)
    monkeypatch.setenv(ways.VARIABLE, name)
    assert ways.way() == name
    ways.note("basic")
    assert ways.missing(["basic", "mend"]) == ["mend"]
    monkeypatch.setenv(ways.VARIABLE, "numba" if name == "native" else "native")
    assert ways.missing(["basic"]) == ["basic"]


def test_other_ways_are_refused(monkeypatch, samples, capsys):
    monkeypatch.setenv(ways.VARIABLE, "fortran")
    with pytest.raises(ConfigError, match="'fortran' is none of native, numba"):
        ways.way()
    assert status_of(["report", str(samples / "plate.vtu")]) == EXIT_USAGE
    (line,) = capsys.readouterr().err.splitlines()
    assert ways.VARIABLE in line


def test_kernels_do_the_same_by_numba(environment):
    said, _ = run("t.checked()", **{**environment, ways.VARIABLE: "numba"})
    assert said == "numba False"


def test_what_kernels_take_and_return_is_the_same_by_numba(environment):
    code = """
import numpy as np
import pytest
assert t.decorators.Entry(t.nothing)(np.zeros(2)) is None
with pytest.raises(TypeError, match="kernels return no array"):
    t.decorators.Entry(t.same)(np.zeros(2))
with pytest.raises(TypeError, match="kernels take C-contiguous arrays"):
    t.decorators.Entry(t.nothing)(np.zeros((4, 4))[:, 0])
fixed = np.zeros(2)
fixed.flags.writeable = False
with pytest.raises(Exception, match="modify readonly array"):
    t.decorators.Entry(t.nothing)(fixed)
"""
    run(code, **{**environment, ways.VARIABLE: "numba"})


def test_a_folder_that_cannot_be_written_is_no_harm_by_numba(environment, tmp_path):
    (tmp_path / "file").touch()
    code = f"t.cache.folder = lambda: t.Path({str(tmp_path)!r}) / 'file' / 'kernels'\nt.checked()"
    said, _ = run(code, **{**environment, ways.VARIABLE: "numba"})
    assert said == "numba False"
    assert not list((ROOT / "tests").rglob("test_ways.found*.nb?"))


def test_damaged_code_is_compiled_again_by_numba(environment, tmp_path):
    environment[ways.VARIABLE] = "numba"
    run("t.checked()", **environment)
    (index,) = tmp_path.rglob("*.nbi")
    (code,) = tmp_path.rglob("*.nbc")
    whole = code.read_bytes()
    code.write_bytes(whole[: len(whole) // 2])
    index_before = index.stat().st_mtime_ns
    assert run("t.checked()", **environment)[0] == "numba False"
    assert next(iter(tmp_path.rglob("*.nbc"))).stat().st_size == len(whole)
    assert next(iter(tmp_path.rglob("*.nbi"))).stat().st_mtime_ns > index_before


# What a numba of other inner names, or a platform without the loader, may do.
FAULTS = {
    "no import": "sys.modules['meshopt_cli.compiled.jit'] = None",
    "a name is gone": "import numba.core.codegen as m; del m.JITCodeLibrary",
    "a method is gone": "import meshopt_cli.compiled.jit as m; del m.Image.emit",
    "an option is gone": "import meshopt_cli.compiled.jit as m; m.OPTIONS['none_such'] = True",
    "no linker": "import llvmlite.binding as m; del m.create_lljit_compiler",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_where_the_loader_fails_numba_does_it(fault, environment, tmp_path):
    said, warned = run(f"{FAULTS[fault]}\nt.checked()\nt.checked()", **environment)
    assert {line.split()[0] for line in said.splitlines()} == {"numba"}
    assert warned.count("the loader of compiled kernels does not know this numba") == 1
    # Later runs do not try again.
    said, warned = run("t.checked()", **environment)
    assert said == "numba False"
    assert warned == ""
    (reason,) = tmp_path.rglob("native.not")
    assert reason.read_text().count("\n") == 1


def test_a_faulty_kernel_is_no_fault_of_the_loader(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "kernels")
    monkeypatch.delenv(ways.VARIABLE, raising=False)
    with pytest.raises(TypeError, match="kernels return no array"):
        decorators.Entry(same)(np.zeros(2))
    assert ways.way() is ways.Way.NATIVE
    # The loader's compiler goes on as if nothing had been.
    assert decorators.Entry(found)(*some()).number == 3
    assert list((tmp_path / "kernels").glob("*.found-*.o"))


def test_a_mesh_is_the_same_by_numba(tmp_path, environment, samples):
    """From nothing: half a minute for the kernels of one pass."""
    mesh = samples / "quadtree.vtk"
    arguments = ["optimize", str(mesh), "", "--passes", "smooth", "-q"]
    written = []
    for name, setting in (("ours.vtk", {}), ("numbas.vtk", environment | {ways.VARIABLE: "numba"})):
        arguments[2] = str(tmp_path / name)
        subprocess.run(
            [sys.executable, "-m", "meshopt_cli", *arguments],
            env={**os.environ, "PYTHONPATH": str(ROOT), **setting},
            check=True,
        )
        written.append((tmp_path / name).read_bytes())
    assert written[0] == written[1] != mesh.read_bytes()
    (folder,) = (tmp_path / "cache").iterdir()
    assert {path.name for path in folder.iterdir() if path.is_file()} == {
        "basic.numba",
        "relocation.numba",
    }


def test_sources_name_the_folder(tmp_path, monkeypatch):
    """numba keys what it keeps on the file of a kernel; helpers lie in others."""
    (tmp_path / "kernels" / "inner").mkdir(parents=True)
    monkeypatch.setattr(cache, "PACKAGE", tmp_path)
    digests = {cache._digest()}
    for name in ("kernels/a.py", "kernels/inner/a.py", "kernels/inner/b.py", "cells.py"):
        (tmp_path / name).write_text("x = 1\n")
        digests.add(cache._digest())
    (tmp_path / "kernels/a.py").write_text("x = 2\n")
    digests.add(cache._digest())
    assert len(digests) == 6
    (tmp_path / "other.py").touch()
    assert cache._digest() in digests
