"""The engine of Dask: steps are done by workers, on this machine or on those of a cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ..cores import n_cores
from ..errors import EXIT_FILES, ConfigError
from .engines import KILLED, Engine, Facts, Step, StepError, facts_of, outcome

EXTRA = "--engine dask needs Dask: pip install 'meshopt-cli[dask]'"
TIMEOUT = 30  # seconds for a scheduler to answer
RETRIES = 3  # of a step whose worker died


class Workers:
    """Those of a scheduler of Dask, which all see the folder of the output."""

    def __init__(self, client: Any) -> None:
        self.client = client

    def map(self, step: Step, calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Facts]]:
        from distributed import KilledWorker, as_completed

        waiting = {
            self.client.submit(outcome, step, call, pure=False, retries=RETRIES): i
            for i, call in enumerate(calls)
        }
        try:
            for future in as_completed(waiting):
                yield waiting[future], facts_of(future.result())
        except KilledWorker:
            raise StepError(KILLED, EXIT_FILES) from None
        finally:
            self.client.cancel(list(waiting))


@contextlib.contextmanager
def workers(
    scheduler: str | None, jobs: int | None, say: Callable[[str], None]
) -> Iterator[Engine]:
    """The workers of a scheduler, or so many processes of this machine.

    Parameters
    ----------
    scheduler : str, optional
        Its address, such as `tcp://host:8786`.
    say : function of a line
        Called with where to watch them.

    Raises
    ------
    ConfigError
        There is no Dask, or no scheduler.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise ConfigError(EXTRA) from None
    with contextlib.ExitStack() as stack:
        where = scheduler or stack.enter_context(
            LocalCluster(n_workers=jobs or n_cores(), threads_per_worker=1, dashboard_address=":0")
        )
        try:
            client = stack.enter_context(Client(where, timeout=TIMEOUT))
        except (OSError, ValueError) as error:
            raise ConfigError(f"--scheduler {scheduler}: no scheduler answers there") from error
        say(f"dashboard: {client.dashboard_link}")
        yield Workers(client)
