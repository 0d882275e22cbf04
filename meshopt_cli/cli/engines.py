"""Who works on meshes in pieces."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..cores import n_cores
from ..errors import ConfigError
from ..formats.vtk.parallel import SUFFIX, is_index
from ..pieces.dask import workers
from ..pieces.engines import Engine, local
from .options import LOG_FILE
from .terminal import say, set_up_log

if TYPE_CHECKING:
    from ..jobs.check import Task
    from ..reports.verdict import Verdict


def require_engine(engine: str | None, scheduler: str | None, path: Path | None) -> None:
    """Refuse an engine where there is nothing for it to do.

    Raises
    ------
    ConfigError
    """
    if (engine or scheduler) and not (path is not None and is_index(path)):
        named = f"{path}: " if path else ""
        raise ConfigError(f"{named}--engine and --scheduler are for meshes in pieces, {SUFFIX}")
    if scheduler and engine == "local":
        raise ConfigError("--scheduler is one of Dask: --engine dask")


def engine_of(
    engine: str | None, scheduler: str | None, jobs: int | None, verbosity: int
) -> AbstractContextManager[Engine]:
    """What does the steps."""
    if engine == "dask" or scheduler:
        return workers(scheduler, jobs, say if verbosity >= 0 else lambda _: None)
    set_up = partial(set_up_log, file=click.get_current_context().meta[LOG_FILE])
    return local(n_cores() if jobs is None else jobs, set_up, verbosity)


def verdicts_on_pieces(
    files: list[Path],
    task: Task,
    engine: str | None,
    scheduler: str | None,
    jobs: int | None,
    verbosity: int,
) -> Iterator[Verdict]:
    """Verdicts on meshes in pieces: on each piece, and on how they fit together.

    Raises
    ------
    ConfigError
        A file has no pieces, or something is asked that needs all of a mesh.
    """
    from ..pieces.check import check_pieces

    for path in files:
        require_engine(engine, scheduler, path)
    if task.mark is not None or task.asked is not None:
        what = "--mark" if task.mark is not None else "a metric"
        raise ConfigError(f"{what}: not for meshes in pieces; meshopt join makes one of them")
    with engine_of(engine, scheduler, jobs, verbosity) as one:
        for path in files:
            yield from check_pieces(path, task, one)
