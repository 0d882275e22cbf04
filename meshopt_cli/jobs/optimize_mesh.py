"""One optimization of a mesh that was read, or is in memory: what is asked for, done to it."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from ..boundary.policy import POLICIES, Fixed, Policy, Slide, Split
from ..constraints.grammar import KeepOff, keep_offs
from ..errors import EXIT_BAD_MESH, BadMeshError, ConfigError, UnsupportedMeshError, chosen, naming
from ..mesh.any_cells import is_of_any_cells
from ..mesh.model import Array, Mesh
from ..passes import PASSES
from ..plans.config import Plan, Request, plan_of, settle
from ..plans.sources import Settled
from ..progress.observer import SILENT, Observer
from ..reports.verdict import Verdict
from ..validity import meant
from ..work.kinds import CELLS, FACES, SIMPLICES
from .admission import InvalidMeshError, require_known_cells
from .findings import verdict_on
from .optimize import Result, optimize
from .quality_arrays import without_quality
from .regions import with_asked_regions
from .report import naming_cells

if TYPE_CHECKING:  # seldom met
    from ..formats import Source
    from ..metric.field import Metric
    from .metric import Asked

log = logging.getLogger("meshopt")

Prepare = Callable[[Iterable[str]], None]


class InvalidFileError(BadMeshError):
    """The mesh breaks a rule of severity error; `verdict` says which and where."""

    def __init__(self, message: str, verdict: Verdict) -> None:
        super().__init__(message)
        self.verdict = verdict


@dataclass(frozen=True)
class Task:
    """What to make of a mesh, and how.

    Attributes
    ----------
    request : Request
        The pipeline and the measure.
    policy : Policy
        What of the boundary stays.
    regions : tuple of str
        Arrays that make regions; all tags where there are none.
    no_data : bool
        Drop all arrays but tags.
    write_quality : bool
        The arrays of `quality_arrays` are made anew for the result.
    all_measures : bool
        Tell the worst Q by every measure, and the angles that the boundary forces; so do
        pipelines that are for them.
    keep_off : tuple of str
        What vertices keep off, as `constraints.grammar` has it.
    metric : Asked, optional
        The metric that drives the work.
    max_size : int, optional
        The most bytes that files may have which are read: see `formats.read`.
    """

    request: Request = field(default_factory=Request)
    policy: Policy = field(default_factory=Fixed)
    regions: tuple[str, ...] = ()
    no_data: bool = False
    write_quality: bool = False
    all_measures: bool = False
    keep_off: tuple[str, ...] = ()
    metric: Asked | None = None
    max_size: int | None = None


def task_of(boundary: str, slide_tolerance: float, **options: Any) -> Task:
    """The task of options that have the names they have on the command line.

    Parameters
    ----------
    boundary : str
        A key of `POLICIES`.
    slide_tolerance : float
        Of `Slide`.
    options
        Fields of `Request` and of `Task`.

    Raises
    ------
    ConfigError
        There is no such boundary.
    """
    policy = chosen(POLICIES, boundary, "boundary")
    of_request = {f.name: options.pop(f.name) for f in fields(Request) if f.name in options}
    made = policy(slide_tolerance) if policy is Slide else policy()
    return Task(Request(**of_request), made, **options)


@dataclass(frozen=True)
class Accepted:
    """A task in which nothing is wrong that can be known without a mesh.

    Attributes
    ----------
    holds : Settled
        What the request and the files of the project say together.
    plan : Plan
        For a mesh of tetrahedra.
    allowed : tuple of str
        Codes of the rules that the mesh may break.
    """

    task: Task
    holds: Settled
    plan: Plan
    allowed: tuple[str, ...]
    keep_offs: tuple[KeepOff, ...]


@dataclass(frozen=True)
class Optimized:
    """A mesh that was optimized.

    Attributes
    ----------
    result : Result
        The worst cells of its `before` have the names that the source has for them.
    before : Mesh
        The mesh that was given, as it was taken.
    plan : Plan
    metric : Metric, optional
        What drove the work, at the points of the result.
    """

    result: Result
    before: Mesh
    plan: Plan
    metric: Metric | None


def accepted(task: Task) -> Accepted:
    """Look for what is wrong with a task before a mesh is read.

    Raises
    ------
    ConfigError
    """
    holds = settle(task.request, task.metric is not None)
    plan = _plan(holds, task)
    _require_use(task.policy, holds)
    return Accepted(task, holds, plan, _allowed(holds, plan.allow), keep_offs(task.keep_off))


def optimize_mesh(
    given: Accepted,
    mesh: Mesh,
    source: Source,
    observer: Observer = SILENT,
    prepare: Prepare | None = None,
    stays: Sequence[Array] | None = None,
) -> Optimized:
    """Optimize a mesh; it is left as it is.

    Parameters
    ----------
    source : Source
        Where it comes from: errors name it.
    prepare : function of groups of kernels, optional
        Called with those that the run needs, before it starts; else they compile as they are
        called.
    stays : sequence of (n,) bool, optional
        Which cells stay as they are, by blocks of the greatest dimension, where the task selects
        none itself.

    Raises
    ------
    ConfigError
        Something of the task does not fit the mesh.
    InvalidFileError
        The mesh is not valid.
    BadMeshError, UnsupportedMeshError, InvariantError
        See `optimize.optimize`.
    """
    task = given.task
    mesh, stale = without_quality(mesh)
    if stale and not task.write_quality:
        log.warning(
            "%s: %s told of the mesh as it was: dropped; --write-quality makes it anew",
            source.path, ", ".join(stale),
        )  # fmt: skip
    try:
        with naming(source.path):
            require_known_cells(mesh)
            mesh = with_asked_regions(source.path, mesh, task.regions)
        kind = kind_of(mesh)
        if task.metric is not None and kind != SIMPLICES:
            raise UnsupportedMeshError(
                f"{source.path}: a metric drives meshes of triangles or of tetrahedra alone; "
                "meshopt report judges any mesh by one"
            )
        plan = _plan(given.holds, task, mesh.dimension(), kind)
        if prepare is not None:
            prepare(plan.kernels())
        with naming(source.path):
            frozen = None
            if stays is not None or not plan.selection.is_whole:
                from .selection import Frozen, frozen_in  # seldom needed

                frozen = (
                    frozen_in(mesh, plan, task.policy, given.keep_offs)
                    if stays is None
                    else Frozen(tuple(stays))
                )
                if frozen is not None and frozen.is_all:
                    frozen, plan = None, plan.idle()
            work = partial(
                _work_for(kind),
                measure=plan.measure,
                observer=observer,
                with_all_measures=task.all_measures or plan.all_measures,
                with_data=not task.no_data,
                policy=task.policy,
                allowed=given.allowed,
                keep_offs=given.keep_offs,
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
        verdict = verdict_on(source.path, source, error.mesh, error.report, EXIT_BAD_MESH)
        raise InvalidFileError(str(error), verdict) from error
    if not task.write_quality:
        result = replace(result, lost=(*(f"the array {name}" for name in stale), *result.lost))
    if not plan.pipeline.repairs:  # else there may be other cells than in the source
        result = replace(result, before=naming_cells(result.before, source, mesh))
    return Optimized(result, mesh, plan, metric)


def kind_of(mesh: Mesh) -> str:
    """The kind of working mesh that a mesh is worked on as."""
    if not is_of_any_cells(mesh):
        return SIMPLICES
    return FACES if mesh.dimension() == 2 else CELLS


def _require_use(policy: Policy, holds: Settled) -> None:
    """Refuse a boundary that may be split where no pass does so, whatever the mesh.

    Raises
    ------
    ConfigError
    """
    if policy.name == Split.name and not any(PASSES[n].splits_boundary for n in holds.passes()):
        able = ", ".join(name for name, step in PASSES.items() if step.splits_boundary)
        raise ConfigError(f"--boundary split: no pass here splits edges; add one that does: {able}")


def _plan(holds: Settled, task: Task, dimension: int | None = None, kind: str = SIMPLICES) -> Plan:
    plan = plan_of(holds, dimension, kind)
    for step in plan.pipeline.passes():
        if task.metric is None and step.needs_metric:
            raise ConfigError(f"the pass {step.name} needs a metric: add --metric or --size")
        if task.metric is not None and not step.takes_metric:
            raise ConfigError(f"the pass {step.name} knows no metric: leave one of them out")
    return plan


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
