"""Sets of items that pairs link."""

from __future__ import annotations

import numpy as np

from ...compiled.decorators import entry, inlined


@inlined
def root_of(parent: np.ndarray, item: int) -> int:
    """The representative of the set of an item; shortens the way there."""
    while parent[item] != item:
        parent[item] = parent[parent[item]]
        item = parent[item]
    return item


@entry(group="check", example=lambda work: (work.order, work.order, work.order))
def unite(parent: np.ndarray, one: np.ndarray, other: np.ndarray) -> None:
    """Join the sets of the items of each pair, and let every item know its representative.

    Parameters
    ----------
    parent : (n,) int64
        Each item its own, at first; at the end the least item of its set.
    one, other : (m,) int64
    """
    for k in range(len(one)):
        a, b = root_of(parent, one[k]), root_of(parent, other[k])
        if a < b:
            parent[b] = a
        else:
            parent[a] = b
    for item in range(len(parent)):
        parent[item] = root_of(parent, item)
