"""`meshopt split`."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import EXIT_DONE
from .options import INPUT, number_option, reading_options, verbosity_options


@click.command("split")
@click.argument("input", type=INPUT)
@click.argument("output", type=click.Path(path_type=Path, dir_okay=False))
@number_option("pieces", required=True, metavar="N", help="How many pieces.")
@reading_options
@verbosity_options()
def command(
    input: Path,
    output: Path,
    pieces: int,
    input_format: str | None,
    max_size: int | None,
    verbosity: int,
) -> int:
    """Cut the mesh in INPUT in pieces of as many cells each, and write these.

    OUTPUT is called .pvtu and names the files of the pieces, which go to a folder beside it; the
    points have the array GlobalPointIds, by which pieces find each other.
    """
    from ..jobs.split_file import split_file

    done = split_file(input, output, pieces, input_format, max_size)
    if verbosity >= 0:
        click.echo(
            f"{output}: {len(done.n_cells)} pieces of {min(done.n_cells):,} to "
            f"{max(done.n_cells):,} cells, {done.n_shared:,} points in several"
        )
    return EXIT_DONE
