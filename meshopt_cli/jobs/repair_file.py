"""One repair from file to file, without a word to the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .. import formats
from ..errors import EXIT_BAD_MESH, EXIT_DONE, naming
from ..files.places import require_writable
from ..formats import Source
from ..mesh.model import Mesh
from ..repairs import repair
from ..reports.repair import RepairReport
from ..validity import Report, check
from ..version import __version__
from .findings import verdict_on


@dataclass(frozen=True)
class RepairTask:
    """What to mend, and where the result goes.

    Attributes
    ----------
    input, output : Path
        See `optimize_file.place_of`.
    mends : tuple of str
        Keys of `repair.MENDS`.
    tolerance : float, optional
        Part of the extent of the mesh within which points are in one place.
    input_format, file_format : str, optional
        Keys of `FORMATS`, whatever the names of the files say.
    binary : bool, optional
        Write text or binary; as the input was where it is left out.
    max_size : int, optional
        The most bytes that the input may have: see `formats.read`.
    """

    input: Path
    output: Path
    mends: tuple[str, ...]
    tolerance: float | None = None
    input_format: str | None = None
    file_format: str | None = None
    binary: bool | None = None
    max_size: int | None = None


def repair_file(task: RepairTask) -> RepairReport:
    """Read a mesh, mend it, and write it, valid or not: the report says what is left.

    Raises
    ------
    ConfigError
        Something of the task is wrong.
    ReadError, WriteError
        A file cannot be read, or written.
    BadMeshError
        No cell would be left.
    """
    require_writable(task.output)
    mesh, source = formats.read(task.input, task.input_format, task.max_size)
    encoding = formats.encoding_for(task.output, source.encoding, task.file_format, task.binary)
    done = repair_mesh(mesh, source, task.mends, task.tolerance)
    written = formats.write(task.output, done.mesh, encoding)
    return report_on_repair(done, source, written)


@dataclass(frozen=True)
class Mended:
    """A mesh that was mended, and what there was and is to find in it."""

    before: Report
    mesh: Mesh
    after: Report
    mends: dict[str, dict[str, int]]
    notes: tuple[str, ...]


def repair_mesh(
    mesh: Mesh, source: Source, mends: tuple[str, ...], tolerance: float | None = None
) -> Mended:
    """Mend a mesh; it is left as it is.

    Parameters
    ----------
    source : Source
        Where it comes from: errors name it.
    mends, tolerance
        See `RepairTask`.

    Raises
    ------
    ConfigError
        There is no such mend.
    BadMeshError
        No cell would be left.
    """
    before = check(mesh, tolerance=tolerance)
    with naming(source.path):
        repaired = repair(mesh, mends, tolerance)
    after = before
    if repaired.mesh is not mesh:
        after = check(repaired.mesh, tolerance=tolerance)
    counts = {name: one.counts for name, one in repaired.mends.items()}
    return Mended(before, repaired.mesh, after, counts, repaired.notes)


def report_on_repair(done: Mended, source: Source, result: Source) -> RepairReport:
    """What is to be said of a repair.

    Parameters
    ----------
    result : Source
        The file of the result, or what else its cells have their names by.
    """
    status = EXIT_DONE if done.after.is_valid else EXIT_BAD_MESH
    return RepairReport(
        __version__,
        str(source.path),
        {group.code: len(group) for group in done.before.groups},
        verdict_on(result.path, result, done.mesh, done.after, status),
        done.mends,
        done.notes,
        source.lost + (result.lost if result is not source else ()),
    )
