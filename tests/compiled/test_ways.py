"""The ways to run the kernels: by the loader, and by numba's own means where it does not work."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.cli.entry import status_of
from meshopt_cli.compiled import cache, decorators, ways
from meshopt_cli.errors import EXIT_USAGE, ConfigError
from support.compiling import array, at, outer, total
from support.processes import outside, start_python
from support.samples import ROOT

pytestmark = pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted")

# Calls kernels, which must do what they do in Python, and prints which way they ran.
CHECK = """
import math
import sys
import numpy as np
from meshopt_cli.compiled import ways
from meshopt_cli.compiled.decorators import Entry
from support import compiling as c
ours, theirs = c.outer(), c.outer()
assert Entry(c.total)(ours, 0.25) == c.total(theirs, 0.25)
np.testing.assert_array_equal(ours.inner.values, theirs.inner.values)
found = Entry(c.described)(np.array([-3.0]))
assert repr(found) == repr(c.described([-3.0]))
assert Entry(c.quotient)(1.0, 0.0) == math.inf
print(ways.way(), "meshopt_cli.compiled.jit" in sys.modules)
"""


def run(code, **environment):
    """What Python prints, and what it says besides."""
    process = start_python(code, **environment)
    out, err = process.communicate()
    assert process.returncode == 0, err
    return out.strip(), err


@pytest.fixture
def environment(tmp_path):
    """An empty folder for machine code, and no way asked for."""
    return {"MESHOPT_CACHE_DIR": str(tmp_path / "cache"), ways.VARIABLE: ""}


@pytest.mark.parametrize("name", ["native", "numba"])
def test_the_environment_names_a_way(name, tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folders", at(tmp_path))
    monkeypatch.setenv(ways.VARIABLE, name)
    assert ways.way() == name
    ways.note("basic")
    assert ways.missing(["basic", "mend"]) == ["mend"]
    monkeypatch.setenv(ways.VARIABLE, "numba" if name == "native" else "native")
    assert ways.missing(["basic"]) == ["basic"]


def test_other_ways_are_refused(monkeypatch, samples, capsys):
    monkeypatch.setenv(ways.VARIABLE, "fortran")
    with pytest.raises(ConfigError, match="'fortran' is none of library, native, numba"):
        ways.way()
    assert status_of(["report", str(samples / "plate.vtu")]) == EXIT_USAGE
    (line,) = capsys.readouterr().err.splitlines()
    assert ways.VARIABLE in line


def test_kernels_do_the_same_by_numba(environment):
    said, _ = run(CHECK, **{**environment, ways.VARIABLE: "numba"})
    assert said == "numba False"


def test_what_kernels_take_and_return_is_the_same_by_numba(environment):
    code = """
import numpy as np
import pytest
from meshopt_cli.compiled.decorators import Entry
from support import compiling as c
assert Entry(c.twice)(np.zeros(2)) is None
with pytest.raises(TypeError, match="kernels return no array"):
    Entry(c.array)(np.zeros(2))
with pytest.raises(TypeError, match="kernels take C-contiguous arrays"):
    Entry(c.twice)(np.zeros((4, 4))[:, 0])
fixed = np.zeros(2)
fixed.flags.writeable = False
with pytest.raises(Exception, match="modify readonly array"):
    Entry(c.twice)(fixed)
"""
    run(code, **{**environment, ways.VARIABLE: "numba"})


def test_a_folder_that_cannot_be_written_is_no_harm_by_numba(environment, tmp_path):
    (tmp_path / "file").touch()
    place = f"pathlib.Path({str(tmp_path)!r}) / 'file' / 'kernels'"
    code = (
        "import pathlib; from meshopt_cli.compiled import cache\n"
        f"cache.folders = lambda: ({place}, [{place}])\n"
    )
    said, _ = run(code + CHECK, **{**environment, ways.VARIABLE: "numba"})
    assert said == "numba False"
    assert not list((ROOT / "tests").rglob("compiling.*.nb?"))


def test_damaged_code_is_compiled_again_by_numba(environment, tmp_path):
    environment[ways.VARIABLE] = "numba"
    run(CHECK, **environment)
    sizes = {path: path.stat().st_size for path in tmp_path.rglob("*.nbc")}
    assert len(sizes) == 3
    for path, size in sizes.items():
        path.write_bytes(path.read_bytes()[: size // 2])
    assert run(CHECK, **environment)[0] == "numba False"
    assert {path: path.stat().st_size for path in tmp_path.rglob("*.nbc")} == sizes


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
    said, warned = run(f"import sys\n{FAULTS[fault]}\n{CHECK}{CHECK}", **environment)
    assert {line.split()[0] for line in said.splitlines()} == {"numba"}
    assert warned.count("the loader of compiled kernels does not know this numba") == 1
    # Later runs do not try again.
    said, warned = run(CHECK, **environment)
    assert said == "numba False"
    assert warned == ""
    (reason,) = tmp_path.rglob("native.not")
    assert reason.read_text().count("\n") == 1


def test_a_faulty_kernel_is_no_fault_of_the_loader(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "folders", at(tmp_path / "kernels"))
    monkeypatch.delenv(ways.VARIABLE, raising=False)
    with pytest.raises(TypeError, match="kernels return no array"):
        decorators.Entry(array)(np.zeros(2))
    assert ways.way() is ways.Way.NATIVE
    # The loader's compiler goes on as if nothing had been.
    assert decorators.Entry(total)(outer(), 0.25) == total(outer(), 0.25)
    assert list((tmp_path / "kernels").glob("*.total-*.o"))


def test_a_mesh_is_the_same_by_numba(tmp_path, environment, samples):
    """From nothing: a quarter of a minute for the kernels of the pass with the fewest."""
    mesh = samples / "quadtree.vtk"
    written = []
    for name, setting in (("ours.vtk", {}), ("numbas.vtk", environment | {ways.VARIABLE: "numba"})):
        out = tmp_path / name
        assert outside("optimize", mesh, out, "--passes", "collapse", "-q", **setting).status == 0
        written.append(out.read_bytes())
    assert written[0] == written[1] != mesh.read_bytes()
    (folder,) = (tmp_path / "cache").iterdir()
    assert {path.name for path in folder.iterdir() if path.is_file()} == {
        "basic.numba",
        "collapse.numba",
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
