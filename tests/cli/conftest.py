"""The command line in this process, and files to give it."""

import logging

import pytest

from meshopt_cli.cli.entry import status_of
from support.edits import shaken
from support.files import write
from support.meshes import in_space, tet_grid, tri_grid
from support.processes import Ran, without_notice


@pytest.fixture(autouse=True)
def _plain_environment(monkeypatch):
    """What a user may have set does not change what is shown."""
    for name in ("FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "COLUMNS", "MESHOPT_TRACEBACK"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture(autouse=True)
def _log_as_before():
    """Give the log back to the other tests as it was."""
    log = logging.getLogger("meshopt")
    handlers, level, propagate = log.handlers[:], log.level, log.propagate
    yield
    log.handlers[:], log.propagate = handlers, propagate
    log.setLevel(level)


@pytest.fixture
def meshopt(capsys):
    """Run a command line in this process."""

    def run(*arguments):
        capsys.readouterr()
        status = status_of([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Ran(status, out, without_notice(err))

    return run


@pytest.fixture
def tets(tmp_path):
    """A file of tetrahedra with something to gain."""
    return write(tmp_path / "tets.vtk", shaken(tet_grid(4)))


@pytest.fixture
def triangles(tmp_path):
    return write(tmp_path / "triangles.vtu", in_space(shaken(tri_grid(6))))


@pytest.fixture
def broken(samples):
    return samples / "broken.vtk"
