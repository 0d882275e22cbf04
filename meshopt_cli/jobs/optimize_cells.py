"""One optimization of a mesh of any cells: what does not change stays as it was read."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from .. import validity
from ..boundary.policy import Fixed, Policy
from ..cells import FAMILIES, SIMPLICES
from ..constraints.grammar import KeepOff
from ..constraints.model import Constraints
from ..errors import InvariantError, UnsupportedMeshError
from ..mesh.any_cells import AnyCells, cast_any, points_left, with_cells
from ..mesh.cast import Simplices
from ..mesh.model import Block, Mesh
from ..mesh.tags import regions_in
from ..passes import Tally
from ..plans.pipeline import Pipeline
from ..plans.stages import Line, Outcome
from ..plans.stop import NOTHING_TO_GAIN, TANGLED
from ..progress.observer import SILENT, Observer, Stage
from ..quality.families import summarize_mesh
from ..quality.measurable import measurable
from ..quality.measures import OF_SIMPLICES, Measure
from ..quality.summary import Summary
from ..repairs import repair
from ..transfer.carry import carry_on_points, tags_only
from ..work.cells import CellWork
from ..work.face_work import work_on
from ..work.standing import Standing
from .admission import (
    CURVED,
    OVERLAPPING,
    TURNED,
    InvalidMeshError,
    errors_in,
    not_valid,
    require_range,
)
from .mending import mended
from .optimize import MEETING, ROUNDING, Result
from .told import constraints_on, in_work, prove_told

if TYPE_CHECKING:  # seldom met
    from .selection import Frozen

log = logging.getLogger("meshopt")

# Rules that a tangle of cells breaks, which moving vertices mends.
TANGLE = {"M101", "M102", "M104", "M105", "M209", "M210"}
# Rules that cells break which are listed the other way round.
TURNED_CELLS = {"M101", "M103", "M104", "M207"}
# How often cells that came to be curved the wrong way inside are held, and the rest done anew.
MOST_TRIES = 5


@dataclass(frozen=True)
class Admitted:
    """A mesh to be worked on.

    Attributes
    ----------
    mesh : Mesh
        With its cells turned where they ran the other way round.
    tangle : Report or None
        What is wrong with it, and to be mended by moving vertices.
    curved : set of (int, int)
        Block and row of the cells whose Jacobian is not positive inside, though their corners are:
        the boundary may leave them no choice.
    """

    mesh: Mesh
    tangle: validity.Report | None
    curved: frozenset[tuple[int, int]]


def optimize_cells(
    mesh: Mesh,
    pipeline: Pipeline,
    measure: Measure,
    observer: Observer = SILENT,
    with_all_measures: bool = False,
    with_data: bool = True,
    policy: Policy = Fixed(),  # noqa: B008 (a frozen value)
    allowed: tuple[str, ...] = (),
    keep_offs: tuple[KeepOff, ...] = (),
    frozen: Frozen | None = None,
) -> Result:
    """Optimize a mesh of quads, pyramids, wedges or hexahedra, alone or among simplices.

    Parameters and errors are those of `optimize.optimize`; besides:

    Raises
    ------
    ConfigError
        The measure cannot steer such cells.
    UnsupportedMeshError
        Vertices of the boundary are to move.
    """
    start = time.perf_counter()
    if not isinstance(policy, Fixed):
        raise UnsupportedMeshError(
            f"--boundary {policy.name} is for meshes of triangles or tetrahedra alone"
        )
    observer.entered(Stage.CHECK)
    tallies: list[Tally] = []
    if pipeline.repairs:
        mesh, tallies = mended(mesh, pipeline.repairs)
    require_range(mesh)
    admitted = _admitted(mesh, pipeline, allowed)
    whole, with_rest = admitted.mesh, _as_it_is
    if frozen is not None:
        frozen.require_same(mesh, whole)
        with_rest = partial(frozen.put_back, whole)
        admitted = _without(frozen, admitted, allowed)
    mesh = admitted.mesh
    part = cast_any(mesh)
    if frozen is not None:
        part.fixed[frozen.vertices(whole)] = True
    if not MEETING.isdisjoint(allowed):
        part.fixed[validity.vertices_apart(mesh)] = True
    pipeline.require_measures(measure, part.families)
    others = tuple(OF_SIMPLICES.values()) if with_all_measures else ()
    before = _summary(whole, measure, others)
    everywhere = np.ones(len(part.points), dtype=bool)
    told = constraints_on(mesh, part, keep_offs, everywhere)
    if told is not None:
        pipeline = pipeline.confined()
    result, worked, outcome = _improved(
        admitted, part, pipeline, measure, observer, allowed, told, with_rest
    )  # fmt: skip
    prove_told(told, part, in_work(part, result.points), np.arange(len(part.points)), part.fixed)
    lost: tuple[str, ...] = ()
    if not with_data:
        result = tags_only(result, regions_in(mesh).arrays)
    elif result is not mesh and admitted.tangle is None:
        result, lost = _carried(mesh, part, result, worked)
    result = with_rest(result, points_left(part, worked))
    after = _summary(result, measure, others)
    _prove(before, after, admitted.tangle)
    standing = Standing(1.0 / before.worst, before.mean, before.mean)
    lines = (*(Line(0, tally, standing) for tally in tallies), *outcome.lines)
    return Result(
        result, measure, before, after, lines, outcome.stopped, time.perf_counter() - start,
        regions_in(whole), lost, tuple(outcome.left_out),
    )  # fmt: skip


def _admitted(mesh: Mesh, pipeline: Pipeline, allowed: tuple[str, ...]) -> Admitted:
    """Take a mesh to be worked on.

    Raises
    ------
    InvalidMeshError
        Something is wrong that neither turning cells nor moving vertices mends.
    """
    report = validity.check(mesh, ignore=allowed)
    if errors_in(report) & TURNED_CELLS:
        done = repair(mesh, ["orientation"])
        again = validity.check(done.mesh, ignore=allowed)
        if _is_curved_at_most(again):
            log.warning(TURNED, sum(done.counts.values()))
            mesh, report = done.mesh, again
    if _is_curved_at_most(report):
        return Admitted(mesh, None, _named(report))
    if not errors_in(report) <= TANGLE or not pipeline.mends_tangles:
        raise InvalidMeshError(not_valid(report, allowed), mesh, report)
    log.warning("the mesh has inverted or flat cells: they are to be untangled")
    return Admitted(mesh, report, _named(report))


def _as_it_is(result: Mesh, origin: np.ndarray) -> Mesh:
    return result


def _without(frozen: Frozen, admitted: Admitted, allowed: tuple[str, ...]) -> Admitted:
    """The mesh without cells that stay, and what is curved of both where they are put back."""
    whole = admitted.mesh
    rest = frozen.left_out_of(replace(whole, regions=regions_in(whole).arrays))
    curved = admitted.curved
    if curved:
        again = frozen.put_back(whole, rest, np.arange(len(whole.points)))
        curved = _named(validity.check(again, ignore=allowed))
    return replace(admitted, mesh=rest, curved=curved)


def _is_curved_at_most(report: validity.Report) -> bool:
    """Whether nothing is wrong but inside cells, which may reach into others there."""
    broken = errors_in(report)
    return not broken or (broken <= CURVED | OVERLAPPING and bool(broken & CURVED))


def _named(report: validity.Report) -> frozenset[tuple[int, int]]:
    """Block and row of the cells that errors name."""
    found: set[tuple[int, int]] = set()
    for group in report.errors:
        if group.places.cells is not None:
            found |= {(block, row) for block, row in group.places.cells.tolist()}
    return frozenset(found)


def _improved(
    admitted: Admitted,
    part: AnyCells,
    pipeline: Pipeline,
    measure: Measure,
    observer: Observer,
    allowed: tuple[str, ...],
    told: Constraints | None,
    with_rest: Callable[[Mesh, np.ndarray], Mesh],
) -> tuple[Mesh, AnyCells, Outcome]:
    """The mesh after the work, and the same as it was worked on.

    What comes to be wrong inside cells is held where it was: positive corners do not make a
    Jacobian that is positive everywhere.

    Parameters
    ----------
    with_rest : function of a mesh and the points of the input that its own were
        Puts the cells back that stay.

    Raises
    ------
    InvalidMeshError
        A tangle was not mended.
    """
    mesh, tangle, held = admitted.mesh, admitted.tangle, part
    for _ in range(MOST_TRIES):
        observer.entered(Stage.WORK)
        outcome = pipeline.run(work_on(held, measure.judge, told), observer)
        if outcome.stopped == TANGLED:
            assert tangle is not None
            raise InvalidMeshError("it could not be untangled: nothing written", mesh, tangle)
        assert isinstance(outcome.work, CellWork)
        observer.entered(Stage.PROVE)
        worked = outcome.work.result()
        result, origin = with_cells(mesh, part, worked), points_left(part, worked)
        whole = with_rest(result, origin)
        report = validity.check(whole, ignore=allowed)
        wrong = _named(report) - admitted.curved
        if _is_curved_at_most(report) and not wrong:
            if not report.is_valid:
                log.warning(
                    "what is wrong with %d cells stays, as it came (%s)",
                    len(_named(report)), ", ".join(sorted(errors_in(report))),
                )  # fmt: skip
            return result, worked, outcome
        if tangle is not None:
            raise InvalidMeshError("untangling leaves it invalid: nothing written", mesh, tangle)
        fixed = held.fixed.copy()
        for block, row in wrong:
            fixed[origin[whole.blocks[block].cells[row]]] = True
        held = replace(held, fixed=fixed)
    outcome.stopped = NOTHING_TO_GAIN
    return mesh, part, outcome


def _carried(
    mesh: Mesh, part: AnyCells, result: Mesh, worked: AnyCells
) -> tuple[Mesh, tuple[str, ...]]:
    """The result with the arrays on points, which are those of the places that they come to."""
    if not mesh.point_data:
        return result, ()
    origin = points_left(part, worked)
    new_number = np.full(len(mesh.points), -1)
    new_number[origin] = np.arange(len(origin))
    divided, after = _divided(part), new_number[_divided(worked)]
    d = part.dimension
    before = Simplices(
        part.points, np.ascontiguousarray(divided), region=np.zeros(len(divided), np.int64),
        fixed=part.fixed, facets=np.empty((0, d), np.int64), edges=np.empty((0, 2), np.int64),
        frame=part.frame, single=part.single, turned=False,
    )  # fmt: skip
    flat = _in_part(mesh, part, divided), _in_part(result, part, after)
    carried, dropped = carry_on_points(*flat, before, origin)
    if dropped:
        log.warning("arrays that do not follow the points are dropped: %s", ", ".join(dropped))
    lost = tuple(f"the array {name}" for name in dropped)
    return replace(result, point_data=carried.point_data), lost


def _divided(part: AnyCells) -> np.ndarray:
    """The simplices that cells are divided into."""
    return np.concatenate(
        [group.cells[:, simplex] for group in part.cell_sets
         for simplex in FAMILIES[group.family].partitions[0]]
    )  # fmt: skip


def _in_part(mesh: Mesh, part: AnyCells, divided: np.ndarray) -> Mesh:
    """A mesh of the simplices that its cells are divided into, for the transfer of arrays."""
    return replace(mesh, blocks=[Block(SIMPLICES[part.dimension], divided)])


def _summary(mesh: Mesh, measure: Measure, others: tuple[Measure, ...]) -> Summary:
    return summarize_mesh(mesh, measurable(mesh), measure, others)


def _prove(before: Summary, after: Summary, tangle: validity.Report | None) -> None:
    """Compare a result with its input.

    Raises
    ------
    InvariantError
        It is worse: a bug.
    """
    if after.n_invalid or (tangle is None and after.worst > before.worst * (1 + ROUNDING)):
        raise InvariantError(f"the worst Q rose from {before.worst} to {after.worst}")
