"""One optimization from file to file, without a word to the terminal."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from .. import formats
from ..boundary.policy import Fixed, Policy, Split
from ..errors import EXIT_BAD_MESH, BadMeshError, ConfigError, naming
from ..files.places import require_writable
from ..formats import PIPE, Written
from ..mesh.any_cells import is_of_any_cells
from ..mesh.model import Mesh
from ..passes import PASSES, Observer
from ..plans.config import Request, plan_for
from ..plans.pipeline import Pipeline
from ..report.model import Report
from ..report.verdict import Verdict
from ..validity import meant
from ..work.kinds import CELLS, FACES, SIMPLICES
from .admission import InvalidMeshError, require_known_cells
from .findings import verdict_on
from .illustrate import illustrated
from .optimize import Result, optimize
from .quality_arrays import with_quality, without_quality
from .regions import with_asked_regions
from .report import naming_cells, report_of

log = logging.getLogger("meshopt")


class InvalidFileError(BadMeshError):
    """The mesh of the file breaks a rule of severity error; `verdict` says which and where."""

    def __init__(self, message: str, verdict: Verdict) -> None:
        super().__init__(message)
        self.verdict = verdict


@dataclass(frozen=True)
class FileTask:
    """What to optimize, how, and where the result goes.

    Attributes
    ----------
    input, output : Path
        `formats.PIPE` stands for stdin and stdout; see `place_of`.
    request : Request
        The pipeline and the measure.
    policy : Policy
        What of the boundary stays.
    fail_above : float, optional
        Write nothing where a cell stays worse than this Q.
    input_format, file_format : str, optional
        Keys of `FORMATS`, whatever the names of the files say.
    max_size : int, optional
        The most bytes that the input may have: see `formats.read`.
    binary : bool, optional
        Write text or binary; as the input was where it is left out.
    regions : tuple of str
        Arrays that make regions; all tags where there are none.
    no_data : bool
        Drop all arrays but tags.
    write_quality : bool
        Put the arrays of `quality_arrays` on the cells of the output.
    all_measures : bool
        Tell the worst Q by every measure, and the angles that the boundary forces; so do
        pipelines that are for them.
    with_pictures : bool
        Draw the mesh before and after, where there is what draws it.
    """

    input: Path
    output: Path
    request: Request = field(default_factory=Request)
    policy: Policy = field(default_factory=Fixed)
    fail_above: float | None = None
    input_format: str | None = None
    file_format: str | None = None
    max_size: int | None = None
    binary: bool | None = None
    regions: tuple[str, ...] = ()
    no_data: bool = False
    write_quality: bool = False
    all_measures: bool = False
    with_pictures: bool = False


@dataclass(frozen=True)
class FileResult:
    """An optimized mesh, what is to be said of it, and its file; None where it was too bad."""

    result: Result
    report: Report
    written: Written | None


def _require_use(policy: Policy, pipeline: Pipeline) -> None:
    """Refuse a boundary that may be split where no pass does so.

    Raises
    ------
    ConfigError
    """
    if policy.name == Split.name and not any(step.splits_boundary for step in pipeline.passes()):
        able = ", ".join(name for name, step in PASSES.items() if step.splits_boundary)
        raise ConfigError(f"--boundary split: no pass here splits edges; add one that does: {able}")


def optimize_file(
    task: FileTask,
    observer: Observer | None = None,
    prepare: Callable[[Iterable[str]], None] | None = None,
) -> FileResult:
    """Read a mesh, optimize it, and write it where it is good enough.

    Parameters
    ----------
    prepare : function of groups of kernels, optional
        Called with those that the run needs, before it starts; else they compile as they are
        called.

    Raises
    ------
    ConfigError
        Something of the task is wrong; most of it is found before the file is read.
    ReadError, WriteError
        A file cannot be read, or written.
    InvalidFileError
        The mesh is not valid.
    BadMeshError, UnsupportedMeshError, InvariantError
        See `optimize`.
    """
    # What is wrong with the request is said before the mesh is read.
    asked = plan_for(task.request)
    _require_use(task.policy, asked.pipeline)
    allowed = _allowed(task.request, asked.allow)
    require_writable(task.output)
    clock = [time.perf_counter()]
    mesh, source = formats.read(task.input, task.input_format, task.max_size)
    mesh, stale = without_quality(mesh)
    if stale and not task.write_quality:
        source = replace(source, lost=(*source.lost, *(f"the array {name}" for name in stale)))
        log.warning(
            "%s: %s told of the mesh as it was: dropped; --write-quality makes it anew",
            task.input, ", ".join(stale),
        )  # fmt: skip
    try:
        with naming(task.input):
            require_known_cells(mesh)
            mesh = with_asked_regions(task.input, mesh, task.regions)
        kind = kind_of(mesh)
        plan = plan_for(task.request, mesh.dimension(), kind)
        encoding = formats.encoding_for(task.output, source.encoding, task.file_format, task.binary)
        clock.append(time.perf_counter())
        if prepare is not None:
            prepare(plan.kernels())
        with naming(task.input):
            result = _work_for(kind)(
                mesh,
                plan.pipeline,
                plan.measure,
                observer,
                task.all_measures or plan.all_measures,
                not task.no_data,
                task.policy,
                allowed,
            )
    except InvalidMeshError as error:
        verdict = verdict_on(task.input, source, error.mesh, error.report, EXIT_BAD_MESH)
        raise InvalidFileError(str(error), verdict) from error
    clock.append(time.perf_counter())
    is_bad = task.fail_above is not None and result.after.worst > task.fail_above
    worked = with_quality(result.mesh, plan.measure) if task.write_quality else result.mesh
    written = None if is_bad else formats.write(task.output, worked, encoding)
    if not plan.pipeline.repairs:  # else there may be other cells than in the file
        result = replace(result, before=naming_cells(result.before, source, mesh))
    if written is not None:
        result = replace(result, after=naming_cells(result.after, written, worked))
    clock.append(time.perf_counter())
    times = (b - a for a, b in pairwise(clock))
    seconds = dict(zip(("read", "optimize", "write"), times, strict=True))
    report = report_of(source, result, seconds, written)
    if task.with_pictures:
        report = illustrated(report, [mesh, result.mesh])
    return FileResult(result, report, written)


def kind_of(mesh: Mesh) -> str:
    """The kind of working mesh that a mesh is worked on as."""
    if not is_of_any_cells(mesh):
        return SIMPLICES
    return FACES if mesh.dimension() == 2 else CELLS


def _work_for(kind: str) -> Callable[..., Result]:
    """What optimizes a kind of mesh."""
    if kind == SIMPLICES:
        return optimize
    from .optimize_cells import optimize_cells  # its kernels take their time to load

    return optimize_cells


def _allowed(request: Request, codes: tuple[str, ...]) -> tuple[str, ...]:
    """The rules that the mesh may break, by their codes.

    Raises
    ------
    ConfigError
        There is no such rule, or no mesh breaks it on purpose.
    """
    try:
        return meant(codes)
    except ConfigError as error:
        source = "--allow" if request.allow is not None else f"{request.config}: allow"
        raise ConfigError(f"{source}: {error}") from None


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
