"""`meshopt optimize` of a mesh in pieces."""

from __future__ import annotations

import contextlib
import logging
import sys
from collections.abc import Iterator
from pathlib import Path

from ..errors import EXIT_BAD_MESH, EXIT_DONE, ConfigError
from ..files.places import require_places
from ..jobs.optimize_mesh import accepted
from ..pieces.run import PiecesTask, Told, are_pieces, optimize_pieces
from ..reports.outputs import Manner, ReportOutput, write_reports
from .engines import engine_of
from .output import print_reports, with_command
from .terminal import compile_kernels, is_plain, say

log = logging.getLogger("meshopt")


def run(
    task: PiecesTask,
    engine: str | None,
    scheduler: str | None,
    jobs: int | None,
    shown: ReportOutput,
    written: dict[Path, ReportOutput],
    verbosity: int,
) -> int:
    """Optimize a mesh in pieces, and report; returns the exit status."""
    if not are_pieces(task.input, task.output):
        raise ConfigError(
            f"{task.output}: pieces are made of pieces: meshopt split {task.input} makes some"
        )
    require_places([task.output, *written], [task.input], replaced=[task.output])
    compile_kernels(verbosity < 0, accepted(task.task).plan.kernels())
    with engine_of(engine, scheduler, jobs, verbosity) as one, _told(verbosity) as told:
        report = with_command(optimize_pieces(task, one, told))
    manner = Manner(verbosity)
    for path, row in written.items():
        write_reports(path, [report], row, manner)
    if shown.name != "table" or verbosity >= 0:
        print_reports([report], shown, manner)
    if report.output is not None:
        return EXIT_DONE
    assert report.after is not None
    worst = f"the worst Q stays at {report.after.worst:.4g}, above {task.fail_above:g}"
    say(f"{task.input}: {worst}: nothing written")
    return EXIT_BAD_MESH


@contextlib.contextmanager
def _told(verbosity: int) -> Iterator[Told]:
    """What is told of a run: a line on a terminal, and to the log alone elsewhere."""

    def note(what: str, done: int, n: int, worst: float) -> None:
        log.debug("%s: %d of %d pieces, worst Q %.4g", what, done, n, worst)

    if verbosity < 0 or not sys.stderr.isatty():
        yield note
        return
    from ..progress.lines import tqdm_pieces

    with tqdm_pieces(sys.stderr, is_plain(err=True)) as line:

        def told(what: str, done: int, n: int, worst: float) -> None:
            note(what, done, n, worst)
            line(what, done, n, worst)

        yield told
