"""`meshopt check`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from .. import __version__
from ..errors import EXIT_BAD_MESH, EXIT_DONE
from ..report.verdict import Verdict
from .check_config import Configured
from .options import Number, measure_option, verbosity_options

FORMATS = ("text", "json", "github", "junit", "sarif")


def _codes(ctx: click.Context, parameter: click.Parameter, value: str | None) -> tuple[str, ...]:
    return tuple(c.strip() for c in (value or "").split(",") if c.strip())


def gate_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The limits that a user can set."""
    options = (
        click.option("--fail-above", type=Number(1), metavar="Q",
                     help="A cell worse than Q makes the mesh bad (M401)."),
        measure_option,
        click.option("--min-angle", type=Number(0), metavar="DEGREES",
                     help="Least dihedral angle, or angle of a face in the plane (M402)."),
        click.option("--max-angle", type=Number(0), metavar="DEGREES",
                     help="Greatest such angle (M402)."),
        click.option("--min-size", type=Number(0), metavar="LENGTH",
                     help="Least length of an edge (M403)."),
        click.option("--max-aspect", type=Number(1), metavar="Q",
                     help="Greatest aspect ratio, whatever --measure says (M404)."),
        click.option("--gate", multiple=True, metavar="GATE",
                     help='Any other limit, such as "height-min>=0.1" or, in one region, '
                          '"dihedral-min>=10 @ steel" (M404). Repeatable.'),
    )  # fmt: skip
    for option in reversed(options):
        function = option(function)
    return function


@click.command("check", cls=Configured)
@click.argument("meshes", nargs=-1, type=click.Path(path_type=Path), metavar="MESH...")
@click.option("--select", callback=_codes, metavar="CODES", help="Only these rules, by prefixes.")
@click.option("--extend-select", callback=_codes, metavar="CODES",
              help="These rules too, such as those on request.")  # fmt: skip
@click.option("--ignore", callback=_codes, metavar="CODES", help="All but these, by prefixes.")
@gate_options
@click.option("--tolerance", type=click.FloatRange(0, 0.1, min_open=True), metavar="T",
              help="Points nearer than T of the extent coincide; vertices nearer to a facet than "
                   "T of its size lie on it.")  # fmt: skip
@click.option("--format", "form", type=click.Choice(FORMATS), default="text", show_default=True)
@click.option("--limit", type=click.IntRange(0), default=10, show_default=True, metavar="N",
              help="Findings of a rule that are listed for a file; 0 lists all.")  # fmt: skip
@click.option("--statistics", is_flag=True, help="Count the findings of each rule instead.")
@click.option("--mark", type=click.Path(path_type=Path), metavar="FILE",
              help="Write the cells and points that are found, with their codes.")  # fmt: skip
@click.option("--jobs", type=click.IntRange(1), metavar="N",
              help="Processes; as many as there are cores where it is worth it.")  # fmt: skip
@click.option("--exit-zero", is_flag=True, help="Exit with 0 although a mesh is bad.")
@click.option("--no-config", is_flag=True, help="Read no meshopt.toml or pyproject.toml.")
@click.option("--explain", metavar="CODE", help="Say what a rule means, and check nothing.")
@verbosity_options
def command(
    meshes: tuple[Path, ...],
    select: tuple[str, ...],
    extend_select: tuple[str, ...],
    ignore: tuple[str, ...],
    tolerance: float | None,
    form: str,
    limit: int,
    statistics: bool,
    mark: Path | None,
    jobs: int | None,
    exit_zero: bool,
    no_config: bool,
    explain: str | None,
    verbosity: int,
    **limits: Any,
) -> int:
    """Look for everything that makes meshes invalid.

    MESH is a file, a folder with meshes, or a pattern. Rules of severity error make the exit
    status 1, warnings do not. Defaults of the options can stand in the table [check] of a
    meshopt.toml, or [tool.meshopt.check] of a pyproject.toml, from the working directory
    upwards. `meshopt list rules` says what the codes mean.
    """
    from ..jobs.check import Task, examine_all, files_in
    from .terminal import compile_kernels, set_up_log

    if explain is not None:
        click.echo(_explained(explain))
        return EXIT_DONE
    if not meshes:
        raise click.UsageError("Missing argument 'MESH...'.")
    if statistics and form not in ("text", "json"):
        raise click.UsageError(f"--statistics goes with text and json, not with {form}")
    gates = _gates(**limits)
    kept = limit or None
    task = Task(select, ignore, extend_select, gates, tolerance, kept, mark, verbosity)
    checked = task.checked  # an unknown code is an error before any file is read
    files = files_in(meshes)
    if mark is not None:
        if len(files) > 1:
            raise click.UsageError("--mark goes with one mesh")
        if mark.resolve() == files[0].resolve():
            raise click.UsageError("--mark would replace the mesh itself")
    if checked and _needs_kernels(files, gates):
        compile_kernels(verbosity < 0, ("basic", "check"))
    verdicts = []
    for verdict in examine_all(files, task, jobs, set_up_log):
        verdicts.append(verdict)
        if verdict.error:
            click.echo(f"meshopt: {verdict.error}", err=True)
        if form == "text":
            _show(verdict, statistics, verbosity)
    if form == "text":
        _show_all(verdicts, statistics, verbosity)
    else:
        _dump(form, verdicts, statistics)
    status = max(verdict.status for verdict in verdicts)
    return EXIT_DONE if exit_zero and status == EXIT_BAD_MESH else status


def _gates(
    fail_above: float | None,
    measure: str | None,
    min_angle: float | None,
    max_angle: float | None,
    min_size: float | None,
    max_aspect: float | None,
    gate: tuple[str, ...],
):
    """The limits from the options.

    Raises
    ------
    ConfigError
        A gate that cannot be understood, or a measure that there is not.
    """
    from ..validity import Gates, Limit, limit_of

    if measure is not None:
        from ..quality.summary import measure_named

        measure_named(measure)
    limits = [limit_of(text) for text in gate]
    both = ("dihedral", "corner")
    if min_angle is not None:
        limits += [Limit(f"{kind}-min", True, min_angle, code="M402") for kind in both]
    if max_angle is not None:
        limits += [Limit(f"{kind}-max", False, max_angle, code="M402") for kind in both]
    if min_size is not None:
        limits.append(Limit("edge-min", True, min_size, code="M403"))
    if max_aspect is not None:
        limits.append(Limit("aspect-ratio", False, max_aspect))
    return Gates(fail_above, measure, tuple(limits))


def _needs_kernels(files: list[Path], gates) -> bool:
    """Whether compiled code will be called: for measures, and for large meshes."""
    from ..validity.limits import QUANTITIES

    if gates.fail_above is not None or any(x.quantity not in QUANTITIES for x in gates.limits):
        return True
    return any(path.is_file() and path.stat().st_size > LARGE for path in files)


LARGE = 5 << 20  # bytes of a file that may hold more cells than numpy alone deals with


def _explained(code: str) -> str:
    """All that there is to say of a rule, or of each with this prefix."""
    from ..validity import choose

    parts = []
    for rule in choose([code]):
        on_request = ", on request (--extend-select)" if rule.on_request else ""
        lines = [f"{rule.code} {rule.title} ({rule.severity}{on_request})", rule.explanation]
        if rule.source:
            lines.append(f"Source: {rule.source}.")
        parts.append("\n".join([*lines, f"Fix: {rule.fix}"]))
    return "\n\n".join(parts)


def _show(verdict: Verdict, statistics: bool, verbosity: int) -> None:
    from ..report.check_text import finding_lines, last_line

    if verdict.counts is None:
        return
    if not statistics:
        for line in finding_lines(verdict):
            click.echo(line)
    if verbosity >= 0:
        click.echo(last_line(verdict))


def _show_all(verdicts: list[Verdict], statistics: bool, verbosity: int) -> None:
    from ..report.check_text import statistics_lines, summary_line

    if statistics:
        for line in statistics_lines(verdicts, _titles()):
            click.echo(line)
    if verbosity >= 0 and len(verdicts) > 1:
        click.echo(summary_line(verdicts))


def _titles() -> dict[str, str]:
    from ..validity import RULES

    return {code: rule.title for code, rule in RULES.items()}


def _dump(form: str, verdicts: list[Verdict], statistics: bool) -> None:
    """All verdicts in a format for programs."""
    if form == "json":
        from ..report.check_json import to_json

        click.echo(to_json(verdicts, statistics))
    elif form == "github":
        from ..report.check_github import commands

        titles = _titles()
        for verdict in verdicts:
            for line in commands(verdict, titles):
                click.echo(line)
    elif form == "junit":
        from ..report.check_junit import to_junit

        click.echo(to_junit(verdicts, _titles()), nl=False)
    else:
        from ..report.check_sarif import to_sarif
        from ..validity import RULES

        click.echo(to_sarif(verdicts, RULES, __version__))
