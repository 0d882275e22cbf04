"""The same input gives the same bytes: run twice, compiled or interpreted, bounds checked."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from support.edits import shaken
from support.meshes import tet_grid, tri_grid
from support.samples import ROOT


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A small mesh of each kind, and what a compiled run makes of it."""
    folder = tmp_path_factory.mktemp("small")
    made = {}
    for name, mesh in (
        ("tets", shaken(tet_grid(3), 0.9, 1)),
        ("tris", shaken(tri_grid(5), 1.5, 1)),
    ):
        path = folder / f"{name}.mesh"
        formats.write(path, mesh, formats.FORMATS["medit"].default)
        made[path] = written(path, folder / f"{name}.out.mesh")
    return made


def written(path, output, preset="best"):
    """Optimize in this process; returns the bytes of the result."""
    assert status_of(["optimize", str(path), str(output), "-q", "--preset", preset]) == 0
    return output.read_bytes()


def in_process(path, output, preset="best", **environment):
    """Optimize in another process; returns the bytes of the result."""
    command = [sys.executable, "-m", "meshopt_cli", "optimize", path, output]
    subprocess.run(
        [*command, "-q", "--preset", preset],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        check=True,
    )
    return output.read_bytes()


def test_two_runs(small, tmp_path):
    for path, expected in small.items():
        assert written(path, tmp_path / path.name) == expected


def test_the_result_is_another_mesh(small):
    for path, expected in small.items():
        assert path.read_bytes() != expected


def test_interpreted(small, tmp_path):
    """Numpy looks at every index here, so that none is beyond its array."""
    for path, expected in small.items():
        assert in_process(path, tmp_path / path.name, NUMBA_DISABLE_JIT="1") == expected


def test_bounds_checked(small, tmp_path):
    """Compiled code that looks at every index: of the preset that takes least to compile."""
    environment = {"NUMBA_BOUNDSCHECK": "1", "MESHOPT_CACHE_DIR": str(tmp_path / "kernels")}
    for path in small:
        expected = written(path, tmp_path / path.name, "fast")
        assert in_process(path, tmp_path / path.name, "fast", **environment) == expected
