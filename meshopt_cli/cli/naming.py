"""Errors about a mesh, with the name of its file."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from ..errors import BadMeshError, ConfigError, InvariantError, UnsupportedMeshError


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Put the name of the file before what is said of the mesh in it."""
    try:
        yield
    except (BadMeshError, ConfigError, UnsupportedMeshError, InvariantError) as error:
        error.args = (f"{path}: {error}", *error.args[1:])
        raise
