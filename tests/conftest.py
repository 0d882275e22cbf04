"""What several test modules share."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from support.samples import SAMPLES


@pytest.fixture(scope="session")
def samples() -> Path:
    """The folder with the sample meshes."""
    return SAMPLES


@pytest.fixture(autouse=True)
def _log_of_its_own():
    """The command line takes the log over; every test starts as if none had run."""
    log = logging.getLogger("meshopt")
    log.handlers[:] = []
    log.propagate = True
    log.setLevel(logging.NOTSET)
