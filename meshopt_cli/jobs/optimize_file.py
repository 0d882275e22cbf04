"""One optimization from file to file, without a word to the terminal."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from .. import formats
from ..errors import ConfigError
from ..files.places import require_writable
from ..formats import PIPE, Encoding, Source, Written
from ..formats.medit_sol import is_sol
from ..progress.observer import SILENT, Observer, Stage
from ..reports.model import Report
from .optimize import Result
from .optimize_mesh import Optimized, Prepare, Task, accepted, optimize_mesh
from .quality_arrays import with_quality
from .report import naming_cells, report_of


@dataclass(frozen=True)
class FileTask:
    """What to optimize, how, and where the result goes.

    Attributes
    ----------
    input, output : Path
        `formats.PIPE` stands for stdin and stdout; see `place_of`.
    task : Task
        What to make of the mesh.
    fail_above : float, optional
        Write nothing where a cell stays worse than this Q.
    input_format, file_format : str, optional
        Keys of `FORMATS`, whatever the names of the files say.
    binary : bool, optional
        Write text or binary; as the input was where it is left out.
    metric_out : str, optional
        Where the metric at the points of the result goes: see `write_optimized`.
    with_pictures : bool
        Draw the mesh before and after, where there is what draws it.
    """

    input: Path
    output: Path
    task: Task = field(default_factory=Task)
    fail_above: float | None = None
    input_format: str | None = None
    file_format: str | None = None
    binary: bool | None = None
    metric_out: str | None = None
    with_pictures: bool = False

    @property
    def sources(self) -> list[Path]:
        """The files that are read."""
        metric = self.task.metric
        return [self.input, *([metric.path] if metric and metric.path else [])]

    @property
    def places(self) -> list[Path]:
        """The files that are written."""
        return [self.output, *([self.metric_path] if self.metric_path else [])]

    @property
    def metric_path(self) -> Path | None:
        """The file that the metric goes to, if it is one."""
        named = Path(self.metric_out or "")
        return named if is_sol(named) else None


@dataclass(frozen=True)
class FileResult:
    """An optimized mesh, what is to be said of it, and its file; None where it was too bad."""

    result: Result
    report: Report
    written: Written | None


def optimize_file(
    task: FileTask, observer: Observer = SILENT, prepare: Prepare | None = None
) -> FileResult:
    """Read a mesh, optimize it, and write it where it is good enough.

    Parameters
    ----------
    prepare : function of groups of kernels, optional
        See `optimize_mesh`.

    Raises
    ------
    ConfigError
        Something of the task is wrong; most of it is found before the file is read.
    ReadError, WriteError
        A file cannot be read, or written.
    InvalidFileError
        The mesh is not valid.
    BadMeshError, UnsupportedMeshError, InvariantError
        See `optimize.optimize`.
    """
    given = accepted(task.task)
    require_writable(task.output)
    if task.metric_out is not None and given.task.metric is None:
        raise ConfigError("--metric-out is of no use without --metric or --size")
    if task.metric_path is not None:
        require_writable(task.metric_path)
    clock = [time.perf_counter()]
    observer.entered(Stage.READ)
    mesh, source = formats.read(task.input, task.input_format, given.task.max_size)
    encoding = formats.encoding_for(task.output, source.encoding, task.file_format, task.binary)
    clock.append(time.perf_counter())
    done = optimize_mesh(given, mesh, source, observer, prepare)
    clock.append(time.perf_counter())
    written = None
    if task.fail_above is None or done.result.after.worst <= task.fail_above:
        observer.entered(Stage.WRITE)
        quality, metric_out = given.task.write_quality, task.metric_out
        done, written = write_optimized(done, task.output, encoding, quality, metric_out)
    clock.append(time.perf_counter())
    times = (b - a for a, b in pairwise(clock))
    seconds = dict(zip(("read", "optimize", "write"), times, strict=True))
    report = report_on_run(done, source, written, seconds, task.with_pictures)
    return FileResult(done.result, report, written)


def write_optimized(
    done: Optimized,
    path: Path,
    encoding: Encoding,
    write_quality: bool = False,
    metric_out: str | None = None,
) -> tuple[Optimized, Written]:
    """Write an optimized mesh to a file.

    Parameters
    ----------
    encoding : Encoding
        See `formats.encoding_for`.
    write_quality : bool
        Put the arrays of `quality_arrays` on its cells.
    metric_out : str, optional
        Where the metric at its points goes: a file called `.sol` or `.solb`, or else an array of
        the mesh by this name.

    Returns
    -------
    done : Optimized
        Its worst cells have the names that they have in the file.
    written : Written

    Raises
    ------
    WriteError
    """
    mesh = with_quality(done.result.mesh, done.plan.measure) if write_quality else done.result.mesh
    if done.metric is not None and metric_out is not None:
        from .metric import with_metric  # seldom needed

        mesh = with_metric(mesh, done.metric, metric_out, encoding.format)
    written = formats.write(path, mesh, encoding)
    return named_in(done, written), written


def named_in(done: Optimized, source: Source) -> Optimized:
    """The same, its worst cells having the names by which a file of the result calls them."""
    result = done.result
    return replace(
        done, result=replace(result, after=naming_cells(result.after, source, result.mesh))
    )


def report_on_run(
    done: Optimized,
    source: Source,
    written: Written | None,
    seconds: dict[str, float],
    with_pictures: bool = False,
) -> Report:
    """What is to be said of an optimization.

    Parameters
    ----------
    seconds : dict of str to float
        How long each part of it took.
    with_pictures : bool
        Draw the mesh before and after, where there is what draws it.
    """
    report = report_of(source, done.result, seconds, written)
    if with_pictures:
        from .illustrate import illustrated  # seldom needed

        report = illustrated(report, [done.before, done.result.mesh])
    return report


def place_of(input: Path, output: Path | None, in_place: bool) -> Path:
    """Where the result goes.

    Raises
    ------
    ConfigError
        The output is missing, or is the input without `in_place`.
    """
    if output is None:
        if input == PIPE:
            raise ConfigError("OUTPUT is missing: - is stdout")
        if not in_place:
            raise ConfigError("OUTPUT is missing (with --in-place it may be)")
        return input
    if PIPE in (input, output):
        return output
    same = os.path.exists(output) and os.path.exists(input) and os.path.samefile(input, output)
    if same and not in_place:
        raise ConfigError(f"{output} is the input itself: add --in-place to replace it")
    return output
