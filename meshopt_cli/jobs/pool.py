"""The same work on many files, in as many processes as it is worth."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from ..cores import n_cores
from ..errors import EXIT_TERMINATED
from ..files.ending import between_steps, clean_up

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

Task = TypeVar("Task")
Done = TypeVar("Done")

# Files smaller than this together are not worth another process.
SMALL = 4 << 20


def each(
    tasks: Sequence[tuple[Path, Task]],
    work: Callable[[Path, Task], Done],
    killed: Callable[[Path, Task, str], Done],
    jobs: int | None,
    set_up: Callable[[int], None],
    verbosity: int,
    note: Callable[[Done], None] = lambda done: None,
) -> Iterator[Done]:
    """What comes of each file, in their order.

    Parameters
    ----------
    tasks : sequence of (Path, task)
    work : function of a file and its task
        It catches what can go wrong.
    killed : function of a file, its task and a line for people
        What comes of a file whose process was killed.
    jobs : int or None
        Processes at most; None: as many as it is worth.
    set_up : function of the verbosity
        Called first in every process: it says where the log goes.
    note : function of what comes of a file
        Called as soon as another process is done with it, before its turn.
    """
    paths = [path for path, _ in tasks]
    n_processes = min(_jobs(paths) if jobs is None else jobs, len(paths))
    if n_processes <= 1:
        yield from (work(*task) for task in tasks)
        return
    from concurrent.futures.process import BrokenProcessPool

    with started(n_processes, set_up, verbosity) as pool:
        pending = [(task, pool.submit(work, *task)) for task in tasks]
        for _, future in pending:
            future.add_done_callback(lambda one: None if _failed(one) else note(one.result()))
        for (path, task), future in pending:
            try:
                yield future.result()
            except BrokenProcessPool:
                yield killed(path, task, f"{path}: its process was killed: try --jobs 1")


@contextlib.contextmanager
def started(
    n_processes: int, set_up: Callable[[int], None], verbosity: int
) -> Iterator[ProcessPoolExecutor]:
    """So many processes, that end with this one; see `each`."""
    from concurrent.futures import ProcessPoolExecutor

    pool = ProcessPoolExecutor(n_processes, None, _start_worker, (set_up, verbosity))
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _failed(future: Future[Done]) -> bool:
    return future.cancelled() or future.exception() is not None


def _start_worker(set_up: Callable[[int], None], verbosity: int) -> None:
    """Leave it to the process that started this one to end it, and end with it."""
    import multiprocessing
    import signal
    import threading
    from multiprocessing.connection import wait

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), lambda *_: between_steps(_leave))
    parent = multiprocessing.parent_process()
    if parent is not None:

        def follow() -> None:
            wait([parent.sentinel])
            between_steps(_leave)

        threading.Thread(target=follow, daemon=True).start()
    set_up(verbosity)


def _leave() -> None:
    """End this process, without what is temporary."""
    clean_up()
    os._exit(EXIT_TERMINATED)


def _jobs(paths: list[Path]) -> int:
    total = 0
    for path in paths:
        try:
            total += path.stat().st_size
        except OSError:
            continue
    if len(paths) < 2 or total < SMALL:
        return 1
    return n_cores()
