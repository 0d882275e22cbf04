"""What several test modules share."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from support.samples import SAMPLES
from support.settings import MORE, VARIABLE


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


def pytest_terminal_summary(terminalreporter):
    """Say how to try more."""
    if not MORE:
        terminalreporter.line(
            f"property tests try the same examples each time: {VARIABLE}=10 in the environment "
            "tries ten times as many, at random"
        )
