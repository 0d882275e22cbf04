"""One repair from file to file, without a word to the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .. import __version__, formats
from ..errors import EXIT_BAD_MESH, EXIT_DONE, naming
from ..files.places import require_writable
from ..repair import repair
from ..report.repair import RepairReport
from ..validity import check
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
    before = check(mesh, tolerance=task.tolerance)
    with naming(task.input):
        repaired = repair(mesh, task.mends, task.tolerance)
    after = before
    if repaired.mesh is not mesh:
        after = check(repaired.mesh, tolerance=task.tolerance)
    written = formats.write(task.output, repaired.mesh, encoding)
    status = EXIT_DONE if after.is_valid else EXIT_BAD_MESH
    return RepairReport(
        __version__,
        str(task.input),
        {group.code: len(group) for group in before.groups},
        verdict_on(task.output, written, repaired.mesh, after, status),
        {name: one.counts for name, one in repaired.mends.items()},
        repaired.notes,
        source.lost + written.lost,
    )
