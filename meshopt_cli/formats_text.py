"""Numbers to and from text, at the speed of C and without losing a bit."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from itertools import chain
from typing import BinaryIO

import numpy as np

from .mesh import Array

CHUNK = 1 << 16


class UnreadableError(ValueError):
    """What a file holds cannot be read, for a reason that the user can be told."""


def numbers(text: bytes, dtype: type) -> Array:
    """Parse numbers parted by blanks or line ends.

    Parameters
    ----------
    text : bytes
        Nothing but numbers; it may be empty.
    dtype : type
        int or float.

    Raises
    ------
    UnreadableError
        Something in the text is not a number of that type.
    """
    if not text or text.isspace():
        return np.empty(0, dtype=dtype)  # numpy makes one number of blanks
    with warnings.catch_warnings():
        # numpy stops at what it cannot read, and only warns
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except (DeprecationWarning, ValueError):
            raise UnreadableError("a number was expected, and something else found") from None


def write_rows(stream: BinaryIO, row: str, columns: Iterable[Array]) -> None:
    """Write one line a row from columns of equal length.

    Parameters
    ----------
    stream : binary file
    row : str
        The line, with a `%d` for each column of integers and a `%r` for each of
        reals: `repr` is the shortest text that reads back as the same bits.
    columns : iterable of (n,) array
    """
    columns = list(columns)
    n = len(columns[0])
    for start in range(0, n, CHUNK):
        parts = [column[start : start + CHUNK].tolist() for column in columns]
        values = tuple(chain.from_iterable(zip(*parts, strict=True)))
        stream.write((row * len(parts[0]) % values).encode())
