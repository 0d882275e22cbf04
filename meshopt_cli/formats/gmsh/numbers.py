"""The numbers of a section of a Gmsh file, in text or in binary of either order of bytes."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ...mesh.model import Array
from ..sniff import GmshHeader, UnreadableError
from ..text import numbers

# What a number is: an integer of 4 bytes, a count or number of an entity's part of 4 or 8 bytes
# (in version 4), or a real.
INTEGER, COUNT, REAL = "i", "c", "f"

Columns = Sequence[tuple[str, int]]

_FIRST_STEP = 64  # rows that are compared at once, at first


class TruncatedError(UnreadableError):
    """There is less in a section than it announces."""


class Numbers:
    """The numbers of a section, taken one after another.

    Every count in a file is compared with what is left of the section, before it is believed.

    Parameters
    ----------
    name : str
        Of the section, for messages.
    content : bytes
        What stands between its first and its last line.
    header : GmshHeader
    real : bool
        Whether there are reals among the numbers of a text: integers are then read as reals too,
        which is exact to 2^53, and much slower.
    """

    def __init__(self, name: str, content: bytes, header: GmshHeader, real: bool = True) -> None:
        self.name, self._text, self._at = name, header.text, 0
        if header.text:
            try:
                self._flat = numbers(content, np.float64 if real else np.int64)
            except UnreadableError as error:
                raise UnreadableError(f"in the section ${name}, {error}") from None
            if not len(self._flat):
                raise TruncatedError(f"the section ${name} is empty")
        else:
            self._flat = np.frombuffer(content, np.uint8)
        wide = header.size if header.version >= 4 else 4
        kinds = {INTEGER: "i4", COUNT: f"i{wide}", REAL: "f8"}
        self._kinds = {kind: np.dtype(header.order + stored) for kind, stored in kinds.items()}

    def _widths(self, columns: Columns) -> list[int]:
        """Numbers of a text, or bytes, of each column."""
        if self._text:
            return [width for _, width in columns]
        return [width * self._kinds[kind].itemsize for kind, width in columns]

    def left(self) -> int:
        """How many numbers of a text are left, or bytes."""
        return len(self._flat) - self._at

    def rows(self, count: int, *columns: tuple[str, int]) -> list[Array]:
        """Take a table.

        Parameters
        ----------
        count : int
        columns : (kind, width) tuples
            What stands side by side in a row.

        Returns
        -------
        list of (count, width) int64 or float64 arrays

        Raises
        ------
        TruncatedError
            There is less in the section.
        """
        widths = self._widths(columns)
        size = sum(widths)
        if not 0 <= count * size <= self.left():
            width = sum(w for _, w in columns)
            raise self.truncated(
                f"{count} rows of {width} numbers" if count != 1 else f"{width} numbers"
            )
        start = self._at
        self._at += count * size
        if self._text:
            table = self._flat[start : self._at].reshape(count, size)
            parts = np.split(table, np.cumsum(widths)[:-1], axis=1)
        else:
            fields = [(f"f{i}", self._kinds[k], (w,)) for i, (k, w) in enumerate(columns)]
            records = np.ndarray(count, np.dtype(fields), self._flat.data, start)
            parts = [records[name] for name, *_ in fields]
        given = zip(parts, columns, strict=True)
        return [_real(part) if kind == REAL else self._whole(part) for part, (kind, _) in given]

    def run(self, most: int, columns: Columns, keys: tuple[int, ...]) -> list[Array]:
        """Take the rows at the beginning that are alike, one at least, as `rows` gives them.

        Parameters
        ----------
        most : int
            So many at the most.
        keys : tuple of int
            The columns in which all have the same numbers as the first.
        """
        widths = self._widths(columns)
        size, ends = sum(widths), np.cumsum(widths).tolist()
        most = min(most, self.left() // size)
        if most < 1:
            raise self.truncated(f"one row more of {sum(w for _, w in columns)} numbers")
        table = self._flat[self._at : self._at + most * size].reshape(most, size)
        n, step = 1, _FIRST_STEP
        while n < most:
            part = table[n : n + step]
            same = np.ones(len(part), bool)
            for key in keys:
                span = slice(ends[key] - widths[key], ends[key])
                same &= (part[:, span] == table[0, span]).all(axis=1)
            if not same.all():
                n += int(same.argmin())
                break
            n, step = n + len(part), 2 * step
        return self.rows(n, *columns)

    def peek(self, *columns: tuple[str, int]) -> list[list[int]]:
        """The integers of the row that comes next, without taking it."""
        here = self._at
        try:
            return [row[0].tolist() for row in self.rows(1, *columns)]
        finally:
            self._at = here

    def integers(self) -> Array:
        """All that is left, of integers only, without taking it."""
        if self._text:
            return self._flat[self._at :]
        kind = self._kinds[INTEGER]
        return np.ndarray(self.left() // kind.itemsize, kind, self._flat.data, self._at)

    def skip(self, count: int) -> None:
        """Pass over some integers."""
        self._at += count if self._text else count * self._kinds[INTEGER].itemsize

    def line_count(self) -> int:
        """Take the count that stands on a line of text, in binary too."""
        if self._text:
            return self.one(INTEGER)
        line = re.match(rb"\s*(\d+)[ \t]*\r?\n", self._flat[self._at : self._at + 32].tobytes())
        if not line:
            raise UnreadableError(f"in the section ${self.name}, a count was expected")
        self._at += line.end()
        return int(line[1])

    def take(self, kind: str, count: int) -> Array:
        """Take some numbers of one kind, (count,)."""
        return self.rows(1, (kind, count))[0][0]

    def one(self, kind: str = COUNT) -> int:
        """Take an integer."""
        return int(self.take(kind, 1)[0])

    def some(self, kind: str) -> list[int]:
        """Take a count, and then so many integers."""
        return self.take(kind, self.one()).tolist()

    def truncated(self, wanted: str) -> TruncatedError:
        """The error that says what is missing."""
        return TruncatedError(
            f"the section ${self.name} is truncated or malformed: it announces {wanted} "
            f"where {self.left()} {'numbers' if self._text else 'bytes'} are left"
        )

    def _whole(self, values: Array) -> Array:
        if values.dtype.kind != "f":
            return values.astype(np.int64, copy=False)
        with np.errstate(invalid="ignore"):
            whole = values.astype(np.int64)
        if not np.array_equal(whole, values):
            raise UnreadableError(f"in the section ${self.name}, a whole number was expected")
        return whole


def _real(values: Array) -> Array:
    return values.astype(np.float64, copy=False)
