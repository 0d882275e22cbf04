"""What several test modules share."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

SAMPLES = Path(__file__).parent.parent / "samples"


@pytest.fixture(scope="session")
def samples() -> Path:
    """The folder with the sample meshes."""
    return SAMPLES


@pytest.fixture(autouse=True)
def _log_as_it_was():
    """The command line takes the log over: give it back after each test."""
    log = logging.getLogger("meshopt")
    before = log.handlers[:], log.propagate, log.level
    yield
    log.handlers[:], log.propagate, log.level = before
