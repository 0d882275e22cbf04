"""`meshopt check`."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import EXIT_BAD_MESH, EXIT_DONE, MeshoptError
from .options import Number, measure_option, verbosity_options


def _codes(ctx: click.Context, parameter: click.Parameter, value: str | None) -> tuple[str, ...]:
    return tuple(c.strip() for c in (value or "").split(",") if c.strip())


@click.command("check")
@click.argument("meshes", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--fail-above", type=Number(1), metavar="Q",
    help="A cell worse than Q makes the mesh bad (M401).",
)  # fmt: skip
@measure_option
@click.option("--select", callback=_codes, metavar="CODES", help="Only these rules, by prefixes.")
@click.option("--ignore", callback=_codes, metavar="CODES", help="All but these, by prefixes.")
@click.option(
    "--format", "form", type=click.Choice(["text", "json"]), default="text", show_default=True
)
@verbosity_options
def command(
    meshes: tuple[Path, ...],
    fail_above: float | None,
    measure: str | None,
    select: tuple[str, ...],
    ignore: tuple[str, ...],
    form: str,
    verbosity: int,
) -> int:
    """Look for everything that makes meshes invalid.

    Rules of severity error make the exit status 1, warnings do not. `meshopt list rules` says
    what the codes mean.
    """
    from .. import formats, validity
    from .findings import dump, report_dict, show_findings

    validity.choose(select, ignore)
    gates = validity.Gates(fail_above, measure)
    status = EXIT_DONE
    values = []
    for path in meshes:
        try:
            mesh, source = formats.read(path)
        except MeshoptError as error:
            click.echo(f"meshopt: {error}", err=True)
            values.append({"path": str(path), "valid": False, "status": error.exit_status,
                           "error": str(error)})  # fmt: skip
            status = max(status, error.exit_status)
            continue
        report = validity.check(mesh, select, ignore, gates)
        own = EXIT_DONE if report.is_valid else EXIT_BAD_MESH
        if mesh.dimension() < 2:
            click.echo(f"meshopt: {path}: no triangles or tetrahedra to check", err=True)
            own = EXIT_BAD_MESH
        if form == "json":
            values.append(report_dict(path, source, mesh, report, own))
        else:
            show_findings(path, source, mesh, report)
        status = max(status, own)
        if form == "text" and verbosity >= 0:
            click.echo(_verdict(path, report, own))
    if form == "json":
        click.echo(dump(values))
    return status


def _verdict(path: Path, report, status: int) -> str:
    """The last line on a file: whether it is valid, and how much was found."""
    n_errors = sum(len(g) for g in report.errors)
    n_warnings = sum(len(g) for g in report.warnings)
    word = "valid" if status == EXIT_DONE else "not valid"
    counts = [f"{n:,} {what}{'' if n == 1 else 's'}"
              for n, what in ((n_errors, "error"), (n_warnings, "warning")) if n]  # fmt: skip
    return f"{path}: {word}" + (f" ({', '.join(counts)})" if counts else "")
