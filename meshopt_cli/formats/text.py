"""Rows of numbers as lines of text, and back, at the speed of numpy.

meshio formats one row at a time, and reads numbers through C's streams, which takes integers
four times as long as from memory.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np

from ..mesh.model import Array
from .sniff import UnreadableError

_CHUNK = 1 << 16  # rows at a time, which bounds the memory it takes


def lines(*columns: Array) -> Iterator[bytes]:
    """Rows as text: numbers with a blank between them, and a line break after each row.

    Parameters
    ----------
    columns : (n,) or (n, k) arrays of integers or reals
        Side by side they make the rows. Reals have as many digits as bring them back exactly.

    Yields
    ------
    Some thousands of lines at a time.
    """
    tables = [column if column.ndim == 2 else column[:, None] for column in columns]
    for start in range(0, len(tables[0]), _CHUNK):
        part = [table[start : start + _CHUNK] for table in tables]
        if all(table.dtype.kind in "iu" for table in part):
            yield _integers(np.column_stack(part))
        else:
            yield _numbers(part)


def numbers(text: bytes, kind: type[np.generic]) -> Array:
    """All the numbers in a text, int64 or float64.

    Raises
    ------
    UnreadableError
        There is something else in it.
    """
    try:
        with warnings.catch_warnings():
            # numpy stops at what it cannot read, and only warns
            warnings.simplefilter("error", DeprecationWarning)
            return np.fromstring(text, kind, sep=" ") if text.strip() else np.empty(0, kind)
    except (DeprecationWarning, ValueError):
        raise UnreadableError("a number was expected, and something else found") from None


def rows_of(name: str, text: bytes, count: int, kinds: type[np.generic], width: int) -> Array:
    """The rows of a section, (count, width).

    Raises
    ------
    UnreadableError
        There are fewer or more of them.
    """
    found = numbers(text, kinds)
    if len(found) != count * width:
        raise UnreadableError(
            f"truncated or malformed: {name} has {len(found)} numbers, and not {count} x {width}"
        )
    return found.reshape(count, width)


def _numbers(part: list[Array]) -> bytes:
    """Rows in which some numbers are real."""
    # a float32 has fewer digits than the float64 that would hold it
    exact = [table.astype(str) if table.dtype == np.float32 else table for table in part]
    row = " ".join(["%s"] * sum(table.shape[1] for table in exact)) + "\n"
    values: Iterable[float]
    if len(exact) == 1:
        values = exact[0].ravel().tolist()
    else:
        columns = [column for table in exact for column in table.T.tolist()]
        values = chain.from_iterable(zip(*columns, strict=True))
    return (row * len(part[0]) % tuple(values)).encode()


def _integers(rows: Array) -> bytes:
    """Rows of integers: all their digits are found at once, one place after another."""
    n, width = rows.shape
    flat = rows.ravel()
    negative = flat < 0
    size = np.abs(flat)
    greatest = int(size.max(initial=0))
    rest = size.astype(np.uint32 if greatest < 2**32 else np.uint64)
    places = len(str(greatest))
    # a sign, the digits and what follows the number
    letters = np.empty((len(flat), places + 2), np.uint8)
    wanted = np.empty(letters.shape, bool)
    for place in range(places, 0, -1):
        wanted[:, place] = rest > 0
        tens = rest // 10
        letters[:, place] = rest - 10 * tens + ord("0")
        rest = tens
    wanted[:, places] = True  # of a 0 too
    wanted[:, places + 1] = True
    letters[:, places + 1] = ord(" ")
    letters[:, places + 1].reshape(n, width)[:, -1] = ord("\n")
    wanted[:, 0] = False
    if negative.any():
        # the sign stands right before the first digit
        first = wanted.argmax(axis=1) - 1
        letters[negative, first[negative]] = ord("-")
        wanted[negative, first[negative]] = True
    return letters[wanted].tobytes()
