"""How much is tried."""

from __future__ import annotations

from hypothesis import settings


def examples(n: int) -> settings:
    """Try n examples, however long the first one takes: it may have to compile."""
    return settings(max_examples=n, deadline=None)
