"""`meshopt view`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import EXIT_DONE
from . import completion
from .options import INPUT, OUTPUT, number_option, reading_options, verbosity_options


@click.command("view")
@click.argument("mesh", type=INPUT)
@click.option(
    "-o", "--output", type=OUTPUT, metavar="FILE",
    help="Where the picture goes, .png or .svg; without it a window opens.",
)  # fmt: skip
@click.option(
    "--measure", metavar="NAME",
    help="What colours tell, of any kind; see `meshopt list measures`.",
    shell_complete=completion.of(completion.limits),
)  # fmt: skip
@click.option(
    "--cut", metavar="PLACE",
    help="Draw only whole cells below a plane, such as x=0.5 or z=50%; without it solids are cut "
         "in the middle, and `none` leaves them whole.",
)  # fmt: skip
@number_option("shrink", metavar="S", help="Draw cells smaller, such as 0.8 of their size.")
@number_option(
    "worst", metavar="N", help="Draw each of the N worst cells with its surroundings instead."
)
@click.option(
    "--negative", is_flag=True,
    help="Colour cells by their orientation: positive, flat or negative; facets of a surface by "
         "the side that is seen.",
)  # fmt: skip
@number_option("width", metavar="PX", help="Pixels across the picture, 1600 without it.")
@reading_options
@verbosity_options()
def command(
    mesh: Path,
    output: Path | None,
    worst: int | None,
    verbosity: int,
    **options: Any,
) -> int:
    """Draw the mesh in a file, its cells coloured by their quality.

    Plane meshes are seen from above, surfaces and solids askew; facets whose Q is above 10 are
    outlined, and of solids the whole cells on one side of a cut are drawn, shrunk. This needs
    the extra `plot`.
    """
    from ..files.places import require_places
    from ..jobs.view import ViewTask, view_file
    from .terminal import compile_kernels

    task = ViewTask(mesh, output, worst=worst or 0, **options)
    require_places([] if output is None else [output], [mesh])
    view_file(task, lambda: compile_kernels(verbosity < 0))
    return EXIT_DONE
