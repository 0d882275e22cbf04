"""A mesh cut in pieces, and pieces put together, from file to file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from .. import formats, validity
from ..errors import BadMeshError, ConfigError, naming
from ..files.folders import replacing_folder, require_own_folder
from ..files.places import require_writable
from ..formats import FORMATS
from ..formats.vtk.dataset import MARKS
from ..formats.vtk.parallel import SUFFIX, folder_of, is_index, is_piece_of, names_of, write_index
from ..formats.vtk.pieces import ALIASES, DUPLICATE
from ..mesh.model import Mesh, top_blocks
from ..mesh.pieces import IDS, cut, part_of
from ..mesh.tags import PARTITION
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
    require_own_folder(folder_of(path), partial(is_piece_of, path))


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


def gather_files(
    inputs: Sequence[Path],
    output: Path,
    input_format: str | None = None,
    max_size: int | None = None,
) -> Cut:
    """Make each of several files a piece, as Gmsh writes the partitions of a mesh.

    A point has the number of its file, or that of the array `IDS` or its like. Ghosts, cells of
    another partition, are left out, and points that no cell has.

    Raises
    ------
    ConfigError
        The output is no `.pvtu`.
    ReadError, WriteError
    BadMeshError
        A file has a cell with a vertex that is not there, or other arrays than the first.
    """
    require_index(output)
    encoding = FORMATS["vtu"].default
    names, counts, lost = names_of(output, len(inputs)), [], dict[str, None]()
    every, arrays = [], None
    with replacing_folder(folder_of(output)) as folder:
        for name, path in zip(names, inputs, strict=True):
            mesh, _ = formats.read(path, input_format, max_size)
            with naming(path):
                report = validity.check(mesh, READABLE)
                if not report.is_valid:
                    raise BadMeshError(not_valid(report))
                known = next((n for n in mesh.point_data if n.lower() in ALIASES), None)
                ids = np.arange(len(mesh.points)) if mesh.numbers is None else mesh.numbers
                ids = ids if known is None else mesh.point_data.pop(known)
                mesh.point_data[IDS] = ids.astype(np.int64)
                whole, dropped = formats.fitted(output, own_partition(mesh), encoding)
                piece = part_of(whole, [np.ones(len(b.cells), bool) for b in whole.blocks])
                found = {*piece.point_data, *(n for block in piece.blocks for n in block.data)}
                if arrays is not None and found != arrays:
                    raise BadMeshError("it has other arrays than the first piece")
            arrays = found
            formats.write(folder / name, piece, encoding)
            lost |= dict.fromkeys(dropped)
            counts.append(sum(len(block.cells) for block in top_blocks(piece)))
            every.append(piece.point_data[IDS])
    write_index(output, names, piece)
    _, times = np.unique(np.concatenate(every), return_counts=True)
    return Cut(output, tuple(counts), int(np.count_nonzero(times > 1)), tuple(lost))


def own_partition(mesh: Mesh) -> Mesh:
    """A file of a partition without its ghosts: most of its cells are in the same one."""
    numbers = [block.data[PARTITION] for block in top_blocks(mesh) if PARTITION in block.data]
    if not numbers:
        return own_cells(mesh)
    found, count = np.unique(np.concatenate(numbers), return_counts=True)
    own = found[found > 0][np.argmax(count[found > 0])] if (found > 0).any() else 0
    masks = [
        block.data[PARTITION] == own
        if PARTITION in block.data and any(block is one for one in top_blocks(mesh))
        else np.ones(len(block.cells), bool)
        for block in mesh.blocks
    ]
    return part_of(mesh, masks)


def own_cells(mesh: Mesh) -> Mesh:
    """A piece without its ghosts, cells that another piece has, and without what marks them."""
    if not any(name in MARKS for block in mesh.blocks for name in block.data):
        return mesh
    masks = []
    for block in mesh.blocks:
        marks = next((block.data[name] for name in MARKS if name in block.data), None)
        masks.append(np.ones(len(block.cells), bool) if marks is None else marks & DUPLICATE == 0)
    mesh = part_of(mesh, masks)
    for block in mesh.blocks:
        block.data = {name: a for name, a in block.data.items() if name not in MARKS}
    mesh.point_data = {name: a for name, a in mesh.point_data.items() if name not in MARKS}
    return mesh


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
