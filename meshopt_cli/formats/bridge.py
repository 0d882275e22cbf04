"""Between a `Mesh` and meshio: what it reads, and what it says meanwhile."""

from __future__ import annotations

import contextlib
import io
import logging
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..mesh.model import Block, Mesh
from .sniff import UnreadableError

if TYPE_CHECKING:
    import meshio

log = logging.getLogger("meshopt")


@contextlib.contextmanager
def listening(level: int) -> Iterator[None]:
    """Send what meshio prints to our log, and do not let numpy read half a number."""
    from meshio._mesh import topological_dimension

    topological_dimension.update(wedge15=3, pyramid13=3)  # which it knows everywhere else
    said = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(said),
            warnings.catch_warnings(),
        ):
            # numpy stops at what it cannot read, and only warns
            warnings.filterwarnings("error", message=".*could not be read to its end")
            yield
    except DeprecationWarning:
        raise UnreadableError("a number was expected, and something else found") from None
    finally:
        if said.getvalue():
            log.log(level, "meshio: %s", " ".join(said.getvalue().split()))


@contextlib.contextmanager
def prepared(path: Path, data: bytes, plain: bytes, name: str = "mesh") -> Iterator[Path]:
    """Give meshio a file with `plain` in it: the one at `path` if that is its `data`."""
    if plain == data:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, name)
        copy.write_bytes(plain)
        yield copy


def from_meshio(mesh: meshio.Mesh) -> Mesh:
    """Take over what meshio read."""
    arrays = mesh.cell_data
    blocks = [
        Block(block.type, np.asarray(block.data), {name: arrays[name][i] for name in arrays})
        for i, block in enumerate(mesh.cells)
    ]
    return Mesh(mesh.points, blocks, dict(mesh.point_data))
