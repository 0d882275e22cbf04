"""Elements of version 2 that differ from one to the next in the number of their tags.

So they do where cells at the rim of a partition have a tag for each neighbour. Rows of unequal
length are found one by one, and taken all at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...mesh.model import Array
from ..sniff import GmshHeader
from .numbers import Numbers
from .types import Element, element_of

SHORT = 16  # rows that are alike: from so few on, those that follow are taken as mixed ones
_MOST = 1 << 16  # rows at a time, which bounds the memory it takes
_N_TAGS = 4  # group, entity, number of partitions, partition


class MixedRows(NamedTuple):
    """Elements of one type that follow each other.

    Attributes
    ----------
    element : Element
    numbers : (n,) int64
    nodes : (n, k) int64
    counts : (n,) int64
        How many tags each has.
    tags : (n, 4) int64
        The first of them, 0 where there are fewer.
    """

    element: Element
    numbers: Array
    nodes: Array
    counts: Array
    tags: Array


def take_mixed(numbers: Numbers, most: int, header: GmshHeader) -> Iterator[MixedRows]:
    """Take the elements that come next, up to one that cannot be read so."""
    found = numbers.integers()
    lead = 3 if header.text else 4  # what comes before the tags
    starts, codes, counts = _walked(found, min(most, _MOST), header.text, lead)
    numbers.skip(int(starts[-1]))
    starts = starts[:-1]
    ends = [0, *(np.flatnonzero(np.diff(codes)) + 1).tolist(), len(codes)] if len(codes) else []
    for first, last in pairwise(ends):
        element = element_of(int(codes[first]))
        assert element is not None  # as it was walked over
        at, n_tags = starts[first:last], counts[first:last]
        places = (at + lead)[:, None] + np.arange(_N_TAGS)
        tags = found[np.minimum(places, len(found) - 1)].astype(np.int64)
        tags[np.arange(_N_TAGS) >= n_tags[:, None]] = 0
        nodes = found[(at + lead + n_tags)[:, None] + np.arange(element.n_nodes)]
        labels = found[at if header.text else at + lead - 1].astype(np.int64)
        yield MixedRows(element, labels, nodes.astype(np.int64), n_tags, tags)


def _walked(found: Array, most: int, text: bool, lead: int) -> tuple[Array, Array, Array]:
    """Where each row starts, and where the last one ends; types and numbers of tags."""
    starts, codes, counts = [0], list[int](), list[int]()
    while len(codes) < most:
        at = starts[-1]
        head = found[at : at + 3].tolist()
        if len(head) < 3 or not (text or head[1] == 1):
            break
        code, n_tags = (head[1], head[2]) if text else (head[0], head[2])
        element = element_of(code)
        if element is None or not element.n_nodes or n_tags < 0:
            break
        end = at + lead + n_tags + element.n_nodes
        if end > len(found):
            break
        starts.append(end)
        codes.append(code)
        counts.append(n_tags)
    return np.array(starts), np.array(codes, np.int64), np.array(counts, np.int64)
