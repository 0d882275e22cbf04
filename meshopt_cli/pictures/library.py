"""What pictures are drawn by, and what to do where it is missing."""

from __future__ import annotations

from importlib.util import find_spec

from ..errors import ConfigError

LIBRARIES = ("matplotlib", "pyvista")
REMEDY = "pip install 'meshopt-cli[plot]'"


def missing() -> str:
    """What is missing for pictures, and how to get it, in words; empty where nothing is."""
    names = [name for name in LIBRARIES if find_spec(name) is None]
    return f"pictures need {' and '.join(names)}: {REMEDY}" if names else ""


def require() -> None:
    """Find out whether pictures can be drawn.

    Raises
    ------
    ConfigError
        A library is missing.
    """
    if what := missing():
        raise ConfigError(what)
