"""`meshopt join`."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import EXIT_DONE
from .options import file_options, verbosity_options


@click.command("join")
@file_options
@verbosity_options()
def command(
    input: Path,
    output: Path | None,
    file_format: str | None,
    input_format: str | None,
    binary: bool | None,
    max_size: int | None,
    in_place: bool,
    verbosity: int,
) -> int:
    """Put the pieces of the mesh that INPUT names together, and write it to OUTPUT.

    INPUT is called .pvtu. Any other mesh is written in the format of OUTPUT.
    """
    from ..jobs.optimize_file import place_of
    from ..jobs.split_file import join_file

    place = place_of(input, output, in_place)
    n_cells, n_points = join_file(input, place, input_format, file_format, binary, max_size)
    if verbosity >= 0:
        click.echo(f"{place}: {n_cells:,} cells, {n_points:,} points", err=str(place) == "-")
    return EXIT_DONE
