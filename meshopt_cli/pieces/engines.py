"""Where the steps of a run in pieces are done: here, in other processes, or on other machines."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

from ..errors import EXIT_FILES, MeshoptError

Facts = dict[str, Any]
Step = Callable[..., Facts]
KILLED = (
    "a process was killed, for want of memory perhaps: what is done is kept; run the same again, "
    "with fewer --jobs"
)


class StepError(MeshoptError):
    """What a step raised elsewhere: one line, and the exit status."""

    def __init__(self, message: str, exit_status: int) -> None:
        super().__init__(message)
        self.exit_status = exit_status


class Engine(Protocol):
    """What does steps."""

    def map(self, step: Step, calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Facts]]:
        """Do a step with each of some arguments; yields its number and facts as it is done.

        Raises
        ------
        MeshoptError
            What a step raised.
        """


class Here:
    """One step after the other."""

    def map(self, step: Step, calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Facts]]:
        yield from ((i, step(*call)) for i, call in enumerate(calls))


class Processes:
    """Several steps at a time, each in a process of this machine."""

    def __init__(self, pool: Any) -> None:
        self.pool = pool

    def map(self, step: Step, calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Facts]]:
        from concurrent.futures import as_completed
        from concurrent.futures.process import BrokenProcessPool

        waiting = {self.pool.submit(outcome, step, call): i for i, call in enumerate(calls)}
        try:
            for future in as_completed(waiting):
                yield waiting[future], facts_of(future.result())
        except BrokenProcessPool:
            raise StepError(KILLED, EXIT_FILES) from None
        finally:
            for future in waiting:
                future.cancel()


@contextlib.contextmanager
def local(jobs: int, set_up: Callable[[int], None], verbosity: int) -> Iterator[Engine]:
    """The engine of this machine."""
    if jobs < 2:
        yield Here()
        return
    from ..jobs.pool import started

    with started(jobs, set_up, verbosity) as pool:
        yield Processes(pool)


def outcome(step: Step, call: tuple[Any, ...]) -> Facts | tuple[str, int]:
    """What a step said, or the line and the status of what it raised: not all errors travel."""
    try:
        return step(*call)
    except MeshoptError as error:
        return str(error), error.exit_status


def facts_of(done: Facts | tuple[str, int]) -> Facts:
    """What a step said.

    Raises
    ------
    StepError
    """
    if isinstance(done, dict):
        return done
    raise StepError(*done)
