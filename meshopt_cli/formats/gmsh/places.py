"""Where a number that a file gives to nodes or elements stands among them."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...mesh.model import Array


class Places:
    """The numbers of nodes or of elements, in the order of a mesh.

    Parameters
    ----------
    numbers : (n,) int64
        In any order, with gaps.
    """

    def __init__(self, numbers: Array) -> None:
        self.numbers = numbers
        n = len(numbers)
        self._first = int(numbers[0]) if n else 1
        self._runs = bool(np.array_equal(numbers, np.arange(self._first, self._first + n)))

    @property
    def count_on(self) -> bool:
        """Whether the numbers count on from 1."""
        return self._runs and self._first == 1

    @cached_property
    def _order(self) -> Array:
        return np.argsort(self.numbers, kind="stable")

    def of(self, wanted: Array) -> Array:
        """Where wanted numbers stand, int64 in the same shape, out of range if they do not."""
        n = len(self.numbers)
        if self._runs:
            return wanted - self._first
        at = np.searchsorted(self.numbers, wanted, sorter=self._order)
        at = self._order[np.minimum(at, n - 1)]
        return np.where(self.numbers[at] == wanted, at, -1)

    def there(self, wanted: Array) -> tuple[Array, Array]:
        """Where wanted numbers stand, and which of them do; the others are -1."""
        at = self.of(wanted)
        inside = (at >= 0) & (at < len(self.numbers))
        return np.where(inside, at, -1), inside
