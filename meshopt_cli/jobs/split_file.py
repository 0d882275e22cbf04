"""A mesh cut in pieces, and pieces put together, from file to file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import formats, validity
from ..errors import BadMeshError, ConfigError, naming
from ..files.folders import replacing_folder, require_own_folder
from ..files.places import require_writable
from ..formats import FORMATS
from ..formats.vtk.parallel import SUFFIX, folder_of, is_index, names_of, write_index
from ..mesh.model import top_blocks
from ..mesh.pieces import IDS, cut
from .admission import READABLE, not_valid


@dataclass(frozen=True)
class Cut:
    """What came of cutting a mesh: cells of the greatest dimension in each piece, and how many
    points several pieces have."""

    output: Path
    n_cells: tuple[int, ...]
    n_shared: int
    lost: tuple[str, ...] = ()


def require_index(path: Path) -> None:
    """Refuse a place for pieces that is not called so.

    Raises
    ------
    ConfigError, WriteError
    """
    if not is_index(path):
        raise ConfigError(f"{path}: pieces go to a file called {SUFFIX}, and a folder beside it")
    require_writable(path)
    require_own_folder(folder_of(path), ".vtu")


def split_file(
    input: Path, output: Path, n: int, input_format: str | None = None, max_size: int | None = None
) -> Cut:
    """Cut the mesh of a file in n pieces, which a `.pvtu` beside their folder names.

    Raises
    ------
    ConfigError
        The output is no `.pvtu`, or there are fewer cells than pieces.
    ReadError, WriteError
    BadMeshError
        A cell has a vertex that is not there.
    """
    require_index(output)
    mesh, _ = formats.read(input, input_format, max_size)
    with naming(input):
        report = validity.check(mesh, READABLE)
        if not report.is_valid:
            raise BadMeshError(not_valid(report))
        n_cells = sum(len(block.cells) for block in top_blocks(mesh))
        if n > n_cells:
            raise ConfigError(f"{n} pieces cannot be made of {n_cells:,} cells")
    encoding = FORMATS["vtu"].default
    whole, lost = formats.fitted(output, mesh, encoding)
    names, counts = names_of(output, n), []
    times = np.zeros(len(mesh.points), dtype=np.int64)
    with replacing_folder(folder_of(output)) as folder:
        for name, piece in zip(names, cut(whole, n), strict=True):
            formats.write(folder / name, piece, encoding)
            counts.append(sum(len(block.cells) for block in top_blocks(piece)))
            times[piece.point_data[IDS]] += 1
    write_index(output, names, piece)
    return Cut(output, tuple(counts), int(np.count_nonzero(times > 1)), lost)


def join_file(
    input: Path,
    output: Path,
    input_format: str | None = None,
    file_format: str | None = None,
    binary: bool | None = None,
    max_size: int | None = None,
) -> tuple[int, int]:
    """Put the pieces of a mesh together; returns the numbers of its cells and points.

    Raises
    ------
    ConfigError, ReadError, WriteError
    """
    require_writable(output)
    mesh, source = formats.read(input, input_format, max_size)
    encoding = formats.encoding_for(output, source.encoding, file_format, binary)
    mesh.point_data.pop(IDS, None)
    formats.write(output, mesh, encoding)
    return sum(len(block.cells) for block in mesh.blocks), len(mesh.points)
