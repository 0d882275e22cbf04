"""Many files at once."""

import os
import subprocess
import sys

import pytest

from support.broken import BROKEN
from support.files import write
from support.meshes import quad_grid, tet_grid


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "meshes"
    (folder / "inner").mkdir(parents=True)
    write(folder / "a.vtu", tet_grid(1))
    write(folder / "b.mesh", BROKEN["hanging node"][0])
    write(folder / "inner" / "c.vtk", quad_grid(2))
    (folder / "notes.txt").write_text("no mesh")
    return folder


def test_folders_and_patterns(check, folder, tmp_path):
    status, out, err = check(folder)
    assert (status, err) == (1, "")
    assert out.splitlines()[-1] == "3 files: 2 valid, 1 not valid"
    assert "c.vtk: valid" in out
    _, out, _ = check(folder / "*.vtu", folder / "**" / "*.vtk", folder / "a.vtu")
    assert out.splitlines()[-1] == "2 files: 2 valid"
    for nothing in (folder / "*.msh", tmp_path / "empty"):
        (tmp_path / "empty").mkdir(exist_ok=True)
        status, out, err = check(nothing)
        assert (status, out) == (3, "")
        assert str(nothing) in err


@pytest.mark.parametrize("form", ["text", "json", "github", "junit", "sarif"])
def test_processes_change_nothing(check, folder, form):
    missing = folder / "missing.vtu"
    alone = check(folder, missing, "--format", form, "--jobs", "1")
    assert check(folder, missing, "--format", form, "--jobs", "3") == alone
    assert alone[0] == 3


def test_small_files_need_no_compiler(good):
    code = (
        "import sys; from meshopt_cli.cli.entry import status_of\n"
        f"assert status_of(['check', {str(good)!r}, '--min-angle', '1']) == 0\n"
        "print({'numba', 'tqdm'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True,
                         env=os.environ)  # fmt: skip
    assert ran.stdout.splitlines()[-1] == "set()"
