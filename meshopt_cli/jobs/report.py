"""Reports: of the mesh in a file, and of an optimization."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from .. import formats
from ..cells import family_of
from ..errors import BadMeshError, ConfigError, naming, shown
from ..formats import Numbering, Source, Written
from ..mesh.model import Mesh
from ..mesh.tags import regions_in
from ..plans.stages import Line
from ..quality.families import summarize_mesh
from ..quality.measurable import measurable
from ..quality.measures import DEFAULT_MEASURE, MEASURES, OF_SIMPLICES
from ..quality.statistics import measures_named, statistics, table_measure
from ..quality.summary import Summary
from ..quality.worst import WorstCell
from ..reports.model import FileFacts, PassFacts, Report
from ..validity import check
from ..version import __version__
from .admission import READABLE, require_range
from .optimize import Result
from .quality_arrays import with_quality
from .regions import with_asked_regions

if TYPE_CHECKING:  # seldom met
    from .metric import Asked

log = logging.getLogger("meshopt")


@dataclass(frozen=True)
class Wanted:
    """What a report on a mesh is to tell.

    Attributes
    ----------
    names : tuple of str
        Measures, what is told of all cells by each; the first that is a Q ranks them in Table
        18.3. See `statistics.measures_named`.
    all_measures : bool
        Whether the worst Q by every measure is wanted.
    regions : tuple of str
        Arrays that make regions, if not all tags do: what lies between regions is boundary.
    marked : Path, optional
        Where the mesh goes with its quality on the cells.
    with_histograms : bool
        Whether the values of the measures are put into bins.
    metric : Asked, optional
        The metric that the mesh is judged by.
    max_size : int, optional
        See `formats.read`: for the file of the metric, too.
    with_pictures : bool
        Whether the mesh is drawn, where there is what draws it.
    """

    names: tuple[str, ...] = ()
    all_measures: bool = False
    regions: tuple[str, ...] = ()
    marked: Path | None = None
    with_histograms: bool = False
    metric: Asked | None = None
    max_size: int | None = None
    with_pictures: bool = False


def report_on(path: Path, wanted: Wanted = Wanted(), input_format: str | None = None) -> Report:
    """The figures of the mesh in a file; see `report_on_mesh`.

    Raises
    ------
    ReadError
        The file cannot be read.
    """
    if wanted.marked is not None:
        formats.encoding_for(wanted.marked)  # what is wrong is said before the mesh is read
    mesh, source = formats.read(path, input_format, wanted.max_size)
    return report_on_mesh(mesh, source, wanted)


def report_on_mesh(mesh: Mesh, source: Source, wanted: Wanted) -> Report:
    """The figures of a mesh; what they leave out is logged as a warning.

    Parameters
    ----------
    source : Source
        Where it comes from: errors name it.

    Raises
    ------
    ConfigError
        The mesh has no such array, there is no such measure, or the metric is none.
    ReadError, WriteError
        A file cannot be read, or written.
    BadMeshError, UnsupportedMeshError
        There are no cells in it to measure, or none that has the measure.
    """
    path = source.path
    with naming(path):
        if not check(mesh, READABLE).is_valid:
            raise BadMeshError("the mesh is not valid: see meshopt check")
        require_range(mesh)
        mesh = with_asked_regions(path, mesh, wanted.regions)
        part = measurable(mesh)
        others = tuple(OF_SIMPLICES.values()) if wanted.all_measures else ()
        measures = measures_named(wanted.names)
        measure = table_measure(measures, MEASURES[DEFAULT_MEASURE])
        summary = summarize_mesh(mesh, part, measure, others)
        summary = naming_cells(summary, source, mesh)
        found = statistics(part, measures, wanted.with_histograms)
        judged = None
        if wanted.metric is not None:
            from .metric import judge_by, with_judged  # seldom needed

            judged = judge_by(wanted.metric, mesh, source, part, measure, wanted.max_size)
        made = regions_in(mesh)
    if wanted.marked is not None:
        marked = with_quality(mesh, measure, [m for m in measures if m is not measure])
        marked = with_judged(marked, judged) if judged else marked
        formats.write(wanted.marked, marked, formats.encoding_for(wanted.marked))
    idle = {m.name for m in measures if not m.ways.keys() & part.cells.keys()}
    notes = part.notes
    if asked := [name for name in wanted.names if name in idle]:
        notes = (f"no cell has the measure {', '.join(asked)}", *notes)
    for note in notes:
        log.warning("%s: %s", path, note)
    report = Report(
        __version__, facts_of(source), summary, regions=made, statistics=found, lost=source.lost,
        notes=notes,
        metric=judged.summary if judged else None,
    )  # fmt: skip
    if wanted.with_pictures:
        from .illustrate import illustrated  # seldom needed

        return illustrated(report, [mesh])
    return report


def compared(before: Report, after: Report) -> Report:
    """A report on two meshes, as if one had been made of the other.

    Parameters
    ----------
    before, after : Report
        On a mesh each.

    Raises
    ------
    ConfigError
        Their cells are not of one dimension.
    """
    if before.before.dimension != after.before.dimension:
        raise ConfigError(
            f"{after.input.path}: cells of dimension {after.before.dimension} are not compared "
            f"with those of {before.input.path}, of dimension {before.before.dimension}"
        )
    pictures = after.pictures
    if before.pictures is not None and pictures is not None:
        wholes, worst = before.pictures.wholes, before.pictures.worst
        pictures = replace(pictures, wholes=wholes + pictures.wholes, worst=worst + pictures.worst)
    return replace(
        before,
        output=after.input,
        after=after.before,
        statistics_after=after.statistics,
        metric_after=after.metric,
        lost=_told_of(before, before.lost) + _told_of(after, after.lost),
        notes=_told_of(before, before.notes) + _told_of(after, after.notes),
        pictures=pictures,
    )


def _told_of(report: Report, lines: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{shown(report.input.path)}: {line}" for line in lines)


def report_of(
    source: Source, result: Result, seconds: dict[str, float], written: Written | None
) -> Report:
    """What is to be said of an optimization; `written` is None when nothing was."""
    return Report(
        __version__,
        facts_of(source),
        result.before,
        None if written is None else facts_of(written),
        result.after,
        tuple(_pass_facts(line) for line in result.lines),
        result.stopped,
        seconds,
        result.regions,
        source.lost + result.lost + (() if written is None else written.lost),
        left_out=result.left_out,
        metric=result.in_metric and result.in_metric[0],
        metric_after=result.in_metric and result.in_metric[1],
    )


def facts_of(source: Source) -> FileFacts:
    """What a report says of a file."""
    return FileFacts(str(source.path), source.encoding.format, source.sha256)


def naming_cells(summary: Summary, source: Source, mesh: Mesh) -> Summary:
    """A summary of a mesh whose worst cells have the names by which its file calls them.

    Parameters
    ----------
    source : Source
        Of the file that the mesh is in.
    """
    numbering = formats.numbering(source.encoding, mesh)

    def named(one: WorstCell) -> WorstCell:
        return replace(one, cell=cell_name(mesh, numbering, one.family, one.number))

    parts = tuple(naming_cells(part, source, mesh) for part in summary.parts)
    return replace(summary, parts=parts, worst_cells=tuple(map(named, summary.worst_cells)))


def cell_name(mesh: Mesh, numbering: Numbering, family: str, row: int) -> str:
    """What the file of a mesh calls a cell, by its row among all of its family."""
    for i, block in enumerate(mesh.blocks):
        kind = family_of(block.type)
        if kind is None or kind.name != family:
            continue
        if row < len(block.cells):
            return numbering.cell(i, row)
        row -= len(block.cells)
    return ""


def _pass_facts(line: Line) -> PassFacts:
    tally, least = line.tally, line.standing.worst
    return PassFacts(
        line.round,
        tally.name,
        tally.visited,
        tally.applied,
        tally.refused,
        tally.seconds,
        1.0 / least if least > 0 else float("inf"),
        line.standing.mean,
        tally.kinds,
    )
