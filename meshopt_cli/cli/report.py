"""`meshopt report`."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import click

from ..errors import EXIT_DONE, EXIT_FILES, BadMeshError, MeshoptError
from .naming import naming
from .options import measure_option, verbosity_options
from .output import REPORT_FORMATS

log = logging.getLogger("meshopt")

# Rules without which cells have no shape to measure.
READABLE = ("M00",)


@click.command("report")
@click.argument("meshes", nargs=-1, required=True, type=click.Path(path_type=Path))
@measure_option
@click.option(
    "--format", "form", type=click.Choice(REPORT_FORMATS), default="table", show_default=True
)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write to a file instead.")
@verbosity_options
def command(
    meshes: tuple[Path, ...],
    measure: str | None,
    form: str,
    output: Path | None,
    verbosity: int,
) -> int:
    """Show the quality of meshes as the rows of Table 18.3."""
    from .. import __version__, formats
    from ..quality.partial import measurable
    from ..quality.summary import DEFAULT_MEASURE, MEASURES, measure_named, summarize
    from ..report.model import Report
    from ..validity import check
    from .output import as_text, facts_of, print_report
    from .terminal import compile_kernels

    chosen = measure_named(measure or DEFAULT_MEASURE)
    compile_kernels(verbosity < 0)
    others = tuple(MEASURES.values()) if form == "json" else ()
    reports = []
    status = EXIT_DONE
    for path in meshes:
        try:
            mesh, source = formats.read(path)
            with naming(path):
                if not check(mesh, READABLE).is_valid:
                    raise BadMeshError("the mesh is not valid: see meshopt check")
                part = measurable(mesh)
                summary = summarize(part.simplices, chosen, others)
        except MeshoptError as error:
            click.echo(f"meshopt: {error}", err=True)
            status = max(status, error.exit_status)
            continue
        for note in part.notes:
            log.warning("%s: %s", path, note)
        summary = replace(summary, n_points=part.n_points)
        reports.append(Report(__version__, facts_of(source), summary))
    if reports and output is None:
        print_report(reports, form)
    elif reports and output is not None:
        try:
            output.write_text(as_text(reports, form), "utf-8", "backslashreplace")
        except OSError as error:
            click.echo(f"meshopt: {output}: {error.strerror}", err=True)
            return EXIT_FILES
    return status
