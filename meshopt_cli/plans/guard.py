"""The best mesh of some rounds."""

from __future__ import annotations

from ..passes import Work
from ..work.standing import Standing

# A worst q within this part of the best one counts as that: 1e-4 and 5e-3 behave alike.
LIKE = 1e-3


class Guard:
    """Remembers the best state to go on from, so that it can be gone back to.

    The worst q decides; of those within `LIKE` of the best that was seen, what passes have left
    to do by aims of their own, and then what all cells are worth (`Standing.cost`). Where the
    boundary holds the worst cell, much that is good for the others would else be given up for a
    worst q that hardly differs, or for a mean at the expense of which bad cells got better.
    Where edges are fitted to a metric, what they lack decides.
    """

    def __init__(self, work: Work) -> None:
        self.best = work.standing()
        self._worst = self.best.worst  # the best that was seen
        self._kept: Work | None = None  # without it the present state is the best

    def keep(self, work: Work) -> None:
        """Before the state changes: keep a copy if it is the best."""
        if self._kept is None:
            self._kept = work.copy()

    def note(self, work: Work) -> Standing:
        """Take the present state for the best unless it is worse; returns how good it is."""
        now = work.standing()
        self._worst = max(self._worst, now.worst)
        if not self._prefers_best_to(now):
            self.best = now
            self._kept = None
        return now

    def better_of(self, work: Work) -> Work:
        """The present state, or the best one if that is better."""
        if self._kept is None or not self._prefers_best_to(work.standing()):
            return work
        return self._kept

    def _prefers_best_to(self, now: Standing) -> bool:
        if self._worst <= 0.0:
            return self.best.is_better_than(now)
        if self.best.lack != now.lack and now.worst > 0.0:
            return self.best.lack < now.lack
        near = (1.0 - LIKE) * self._worst
        if now.worst < near or self.best.worst < near:
            return self.best.worst > now.worst
        if self.best.left != now.left:
            return self.best.left < now.left
        return self.best.cost < now.cost - 1e-9
