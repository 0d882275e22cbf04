"""Reports: of the mesh in a file, and of an optimization."""

from __future__ import annotations

import logging
from pathlib import Path

from .. import __version__, formats
from ..errors import BadMeshError, naming
from ..formats import Source, Written
from ..mesh.tags import regions_in
from ..plans.stages import Line
from ..quality.measures import QUALITIES, Measure
from ..quality.partial import measurable
from ..quality.summary import summarize
from ..report.model import FileFacts, PassFacts, Report
from ..validity import check
from .admission import require_range
from .optimize import Result
from .regions import with_asked_regions

log = logging.getLogger("meshopt")

# Rules without which cells have no shape to measure.
READABLE = ("M00",)


def report_on(
    path: Path,
    measure: Measure,
    all_measures: bool = False,
    regions: tuple[str, ...] = (),
    input_format: str | None = None,
    max_size: int | None = None,
) -> Report:
    """The figures of the mesh in a file; what they leave out is logged as a warning.

    Parameters
    ----------
    all_measures : bool
        Whether the worst Q by every measure is wanted.
    regions : tuple of str
        Arrays that make regions, if not all tags do: what lies between regions is boundary.

    input_format, max_size : optional
        See `formats.read`.

    Raises
    ------
    ConfigError
        The mesh has no such array.
    ReadError
        The file cannot be read.
    BadMeshError, UnsupportedMeshError
        There are no simplices in it to measure.
    """
    mesh, source = formats.read(path, input_format, max_size)
    with naming(path):
        if not check(mesh, READABLE).is_valid:
            raise BadMeshError("the mesh is not valid: see meshopt check")
        require_range(mesh)
        mesh = with_asked_regions(path, mesh, regions)
        part = measurable(mesh)
        others = tuple(QUALITIES.values()) if all_measures else ()
        summary = summarize(part.simplices, measure, others)
        made = regions_in(mesh)
    for note in part.notes:
        log.warning("%s: %s", path, note)
    return Report(__version__, facts_of(source), summary, regions=made, lost=source.lost)


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
    )


def facts_of(source: Source) -> FileFacts:
    """What a report says of a file."""
    return FileFacts(str(source.path), source.encoding.format, source.sha256)


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
    )
