"""Between a `Mesh` and meshio: what it reads, and what it says meanwhile."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..mesh.model import Block, Mesh

if TYPE_CHECKING:
    import meshio

log = logging.getLogger("meshopt")


@contextlib.contextmanager
def listening(level: int) -> Iterator[None]:
    """Send what meshio prints to our log."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            yield
    finally:
        if said.getvalue():
            log.log(level, "meshio: %s", " ".join(said.getvalue().split()))


def from_meshio(mesh: meshio.Mesh) -> Mesh:
    """Take over what meshio read."""
    arrays = mesh.cell_data
    blocks = [
        Block(block.type, np.asarray(block.data), {name: arrays[name][i] for name in arrays})
        for i, block in enumerate(mesh.cells)
    ]
    return Mesh(mesh.points, blocks, dict(mesh.point_data))
