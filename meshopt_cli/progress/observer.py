"""Who watches a run, and how it is ended before its time."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:  # it imports numpy
    from ..work.standing import Standing


class Stage(enum.StrEnum):
    """What a run is at, in words."""

    READ = "reading"
    CHECK = "checking"
    WORK = "optimizing"
    PROVE = "comparing"
    WRITE = "writing"


class StoppedError(Exception):
    """Raised between two steps of a pass; the mesh is whole."""


class OutOfTimeError(StoppedError):
    """There is no time left."""


class CancelledError(StoppedError):
    """Whoever watches has seen enough."""


class Observer(Protocol):
    """Somebody who watches passes at work, such as a progress bar."""

    def entered(self, stage: Stage) -> None:
        """A stage of the run begins."""

    def started(self, name: str, total: int) -> None:
        """A sweep of this pass over so many entities begins."""

    def advanced(self, by: int) -> None:
        """So many more were visited. The mesh is whole here, should an interrupt come."""

    def stood(self, standing: Standing, round: int = 0) -> None:
        """How the mesh stands: before the first pass, and after each of a round."""

    @property
    def is_cancelled(self) -> bool:
        """Whether the run is to end here, with the best mesh so far. Often asked."""


class Silent:
    """The observer that does nothing."""

    is_cancelled = False

    def entered(self, stage: Stage) -> None:
        pass

    def started(self, name: str, total: int) -> None:
        pass

    def advanced(self, by: int) -> None:
        pass

    def stood(self, standing: Standing, round: int = 0) -> None:
        pass


SILENT = Silent()
