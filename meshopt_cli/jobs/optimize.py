"""One optimization from mesh to mesh: check, cast, run the pipeline, prove the result."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass, replace

import numpy as np

from .. import validity
from ..boundary.proof import prove, prove_slide, prove_volumes
from ..boundary.sliding import find, redeclared
from ..errors import BadMeshError, InvariantError, UnsupportedMeshError
from ..mesh.cast import cast, with_positive_tets, with_simplices
from ..mesh.model import Mesh, main_blocks, main_type
from ..mesh.tags import tags_of
from ..passes import Observer
from ..plans.pipeline import Line, Pipeline
from ..quality.summary import MEASURES, Measure, Summary, forced_angles, summarize
from ..transfer.carry import carry
from ..work.workspace import Workspace

Array = np.ndarray
log = logging.getLogger("meshopt")

# Extents of a mesh between which the sixth power of a length is a number.
EXTENTS = 1e-40, 1e40

# Rules that turning cells may mend.
ORIENTATION = {"M101", "M103", "M207"}

# Rules that a tangle breaks: cells with a negative volume, and those that they lie across.
TANGLE = {"M101", "M102", "M205", "M207", "M209", "M210"}


class InvalidMeshError(BadMeshError):
    """The mesh breaks a rule of severity error; `report` says which and where."""

    def __init__(self, message: str, mesh: Mesh, report: validity.Report) -> None:
        super().__init__(message)
        self.mesh = mesh
        self.report = report


@dataclass(frozen=True)
class Result:
    """An optimized mesh and how it came about."""

    mesh: Mesh
    measure: Measure
    before: Summary
    after: Summary
    lines: list[Line]
    stopped: str
    seconds: float


def optimize(
    mesh: Mesh,
    pipeline: Pipeline,
    measure: Measure,
    observer: Observer | None = None,
    with_all_measures: bool = False,
    with_data: bool = True,
    slide: float | None = None,
) -> Result:
    """Optimize a mesh; the input is left as it is.

    Parameters
    ----------
    with_all_measures : bool
        Whether the summaries tell the worst Q by every measure, and the angles that the boundary
        forces, which takes a while.
    with_data : bool
        Whether the arrays of the mesh go along; its tags do in any case.
    slide : float, optional
        Let the boundary be worked on where it is plane or straight within this tolerance; without
        it, the boundary stays exactly as it is.

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
    require_simplices(mesh)
    require_range(mesh)
    mesh, tangle = sound(mesh, any(step.name == "untangle" for step in pipeline.passes()))
    source = cast(mesh)
    others = tuple(MEASURES.values()) if with_all_measures else ()
    before = summarize(source, measure, others)
    sliding = None if slide is None else find(mesh, source, slide)
    work = Workspace(source, measure.judge, before.target, slide=sliding)
    outcome = pipeline.run(work, observer)
    if tangle and outcome.work.standing().worst <= 0.0:
        raise InvalidMeshError("it could not be untangled: nothing written", mesh, tangle)
    worked, origin = outcome.work.result()
    lines, stopped = outcome.lines, outcome.stopped
    del work, outcome  # a third of the memory
    result = with_simplices(mesh, worked, origin, source)
    if sliding is not None:
        result, patch = redeclared(mesh, result, sliding, worked, origin)
        prove_slide(source, worked, sliding, patch, origin)
    if tangle and not validity.check(result).is_valid:
        raise InvalidMeshError("untangling leaves it invalid: nothing written", mesh, tangle)
    result, lost = carry(mesh, result, source, origin, with_data)
    if lost:
        log.warning("arrays that do not follow the cells are dropped: %s", ", ".join(lost))
    # An array that numbers cells may have few values left, and would pass for a tag.
    tags = tuple(tags_of(main_blocks(mesh, main_type(mesh)), mesh.regions))
    final = cast(replace(result, regions=tags))
    after = summarize(final, measure, others, before.target if sliding is None else None)
    if after.n_invalid or after.worst > before.worst * (1 + 1e-6):
        raise InvariantError(f"the worst Q rose from {before.worst} to {after.worst}")
    if with_all_measures:
        forced = forced_angles(source)
        before, after = replace(before, forced=forced), replace(after, forced=forced)
    if sliding is None:
        prove(source, final, mesh.points, result.points, origin)
    prove_volumes(source, final, slide or 0.0)
    return Result(result, measure, before, after, lines, stopped, time.perf_counter() - start)


def require_range(mesh: Mesh) -> None:
    """Refuse coordinates whose products are no numbers any more.

    Raises
    ------
    UnsupportedMeshError
        With what to do.
    """
    extent = float(np.max(np.ptp(mesh.points.astype(np.float64), axis=0), initial=0.0))
    low, high = EXTENTS
    if np.isfinite(extent) and extent > 0.0 and not low <= extent <= high:
        raise UnsupportedMeshError(
            f"the mesh is {extent:.3g} across: scale it to between {low:g} and {high:g}"
        )


def require_simplices(mesh: Mesh) -> None:
    """Refuse a mesh that has other cells than those that can be optimized.

    Raises
    ------
    InvalidMeshError
        It has, and it is not valid either.
    BadMeshError, UnsupportedMeshError
        See `mesh.main_type`.
    """
    try:
        main_type(mesh)
    except UnsupportedMeshError:
        report = validity.check(mesh, overlaps=False)
        if report.is_valid:
            raise
        raise InvalidMeshError(_not_valid(report), mesh, report) from None


def _not_valid(report: validity.Report) -> str:
    codes = ", ".join(sorted(group.code for group in report.errors))
    return f"the mesh is not valid ({codes}): nothing written"


def sound(mesh: Mesh, untangles: bool) -> tuple[Mesh, validity.Report | None]:
    """The mesh, with its tetrahedra turned where that is all it lacks.

    Parameters
    ----------
    untangles : bool
        Whether inverted and flat cells are let through, to be mended.

    Returns
    -------
    mesh : Mesh
    tangle : Report or None
        What is wrong with it and to be mended.

    Raises
    ------
    InvalidMeshError
        It breaks a rule of severity error that neither turning nor untangling mends.
    """
    report = validity.check(mesh, overlaps=False)
    if report.is_valid:
        return mesh, None
    broken = {group.code for group in report.errors}
    if broken <= ORIENTATION:
        turned, n_turned = with_positive_tets(mesh)
        if n_turned and validity.check(turned, overlaps=False).is_valid:
            log.warning("%d cells had the other orientation: they are turned", n_turned)
            return turned, None
    if untangles and broken <= TANGLE and broken & {"M101", "M102"}:
        log.warning("the mesh has inverted or flat cells: they are to be untangled")
        return mesh, report
    raise InvalidMeshError(_not_valid(report), mesh, report)
