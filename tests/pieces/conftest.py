"""Meshes in pieces, in files."""

from __future__ import annotations

import pytest

from meshopt_cli import formats
from meshopt_cli.jobs.split_file import split_file
from support.edits import halves, shaken
from support.files import write
from support.meshes import tet_grid, tri_grid


@pytest.fixture
def whole(tmp_path):
    """A file of tetrahedra in two regions, with something to gain everywhere."""
    return write(tmp_path / "whole.vtu", halves(shaken(tet_grid(8), 0.25, 3)))


@pytest.fixture
def triangles(tmp_path):
    """A file of triangles, likewise."""
    return write(tmp_path / "flat.vtu", shaken(tri_grid(24), 0.3, 3))


@pytest.fixture
def pieces_of(tmp_path):
    """Cut a file in n pieces; returns the index."""

    def cut(path, n):
        index = tmp_path / f"{path.stem}-in-{n}.pvtu"
        split_file(path, index, n)
        return index

    return cut


@pytest.fixture
def read():
    """Read all pieces of an index, one by one."""
    from meshopt_cli.formats.vtk.parallel import sources_of

    return lambda index: [formats.read(path)[0] for path in sources_of(index)]
