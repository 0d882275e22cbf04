"""Which of some changes are made at once, those that have nothing in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

Array = np.ndarray


def apart(changes: Iterable[int], touched: Callable[[int], Array], n: int) -> Array:
    """Those of some changes that touch nothing which one before them does, in their order.

    Parameters
    ----------
    touched : function of a change
        Gives what it touches, out of [0, n).
    """
    taken = np.zeros(n, dtype=bool)
    chosen = []
    for change in changes:
        those = touched(change)
        if not taken[those].any():
            taken[those] = True
            chosen.append(change)
    return np.array(chosen, dtype=np.int64)
