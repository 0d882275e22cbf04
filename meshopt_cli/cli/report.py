"""`meshopt report`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import EXIT_DONE, ConfigError, MeshoptError, chosen
from ..reports.outputs import NORMAL, OUTPUTS, output_of, write_reports
from . import completion
from .options import (
    INPUT,
    OUTPUT,
    all_names_in,
    metric_options,
    reading_options,
    region_option,
    verbosity_options,
)

if TYPE_CHECKING:
    from ..jobs.metric import Asked
    from ..reports.model import Report


@click.command("report")
@click.argument("meshes", nargs=-1, required=True, type=INPUT, metavar="MESH...")
@click.option(
    "--measure",
    "measures",
    metavar="NAMES",
    multiple=True,
    callback=all_names_in,
    help="What to measure, with commas: the first Q ranks the cells; `all`, or see `meshopt list "
    "measures`.",
    shell_complete=completion.of(completion.limits, many=True),
)
@metric_options("Judge the mesh, besides, by")
@click.option(
    "--against", type=INPUT, metavar="BEFORE",
    help="Compare with another mesh: rows of it before, and of MESH after.",
)  # fmt: skip
@region_option
@click.option(
    "--format", "form", metavar=f"[{'|'.join(OUTPUTS)}]",
    help="What the report looks like: as the suffix of the file says, or a table.",
)  # fmt: skip
@click.option("-o", "--output", type=OUTPUT, metavar="FILE", help="Write to a file instead.")
@click.option(
    "--write-quality",
    "marked",
    type=OUTPUT,
    metavar="FILE",
    help="Write the mesh with its quality as arrays on the cells: Q, type, region, and all that "
    "is measured.",
)
@reading_options
@verbosity_options()
def command(
    meshes: tuple[Path, ...],
    measures: tuple[str, ...] | None,
    asked: Asked | None,
    against: Path | None,
    regions: tuple[str, ...],
    form: str | None,
    output: Path | None,
    marked: Path | None,
    input_format: str | None,
    max_size: int | None,
    verbosity: int,
) -> int:
    """Show the quality of meshes as the rows of Table 18.3.

    MESH is a file, a folder with meshes, or a pattern.
    """
    if form is not None:
        row = chosen(OUTPUTS, form, "form of reports")
    elif output is not None:
        row = output_of(output)
    else:
        row = OUTPUTS["table"]
    from ..files.places import require_places
    from ..jobs.meshes import files_in
    from ..jobs.report import Wanted, compared, report_on
    from ..quality.statistics import measures_named
    from .output import print_reports, with_command
    from .terminal import compile_kernels, say

    measures_named(names := measures or ())  # what is wrong is said before a mesh is read
    files = files_in(meshes)
    if marked is not None and len(files) > 1:
        raise ConfigError("--write-quality goes with one mesh")
    others = (against, asked.path if asked else None)
    read = [*files, *(path for path in others if path is not None)]
    require_places([place for place in (output, marked) if place is not None], read)
    compile_kernels(verbosity < 0)
    wanted = Wanted(
        names, row.all_measures, regions, marked, row.histograms, asked, max_size, row.pictures
    )

    def told(path: Path, wanted: Wanted) -> Report:
        return with_command(report_on(path, wanted, input_format))

    before = None if against is None else told(against, replace(wanted, marked=None))
    reports = []
    status = EXIT_DONE
    for path in files:
        try:
            one = told(path, wanted)
            reports.append(one if before is None else compared(before, one))
        except MeshoptError as error:
            say(str(error))
            status = max(status, error.exit_status)
    if reports and output is None:
        print_reports(reports, row, NORMAL)
    elif reports and output is not None:
        write_reports(output, reports, row)
    return status
