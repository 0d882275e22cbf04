"""When rounds end, and why."""

from __future__ import annotations

from dataclasses import dataclass

from ..work.standing import Standing

# Why a run ended.
DONE = "done"
NOTHING_TO_GAIN = "nothing to gain"
NO_CHANGE = "no change"
GAIN_BELOW = "gain below"
TARGET_REACHED = "target quality"
ROUNDS_DONE = "rounds"
TIME_IS_UP = "time limit"
CANCELLED = "cancelled"
TANGLED = "tangled"


@dataclass(frozen=True)
class Stop:
    """When rounds end.

    Attributes
    ----------
    rounds : int
        At most so many rounds.
    gain : float
        End when a round lowers neither the worst Q, nor the mean Q, nor the mean Q of the
        worst hundredth of the cells, nor what passes have left to do by this part of it.
    target_quality : float
        End when the worst Q is at most this; 1 never ends.
    """

    rounds: int = 10
    gain: float = 1e-3
    target_quality: float = 1.0

    def at_first(self, standing: Standing) -> str:
        """Why rounds do not even begin; empty where they do."""
        return TARGET_REACHED if self._is_target(standing) else ""

    def reason(self, round: int, changed: bool, before: Standing, after: Standing) -> str:
        """Why rounds end after this one; empty while they go on."""
        if not changed:
            return NO_CHANGE
        if self._is_target(after):
            return TARGET_REACHED
        if gain(before, after) < self.gain:
            return GAIN_BELOW
        return ROUNDS_DONE if round >= self.rounds else ""

    def _is_target(self, standing: Standing) -> bool:
        return self.target_quality > 1.0 and standing.worst * self.target_quality >= 1.0


def gain(before: Standing, after: Standing) -> float:
    """The largest of what the worst Q, the mean Q, its tail and what is left to do lost.

    Each as a part of itself. Where edges are fitted to a metric, what they lack counts alone.
    """
    if after.worst <= 0.0 or before.worst <= 0.0:
        return float("inf") if after.worst > before.worst else 0.0
    if before.lack or after.lack:
        return 1.0 - after.lack / before.lack if before.lack else 0.0
    return max(
        1.0 - before.worst / after.worst,
        1.0 - after.mean / before.mean,
        1.0 - after.tail / before.tail,
        (before.left - after.left) / max(before.left, 1),
    )
