"""The words, lines and arrays of a file of VTK without XML, one after another."""

from __future__ import annotations

import re
from itertools import islice
from urllib.parse import unquote

import numpy as np

from ...mesh.model import Array
from ..sniff import UnreadableError
from ..text import numbers

# VTK's names of numbers. A vtkIdType has 32 bits in binary files, and 64 in memory.
_ID = "vtkidtype"
NUMBERS = {
    "char": "i1", "signed_char": "i1", "unsigned_char": "u1", "short": "i2",
    "unsigned_short": "u2", "int": "i4", "unsigned_int": "u4", "long": "i8",
    "unsigned_long": "u8", "long_long": "i8", "unsigned_long_long": "u8", "__int64": "i8",
    "unsigned___int64": "u8", _ID: "i4", "float": "f4", "double": "f8",
    **{f"vtktypeint{8 * n}": f"i{n}" for n in (1, 2, 4, 8)},
    **{f"vtktypeuint{8 * n}": f"u{n}" for n in (1, 2, 4, 8)},
    "vtktypefloat32": "f4", "vtktypefloat64": "f8",
}  # fmt: skip
BIT = "bit"
STRINGS = ("string", "utf8_string", "unicode_string", "variant")

_WORD = re.compile(rb"\s*(\S+)")
_BARE = re.compile(rb"\S+")
# What people write into files by hand: after a sign that stands alone, for names may have it.
_COMMENT = re.compile(rb"#(?!\S)[^\n]*")
_CHUNK = 1 << 21  # bytes at a time, which bounds the memory it takes


class Cursor:
    """A place in a file, from which it is read on.

    Parameters
    ----------
    data : bytes
        The whole file.
    at : int
        Where its header ends.
    binary : bool
        Arrays are binary, in big-endian order; all else is text.
    """

    def __init__(self, data: bytes, at: int, binary: bool):
        if not binary and data.find(b"#", at) >= 0:
            data = data[:at] + _COMMENT.sub(_blank, data[at:])
        self.data = data
        self.at = at
        self.binary = binary
        self.letters = None if binary else _words(data)

    @property
    def place(self) -> str:
        """Where that is, for messages: "line 12", or "byte 345"."""
        if self.binary:
            return f"byte {self.at}"
        breaks = self.data.count(b"\n", 0, self.at)
        return f"line {breaks + 1}"

    def refuse(self, reason: str) -> UnreadableError:
        """An error that says where it is."""
        return UnreadableError(f"{reason} at {self.place}")

    def word(self) -> str:
        """The next word, past blank lines; "" at the end of the file."""
        found = _WORD.match(self.data, self.at)
        if not found:
            self.at = len(self.data)
            return ""
        self.at = found.end()
        return found[1].decode("latin-1")

    def line(self) -> list[str]:
        """The words in the rest of the line, and past it."""
        end = self.data.find(b"\n", self.at)
        end = len(self.data) if end < 0 else end
        words = self.data[self.at : end].decode("latin-1").split()
        self.at = min(end + 1, len(self.data))
        return words

    def take(self, pattern: re.Pattern[bytes]) -> re.Match[bytes] | None:
        """Go past something, blanks before it included, if it is next."""
        found = pattern.match(self.data, self.at)
        if found:
            self.at = found.end()
        return found

    def past_block(self) -> None:
        """Go past lines up to an empty one, as those of METADATA are."""
        self.line()
        while self.at < len(self.data) and self.line():
            pass

    def array(self, what: str, kind: str, n: int) -> Array | None:
        """Read the next numbers, which start on a new line.

        Parameters
        ----------
        what : str
            What messages call them.
        kind : str
            VTK's name of their type.
        n : int
            How many they are.

        Returns
        -------
        (n,) array, or None for strings

        Raises
        ------
        UnreadableError
            They are not all there, or of an unknown type.
        """
        known = kind.lower()
        if n < 0:
            raise self.refuse(f"{what} cannot have {n} values")
        if known in STRINGS:
            self._past_strings(what, n)
            return None
        if known != BIT and known not in NUMBERS:
            raise self.refuse(f"{what} has values of the unknown type {kind!r}")
        if not self.binary:
            return self._text(what, known, n)
        dtype = np.dtype(">" + NUMBERS.get(known, "u1"))
        packed = self._bytes(what, (n + 7) // 8 if known == BIT else n * dtype.itemsize)
        values = np.frombuffer(packed, dtype)
        if known == BIT:
            return np.unpackbits(values)[:n]
        return values.astype(np.int64) if known == _ID else values

    def _bytes(self, what: str, size: int) -> memoryview:
        if self.at + size > len(self.data):
            there = len(self.data) - self.at
            raise self.refuse(f"truncated: {what} has {there} bytes of {size}")
        self.at += size
        return memoryview(self.data)[self.at - size : self.at]

    def _text(self, what: str, kind: str, n: int) -> Array:
        wanted = np.dtype(NUMBERS.get(kind, "u1"))
        wide = np.int64 if wanted.kind == "i" or wanted.itemsize < 8 else np.uint64
        values = self._numbers(what, np.float64 if wanted.kind == "f" else wide, n)
        if kind == _ID:
            return values
        narrow = values.astype(wanted)
        return narrow if wanted.kind == "f" or np.array_equal(narrow, values) else values

    def _numbers(self, what: str, kind: type[np.generic], n: int) -> Array:
        """The next n numbers of a text: they mostly end where the next word starts."""
        assert self.letters is not None
        after = np.searchsorted(self.letters, self.at)
        end = int(self.letters[after]) if after < len(self.letters) else len(self.data)
        text = self._trimmed(end)
        try:
            values = _parsed(text, kind)
        except UnreadableError:
            values = None
        if values is None or len(values) > n:  # a name may start with a digit
            end = self._past_words(n)
            values = self._parsed_at(what, self.data[self.at : end], kind)
        self.at = end
        if len(values) < n:
            there = f"{what} has {len(values)} numbers of {n}"
            word = self.word()[:40]
            raise self.refuse(f"{there}, and then {word!r}" if word else f"truncated: {there}")
        return values

    def _trimmed(self, end: int) -> bytes:
        """The text up to some place, without the blanks around it, of which no copy is made."""
        at = self.at
        while at < end and self.data[at] <= ord(" "):
            at += 1
        while end > at and self.data[end - 1] <= ord(" "):
            end -= 1
        return self.data[at:end]

    def _parsed_at(self, what: str, text: bytes, kind: type[np.generic]) -> Array:
        try:
            return _parsed(text, kind)
        except UnreadableError:
            for word in _BARE.finditer(text):
                try:
                    _parsed(word[0], kind)
                except UnreadableError:
                    self.at += word.start()
                    found = word[0][:40].decode("latin-1")
                    raise self.refuse(f"a number of {what} was expected, not {found!r}") from None
            raise

    def _past_words(self, n: int) -> int:
        """Where the next n words end."""
        end = self.at
        for found in islice(_BARE.finditer(self.data, self.at), n):
            end = found.end()
        return end

    def _past_strings(self, what: str, n: int) -> None:
        for i in range(n):
            if self.at >= len(self.data):
                raise self.refuse(f"truncated: {what} has {i} strings of {n}")
            if self.binary:
                self._bytes(what, self._length(what))
            else:
                self.line()

    def _length(self, what: str) -> int:
        """Of a string: two bits say how many bytes the others are in."""
        size = {3: 1, 2: 2, 1: 4, 0: 8}[self.data[self.at] >> 6]
        coded = int.from_bytes(self._bytes(what, size), "big")
        return coded & ((1 << (8 * size - 2)) - 1)


def _blank(comment: re.Match[bytes]) -> bytes:
    """Blanks for a comment, so that all else stays in its place."""
    alone = comment.string[comment.start() - 1 : comment.start()].isspace()
    return b" " * len(comment[0]) if alone else comment[0]


def name_of(word: str) -> str:
    """A name, whose blanks and signs are written as "%20"."""
    return unquote(word)


def _parsed(text: bytes, kind: type[np.generic]) -> Array:
    """Numbers of a text; integers may be written as 1.0 too."""
    try:
        return numbers(text, kind)
    except UnreadableError:
        if kind is np.float64:
            raise
    values = numbers(text, np.float64)
    if not (np.abs(values) < 2.0**63).all() or (values != np.trunc(values)).any():
        raise UnreadableError("a whole number was expected")
    return values.astype(kind)


def _words(data: bytes) -> Array:
    """Where words of a text start that are no numbers."""
    letters = np.frombuffer(data, np.uint8)
    found = []
    for start in range(0, len(letters), _CHUNK):
        part = letters[start : start + _CHUNK]
        before = letters[max(start - 1, 0) : start + len(part) - 1]
        is_letter = (part | 32) - ord("a") < 26
        is_letter[len(part) - len(before) :] &= before <= ord(" ")
        found.append(np.flatnonzero(is_letter) + start)
    at = np.concatenate([np.empty(0, np.int64), *found])
    ends = [np.minimum(at + i, len(data) - 1) for i in range(3)]
    first = [(letters[end] | 32) for end in ends]
    odd = np.zeros(len(at), bool)
    for word in (b"nan", b"inf"):
        odd |= np.logical_and.reduce([first[i] == word[i] for i in range(3)])
    return at[~odd]
