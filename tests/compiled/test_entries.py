"""Kernels as Python calls them: compiled once for each layout, stored whole, loaded as stored."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli import formats
from meshopt_cli.compiled import cache, decorators, ways
from support.compiling import Found, Part, array, at, described, first, outer, scaled, total, twice
from support.edits import shaken
from support.meshes import tet_grid
from support.processes import said, start_python

# An interpreted run (NUMBA_DISABLE_JIT) has no compiled kernels to look at.
pytestmark = pytest.mark.skipif(ways.INTERPRETED, reason="kernels are interpreted")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder for machine code."""
    monkeypatch.setattr(cache, "folders", at(tmp_path / "kernels"))
    return tmp_path / "kernels"


@pytest.fixture
def compiled(monkeypatch):
    """Names of the functions that are compiled from now on."""
    from meshopt_cli.compiled import jit

    names = []
    compile_entry = jit.compile_entry

    def noting(function, arguments):
        names.append(function.__name__)
        return compile_entry(function, arguments)

    monkeypatch.setattr(jit, "compile_entry", noting)
    return names


def test_arguments_and_results(folder):
    ours, theirs = outer(), outer()
    assert decorators.Entry(total)(ours, 0.25) == total(theirs, 0.25)
    np.testing.assert_array_equal(ours.inner.values, theirs.inner.values)


def test_none_and_scalars(folder):
    values = np.array([1.5, 2.0])
    assert decorators.Entry(twice)(values) is None
    assert values.tolist() == [3.0, 4.0]
    assert decorators.Entry(first)(values) == 3.0
    assert decorators.Entry(first)(np.array([7, 8])) == 7


def test_named_tuples_come_back(folder):
    for value in (2.0, -3.0):
        found = decorators.Entry(described)(np.array([value]))
        assert found == described(np.array([value]))
        assert isinstance(found, Found)
        assert isinstance(found.rest[1], Part)
        assert isinstance(found.is_positive, bool)


def test_arrays_do_not(folder):
    with pytest.raises(TypeError, match="kernels return no array"):
        decorators.Entry(array)(np.ones(2))


def test_code_is_loaded_as_stored(folder, compiled):
    decorators.Entry(twice)(np.ones(2))
    values = np.ones(2)
    decorators.Entry(twice)(values)
    assert values.tolist() == [2.0, 2.0]
    assert compiled == ["twice"]


def test_every_layout_has_code_of_its_own(folder, compiled):
    entry = decorators.Entry(twice)
    for values in (np.ones(2), np.ones(2, dtype=np.int64), np.ones(5), np.ones(2, np.float32)):
        entry(values)
        assert set(values.tolist()) == {2}
    assert compiled == ["twice"] * 3
    assert len(list(folder.iterdir())) == 3


def test_a_changed_source_is_compiled_again(folder, tmp_path):
    source = tmp_path / "changing.py"
    for factor in (2, 3):
        text = f"def f(x):\n    return {factor} * x\n"
        source.write_text(text)
        names = {"__name__": "changing"}
        exec(compile(text, source, "exec"), names)
        assert decorators.Entry(names["f"])(5) == factor * 5


def test_a_read_only_array_cannot_be_written_to(folder):
    values = np.ones(2)
    values.flags.writeable = False
    with pytest.raises(Exception, match="modify readonly array"):
        decorators.Entry(twice)(values)
    assert decorators.Entry(first)(values) == 1.0


@pytest.mark.parametrize("harm", ["cut", "changed", "emptied"])
def test_damaged_code_is_compiled_again(folder, compiled, harm):
    decorators.Entry(twice)(np.ones(2))
    (stored,) = folder.iterdir()
    whole = stored.read_bytes()
    middle = len(whole) // 2
    changed = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    stored.write_bytes({"cut": whole[:middle], "changed": changed, "emptied": b""}[harm])
    values = np.ones(2)
    decorators.Entry(twice)(values)
    assert values.tolist() == [2.0, 2.0]
    assert compiled == ["twice"] * 2
    assert cache.read(stored.name)


@pytest.mark.parametrize(
    "argument",
    [np.ones((4, 4))[:, 0], np.ones((2, 2)).T, np.ones(2, ">f8"), [1.0], np.float32(1.0), "1"],
    ids=["strided", "transposed", "swapped", "list", "float32", "str"],
)
def test_other_arguments_are_refused(folder, argument):
    with pytest.raises(TypeError, match="kernels take"):
        decorators.Entry(twice)(argument)


def test_code_that_needs_functions_of_numba(folder):
    assert decorators.Entry(scaled)(1.5, 3) == 12.0


def test_where_nothing_can_be_written(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setattr(cache, "folders", at(tmp_path / "file" / "kernels"))
    assert decorators.Entry(first)(np.array([7.0])) == 7.0


def test_two_processes_compile_at_once(tmp_path):
    code = (
        "from support import compiling as t; print(*t.decorators.Entry(t.total)(t.outer(), 0.25))"
    )
    both = [start_python(code, MESHOPT_CACHE_DIR=str(tmp_path)) for _ in range(2)]
    count, sum_ = total(outer(), 0.25)
    assert [said(process).strip() for process in both] == [f"{count} {sum_}"] * 2
    (folder,) = tmp_path.iterdir()
    assert [path.suffix for path in folder.iterdir()] == [".o"]


def test_a_warm_run_does_without_numba(tmp_path):
    mesh = tmp_path / "in.mesh"
    formats.write(mesh, shaken(tet_grid(3), 1.0, 1), formats.FORMATS["medit"].default)
    code = (
        "import sys; from meshopt_cli.cli.entry import status_of\n"
        "status = status_of(['optimize', *sys.argv[1:], '-q'])\n"
        "print(status, 'numba' in sys.modules)"
    )
    said(start_python(code, mesh, tmp_path / "out.mesh"))
    assert said(start_python(code, mesh, tmp_path / "out.mesh")).strip() == "0 False"


def test_bounds_are_checked_where_numba_is_told_to(tmp_path):
    code = (
        "import numpy; from support import compiling as t\n"
        "t.decorators.Entry(t.first)(numpy.empty(0))"
    )
    environment = {"NUMBA_BOUNDSCHECK": "1", "MESHOPT_CACHE_DIR": str(tmp_path)}
    _, errors = start_python(code, **environment).communicate()
    assert "a compiled kernel failed" in errors
