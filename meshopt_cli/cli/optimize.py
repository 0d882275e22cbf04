"""`meshopt optimize`."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE
from ..report.outputs import OUTPUTS, SUFFIXES, Manner, output_of, write_reports
from . import completion
from .options import (
    OUTPUT,
    all_names_in,
    file_options,
    measure_option,
    metric_options,
    names_in,
    number_option,
    region_option,
    verbosity_options,
)

if TYPE_CHECKING:
    from ..jobs.metric import Asked

COMMAND_HELP = """Optimize the mesh in INPUT and write it to OUTPUT.

The boundary, the interfaces between regions and the facets that the file declares stay
exactly as they are; the result is never worse than the input. Files that end in .gz are
compressed; - stands for stdin or stdout, and then the report goes to stderr.
"""


@click.command("optimize", help=COMMAND_HELP)
@file_options
@click.option(
    "--preset",
    metavar="NAME",
    help="Pipeline to run; see `meshopt list presets`.",
    shell_complete=completion.of(completion.presets),
)
@click.option(
    "--passes", callback=names_in, metavar="LIST",
    help="Passes to run in rounds, such as smooth,swap; see `meshopt list passes`.",
    shell_complete=completion.of(completion.passes, many=True),
)  # fmt: skip
@click.option(
    "--config", type=click.Path(path_type=Path), metavar="FILE", help="Pipeline in a TOML file."
)
@click.option(
    "--set", "settings", multiple=True, metavar="PASS.OPTION=VALUE",
    help="Set an option of a pass.", shell_complete=completion.of(completion.settings),
)  # fmt: skip
@measure_option
@metric_options("Drive the mesh by")
@click.option(
    "--metric-out",
    metavar="WHERE",
    help="Write the metric at the points of OUTPUT: to a file, .sol or .solb, or as an array.",
)
@number_option("rounds", metavar="N", help="At most so many rounds.")
@number_option("target-quality", metavar="Q", help="Stop when no cell is worse.")
@number_option("time-limit", metavar="S", help="Stop after so many seconds.")
@click.option(
    "--report", "reports", multiple=True, type=OUTPUT, metavar="FILE",
    help=f"Write the report too, as its suffix says: {', '.join(SUFFIXES)}.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@number_option(
    "fail-above", metavar="Q",
    help="Write nothing and exit with 1 when a cell stays worse than Q.",
)  # fmt: skip
@region_option
@click.option(
    "--allow", multiple=True, callback=all_names_in, metavar="CODES",
    help="Rules of check that the mesh breaks on purpose, such as M202,M205 for cracks and "
         "contacts: what they find stays as it is; repeatable.",
    shell_complete=completion.of(completion.rules, many=True),
)  # fmt: skip
@click.option(
    "--boundary", type=click.Choice(["fixed", "slide", "split"]), default="fixed",
    show_default=True,
    help="What of the boundary stays: all of it, its shape (planes and straight ridges, which a "
         "metric drives too), or all, with vertices added on its edges by nonobtuse (triangles of "
         "a plane).",
)  # fmt: skip
@number_option(
    "slide-tolerance", metavar="X", default=1e-6, show_default=True,
    help="Sine of the angle within which facets lie in one plane, and edges in one line.",
)  # fmt: skip
@click.option(
    "--keep-off", multiple=True, metavar="WHAT:DISTANCE",
    help="Vertices are to be so far at least from a plane (x=0.5), an edge, a face, the boundary "
         "or a group; see the README; repeatable.",
)  # fmt: skip
@click.option("--no-data", is_flag=True, help="Drop all arrays but tags.")
@click.option(
    "--write-quality", is_flag=True,
    help="Put Q, type and region of the cells into OUTPUT, as arrays for ParaView.",
)  # fmt: skip
@verbosity_options(verbose="Say more: each run of each pass, and the worst Q by every measure.")
def command(
    input: Path,
    output: Path | None,
    in_place: bool,
    reports: tuple[Path, ...],
    as_json: bool,
    boundary: str,
    slide_tolerance: float,
    asked: Asked | None,
    verbosity: int,
    **options: Any,
) -> int:
    from ..boundary.policy import POLICIES, Slide
    from ..files.places import require_places
    from ..formats import PIPE
    from ..jobs.optimize_file import FileTask, InvalidFileError, optimize_file, place_of
    from ..plans.config import Request
    from .output import print_findings, print_reports, with_command
    from .terminal import compile_kernels, progress, say

    # The rest of the options have the names of what they say of the pipeline, and of the files.
    request = Request(**{f.name: options.pop(f.name) for f in fields(Request)})
    policy = Slide(slide_tolerance) if boundary == Slide.name else POLICIES[boundary]()
    task = FileTask(
        input, place_of(input, output, in_place), request, policy, metric=asked, **options
    )
    shown = OUTPUTS["json" if as_json else "table"]
    written = {path: output_of(path) for path in reports}
    read = [input, *([asked.path] if asked and asked.path else [])]
    made = [task.output, *reports]
    if task.metric_path is not None:
        made.append(task.metric_path)
    require_places(made, read, replaced=[task.output])
    if verbosity > 0 or any(row.all_measures for row in (shown, *written.values())):
        task = replace(task, all_measures=True)
    if any(row.pictures for row in written.values()):
        task = replace(task, with_pictures=True)
    try:
        with progress(verbosity < 0) as observer:
            done = optimize_file(task, observer, partial(compile_kernels, verbosity < 0))
    except InvalidFileError as error:
        print_findings(error.verdict)
        raise
    manner, report = Manner(verbosity), with_command(done.report)
    for path, row in written.items():
        write_reports(path, [report], row, manner)
    if (as_json or verbosity >= 0) and PIPE not in written:
        # Where the mesh goes to stdout, it is all that does.
        err = done.written is not None and task.output == PIPE
        print_reports([report], shown, manner, err)
    if done.written is not None:
        return EXIT_DONE
    worst = f"the worst Q stays at {done.result.after.worst:.4g}, above {task.fail_above:g}"
    say(f"{input}: {worst}: nothing written")
    return EXIT_BAD_MESH
