"""`meshopt optimize`."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE, EXIT_INTERRUPTED, ConfigError
from ..files.ending import what_is_written
from ..reports.outputs import OUTPUTS, SUFFIXES, Manner, ReportOutput, output_of, write_reports
from . import completion
from .options import (
    OUTPUT,
    all_names_in,
    engine_options,
    many_file_options,
    measure_option,
    metric_options,
    names_in,
    number_option,
    region_option,
    verbosity_options,
)

if TYPE_CHECKING:
    from ..jobs.metric import Asked
    from ..jobs.optimize_file import FileTask

PIECES = ".pvtu"  # what a mesh in pieces is called

# Options that are for the files, and not for what is made of the mesh.
OF_FILES = ("fail_above", "input_format", "file_format", "binary", "metric_out")

COMMAND_HELP = """Optimize the mesh in INPUT and write it to OUTPUT.

The boundary, the interfaces between regions and the facets that the file declares stay
exactly as they are; the result is never worse than the input. Files that end in .gz are
compressed; - stands for stdin or stdout, and then the report goes to stderr.
"""


@click.command("optimize", help=COMMAND_HELP)
@many_file_options
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
    "--config", type=click.Path(path_type=Path), metavar="FILE",
    help="Pipeline in a TOML file; see `meshopt schema`.",
)  # fmt: skip
@click.option(
    "--no-config", is_flag=True,
    help="Pass over the meshopt.toml, or pyproject.toml, that is nearest.",
)  # fmt: skip
@click.option(
    "--show-config", is_flag=True,
    help="Print the pipeline that these options make, as a TOML file; no INPUT is needed.",
)  # fmt: skip
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
@click.option(
    "--only", multiple=True, metavar="WHERE",
    help="Work only on cells in a region, an entity or a physical group, by name or number, or in "
         "a box XMIN:XMAX,YMIN:YMAX[,ZMIN:ZMAX]; all others stay as they are; repeatable.",
)  # fmt: skip
@click.option(
    "--freeze",
    multiple=True,
    metavar="WHERE",
    help="Cells there stay as they are, with their vertices; repeatable.",
)
@number_option("below", metavar="Q", help="Work only around cells that are worse than Q.")
@number_option("rounds", metavar="N", help="At most so many rounds.")
@number_option("target-quality", metavar="Q", help="Stop when no cell is worse.")
@number_option("time-limit", metavar="S", help="Stop after so many seconds.")
@number_option(
    "threads", metavar="N",
    help="Threads that work on a mesh of 100,000 tetrahedra and more; as many as there are cores "
         "without. The result is the same for any number.",
)  # fmt: skip
@click.option(
    "--keep-best", is_flag=True,
    help="Let Ctrl-C write the best mesh so far; a second one ends the run at once.",
)  # fmt: skip
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
@engine_options
@click.option(
    "--write-quality", is_flag=True,
    help="Put Q, type and region of the cells into OUTPUT, as arrays for ParaView.",
)  # fmt: skip
@verbosity_options(verbose="Say more: each run of each pass, and the worst Q by every measure.")
def command(
    inputs: list[Path],
    output: Path | None,
    output_dir: Path | None,
    jobs: int | None,
    engine: str | None,
    scheduler: str | None,
    in_place: bool,
    reports: tuple[Path, ...],
    as_json: bool,
    asked: Asked | None,
    keep_best: bool,
    verbosity: int,
    no_config: bool,
    show_config: bool,
    **options: Any,
) -> int:
    from ..jobs.destinations import is_pattern
    from ..jobs.optimize_file import FileTask, place_of
    from ..jobs.optimize_mesh import task_of
    from ..plans.sources import Settled
    from .config import project_of, show

    of_files = {key: options.pop(key) for key in OF_FILES}
    project = Settled() if no_config else project_of()
    work = task_of(metric=asked, project=project, **options)
    if show_config:
        show(work.request, asked is not None)
        return EXIT_DONE
    shown = OUTPUTS["json" if as_json else "table"]
    written = {path: output_of(path) for path in reports}
    if verbosity > 0 or any(row.all_measures for row in (shown, *written.values())):
        work = replace(work, all_measures=True)
    drawn = any(row.pictures for row in written.values())
    target = output or (inputs[0] if in_place and inputs else None)
    if engine or scheduler or (target is not None and target.suffix.lower() == PIECES):
        from . import optimize_pieces as pieces
        from .engines import require_engine

        require_engine(engine, scheduler, target)
        pieces.require_plain(keep_best=keep_best or None, **of_files)
        pieces_task = pieces.PiecesTask(
            inputs[0], place_of(inputs[0], output, in_place), work, of_files["fail_above"]
        )
        return pieces.run(pieces_task, engine, scheduler, jobs, shown, written, verbosity)
    if output_dir is not None or is_pattern(output):
        from .optimize_many import Many, optimize_many

        if keep_best:
            raise ConfigError("--keep-best goes with one mesh")
        task = FileTask(Path(), Path(), work, with_pictures=drawn, **of_files)
        many = Many(inputs, output_dir, output, in_place, jobs)
        return optimize_many(many, task, shown if as_json else None, written, verbosity)
    place = place_of(inputs[0], output, in_place)
    task = FileTask(inputs[0], place, work, with_pictures=drawn, **of_files)
    return _optimize(task, shown, written, verbosity, keep_best)


def _optimize(
    task: FileTask,
    shown: ReportOutput,
    written: dict[Path, ReportOutput],
    verbosity: int,
    keep_best: bool,
) -> int:
    """Optimize one mesh, and report; returns the exit status."""
    from ..files.places import require_places
    from ..formats import PIPE
    from ..jobs.optimize_file import optimize_file
    from ..jobs.optimize_mesh import InvalidFileError
    from .output import print_findings, print_reports, with_command
    from .signals import interrupted_by
    from .terminal import compile_kernels, progress, say

    require_places([*task.places, *written], task.sources, replaced=[task.output])
    try:
        with progress(verbosity < 0) as watch, interrupted_by(
            watch.keep_best if keep_best else lambda: False
        ):  # fmt: skip
            done = optimize_file(task, watch, partial(compile_kernels, verbosity < 0))
    except InvalidFileError as error:
        print_findings(error.verdict)
        raise
    manner, report = Manner(verbosity), with_command(done.report)
    for path, row in written.items():
        write_reports(path, [report], row, manner)
    if (shown.name != "table" or verbosity >= 0) and PIPE not in written:
        # Where the mesh goes to stdout, it is all that does.
        err = done.written is not None and task.output == PIPE
        print_reports([report], shown, manner, err)
    if watch.is_cancelled:
        say(f"interrupted: {what_is_written()}")
        return EXIT_INTERRUPTED
    if done.written is not None:
        return EXIT_DONE
    worst = f"the worst Q stays at {done.result.after.worst:.4g}, above {task.fail_above:g}"
    say(f"{task.input}: {worst}: nothing written")
    return EXIT_BAD_MESH
