"""Between a `Mesh` and meshio: what it reads."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..mesh.model import Block, Mesh

if TYPE_CHECKING:
    import meshio


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep meshio from printing: what is wrong with a file is looked for before."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield


def from_meshio(mesh: meshio.Mesh) -> Mesh:
    """Take over what meshio read."""
    arrays = mesh.cell_data
    blocks = [
        Block(block.type, np.asarray(block.data), {name: arrays[name][i] for name in arrays})
        for i, block in enumerate(mesh.cells)
    ]
    return Mesh(mesh.points, blocks, dict(mesh.point_data))
