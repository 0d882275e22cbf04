"""The best mesh of a run."""

from __future__ import annotations

from ..work.session import Workspace
from ..work.standing import Standing


class Guard:
    """Remembers the best state of a run, so that it can be gone back to."""

    def __init__(self, work: Workspace) -> None:
        self.best = work.standing()
        self._kept = work.copy()

    def note(self, work: Workspace) -> Standing:
        """Keep the present state unless it is worse than the best; returns how good it is."""
        now = work.standing()
        if not self.best.is_better_than(now):
            self.best = now
            del self._kept  # never both of them at once
            self._kept = work.copy()
        return now

    def better_of(self, work: Workspace) -> Workspace:
        """The present state, or the best one if that is better."""
        return self._kept if self.best.is_better_than(work.standing()) else work
