"""`meshopt optimize`."""

from __future__ import annotations

import os
import time
from itertools import pairwise
from pathlib import Path

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE, ConfigError
from .naming import naming
from .options import Number, measure_option, verbosity_options

COMMAND_HELP = """Optimize the mesh in INPUT and write it to OUTPUT.

The boundary, the interfaces between regions and the facets that the file declares stay
exactly as they are; the result is never worse than the input. Files that end in .gz are
compressed; - stands for stdin or stdout, and then the report goes to stderr.
"""


@click.command("optimize", help=COMMAND_HELP)
@click.argument("input", type=click.Path(path_type=Path))
@click.argument("output", type=click.Path(path_type=Path), required=False)
@click.option("--preset", metavar="NAME", help="Pipeline to run; see `meshopt list presets`.")
@click.option(
    "--passes",
    metavar="LIST",
    help="Passes to run in rounds, such as smooth,swap; see `meshopt list passes`.",
)
@click.option(
    "--config", type=click.Path(path_type=Path), metavar="FILE", help="Pipeline in a TOML file."
)
@click.option(
    "--set", "settings", multiple=True, metavar="PASS.OPTION=VALUE", help="Set an option of a pass."
)
@measure_option
@click.option("--rounds", type=click.IntRange(1), help="At most so many rounds.")
@click.option("--target-quality", type=Number(1), metavar="Q", help="Stop when no cell is worse.")
@click.option("--time-limit", type=Number(0), metavar="S", help="Stop after so many seconds.")
@click.option(
    "--report", "reports", multiple=True, type=click.Path(path_type=Path), metavar="FILE",
    help="Write the report too, as its suffix says: .json, .md, .csv or .txt.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.option(
    "--fail-above", type=Number(1), metavar="Q",
    help="Write nothing and exit with 1 when a cell stays worse than Q.",
)  # fmt: skip
@click.option("--file-format", metavar="NAME", help="Format of OUTPUT; see `meshopt list formats`.")
@click.option("--input-format", metavar="NAME", help="Format of INPUT, whatever its name.")
@click.option(
    "--ascii/--binary", "ascii", default=None,
    help="Write text or binary, where the format has both; as INPUT was without.",
)  # fmt: skip
@click.option(
    "--region", "regions", multiple=True, metavar="NAME",
    help="An array of the cells that makes regions, instead of all tags; repeatable.",
)  # fmt: skip
@click.option(
    "--boundary", type=click.Choice(["fixed", "slide"]), default="fixed", show_default=True,
    help="What of the boundary stays: all of it, or its shape (planes and straight ridges).",
)  # fmt: skip
@click.option(
    "--slide-tolerance", type=Number(0), metavar="X", default=1e-6, show_default=True,
    help="Sine of the angle within which facets lie in one plane, and edges in one line.",
)  # fmt: skip
@click.option("--no-data", is_flag=True, help="Drop all arrays but tags.")
@click.option("--in-place", is_flag=True, help="OUTPUT may be INPUT, and is when it is left out.")
@verbosity_options
def command(
    input: Path,
    output: Path | None,
    preset: str | None,
    passes: str | None,
    config: Path | None,
    settings: tuple[str, ...],
    measure: str | None,
    rounds: int | None,
    target_quality: float | None,
    time_limit: float | None,
    reports: tuple[Path, ...],
    as_json: bool,
    fail_above: float | None,
    file_format: str | None,
    input_format: str | None,
    ascii: bool | None,
    regions: tuple[str, ...],
    boundary: str,
    slide_tolerance: float,
    no_data: bool,
    in_place: bool,
    verbosity: int,
) -> int:
    from .. import formats
    from ..boundary.policy import Fixed, Slide
    from ..jobs.admission import InvalidMeshError, require_simplices
    from ..jobs.optimize import optimize
    from ..mesh.tags import with_regions
    from ..plans.config import Request, plan_for
    from .output import form_of, print_report, report_of, write_reports
    from .terminal import compile_kernels, progress, show_findings

    output = _output(input, output, in_place)
    names = None if passes is None else tuple(n.strip() for n in passes.split(",") if n.strip())
    request = Request(preset, names, config, settings, measure, rounds, target_quality, time_limit)
    plan_for(request)  # what is wrong with the options is said before the mesh is read
    for path in reports:
        form_of(path)
    formats.require_place(output)
    clock = [time.perf_counter()]
    mesh, source = formats.read(input, input_format)
    binary = None if ascii is None else not ascii
    as_data = as_json or any(r.suffix.lower() == ".json" for r in reports)
    needs_all = as_data or verbosity > 0 or preset == "best"
    try:
        with naming(input):
            require_simplices(mesh)
            if regions:
                mesh = with_regions(mesh, regions)
        plan = plan_for(request, mesh.dimension())
        encoding = formats.encoding_for(output, source.encoding, file_format, binary)
        clock.append(time.perf_counter())
        compile_kernels(verbosity < 0, plan.kernels())
        with progress(verbosity < 0) as observer, naming(input):
            policy = Slide(slide_tolerance) if boundary == Slide.name else Fixed()
            result = optimize(
                mesh, plan.pipeline, plan.measure, observer, needs_all, not no_data, policy
            )
    except InvalidMeshError as error:
        show_findings(input, source, error.mesh, error.report, err=True)
        raise
    clock.append(time.perf_counter())
    failed = fail_above is not None and result.after.worst > fail_above
    written = None if failed else formats.write(output, result.mesh, encoding)
    clock.append(time.perf_counter())
    seconds = dict(
        zip(("read", "optimize", "write"), (b - a for a, b in pairwise(clock)),
            strict=True)
    )  # fmt: skip
    report = report_of(source, result, seconds, written)
    write_reports(reports, [report], verbosity)
    if as_json or verbosity >= 0:
        # where the mesh goes to stdout, it is all that does
        err = output == formats.PIPE and not failed
        print_report([report], "json" if as_json else "table", verbosity, err)
    if failed:
        click.echo(
            f"meshopt: {input}: the worst Q stays at {result.after.worst:.4g}, above "
            f"{fail_above:g}: nothing written",
            err=True,
        )
        return EXIT_BAD_MESH
    return EXIT_DONE


def _output(input: Path, output: Path | None, in_place: bool) -> Path:
    """Where the result goes.

    Raises
    ------
    ConfigError
        OUTPUT is missing, or is INPUT without `--in-place`.
    """
    pipe = Path("-")
    if output is None:
        if input == pipe:
            raise ConfigError("OUTPUT is missing: - is stdout")
        if not in_place:
            raise ConfigError("OUTPUT is missing (with --in-place it may be)")
        return input
    if pipe in (input, output):
        return output
    same = os.path.exists(output) and os.path.exists(input) and os.path.samefile(input, output)
    if same and not in_place:
        raise ConfigError(f"{output} is the input itself: add --in-place to replace it")
    return output
