"""`meshopt check` with nothing configured, and meshes for it."""

import pytest

from support.broken import BROKEN
from support.files import write
from support.meshes import tet_grid


@pytest.fixture(autouse=True)
def _nothing_configured(tmp_path, monkeypatch):
    """No file of this project is found from the working directory."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def check(meshopt):
    """Run `meshopt check`; gives status, stdout and stderr."""
    return lambda *arguments: meshopt("check", *arguments)


@pytest.fixture
def good(tmp_path):
    return write(tmp_path / "good.vtu", tet_grid(2))


@pytest.fixture
def bad(tmp_path):
    return write(tmp_path / "bad.vtu", BROKEN["tets across each other"][0])


@pytest.fixture
def torn(tmp_path):
    return write(tmp_path / "torn.vtu", BROKEN["crack between tets"][0])
