"""An observer that tells a function how far the run is, and ends it on demand."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .observer import Stage

if TYPE_CHECKING:
    from ..work.standing import Standing

OFTEN = 0.5  # seconds after which it is told anew, in the midst of a pass


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    stage : str
        "reading", "checking", "optimizing", "comparing" or "writing".
    step : str
        The pass at work; empty outside of passes.
    round : int
        The last one of which a pass is through, 0 before that.
    share : float
        What part of the sweep of the pass is done, from 0 to 1.
    worst : float
        Q of the worst cell when the last pass ended; NaN before that is known, infinite where a
        cell is flat or inverted.
    seconds : float
        Since the run began.
    left : float
        Seconds until the sweep ends if it goes on like this; NaN where nothing tells.
    cancel : function
        Ends the run with the best mesh so far; its reason is "cancelled" then.
    """

    stage: str
    step: str
    round: int
    share: float
    worst: float
    seconds: float
    left: float
    cancel: Callable[[], None]


Told = Callable[[Progress], object]


class Watch:
    """Tells of every stage and pass as they begin and end, and every so many seconds between.

    Parameters
    ----------
    told : function of a `Progress`
    often : float
        Seconds.
    """

    def __init__(self, told: Told, often: float = OFTEN) -> None:
        self.is_cancelled = False
        self._told = told
        self._often = often
        self._start = self._last = self._since = time.monotonic()
        self._stage, self._step = "", ""
        self._round = self._done = self._total = 0
        self._worst = math.nan

    def cancel(self) -> None:
        """End the run at the next step, with the best mesh so far."""
        self.is_cancelled = True

    def keep_best(self) -> bool:
        """Cancel the run if there is a mesh to keep, and nobody has done so; whether it is so."""
        if self.is_cancelled or self._stage in (Stage.READ, Stage.CHECK):
            return False
        self.cancel()
        return True

    def entered(self, stage: Stage) -> None:
        self._stage, self._step = stage.value, ""
        self._done = self._total = 0
        self._tell()

    def started(self, name: str, total: int) -> None:
        self._step, self._done, self._total = name, 0, total
        self._since = time.monotonic()
        self._tell_at_times()

    def advanced(self, by: int) -> None:
        self._done += by
        self._tell_at_times()

    def stood(self, standing: Standing, round: int = 0) -> None:
        self._worst = 1.0 / standing.worst if standing.worst > 0.0 else math.inf
        self._round = round or self._round
        self._done = self._total = max(self._total, 1)
        self._tell()

    def _tell_at_times(self) -> None:
        if time.monotonic() - self._last >= self._often:
            self._tell()

    def _tell(self) -> None:
        now = self._last = time.monotonic()
        share = self._done / self._total if self._total else 0.0
        left = (now - self._since) * (1.0 / share - 1.0) if share else math.nan
        self._told(
            Progress(
                self._stage, self._step, self._round, share, self._worst, now - self._start, left,
                self.cancel,
            )
        )  # fmt: skip
