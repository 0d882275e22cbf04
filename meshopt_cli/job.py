"""One optimization from mesh to mesh: check, cast, run the pipeline, prove the result."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass

import numpy as np

from . import adjacency, validity
from .errors import BadMeshError, InvariantError, UnsupportedMeshError
from .mesh import (
    Mesh,
    Simplices,
    cast,
    main_type,
    with_positive_tets,
    with_simplices,
)
from .passes import Observer
from .pipeline import Outcome, Pipeline
from .quality import MEASURES, Measure, Summary, summarize
from .transfer import carry
from .workspace import Workspace

Array = np.ndarray
log = logging.getLogger("meshopt")

# Volume of a region may change by rounding only: this part of the volume of the mesh.
VOLUME_TOLERANCE = 1e-9

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
    outcome: Outcome
    seconds: float


def optimize(
    mesh: Mesh,
    pipeline: Pipeline,
    measure: Measure,
    observer: Observer | None = None,
    with_all_measures: bool = False,
    with_data: bool = True,
) -> Result:
    """Optimize a mesh; the input is left as it is.

    Parameters
    ----------
    with_all_measures : bool
        Whether the summaries tell the worst Q by every measure, which takes a while.
    with_data : bool
        Whether the arrays of the mesh go along; its tags do in any case.

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
    outcome = pipeline.run(Workspace(source, measure.code, before.target), observer)
    if tangle and outcome.work.standing().worst <= 0.0:
        raise InvalidMeshError("it could not be untangled: nothing written", mesh, tangle)
    worked, origin = outcome.work.result()
    result = with_simplices(mesh, worked, origin, source)
    if tangle and not validity.check(result).is_valid:
        raise InvalidMeshError("untangling leaves it invalid: nothing written", mesh, tangle)
    result, lost = carry(mesh, result, source, origin, with_data)
    if lost:
        log.warning("arrays that do not follow the cells are dropped: %s", ", ".join(lost))
    final = cast(result)
    after = summarize(final, measure, others, before.target)
    if after.n_invalid or after.worst > before.worst * (1 + 1e-6):
        raise InvariantError(f"the worst Q rose from {before.worst} to {after.worst}")
    prove(source, final, mesh.points, result.points, origin)
    return Result(result, measure, before, after, outcome, time.perf_counter() - start)


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
        if n_turned and validity.check(turned).is_valid:
            log.warning("%d cells had the other orientation: they are turned", n_turned)
            return turned, None
    if untangles and broken <= TANGLE and broken & {"M101", "M102"}:
        log.warning("the mesh has inverted or flat cells: they are to be untangled")
        return mesh, report
    raise InvalidMeshError(_not_valid(report), mesh, report)


def prove(
    before: Simplices,
    after: Simplices,
    points_before: Array,
    points_after: Array,
    origin: Array,
) -> None:
    """Compare the domain of a result, as it will be written, with that of the input.

    Parameters
    ----------
    points_before, points_after : (np, 2 or 3) array
        As the files have them.
    origin : (np',) int64
        The point of the input that each point of the result was, -1 for a new one.

    Raises
    ------
    InvariantError
        The boundary or an interface changed, or the volume of a region.
    """
    n_points = len(before.points)
    skin = adjacency.canonical(before.skin, n_points)
    if not np.array_equal(skin, adjacency.canonical(origin[after.skin], n_points)):
        raise InvariantError("the facets of the boundary or of an interface changed")
    skin = np.unique(before.skin)
    number = np.full(len(before.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    if not np.array_equal(points_before[skin], points_after[number[skin]]):
        raise InvariantError("a vertex of the boundary moved")
    old, new = _volumes(before), _volumes(after)
    if len(old) != len(new) or np.any(np.abs(old - new) > VOLUME_TOLERANCE * old.sum()):
        raise InvariantError("the volume of a region changed")


def _volumes(mesh: Simplices) -> Array:
    """Volume of each region."""
    corners = mesh.points[mesh.cells] - mesh.points[mesh.cells[:, :1]]
    if mesh.dimension == 2:
        volume = np.cross(corners[:, 1], corners[:, 2])[:, 2] / 2.0
    else:
        volume = np.einsum("ij,ij->i", np.cross(corners[:, 1], corners[:, 2]), corners[:, 3]) / 6.0
    return np.bincount(mesh.region, weights=volume)
