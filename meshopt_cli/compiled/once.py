"""Things that a process makes once, whichever of its threads asks first."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def once(make: Callable[[], T]) -> Callable[[], T]:
    """Call a function the first time, and hand out what it returned after that.

    `functools.cache` holds no lock while it calls: threads that come meanwhile call it again.
    """
    lock = threading.Lock()
    made: list[T] = []

    @functools.wraps(make)
    def kept() -> T:
        if not made:
            with lock:
                if not made:
                    made.append(make())
        return made[0]

    return kept
