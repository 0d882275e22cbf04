"""Where keys stand in a text of TOML, for what is said of one that is wrong.

It takes for granted that the text is TOML: `tomllib` read it, and does not tell where.
"""

from __future__ import annotations

import re

from .keys import Place

_KEY = re.compile(r"[A-Za-z0-9_-]+|\"(?:[^\"\\]|\\.)*\"|'[^']*'")
_TEXT = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|' + r"'''.*?'{3,5}|" + r'"(?:[^"\\]|\\.)*"|' + r"'[^']*'", re.DOTALL
)
_OTHER = re.compile(r"[^,\]}\s#]+")
_BLANK = re.compile(r"(?:\s|#[^\n]*)*")


def line_of(text: str, place: Place) -> int:
    """The line of a key or a row of a list, from 1; that of what holds it where it is not found."""
    found = _Scan(text).starts
    for n in range(len(place), 0, -1):
        if place[:n] in found:
            return text.count("\n", 0, found[place[:n]]) + 1
    return 1


class _Scan:
    """Where everything in a text begins."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self.starts: dict[Place, int] = {}
        self._rows: dict[Place, int] = {}  # how many tables a list of tables has so far
        self._lists: set[Place] = set()
        self._read()

    def _skip(self) -> None:
        found = _BLANK.match(self._text, self._at)
        assert found is not None
        self._at = found.end()

    def _next(self) -> str:
        return self._text[self._at : self._at + 1]

    def _read(self) -> None:
        base: Place = ()
        self._skip()
        while self._next():
            if self._next() == "[":
                base = self._header()
            else:
                self._pair(base)
            self._skip()

    def _header(self) -> Place:
        """A table, or a row of a list of tables."""
        start, is_list = self._at, self._text.startswith("[[", self._at)
        self._at += 2 if is_list else 1
        place: Place = ()
        names = self._keys()
        self._at += 2 if is_list else 1
        for i, name in enumerate(names):
            place = (*place, name)
            self.starts.setdefault(place, start)
            if i == len(names) - 1 and is_list:
                self._lists.add(place)
                self._rows[place] = self._rows.get(place, -1) + 1
            if place in self._lists:
                place = (*place, self._rows[place])
                self.starts.setdefault(place, start)
        return place

    def _keys(self) -> list[str]:
        """The keys of a dotted key."""
        names: list[str] = []
        while True:
            self._skip()
            found = _KEY.match(self._text, self._at)
            if found is None:
                return names
            self._at = found.end()
            names.append(_bare(found[0]))
            self._skip()
            if self._next() != ".":
                return names
            self._at += 1

    def _pair(self, base: Place) -> None:
        """A key and its value."""
        start = self._at
        place = base
        for name in self._keys():
            place = (*place, name)
            self.starts.setdefault(place, start)
        self._at += 1  # the =
        self._value(place)

    def _value(self, place: Place) -> None:
        self._skip()
        if self._next() == "[":
            self._at += 1
            row = 0
            self._skip()
            while self._next() not in ("]", ""):
                self.starts[(*place, row)] = self._at
                self._value((*place, row))
                row += 1
                self._comma()
            self._at += 1
        elif self._next() == "{":
            self._at += 1
            self._skip()
            while self._next() not in ("}", ""):
                self._pair(place)
                self._comma()
            self._at += 1
        else:
            found = _TEXT.match(self._text, self._at) or _OTHER.match(self._text, self._at)
            self._at = found.end() if found else self._at + 1

    def _comma(self) -> None:
        self._skip()
        if self._next() == ",":
            self._at += 1
            self._skip()


def _bare(key: str) -> str:
    """A key without its quotes."""
    if key[0] == "'":
        return key[1:-1]
    if key[0] == '"':
        import tomllib

        return str(tomllib.loads(f"k = {key}")["k"])
    return key
