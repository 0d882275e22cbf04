"""`meshopt split`."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import EXIT_DONE
from .options import number_option, reading_options, verbosity_options


@click.command("split")
@click.argument("files", nargs=-1, type=click.Path(path_type=Path), metavar="INPUT... OUTPUT")
@number_option("pieces", metavar="N", help="In how many pieces one INPUT is cut.")
@reading_options
@verbosity_options()
def command(
    files: tuple[Path, ...],
    pieces: int | None,
    input_format: str | None,
    max_size: int | None,
    verbosity: int,
) -> int:
    """Cut the mesh in INPUT in pieces of as many cells each, and write these.

    OUTPUT is called .pvtu and names the files of the pieces, which go to a folder beside it; the
    points have the array GlobalPointIds, by which pieces find each other. Several INPUTs are pieces
    already, such as the files that Gmsh writes of the partitions of a mesh.
    """
    from ..jobs.split_file import gather_files, split_file

    if len(files) < 2:
        raise click.UsageError(f"Missing argument '{'OUTPUT' if files else 'INPUT...'}'.")
    *inputs, output = files
    if (pieces is None) == (len(inputs) == 1):
        raise click.UsageError("--pieces N goes with one INPUT, which needs it")
    if pieces is not None:
        done = split_file(inputs[0], output, pieces, input_format, max_size)
    else:
        done = gather_files(inputs, output, input_format, max_size)
    if verbosity >= 0:
        click.echo(
            f"{output}: {len(done.n_cells)} pieces of {min(done.n_cells):,} to "
            f"{max(done.n_cells):,} cells, {done.n_shared:,} points in several"
        )
    return EXIT_DONE
