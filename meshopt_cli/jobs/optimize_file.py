"""One optimization from file to file, without a word to the terminal."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from .. import formats
from ..boundary.policy import Fixed, Policy, Split
from ..constraints.grammar import keep_offs
from ..errors import EXIT_BAD_MESH, BadMeshError, ConfigError, UnsupportedMeshError, naming
from ..files.places import require_writable
from ..formats import PIPE, Written
from ..formats.medit_sol import is_sol
from ..mesh.any_cells import is_of_any_cells
from ..mesh.model import Mesh
from ..passes import PASSES, Observer
from ..plans.config import Plan, Request, plan_of, settle
from ..plans.sources import Settled
from ..report.model import Report
from ..report.verdict import Verdict
from ..validity import meant
from ..work.kinds import CELLS, FACES, SIMPLICES
from .admission import InvalidMeshError, require_known_cells
from .findings import verdict_on
from .optimize import Result, optimize
from .quality_arrays import with_quality, without_quality
from .regions import with_asked_regions
from .report import naming_cells, report_of

if TYPE_CHECKING:  # seldom met
    from .metric import Asked

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
    metric : Asked, optional
        The metric that drives the work.
    metric_out : str, optional
        Where the metric at the points of the result goes: a file called `.sol` or `.solb`, or else
        an array of the output by this name.
    with_pictures : bool
        Draw the mesh before and after, where there is what draws it.
    keep_off : tuple of str
        What vertices keep off, as `constraints.grammar` has it.
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
    keep_off: tuple[str, ...] = ()
    metric: Asked | None = None
    metric_out: str | None = None
    with_pictures: bool = False

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


def _require_use(policy: Policy, holds: Settled) -> None:
    """Refuse a boundary that may be split where no pass does so, whatever the mesh.

    Raises
    ------
    ConfigError
    """
    if policy.name == Split.name and not any(PASSES[n].splits_boundary for n in holds.passes()):
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
    holds = settle(task.request, task.metric is not None)
    asked = _plan(holds, task)
    _require_use(task.policy, holds)
    allowed = _allowed(holds, asked.allow)
    off = keep_offs(task.keep_off)
    require_writable(task.output)
    if task.metric_out is not None and task.metric is None:
        raise ConfigError("--metric-out is of no use without --metric or --size")
    if task.metric_path is not None:
        require_writable(task.metric_path)
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
        if task.metric is not None and kind != SIMPLICES:
            raise UnsupportedMeshError(
                f"{task.input}: a metric drives meshes of triangles or of tetrahedra alone; "
                "meshopt report judges any mesh by one"
            )
        plan = _plan(holds, task, mesh.dimension(), kind)
        encoding = formats.encoding_for(task.output, source.encoding, task.file_format, task.binary)
        clock.append(time.perf_counter())
        if prepare is not None:
            prepare(plan.kernels())
        with naming(task.input):
            frozen = None
            if not plan.selection.is_whole:
                from .selection import frozen_in  # seldom needed

                frozen = frozen_in(mesh, plan, task.policy, off)
                if frozen is not None and frozen.is_all:
                    frozen, plan = None, plan.idle()
            work = partial(
                _work_for(kind),
                measure=plan.measure,
                observer=observer,
                with_all_measures=task.all_measures or plan.all_measures,
                with_data=not task.no_data,
                policy=task.policy,
                allowed=allowed,
                keep_offs=off,
                frozen=frozen,
            )
            if task.metric is None:
                result, metric = work(mesh, plan.pipeline), None
            else:
                from .optimize_metric import optimize_in_metric  # seldom needed

                driven = optimize_in_metric(
                    mesh, source, task.metric, plan.pipeline, plan.measure,
                    lambda one, pipeline, of: work(one, pipeline, background_of=of), task.max_size,
                )  # fmt: skip
                result, metric = driven.result, driven.metric
    except InvalidMeshError as error:
        verdict = verdict_on(task.input, source, error.mesh, error.report, EXIT_BAD_MESH)
        raise InvalidFileError(str(error), verdict) from error
    clock.append(time.perf_counter())
    is_bad = task.fail_above is not None and result.after.worst > task.fail_above
    worked = with_quality(result.mesh, plan.measure) if task.write_quality else result.mesh
    if metric is not None and task.metric_out is not None and not is_bad:
        from .metric import with_metric  # seldom needed

        worked = with_metric(worked, metric, task.metric_out, encoding.format)
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
        from .illustrate import illustrated  # seldom needed

        report = illustrated(report, [mesh, result.mesh])
    return FileResult(result, report, written)


def _plan(
    holds: Settled, task: FileTask, dimension: int | None = None, kind: str = SIMPLICES
) -> Plan:
    plan = plan_of(holds, dimension, kind)
    for step in plan.pipeline.passes():
        if task.metric is None and step.needs_metric:
            raise ConfigError(f"the pass {step.name} needs a metric: add --metric or --size")
        if task.metric is not None and not step.takes_metric:
            raise ConfigError(f"the pass {step.name} knows no metric: leave one of them out")
    return plan


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


def _allowed(holds: Settled, codes: tuple[str, ...]) -> tuple[str, ...]:
    """The rules that the mesh may break, by their codes.

    Raises
    ------
    ConfigError
        There is no such rule, or no mesh breaks it on purpose.
    """
    try:
        return meant(codes)
    except ConfigError as error:
        origin = holds.origins["allow"]
        where = "" if origin == "--allow" else ": allow"
        raise ConfigError(f"{origin}{where}: {error}") from None


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
