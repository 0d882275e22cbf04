"""One optimization from mesh to mesh: prepare, improve, restore, prove."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .. import validity
from ..boundary.policy import Boundary, Fixed, Policy, Slide, Split
from ..constraints.grammar import KeepOff
from ..errors import ConfigError, InvariantError
from ..kernels.types import MAPPED
from ..mesh.cast import Simplices, cast, with_simplices
from ..mesh.model import Mesh, main_blocks, main_type
from ..mesh.second_order import SecondOrder, is_second_order, separated
from ..mesh.tags import Regions, regions_in, tags_of
from ..passes import Tally
from ..plans.improve import Worked, improve
from ..plans.pipeline import Pipeline
from ..plans.stages import Line
from ..plans.stop import TANGLED
from ..progress.observer import SILENT, Observer, Stage
from ..quality.measures import OF_SIMPLICES, Measure
from ..quality.summary import Summary, summarize
from ..quality.target import forced_angles
from ..transfer.carry import carry_on_cells, carry_on_points, tags_only
from ..work.background import Background
from ..work.standing import Standing
from .admission import (
    CURVED,
    InvalidMeshError,
    admit,
    errors_in,
    require_known_cells,
    require_range,
)
from .curved import require_plane, to_be_kept, warn_of_curved
from .regions import doubt_regions
from .told import constraints_on, found_stray, prove_told, staying, warn_of_new

if TYPE_CHECKING:  # seldom met
    from ..metric.summary import MetricSummary
    from .selection import Frozen

log = logging.getLogger("meshopt")

# The worst Q may rise by rounding only: this part of it, where a mesh is put back into its file.
ROUNDING = 1e-6

# Rules that cells break which meet without sharing what they meet in.
MEETING = {"M202", "M205"}

BackgroundOf = Callable[[Simplices, Mesh, np.ndarray], Background]


@dataclass(frozen=True)
class Prepared:
    """A mesh that is ready to be worked on.

    Attributes
    ----------
    whole : Mesh
        As it was read, its tetrahedra turned where they had to be.
    source : Mesh
        The same without the cells that stay.
    mesh : Mesh
        This, by its corners where it is of second order.
    second : SecondOrder or None
        How to put its middle nodes back.
    part : Simplices
        What of it is worked on.
    boundary : Boundary
        What of the boundary stays.
    before : Summary
    tangle : Report or None
        What is wrong with the mesh, and to be mended.
    regions : Regions
        What makes regions of its cells.
    allowed : tuple of str
        Codes of the rules that the mesh may break, and the result too.
    mends : tuple of Line
        What was mended of it before.
    """

    whole: Mesh
    source: Mesh
    mesh: Mesh
    second: SecondOrder | None
    part: Simplices
    boundary: Boundary
    before: Summary
    tangle: validity.Report | None
    regions: Regions
    allowed: tuple[str, ...] = ()
    mends: tuple[Line, ...] = ()

    @property
    def numbers(self) -> np.ndarray:
        """The point of `source` that each point of `part` is."""
        return np.arange(len(self.part.points)) if self.second is None else self.second.points


@dataclass(frozen=True)
class Restored:
    """A mesh after the work.

    Attributes
    ----------
    mesh : Mesh
        As it is to be written.
    by_corners : Mesh
        The same, as `Prepared.mesh` is.
    origin : (np',) int64
        The point of the input that each point of `mesh` was, -1 for a new one.
    lost : tuple of str
        What did not go along.
    """

    mesh: Mesh
    by_corners: Mesh
    origin: np.ndarray
    lost: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """An optimized mesh and how it came about.

    `lost` is what of the input did not go along; `left_out` names the passes that are for other
    cells; `in_metric` is what a metric makes of the mesh before and after.
    """

    mesh: Mesh
    measure: Measure
    before: Summary
    after: Summary
    lines: tuple[Line, ...]
    stopped: str
    seconds: float
    regions: Regions
    lost: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    in_metric: tuple[MetricSummary, MetricSummary] | None = None


def optimize(
    mesh: Mesh,
    pipeline: Pipeline,
    measure: Measure,
    observer: Observer = SILENT,
    with_all_measures: bool = False,
    with_data: bool = True,
    policy: Policy = Fixed(),  # noqa: B008 (a frozen value)
    allowed: tuple[str, ...] = (),
    background_of: BackgroundOf | None = None,
    keep_offs: tuple[KeepOff, ...] = (),
    frozen: Frozen | None = None,
) -> Result:
    """Optimize a mesh; the input is left as it is.

    Parameters
    ----------
    with_all_measures : bool
        Whether the summaries tell the worst Q by every measure, and the angles that the boundary
        forces, which takes a while.
    with_data : bool
        Whether the arrays of the mesh go along; its tags do in any case.
    policy : Policy
        What of the boundary stays.
    allowed : tuple of str
        Codes of the rules that the mesh may break on purpose: see `validity.meant`.
    background_of : function, optional
        Makes the metric that drives the work of what is worked on, the mesh that this was taken
        from, and the numbers, (np,), that its points have there.
    keep_offs : tuple of KeepOff
        What the vertices of the mesh keep off; new ones do not.
    frozen : Frozen, optional
        Cells that stay as they are.

    Raises
    ------
    InvalidMeshError
        The mesh is not valid.
    BadMeshError, UnsupportedMeshError
        It has no triangles in a plane, nor tetrahedra, or other cells besides.
    InvariantError
        The result is not what it must be: a bug, and nothing to be used.
    """
    start = time.perf_counter()
    others = tuple(OF_SIMPLICES.values()) if with_all_measures else ()
    observer.entered(Stage.CHECK)
    if isinstance(policy, Slide) and background_of is not None and pipeline.needs_metric:
        policy = replace(policy, resamples=True)
    prepared = prepare(mesh, pipeline, measure, policy, others, allowed, frozen)
    before, kept, near = prepared.before, None, None
    judge, target = measure.judge, before.target
    while True:
        told = constraints_on(prepared.mesh, prepared.part, keep_offs, near)
        if told is not None and background_of is not None:
            raise ConfigError("vertices that are told where to stay know no metric: leave one out")
        background = background_of and background_of(
            prepared.part, prepared.source, prepared.numbers
        )
        if background and not background.is_isotropic:  # sizes alone change no shape
            judge, target = judge._replace(form=MAPPED), 1.0
        observer.entered(Stage.WORK)
        worked = improve(
            prepared.part, pipeline if told is None else pipeline.confined(), judge, target,
            prepared.boundary.patches, prepared.boundary.splittable, observer,
            background=background, constraints=told,
        )  # fmt: skip
        observer.entered(Stage.PROVE)
        restored = restore(prepared, worked, with_data)
        corners = restored.by_corners
        stray = found_stray(prepared.mesh, corners, worked.origin, keep_offs, near)
        if stray is not None:
            near = stray
            continue
        if prepared.second is None:
            break
        kept = to_be_kept(
            prepared.second, restored.mesh, restored.origin, kept, prepared.tangle
        )  # fmt: skip
        if kept is None:
            break
        prepared, near = _keeping(prepared, policy, kept), None
    warn_of_new(prepared.mesh, corners, worked.origin, keep_offs)
    stays = staying(prepared.part, prepared.boundary.patches)
    prove_told(told, prepared.part, worked.part.points, worked.origin, stays)
    after = prove(prepared, worked, restored.by_corners, measure, others, background_of is not None)
    result, part = restored.mesh, prepared.part
    if frozen is not None:  # which are told of, too
        result = frozen.put_back(prepared.whole, result, restored.origin)
        part = cast(prepared.whole)
        before, after = (summarize(one, measure, others) for one in (part, cast(result)))
    if with_all_measures:
        forced = forced_angles(part)
        before, after = replace(before, forced=forced), replace(after, forced=forced)
    if background_of is not None:  # what the boundary allows is told without a metric
        before, after = replace(before, room=None), replace(after, room=None)
    seconds = time.perf_counter() - start
    return Result(
        result,
        measure,
        before,
        after,
        prepared.mends + worked.lines,
        worked.stopped,
        seconds,
        prepared.regions,
        restored.lost,
    )


def prepare(
    mesh: Mesh,
    pipeline: Pipeline,
    measure: Measure,
    policy: Policy,
    others: tuple[Measure, ...] = (),
    allowed: tuple[str, ...] = (),
    frozen: Frozen | None = None,
) -> Prepared:
    """Mend a mesh as the pipeline says, admit it, and take from it what is worked on.

    Parameters
    ----------
    others : tuple of Measure
        Measures whose worst Q is wanted as well.
    allowed : tuple of str
        Codes of the rules that the mesh may break. What meets without being shared stays as it is.
    frozen : Frozen, optional
        Cells that are left out, whose vertices stay.

    Raises
    ------
    InvalidMeshError, BadMeshError, UnsupportedMeshError
        See `optimize`.
    """
    tallies: list[Tally] = []
    if pipeline.repairs:
        from .mending import mended  # few runs need it

        mesh, tallies = mended(mesh, pipeline.repairs)
    require_known_cells(mesh)
    require_range(mesh)
    whole, tangle = admit(mesh, pipeline.mends_tangles and frozen is None, allowed)
    source = whole
    if frozen is not None:
        frozen.require_same(mesh, whole)
        source = frozen.left_out_of(replace(source, regions=regions_in(source).arrays))
    second = separated(source) if is_second_order(source) else None
    if second is not None and policy.name == Split.name:
        raise ConfigError("--boundary split is for cells of first order: leave it out here")
    mesh = source if second is None else second.linear
    part = _part_of(source, second, allowed)
    if frozen is not None:
        part = part.holding(frozen.vertices(whole))
    if second is not None:
        require_plane(second, part)
        warn_of_curved(second)
    tags = tuple(tags_of(main_blocks(mesh, main_type(mesh)), mesh.regions))
    regions = Regions(tags, int(part.region.max()) + 1)
    if regions.count > 1:
        doubt_regions(part, regions)
    before = summarize(part, measure, others)
    boundary = policy.bound_to(mesh, part)
    standing = Standing(1.0 / before.worst, before.mean, before.mean)
    mends = tuple(Line(0, tally, standing) for tally in tallies)
    return Prepared(
        whole, source, mesh, second, part, boundary, before, tangle, regions, allowed, mends
    )  # fmt: skip


def _part_of(source: Mesh, second: SecondOrder | None, allowed: tuple[str, ...]) -> Simplices:
    """What of a mesh is worked on: its corners, if it is of second order."""
    part = cast(source if second is None else second.linear)
    if MEETING.isdisjoint(allowed):
        return part
    apart = validity.vertices_apart(source)
    return part.holding(apart if second is None else np.flatnonzero(np.isin(second.points, apart)))


def _keeping(prepared: Prepared, policy: Policy, kept: np.ndarray) -> Prepared:
    """The same mesh of second order, of which some cells, (ne,) bool, must not change."""
    second = separated(prepared.source, kept)
    part = _part_of(prepared.source, second, prepared.allowed)
    boundary = policy.bound_to(second.linear, part)
    return replace(prepared, mesh=second.linear, second=second, part=part, boundary=boundary)


def restore(prepared: Prepared, worked: Worked, with_data: bool = True) -> Restored:
    """Put what was worked on back among all the rest of a mesh.

    Raises
    ------
    InvalidMeshError
        A tangle was not mended.
    """
    source, mesh, part = prepared.source, prepared.mesh, prepared.part
    tangle, second = prepared.tangle, prepared.second
    if tangle is None and worked.is_untouched:
        if not with_data:
            source, mesh = (tags_only(one, prepared.regions.arrays) for one in (source, mesh))
        return Restored(source.numbered_anew(), mesh, np.arange(len(source.points)))
    if tangle and worked.stopped == TANGLED:
        raise InvalidMeshError("it could not be untangled: nothing written", source, tangle)
    result = with_simplices(mesh, worked.part, worked.origin, part)
    result = prepared.boundary.restore(result, worked.part, worked.origin)
    by_corners = tangle is not None and errors_in(tangle) - CURVED
    if tangle and by_corners and not validity.check(result, ignore=prepared.allowed).is_valid:
        raise InvalidMeshError("untangling leaves it invalid: nothing written", source, tangle)
    if not with_data:
        tags = prepared.regions.arrays
        source, mesh, result = (tags_only(one, tags) for one in (source, mesh, result))
    corners, dropped = carry_on_cells(mesh, result, part, worked.origin)
    if second is None:
        result, origin = corners, worked.origin
        result, more = carry_on_points(source, result, part, origin)
    else:
        result, origin = second.restored(corners, worked.origin)
        result, more = carry_on_points(source, result, part, origin, second.interpolation)
    lost = sorted({*dropped, *more})
    if lost:
        log.warning("arrays that do not follow the cells are dropped: %s", ", ".join(lost))
    return Restored(result, corners, origin, tuple(f"the array {name}" for name in lost))


def prove(
    prepared: Prepared,
    worked: Worked,
    result: Mesh,
    measure: Measure,
    others: tuple[Measure, ...] = (),
    in_metric: bool = False,
) -> Summary:
    """Compare a result with its input; returns its summary.

    Parameters
    ----------
    in_metric : bool
        Whether it was driven by a metric, so that its Q without one may be anything.

    Raises
    ------
    InvariantError
        It is worse, or its boundary or the volume of a region changed.
    """
    before = prepared.before
    # An array that numbers cells may have few values left, and would pass for a tag.
    final = cast(replace(result, regions=prepared.regions.arrays))
    part = worked.part
    if len(prepared.part.idle):  # cells may have come to lie at these lines and faces
        number = np.full(len(prepared.part.points), -1)
        number[worked.origin[worked.origin >= 0]] = np.flatnonzero(worked.origin >= 0)
        idle = number[prepared.part.idle]
        final, part = final.without_facets(idle), part.without_facets(idle)
    target = before.target if prepared.boundary.keeps_facets else None
    after = summarize(final, measure, others, target)
    limit = math.inf if in_metric else before.worst * (1 + ROUNDING)
    if after.n_invalid or after.worst > limit:
        raise InvariantError(f"the worst Q rose from {before.worst} to {after.worst}")
    prepared.boundary.prove(result, final, part, worked.origin)
    return after
